import type { App } from "../app.ts";
import { element, makeInk } from "../panel/element.ts";
import type { Received } from "../received.ts";
import { resize, type Studio } from "../scene/studio.ts";
import type { Box3 } from "three";
import type { Camera } from "../types.ts";

/** Let the browser save a file. */
export function download(blob: Blob, name: string) {
  const address = URL.createObjectURL(blob);
  const link = element("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** A file name made of a robot's name, which may be anything. */
export function fileName(robot: string, extension: string) {
  const plain = robot
    .replace(/[^\p{L}\p{N}_.-]+/gu, "_")
    .replace(/^[_.]+/, "")
    .slice(0, 60);
  return `${plain || "robot"}.${extension}`;
}

// The page's background, from above: the colours that the styles have for it, in light or dark.
const SKY: [number, string][] = [
  [0, "--sky"],
  [0.55, "--haze"],
  [1, "--ground"],
];

/** Draw the canvas, as it was drawn just now, over the page's background. */
function paintCanvas(ink: CanvasRenderingContext2D, canvas: HTMLCanvasElement, width: number, height: number) {
  const sky = ink.createLinearGradient(0, 0, 0, height);
  const styles = getComputedStyle(document.documentElement);
  for (const [at, property] of SKY) sky.addColorStop(at, styles.getPropertyValue(property));
  ink.fillStyle = sky;
  ink.fillRect(0, 0, width, height);
  ink.drawImage(canvas, 0, 0, width, height);
}

/**
 * A picture of the scene on the page's background, at its best.
 *
 * @param preset where to look from; as the page does if none is given
 * @param over draws what stands over the scene
 */
function takePicture(
  studio: Studio,
  width: number,
  height: number,
  preset: Camera | undefined,
  robots: { box(links: number[]): Box3 },
  over: (ink: CanvasRenderingContext2D) => void,
) {
  const { viewer } = studio;
  const { ratio } = studio;
  Object.assign(studio, { alwaysFine: true, ratio: 1 });
  studio.setRatio(1);
  resize(viewer, width, height);
  if (preset) studio.look(preset, robots);
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
 * Save the view as a PNG, with what is written over it.
 *
 * @param scale pixels for one of the screen's
 */
export async function saveScreenshot(page: App, scale: number): Promise<void> {
  const { pane, studio, robot } = page;
  const ratio = scale * window.devicePixelRatio;
  const [width, height] = [pane.clientWidth, pane.clientHeight].map((length) => Math.round(length * ratio));
  const gl = studio.viewer.renderer.getContext();
  const most = Math.min(gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), gl.getParameter(gl.MAX_TEXTURE_SIZE));
  const share = Math.min(1, most / Math.max(width, height));
  const [wide, high] = [Math.floor(width * share), Math.floor(height * share)];
  const canvas = takePicture(studio, wide, high, undefined, robot, (ink) => paintOver(page, ink, wide, high));
  const blob = await new Promise((done: (blob: Blob | null) => void) => canvas.toBlob(done, "image/png"));
  if (blob) download(blob, fileName(robot.about.name, "png"));
  else page.panel.messages.say("The browser made no picture of this size.", { bad: true });
}

// The shorter side of a picture in which letters of labels are as many pixels as in the page.
const LABELS_ACROSS = 640;

/** Draw the picture that the program asks for, and send it. */
export function sendPicture(page: App, { id, width, height, camera }: Received["capture"]) {
  const preset = page.robot.about.cameras.find(({ name }) => name === camera);
  const over = (ink: CanvasRenderingContext2D) => paintOver(page, ink, width, height);
  const picture = takePicture(page.studio, width, height, preset, page.others, over);
  page.send({ kind: "picture", id, data: picture.toDataURL("image/png") });
}

/** Paint the picture that was drawn last, with what the page writes over it. */
function paintPicture(page: App, ink: CanvasRenderingContext2D, width: number, height: number) {
  paintCanvas(ink, page.viewer.renderer.domElement, width, height);
  paintOver(page, ink, width, height);
}

/** Paint what the page writes over the picture onto one of another size. */
function paintOver(page: App, ink: CanvasRenderingContext2D, width: number, height: number) {
  page.speech.paint(ink, width, height);
  const scale = Math.min(width, height) / LABELS_ACROSS;
  ink.save();
  ink.scale(scale, scale);
  page.labels.paint(ink, width / scale, height / scale);
  ink.restore();
}

// A film ends by itself after so many seconds, or bytes: it is kept in memory until it is saved.
const [MOST_SECONDS, MOST_BYTES] = [120, 200e6];
const [RATE, BITS] = [30, 12e6];
const KINDS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];

/** A film of the view: each picture that is drawn, with the labels over it. */
export class Video {
  /** Told every second how long it has been recorded; null when it has ended. */
  told: (seconds: number | null) => void = () => {};
  canvas = document.createElement("canvas");
  ink: CanvasRenderingContext2D;
  recorder: MediaRecorder | null = null;

  constructor(readonly page: App) {
    this.ink = this.canvas.getContext("2d", { alpha: false }) as CanvasRenderingContext2D;
  }

  /** Why there can be none; "" where there can. */
  static get obstacle() {
    if (typeof MediaRecorder === "undefined" || !("captureStream" in HTMLCanvasElement.prototype)) {
      return "This browser records no video.";
    }
    return KINDS.some((kind) => MediaRecorder.isTypeSupported(kind))
      ? ""
      : "This browser records no WebM or MP4 video.";
  }

  get recording() {
    return this.recorder !== null;
  }

  start() {
    const mimeType = KINDS.find((kind) => MediaRecorder.isTypeSupported(kind)) ?? "";
    const { pane } = this.page;
    const ratio = Math.min(window.devicePixelRatio, 2);
    // Codecs want even numbers.
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
      if (recorder.state === "recording") this.told(seconds);
      if (bytes > MOST_BYTES || seconds >= MOST_SECONDS) this.stop();
    };
    recorder.onstop = () => {
      stream.getTracks().forEach((track) => track.stop());
      this.recorder = null;
      this.told(null);
      const type = mimeType.split(";")[0];
      download(new Blob(parts, { type }), fileName(this.page.robot.about.name, type === "video/mp4" ? "mp4" : "webm"));
    };
    this.recorder = recorder;
    recorder.start(1000);
    this.told(0);
    this.page.viewer.set_dirty();
  }

  stop() {
    if (this.recorder?.state === "recording") this.recorder.stop();
  }

  /** A picture has been drawn. */
  add() {
    if (!this.recorder) return;
    const { width, height } = this.canvas;
    paintPicture(this.page, this.ink, width, height);
  }
}
