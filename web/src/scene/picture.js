import { resize } from "./studio.js";

// The page's background, from above: the colours that the styles have for it, in light or dark.
/** @type {[number, string][]} */
const SKY = [
  [0, "--sky"],
  [0.55, "--haze"],
  [1, "--ground"],
];

/**
 * Draw the canvas, as it was drawn just now, over the page's background.
 *
 * @param {CanvasRenderingContext2D} ink
 * @param {HTMLCanvasElement} canvas
 * @param {number} width
 * @param {number} height
 */
export function paintCanvas(ink, canvas, width, height) {
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
 * @param {import("./studio.js").Studio} studio
 * @param {number} width in pixels
 * @param {number} height
 * @param {import("../types.js").Camera | undefined} preset where to look from; as the page does if none is given
 * @param {{ box(links: number[]): import("three").Box3 }} robots
 * @param {(ink: CanvasRenderingContext2D) => void} over draws what stands over the scene
 */
export function takePicture(studio, width, height, preset, robots, over) {
  const { viewer } = studio;
  const { ratio } = studio;
  Object.assign(studio, { alwaysFine: true, ratio: 1 });
  studio.setRatio(1);
  resize(viewer, width, height);
  if (preset) studio.look(preset, robots);
  viewer.render();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const ink = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  paintCanvas(ink, viewer.renderer.domElement, width, height);
  over(ink);
  Object.assign(studio, { alwaysFine: false, ratio });
  studio.setRatio(ratio);
  viewer.set_3d_pane_size();
  return canvas;
}
