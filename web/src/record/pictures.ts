import { paintCanvas, takePicture } from "../scene/picture.ts";
import type { App } from "../app.ts";

// The shorter side of a picture in which letters of labels are as many pixels as in the page.
const LABELS_ACROSS = 640;

/** Draw the picture that the program asks for, and send it. */
export function sendPicture(
  app: App,
  { id, width, height, camera }: { id: string; width: number; height: number; camera: string },
) {
  const preset = app.robot.about.cameras.find(({ name }) => name === camera);
  const over = (ink: CanvasRenderingContext2D) => paintOver(app, ink, width, height);
  const picture = takePicture(app.studio, width, height, preset, app.others, over);
  app.send({ kind: "picture", id, data: picture.toDataURL("image/png") });
}

/** Paint the picture that was drawn last, with what the page writes over it. */
export function paintPicture(app: App, ink: CanvasRenderingContext2D, width: number, height: number) {
  paintCanvas(ink, app.viewer.renderer.domElement, width, height);
  paintOver(app, ink, width, height);
}

/** Paint what the page writes over the picture onto one of another size. */
export function paintOver(app: App, ink: CanvasRenderingContext2D, width: number, height: number) {
  app.speech.paint(ink, width, height);
  const scale = Math.min(width, height) / LABELS_ACROSS;
  ink.save();
  ink.scale(scale, scale);
  app.labels.paint(ink, width / scale, height / scale);
  ink.restore();
}
