import { paintCanvas, takePicture } from "../scene/picture.js";

// The shorter side of a picture in which letters of labels are as many pixels as in the page.
const LABELS_ACROSS = 640;

/**
 * Draw the picture that the program asks for, and send it.
 *
 * @param {import("../app.js").App} app
 * @param {{ id: string, width: number, height: number, camera: string }} message
 */
export function sendPicture(app, { id, width, height, camera }) {
  const preset = app.robot.about.cameras.find(({ name }) => name === camera);
  /** @param {CanvasRenderingContext2D} ink */
  const over = (ink) => paintOver(app, ink, width, height);
  const picture = takePicture(app.studio, width, height, preset, app.others, over);
  app.send({ kind: "picture", id, data: picture.toDataURL("image/png") });
}

/**
 * Paint the picture that was drawn last, with what the page writes over it.
 *
 * @param {import("../app.js").App} app
 * @param {CanvasRenderingContext2D} ink
 * @param {number} width
 * @param {number} height
 */
export function paintPicture(app, ink, width, height) {
  paintCanvas(ink, app.viewer.renderer.domElement, width, height);
  paintOver(app, ink, width, height);
}

/**
 * Paint what the page writes over the picture onto one of another size.
 *
 * @param {import("../app.js").App} app
 * @param {CanvasRenderingContext2D} ink
 * @param {number} width
 * @param {number} height
 */
export function paintOver(app, ink, width, height) {
  app.speech.paint(ink, width, height);
  const scale = Math.min(width, height) / LABELS_ACROSS;
  ink.save();
  ink.scale(scale, scale);
  app.labels.paint(ink, width / scale, height / scale);
  ink.restore();
}
