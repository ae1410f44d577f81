// @ts-nocheck
import { element } from "../panel/element.js";

// Red, green, blue at a share of the way through equally spaced colours.
export function onScale(stops, share) {
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const left = Math.min(Math.floor(at), stops.length - 2);
  return stops[left].map((value, channel) => value + (at - left) * (stops[left + 1][channel] - value));
}

export function scaleBar(stops) {
  const css = (rgb) => `rgb(${rgb.map((value) => Math.round(255 * value)).join(",")})`;
  const bar = element("span", { className: "bar" });
  bar.style.background = `linear-gradient(to right, ${stops.map(css).join(",")})`;
  return bar;
}
