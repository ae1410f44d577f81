import { clamp } from "../math/numbers.js";
import { element } from "../panel/element.js";

/** @typedef {import("../types.js").Vector} Vector */

/**
 * Red, green, blue at a share of the way through equally spaced colours.
 *
 * @param {Vector[]} stops
 * @param {number} share from 0 to 1
 * @returns {Vector}
 */
export function onScale(stops, share) {
  const at = clamp(share, 0, 1) * (stops.length - 1);
  const left = Math.min(Math.floor(at), stops.length - 2);
  const [r, g, b] = stops[left].map((value, channel) => value + (at - left) * (stops[left + 1][channel] - value));
  return [r, g, b];
}

/**
 * A bar in these colours, for the legend.
 *
 * @param {Vector[]} stops
 */
export function scaleBar(stops) {
  const css = (/** @type {Vector} */ rgb) => `rgb(${rgb.map((value) => Math.round(255 * value)).join(",")})`;
  const bar = element("span", { className: "bar" });
  bar.style.background = `linear-gradient(to right, ${stops.map(css).join(",")})`;
  return bar;
}
