import type { App } from "../app.ts";
import { element, makeInk } from "../panel/element.ts";
import type { Received } from "../received.ts";
import { resize, type Studio } from "../scene/studio.ts";

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

/**
 * Take a picture of the scene on the page's background, in the best quality.
 *
 * @param look moves the camera to the picture's
 * @param over draws the labels over the scene
 */
function takePicture(
  studio: Studio,
  width: number,
  height: number,
  look: () => void,
  over: (ink: CanvasRenderingContext2D) => void,
) {
  const { viewer } = studio;
  const { ratio } = studio;
  Object.assign(studio, { alwaysFine: true, ratio: 1 });
  studio.setRatio(1);
  resize(viewer, width, height);
  look();
  viewer.render();
  const ink = makeInk(width, height);
  paintCanvas(ink, viewer.renderer.domElement, width, height);
  over(ink);
  Object.assign(studio, { alwaysFine: false, ratio });
  studio.setRatio(ratio);
  viewer.set_3d_pane_size();
  return ink.canvas;
}

/**
 * Save the view as a PNG, with its labels.
 *
 * @param scale pixels of the picture per pixel of the screen
 */
export async function saveScreenshot(page: App, scale: number): Promise<void> {
  const { pane, studio, robot } = page;
  const ratio = scale * window.devicePixelRatio;
  const [width, height] = [pane.clientWidth, pane.clientHeight].map((length) => Math.round(length * ratio));
  const gl = studio.viewer.renderer.getContext();
  const most = Math.min(gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), gl.getParameter(gl.MAX_TEXTURE_SIZE));
  const share = Math.min(1, most / Math.max(width, height));
  const [wide, high] = [Math.floor(width * share), Math.floor(height * share)];
  const canvas = takePicture(
    studio,
    wide,
    high,
    () => {},
    (ink) => paintOver(page, ink, wide, high),
  );
  const blob = await new Promise((done: (blob: Blob | null) => void) => canvas.toBlob(done, "image/png"));
  if (blob) download(blob, fileName(robot.about.name, "png"));
  else page.panel.messages.say("The browser could not make a picture of this size.", { bad: true });
}

// The length of a picture's shorter side at which its labels have the same size in pixels as in the page.
const LABELS_ACROSS = 640;

/** Draw the picture that the program requests, and send it. */
export function sendPicture(page: App, { id, width, height, camera }: Received["capture"]) {
  const look = () =>
    typeof camera === "string" ? page.studio.look(page.preset(camera), page.others) : page.camera(camera);
  const over = (ink: CanvasRenderingContext2D) => paintOver(page, ink, width, height);
  const picture = takePicture(page.studio, width, height, look, over);
  page.send({ kind: "picture", id, data: picture.toDataURL("image/png") });
}

/** Paint the page's labels onto a picture of another size. */
function paintOver(page: App, ink: CanvasRenderingContext2D, width: number, height: number) {
  page.speech.paint(ink, width, height);
  const scale = Math.min(width, height) / LABELS_ACROSS;
  ink.save();
  ink.scale(scale, scale);
  page.labels.paint(ink, width / scale, height / scale);
  ink.restore();
}

// A video ends automatically after this many seconds or bytes, because it is kept in memory until it is saved.
const [MOST_SECONDS, MOST_BYTES] = [120, 200e6];
const [RATE, BITS] = [30, 12e6];
const KINDS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];

/** Records a video of the view: each picture that is drawn, with its labels. */
export class Video {
  /** Called every second with the length so far, and with null at the end. */
  onProgress: (seconds: number | null) => void = () => {};
  canvas = document.createElement("canvas");
  ink: CanvasRenderingContext2D;
  recorder: MediaRecorder | null = null;

  constructor(readonly page: App) {
    this.ink = this.canvas.getContext("2d", { alpha: false }) as CanvasRenderingContext2D;
  }

  /** Why the browser cannot record video; "" if it can. */
  static get obstacle() {
    if (typeof MediaRecorder === "undefined" || !("captureStream" in HTMLCanvasElement.prototype)) {
      return "This browser cannot record video.";
    }
    return KINDS.some((kind) => MediaRecorder.isTypeSupported(kind))
      ? ""
      : "This browser cannot record WebM or MP4 video.";
  }

  get recording() {
    return this.recorder !== null;
  }

  start() {
    const mimeType = KINDS.find((kind) => MediaRecorder.isTypeSupported(kind)) ?? "";
    const { pane } = this.page;
    const ratio = Math.min(window.devicePixelRatio, 2);
    // Codecs need even sizes.
    this.canvas.width = 2 * Math.round((pane.clientWidth * ratio) / 2);
    this.canvas.height = 2 * Math.round((pane.clientHeight * ratio) / 2);
    const stream = this.canvas.captureStream(RATE);
    const recorder = new MediaRecorder(stream, { mimeType, videoBitsPerSecond: BITS });
    const parts: Blob[] = [];
    let bytes = 0;
    const began = performance.now();
    recorder.ondataavailable = ({ data }) => {
      parts.push(data);
      bytes += data.size;
      const seconds = Math.round((performance.now() - began) / 1000);
      if (recorder.state === "recording") this.onProgress(seconds);
      if (bytes > MOST_BYTES || seconds >= MOST_SECONDS) this.stop();
    };
    recorder.onstop = () => {
      stream.getTracks().forEach((track) => track.stop());
      this.recorder = null;
      this.onProgress(null);
      const type = mimeType.split(";")[0];
      download(new Blob(parts, { type }), fileName(this.page.robot.about.name, type === "video/mp4" ? "mp4" : "webm"));
    };
    this.recorder = recorder;
    recorder.start(1000);
    this.onProgress(0);
    this.page.viewer.set_dirty();
  }

  stop() {
    if (this.recorder?.state === "recording") this.recorder.stop();
  }

  /** Add the picture that has just been drawn. */
  add() {
    if (!this.recorder) return;
    const { width, height } = this.canvas;
    paintCanvas(this.ink, this.page.viewer.renderer.domElement, width, height);
    paintOver(this.page, this.ink, width, height);
  }
}
