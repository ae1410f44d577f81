import { clamp } from "../math/numbers.ts";
import { element } from "../panel/element.ts";
import type { Vector } from "../types.ts";

/**
 * Interpolate between equally spaced colours; returns red, green and blue.
 *
 * @param share from 0 to 1
 */
export function onScale(stops: Vector[], share: number): Vector {
  const at = clamp(share, 0, 1) * (stops.length - 1);
  const left = Math.min(Math.floor(at), stops.length - 2);
  const [r, g, b] = stops[left].map((value, channel) => value + (at - left) * (stops[left + 1][channel] - value));
  return [r, g, b];
}

/** The entries of the legend for a colour scale: what it shows, and a bar between its least and its largest value. */
export function scale({ label, low, high }: { label: string; low: string; high: string }, stops: Vector[]) {
  const css = (rgb: Vector) => `rgb(${rgb.map((value) => Math.round(255 * value)).join(",")})`;
  const bar = element("span", { className: "bar" });
  bar.style.background = `linear-gradient(to right, ${stops.map(css).join(",")})`;
  return [...(label ? [element("b", {}, label)] : []), element("span", { className: "entry" }, low, bar, high)];
}

/** The legend under the picture, with parts for the colours of links, joint pairs, reach, ghosts and others. */
export class Legend {
  parts: Map<string, (string | Node)[]> = new Map(
    ["overlap", "colours", "chains", "pairs", "reach", "ghosts"].map((part) => [part, []]),
  );

  constructor(public box: HTMLElement) {}

  /**
   * Replace a part of the legend.
   *
   * @param children the content; without any, the part is removed
   */
  set(part: string, children: (string | Node)[]) {
    this.parts.set(part, children);
    const shown = [...this.parts.values()].filter(({ length }) => length > 0);
    this.box.replaceChildren(...shown.map((entries) => element("span", { className: "part" }, ...entries)));
    this.box.hidden = shown.length === 0;
  }
}

/** An entry of the legend: a dot in a colour, and its meaning. */
export function entry(text: string, colour: string) {
  const dot = element("span", { className: "dot" });
  dot.style.background = colour;
  return element("span", { className: "entry" }, dot, text);
}
