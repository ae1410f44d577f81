import { clamp } from "../math/numbers.ts";
import { element } from "../panel/element.ts";
import type { Vector } from "../types.ts";

/**
 * Red, green, blue at a share of the way through equally spaced colours.
 *
 * @param share from 0 to 1
 */
export function onScale(stops: Vector[], share: number): Vector {
  const at = clamp(share, 0, 1) * (stops.length - 1);
  const left = Math.min(Math.floor(at), stops.length - 2);
  const [r, g, b] = stops[left].map((value, channel) => value + (at - left) * (stops[left + 1][channel] - value));
  return [r, g, b];
}

/** A bar in these colours, for the legend. */
export function scaleBar(stops: Vector[]) {
  const css = (rgb: Vector) => `rgb(${rgb.map((value) => Math.round(255 * value)).join(",")})`;
  const bar = element("span", { className: "bar" });
  bar.style.background = `linear-gradient(to right, ${stops.map(css).join(",")})`;
  return bar;
}
