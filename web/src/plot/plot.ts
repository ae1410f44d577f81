import "uplot/dist/uPlot.min.css";
import uPlot from "uplot";
import { clamp, fixed } from "../math/numbers.ts";
import { div, element } from "../panel/element.ts";

/*! uPlot 1.6.32 (https://github.com/leeoniya/uPlot)

The MIT License (MIT)

Copyright (c) 2022 Leon Sorokin

Permission is hereby granted, free of charge, to any person obtaining a copy
of this software and associated documentation files (the "Software"), to deal
in the Software without restriction, including without limitation the rights
to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
copies of the Software, and to permit persons to whom the Software is
furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in
all copies or substantial portions of the Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN
THE SOFTWARE. */

// The bundle keeps this licence.
export { uPlot };

/** A line of a plot; the limits that it comes near are drawn faintly. */
interface Line {
  name: string;
  colour: string;
  /** In the unit shown; null for no value. */
  values: (number | null)[];
  limits: (number | null)[];
  /** Whether times at which the line is negative are red; the zero is then always in sight. */
  red?: boolean;
  /** Digits after the decimal point; null for four significant digits. */
  digits: number | null;
  /** The sign of the unit. */
  sign: string;
}

const HEIGHT = 112;
// How near to a limit, as a share of the plot's height.
const NEAR_LIMIT = 0.1;
const RED = "rgb(224 49 49 / 25%)";

const unitsOf = (lines: Line[]) => [...new Set(lines.map(({ sign }) => sign).filter(Boolean))];

/** The texts of an axis, the last one with the unit. */
const withUnit = (texts: string[], unit: string) =>
  texts.map((text, i) => (i === texts.length - 1 ? `${text}${unit === "°" ? "" : " "}${unit}`.trim() : text));

function written(value: number, digits: number | null) {
  if (Number.isNaN(value)) return "–";
  return digits === null ? String(Number(value.toPrecision(4))).replace("-", "−") : fixed(value, digits);
}

/** A plot of numbers over time, with their values at the current time. A press on it moves to that time. */
export class Plot {
  lines: Line[] = [];
  /** The time of the cursor [s]. */
  time = 0;
  times: number[] = [];
  values = div("values");
  picture = element("div", { className: "picture", role: "img" });
  cursor = div("now");
  element: HTMLDivElement;
  outputs: HTMLOutputElement[] | undefined;
  plot: uPlot | undefined;

  heading = element("h3");

  /** @param grows whether new points are added to the same lines */
  constructor(
    public title: string,
    readonly seek: (time: number) => void,
    readonly grows: boolean = false,
  ) {
    this.element = div("plot", div("head", this.heading, this.values), this.picture);
    new ResizeObserver(() => this.resize()).observe(this.picture);
  }

  show(times: number[], lines: Line[], title: string = this.title) {
    this.title = this.heading.title = title;
    const unit = unitsOf(lines).join(", ");
    this.heading.textContent = unit ? `${title} [${unit}]` : title;
    const isSame =
      this.plot && lines.length === this.lines.length && lines.every(({ name }, i) => name === this.lines[i].name);
    this.lines = lines;
    this.times = times;
    if (isSame && this.grows) {
      this.plot?.setData([times, ...lines.map(({ values }) => values)]);
      this.picture.ariaLabel = this.described();
      return;
    }
    this.plot?.destroy();
    this.outputs = lines.map(() => element("output", { ariaLive: "off" }));
    this.values.replaceChildren(
      ...lines.map(({ name, colour }, i) => {
        const dot = element("i", {});
        dot.style.background = colour;
        // A plot of one line has its name.
        return element("span", {}, dot, name === title ? "" : name, " ", (this.outputs as HTMLElement[])[i]);
      }),
    );
    this.picture.ariaLabel = this.described();
    const style = getComputedStyle(this.element);
    const [soft, grid] = [style.color, style.borderTopColor];
    const axis = {
      stroke: soft,
      font: `${Math.round(Number.parseFloat(style.fontSize) * 0.85)}px ${style.fontFamily}`,
      grid: { stroke: grid, width: 1 },
      ticks: { show: false },
    };
    // By default the zero is in sight if it is near.
    const padding: uPlot.Range.Limit = { pad: 0.1, soft: 0, mode: lines.some(({ red }) => red) ? 1 : 3 };
    this.plot = new uPlot(
      {
        width: this.picture.clientWidth || 300,
        height: HEIGHT,
        scales: {
          x: { time: false, range: (_, low, high) => [low, high > low ? high : low + 1] },
          y: { range: { min: padding, max: padding } },
        },
        legend: { show: false },
        cursor: { show: false },
        padding: [6, 10, 0, 0],
        axes: [
          {
            ...axis,
            size: 20,
            gap: 2,
            values: (_, at) =>
              withUnit(
                at.map((time) => `${Number(time.toFixed(3))}`),
                "s",
              ),
          },
          {
            ...axis,
            size: 54,
            gap: 4,
            space: 24,
            values: (_, at) =>
              withUnit(
                at.map((value) => String(Number(value.toFixed(6))).replace("-", "−")),
                unitsOf(lines).length === 1 ? unit : "",
              ),
          },
        ],
        series: [{}, ...lines.map(({ colour }) => ({ stroke: colour, width: 1.75, points: { show: false } }))],
        hooks: { drawAxes: [(plot) => this.drawLimits(plot)], draw: [() => this.place()] },
      },
      [times, ...lines.map(({ values }) => values)],
      this.picture,
    );
    this.plot.over.append(this.cursor);
    this.plot.over.onpointerdown = (event) => this.grab(event);
  }

  // A description of the plot for screen readers.
  described() {
    const spans = this.lines.map(({ name, values, digits, sign }) => {
      let [low, high] = [Infinity, -Infinity];
      for (const value of values) if (value !== null) [low, high] = [Math.min(low, value), Math.max(high, value)];
      return `${name} from ${written(low, digits)} to ${written(high, digits)} ${sign}`.trim();
    });
    return `${this.title} over ${(this.times.at(-1) ?? 0).toFixed(2)} s: ${spans.join(", ") || "nothing moves"}`;
  }

  drawLimits({ ctx, bbox, valToPos, scales }: uPlot) {
    const { min, max } = scales.y;
    ctx.save();
    ctx.fillStyle = RED;
    ctx.beginPath();
    const x = (i: number) => Math.round(valToPos(this.times[Math.min(i, this.times.length - 1)], "x", true));
    for (const { values } of this.lines.filter(({ red }) => red)) {
      values.forEach((value, i) => {
        if ((value ?? 0) < 0) ctx.rect(x(i), bbox.top, Math.max(x(i + 1) - x(i), 1), bbox.height);
      });
    }
    ctx.fill();
    ctx.globalAlpha = 0.55;
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([3 * devicePixelRatio, 4 * devicePixelRatio]);
    ctx.font = `${Math.round(11 * devicePixelRatio)}px system-ui, sans-serif`;
    ctx.textAlign = "left";
    ctx.textBaseline = "alphabetic";
    const named: number[] = [];
    for (const { colour, limits, name, red, values } of this.lines) {
      ctx.strokeStyle = ctx.fillStyle = colour;
      for (const limit of limits) {
        if (limit === null || min === undefined || max === undefined || limit < min || limit > max) continue;
        const near = NEAR_LIMIT * (max - min);
        if (!red && !values.some((value) => value !== null && Math.abs(value - limit) < near)) continue;
        const y = Math.round(valToPos(limit, "y", true));
        ctx.beginPath();
        ctx.moveTo(bbox.left, y);
        ctx.lineTo(bbox.left + bbox.width, y);
        ctx.stroke();
        // Its name where there is room: below an upper limit and above a lower one.
        const [, upper] = limits;
        const at = y + (limit === upper ? 12 : -4) * devicePixelRatio;
        if (upper === undefined || named.some((other) => Math.abs(other - at) < 12 * devicePixelRatio)) continue;
        named.push(at);
        ctx.fillText(`limit of ${name}`, bbox.left + 6 * devicePixelRatio, at);
      }
    }
    ctx.restore();
  }

  grab(event: PointerEvent) {
    const { plot } = this;
    if (!plot || event.button !== 0) return;
    event.preventDefault();
    const { over } = plot;
    const seek = ({ clientX }: PointerEvent) => {
      const { left, width } = over.getBoundingClientRect();
      const time = plot.posToVal(clamp(clientX - left, 0, width), "x");
      this.seek(clamp(time, this.times[0], this.times.at(-1) ?? 0));
    };
    over.setPointerCapture(event.pointerId);
    seek(event);
    over.onpointermove = seek;
    over.onpointerup = over.onpointercancel = () => (over.onpointermove = null);
  }

  /**
   * Move the cursor to a time.
   *
   * @param valueOf gives the value of a line, in the unit shown
   */
  setTime(time: number, valueOf: (line: number) => number) {
    this.time = time;
    this.place();
    this.lines.forEach(({ digits, sign }, i) => {
      const text = `${written(valueOf(i), digits)}${sign === "°" ? "" : " "}${sign}`.trim();
      if (this.outputs) this.outputs[i].textContent = text;
    });
  }

  // Place the cursor; before the plot is drawn, it cannot convert times to pixels.
  place() {
    const { plot, times } = this;
    if (!plot || plot.scales.x.max === undefined) return;
    const time = clamp(this.time, times[0], times[times.length - 1]);
    this.cursor.style.transform = `translateX(${plot.valToPos(time, "x")}px)`;
  }

  resize() {
    const { clientWidth: width } = this.picture;
    if (this.plot && width > 0 && width !== this.plot.width) this.plot.setSize({ width, height: HEIGHT });
  }

  clear() {
    this.plot?.destroy();
    this.plot = undefined;
  }
}
