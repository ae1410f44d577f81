import type { App } from "../app.ts";
import { download, fileName, paintPicture } from "./pictures.ts";

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
