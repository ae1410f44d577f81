import { resize, type Studio } from "./studio.ts";
import type { Camera } from "../types.ts";
import type { Box3 } from "three";

// The page's background, from above: the colours that the styles have for it, in light or dark.
const SKY: [number, string][] = [
  [0, "--sky"],
  [0.55, "--haze"],
  [1, "--ground"],
];

/** Draw the canvas, as it was drawn just now, over the page's background. */
export function paintCanvas(ink: CanvasRenderingContext2D, canvas: HTMLCanvasElement, width: number, height: number) {
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
 * @param width in pixels
 * @param preset where to look from; as the page does if none is given
 * @param over draws what stands over the scene
 */
export function takePicture(
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
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const ink = canvas.getContext("2d") as CanvasRenderingContext2D;
  paintCanvas(ink, viewer.renderer.domElement, width, height);
  over(ink);
  Object.assign(studio, { alwaysFine: false, ratio });
  studio.setRatio(ratio);
  viewer.set_3d_pane_size();
  return canvas;
}
