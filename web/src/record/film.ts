import type { App } from "../app.ts";
import { button, element, openDialog } from "../panel/element.ts";
import type { Received } from "../received.ts";
import { Pictures, download, fileName, lookFrom } from "./pictures.ts";
import { COLOURS, toPlanes } from "./planes.ts";
import { webm, type EncodedPicture, type Track } from "./webm.ts";

type Form = Received["film"]["form"];

/** Takes the pictures of a film, one after another, and makes a file of them. */
interface Film {
  add(ink: CanvasRenderingContext2D): Promise<void>;
  end(): Promise<Blob>;
  close(): void;
}

// Pictures per second of a film from the page. A film is kept in memory until it is saved: its largest size in bytes, and the
// most pictures.
const RATE = 30;
const MOST_BYTES = 1e9;
const MOST_PICTURES = 0xffff;
// Seconds from one picture that can be decoded alone to the next, and bits for each pixel in a second.
const BETWEEN_KEYS = 2;
const DEPTH = 8;
const CODECS = ["vp09.00.61.08", "vp8"];

/** How this browser encodes video of a size; null if it cannot, as without HTTPS on another machine. */
async function encoding(width: number, height: number, framerate: number): Promise<VideoEncoderConfig | null> {
  if (typeof VideoEncoder === "undefined") return null;
  const bitrate = DEPTH * width * height;
  for (const codec of CODECS) {
    const config: VideoEncoderConfig = { codec, width, height, framerate, bitrate, latencyMode: "quality" };
    const { supported } = await VideoEncoder.isConfigSupported(config).catch(() => ({ supported: false }));
    if (supported) return config;
  }
  return null;
}

/** A film as WebM. */
class WebmFilm implements Film {
  pictures: EncodedPicture[] = [];
  count = 0;
  bytes = 0;
  encoder: VideoEncoder;
  track: Track;
  /** Rejected when the encoder fails. */
  failure: Promise<never>;

  constructor(config: VideoEncoderConfig, fps: number) {
    const { codec, width, height } = config;
    this.track = { codec: codec === "vp8" ? "vp8" : "vp09", width, height, fps };
    let fail: (reason: Error) => void = () => {};
    this.failure = new Promise((_, reject) => (fail = reject));
    this.failure.catch(() => {});
    this.encoder = new VideoEncoder({ output: (chunk) => this.keep(chunk), error: fail });
    this.encoder.configure(config);
  }

  keep(chunk: EncodedVideoChunk) {
    const data = new Uint8Array(chunk.byteLength);
    chunk.copyTo(data);
    this.bytes += data.length;
    this.pictures.push({ data, isKey: chunk.type === "key" });
  }

  async add(ink: CanvasRenderingContext2D) {
    const { encoder } = this;
    const { fps, width, height } = this.track;
    const { data } = ink.getImageData(0, 0, width, height);
    const frame = new VideoFrame(toPlanes(data, width, height), {
      format: "I420",
      codedWidth: width,
      codedHeight: height,
      timestamp: Math.round((1e6 * this.count) / fps),
      duration: Math.round(1e6 / fps),
      colorSpace: COLOURS,
    });
    encoder.encode(frame, { keyFrame: this.count % Math.ceil(BETWEEN_KEYS * fps) === 0 });
    frame.close();
    this.count += 1;
    const dequeued = () => new Promise((done) => encoder.addEventListener("dequeue", done, { once: true }));
    do await Promise.race([dequeued(), this.failure]);
    while (encoder.encodeQueueSize > 1);
    checkSize(this.bytes);
  }

  async end() {
    await Promise.race([this.encoder.flush(), this.failure]);
    return new Blob(webm(this.track, this.pictures), { type: "video/webm" });
  }

  close() {
    if (this.encoder.state !== "closed") this.encoder.close();
  }
}

/** A film as PNG files, one after another, which the program puts into a ZIP file. */
class PngFilm implements Film {
  files: Blob[] = [];
  bytes = 0;

  async add(ink: CanvasRenderingContext2D) {
    const blob = await new Promise((done: (blob: Blob | null) => void) => ink.canvas.toBlob(done, "image/png"));
    if (!blob) throw new Error("the browser cannot make a picture of this size");
    this.files.push(blob);
    this.bytes += blob.size;
    checkSize(this.bytes);
  }

  async end() {
    return new Blob(this.files);
  }

  close() {}
}

function checkSize(bytes: number) {
  if (bytes > MOST_BYTES) throw new Error("the video has more than 1 GB: film a shorter motion or a smaller picture");
}

/**
 * Film the motion of the player from its beginning to its end: show it at each picture's time, draw it in the best quality,
 * encode it. The last picture shows the end. The player's speed counts; its time is the same afterwards.
 *
 * @param look moves the camera to the film's, when the robot is at the beginning
 * @param tell called after each picture with the number of pictures so far and in all; throws to cancel
 */
async function film(
  page: App,
  { fps, width, height, form }: { fps: number; width: number; height: number; form: Form },
  look: () => void,
  tell: (done: number, all: number) => void,
): Promise<Blob> {
  const { player, viewer } = page;
  const { playback } = player;
  if (!playback) throw new Error("there is no motion to film");
  const { time: before, duration } = playback;
  const step = player.speed / fps;
  const count = Math.ceil(duration / step - 1e-6) + 1;
  if (count > MOST_PICTURES) throw new Error(`a video has at most ${MOST_PICTURES} pictures; this one has ${count}`);
  const config = form === "webm" ? await encoding(width, height, fps) : null;
  if (form === "webm" && !config) {
    throw new Error("this browser cannot encode video here; the program can save a .zip of PNG files");
  }
  const made = config ? new WebmFilm(config, fps) : new PngFilm();
  const drawing = new Pictures(page, width, height);
  try {
    for (let i = 0; i < count; i++) {
      player.seek(Math.min(i * step, duration));
      if (i === 0) {
        page.stance.settle();
        look();
      }
      drawing.draw();
      if (viewer.renderer.getContext().isContextLost()) throw new Error("the browser has lost the graphics card");
      await made.add(drawing.ink);
      if (player.playback !== playback) throw new Error("the motion has been replaced");
      tell(i + 1, count);
    }
    return await made.end();
  } finally {
    made.close();
    drawing.end();
    if (player.playback === playback) player.seek(before);
  }
}

/** Film the motion as the view shows it, with a dialog that shows the progress, and save the file. */
export async function saveFilm(page: App): Promise<void> {
  const { pane, player, panel, robot } = page;
  if (!player.loaded) {
    return panel.messages.say("There is no motion to film: record one or set key frames.", { bad: true });
  }
  const ratio = Math.min(devicePixelRatio, 2);
  const [width, height] = [pane.clientWidth, pane.clientHeight].map((length) => 2 * Math.round((length * ratio) / 2));
  const bar = element("progress", { max: 1, value: 0, ariaLabel: "Pictures drawn" });
  const line = element("p", {}, "The first picture is being drawn.");
  const cancelled = new Error();
  const dialog = openDialog(
    "Video",
    line,
    bar,
    button("Cancel", () => dialog.close()),
  );
  try {
    const blob = await film(
      page,
      { fps: RATE, width, height, form: "webm" },
      () => {},
      (done, all) => {
        if (!dialog.open) throw cancelled;
        Object.assign(bar, { max: all, value: done });
        line.textContent = `Picture ${done} of ${all}`;
      },
    );
    download(blob, fileName(robot.about.name, "webm"));
  } catch (error) {
    if (error !== cancelled) panel.messages.say(`No video: ${(error as Error).message}.`, { bad: true });
  } finally {
    dialog.close();
  }
}

// A message to the program has at most this many bytes of the film, before they are written as text.
const PIECE = 3 << 20;

/** Film the motion for the program; send it the progress, and then the file in pieces. */
export async function sendFilm(page: App, { id, camera, ...what }: Received["film"]): Promise<void> {
  const send = (answer: object) => page.send({ kind: "film", id, ...answer });
  try {
    const blob = await film(
      page,
      what,
      () => lookFrom(page, camera),
      (done, all) => send({ done, all }),
    );
    for (let from = 0; from < blob.size; from += PIECE) {
      const reader = new FileReader();
      const read = new Promise((done) => (reader.onload = done));
      reader.readAsDataURL(blob.slice(from, from + PIECE));
      await read;
      send({ data: reader.result, last: from + PIECE >= blob.size });
    }
  } catch (error) {
    send({ error: (error as Error).message });
  }
}
