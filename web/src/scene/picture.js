// @ts-nocheck
import { resize } from "./studio.js";

const SKY = [
  [0, "#fbfcfd"],
  [0.55, "#eef1f6"],
  [1, "#dde3ec"],
];

// A picture of the scene on the page's background, with what `over` draws over it, as a data URI.
export function takePicture(studio, width, height, preset, robot, over) {
  const { viewer } = studio;
  const ratio = viewer.renderer.getPixelRatio();
  viewer.renderer.setPixelRatio(1);
  resize(viewer, width, height);
  if (preset) studio.look(preset, robot);
  viewer.render();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const ink = canvas.getContext("2d");
  const sky = ink.createLinearGradient(0, 0, 0, height);
  for (const [at, colour] of SKY) sky.addColorStop(at, colour);
  ink.fillStyle = sky;
  ink.fillRect(0, 0, width, height);
  ink.drawImage(viewer.renderer.domElement, 0, 0);
  over(ink);
  viewer.renderer.setPixelRatio(ratio);
  viewer.set_3d_pane_size();
  return canvas.toDataURL("image/png");
}
