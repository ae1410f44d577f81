import type { App } from "../app.ts";
import { element, makeInk } from "../panel/element.ts";
import type { Received } from "../received.ts";

/** Save a file through the browser. */
export function download(blob: Blob, name: string) {
  const address = URL.createObjectURL(blob);
  const link = element("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** Make a valid file name from a robot's name, which may be any text. */
export function fileName(robot: string, extension: string) {
  const plain = robot
    .replace(/[^\p{L}\p{N}_.-]+/gu, "_")
    .replace(/^[_.]+/, "")
    .slice(0, 60);
  return `${plain || "robot"}.${extension}`;
}

// The length of a picture's shorter side at which its labels have the same size in pixels as in the page.
const LABELS_ACROSS = 640;

// The page's background from top to bottom: positions and the names of the colours in the styles.
const SKY: [number, string][] = [
  [0, "--sky"],
  [0.55, "--haze"],
  [1, "--ground"],
];

/** Draw the page's background, and the canvas over it, which must just have been drawn. */
function paintCanvas(ink: CanvasRenderingContext2D, canvas: HTMLCanvasElement, width: number, height: number) {
  const sky = ink.createLinearGradient(0, 0, 0, height);
  const styles = getComputedStyle(document.documentElement);
  for (const [at, property] of SKY) sky.addColorStop(at, styles.getPropertyValue(property));
  ink.fillStyle = sky;
  ink.fillRect(0, 0, width, height);
  ink.drawImage(canvas, 0, 0, width, height);
}

/** Draws pictures of one size in the best quality, with labels and the page's background, instead of the view until `end`. */
export class Pictures {
  ink = makeInk(this.width, this.height);

  constructor(
    readonly page: App,
    readonly width: number,
    readonly height: number,
  ) {
    Object.assign(page.studio, { alwaysFine: true, ratio: 1 });
    this.fit();
  }

  /** Give the scene the size of the pictures, which the page's own size may have replaced. */
  fit() {
    const { camera, renderer } = this.page.viewer;
    const { width, height } = renderer.domElement;
    this.page.studio.setRatio(1);
    if (width === this.width && height === this.height) return;
    camera.aspect = this.width / this.height;
    // On the screen, the canvas keeps its size.
    renderer.setSize(this.width, this.height, false);
  }

  draw() {
    const { page, ink, width, height } = this;
    this.fit();
    page.viewer.render();
    paintCanvas(ink, page.viewer.renderer.domElement, width, height);
    if (page.eyes.filling) return ink.canvas;
    const scale = Math.min(width, height) / LABELS_ACROSS;
    ink.save();
    ink.scale(scale, scale);
    page.labels.paint(ink, width / scale, height / scale);
    ink.restore();
    return ink.canvas;
  }

  end() {
    const { eyes, studio, viewer } = this.page;
    eyes.fill(null);
    Object.assign(studio, { alwaysFine: false, ratio: devicePixelRatio });
    studio.setRatio(studio.ratio);
    viewer.set_3d_pane_size();
  }
}

/** Save the view as a PNG, with its labels. */
export async function saveScreenshot(page: App): Promise<void> {
  const { pane, studio, robot } = page;
  const ratio = page.panel.settings.scale * window.devicePixelRatio;
  const [width, height] = [pane.clientWidth, pane.clientHeight].map((length) => Math.round(length * ratio));
  const gl = studio.viewer.renderer.getContext();
  if (gl.isContextLost()) return page.panel.messages.say("There is no picture to save.", { bad: true });
  const most = Math.min(gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), gl.getParameter(gl.MAX_TEXTURE_SIZE));
  const share = Math.min(1, most / Math.max(width, height));
  const [wide, high] = [Math.floor(width * share), Math.floor(height * share)];
  const pictures = new Pictures(page, wide, high);
  const canvas = pictures.draw();
  pictures.end();
  const blob = await new Promise((done: (blob: Blob | null) => void) => canvas.toBlob(done, "image/png"));
  if (blob) download(blob, fileName(robot.about.name, "png"));
  else page.panel.messages.say("The browser could not make a picture of this size.", { bad: true });
}

/** Put the camera at one of the presets or at a pose, or look through a camera of the robot. */
export function lookFrom(page: App, camera: string | number[]) {
  if (typeof camera !== "string") page.camera(camera);
  else if (page.eyes.find(camera)) page.eyes.fill(camera);
  else page.studio.look(page.preset(camera), page.others);
}

/** Draw the picture that the program requests, and send it. */
export function sendPicture(page: App, { id, width, height, camera }: Received["capture"]) {
  const pictures = new Pictures(page, width, height);
  lookFrom(page, camera);
  const data = pictures.draw().toDataURL("image/png");
  pictures.end();
  page.send({ kind: "picture", id, data, last: true });
}
