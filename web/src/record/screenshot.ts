import { takePicture } from "../scene/picture.ts";
import { paintOver } from "./pictures.ts";
import { download, fileName } from "./download.ts";
import type { App } from "../app.ts";

/**
 * Save the view as a PNG, with what is written over it.
 *
 * @param scale pixels for one of the screen's
 */
export async function saveScreenshot(app: App, scale: number): Promise<void> {
  const { pane, studio, robot } = app;
  const ratio = scale * window.devicePixelRatio;
  const [width, height] = [pane.clientWidth, pane.clientHeight].map((length) => Math.round(length * ratio));
  const gl = studio.viewer.renderer.getContext();
  const most = Math.min(gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), gl.getParameter(gl.MAX_TEXTURE_SIZE));
  const share = Math.min(1, most / Math.max(width, height));
  const [wide, high] = [Math.floor(width * share), Math.floor(height * share)];
  const canvas = takePicture(studio, wide, high, undefined, robot, (ink) => paintOver(app, ink, wide, high));
  const blob = await new Promise((done: (blob: Blob | null) => void) => canvas.toBlob(done, "image/png"));
  if (blob) download(blob, fileName(robot.about.name, "png"));
  else app.panel.messages.say("The browser made no picture of this size.", { bad: true });
}
