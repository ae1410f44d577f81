import "./plot.css";
import { firstWhere } from "../math/numbers.ts";
import { element } from "../panel/element.ts";
import { OffScreen } from "../robot/nodes.ts";
import type { Player } from "../timeline/player.ts";
import type { Coordinate } from "../types.ts";
import { matches } from "../values/names.ts";
import { unitOf } from "../values/units.ts";
import { Plot } from "./plot.ts";
import { busiest, evenTimes, sampleTimes } from "../timeline/motion.ts";
import type { Curves } from "./streams.ts";

const COLOURS = ["#d9480f", "#1c7ed6", "#2b8a3e", "#ae3ec9", "#a17a00", "#0c8599", "#c2255c", "#5f3dc4"];
const AXES = { x: "#e03131", y: "#2f9e44", z: "#3b7ddd" };
const [MOST_TIMES, MOST_PLACES, MOST_LINES] = [1500, 400, 6];
// How long [ms] a change waits for further changes before the plots are drawn.
const PATIENCE = 80;

/**
 * The plots: joint angles and the position of a frame over the time of the motion that is played, and the program's plots.
 * While hidden, it draws nothing. The first points that the program plots open it, if the picture keeps half the height.
 */
export class PlotStrip {
  coordinates = this.player.page.robot.about.coordinates;
  /** A copy of the robot's tree that computes poses in other configurations. */
  skeleton: OffScreen | undefined = undefined;
  waiting: ReturnType<typeof setTimeout> | undefined = undefined;
  button = this.player.switch("plot", "Plots", () => this.toggle(), "Plots");
  joints = new Plot("Joints", (time) => this.player.seek(time));
  places = new Plot("Position", (time) => this.player.seek(time));
  element = element("section", { className: "plots", hidden: true, ariaLabel: "Plots" });
  drawn?: Coordinate[];
  /** The program's plots and their curves, by title. */
  streams: Map<string, { plot: Plot; curves: Curves }> = new Map();
  /** Whether the program has plotted something, and whether the user has opened or closed the plots. */
  begun = false;
  asked = false;
  waitingPoints: ReturnType<typeof setTimeout> | undefined = undefined;
  /** The time that drawing the program's plots took [ms]. */
  took = 0;

  constructor(readonly player: Player) {
    const { page } = player;
    page.addEventListener("selected", () => this.later());
    page.panel.joints.search.addEventListener("input", () => this.later());
    this.element.append(this.joints.element, this.places.element);
    player.addEventListener("motion", () => this.later());
    const offer = () => (this.button.hidden = !player.loaded && page.streams.live.size === 0);
    player.addEventListener("motion", offer);
    page.streams.addEventListener("points", offer);
    offer();
    page.streams.addEventListener("points", () => this.pointsCame());
    player.addEventListener("time", () => this.setTime());
    page.panel.settings.addEventListener("units", () => this.later());
    page.panel.settings.addEventListener("theme", () => this.later());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.later());
  }

  toggle() {
    this.asked = true;
    this.open(this.element.hidden !== false);
  }

  open(on: boolean) {
    this.element.hidden = !on;
    this.button.setAttribute("aria-pressed", String(on));
    this.player.bar.classList.toggle("plotting", on);
    if (on) this.update();
    else {
      [this.joints, this.places, ...[...this.streams.values()].map(({ plot }) => plot)].forEach((plot) => plot.clear());
    }
  }

  pointsCame() {
    if (!this.begun && this.player.page.streams.live.size > 0) {
      this.begun = true;
      this.open(true);
    }
    // Drawing many points is slow; waiting three times as long leaves three quarters of the time to the rest of the page.
    if (!this.element.hidden) {
      this.waitingPoints ??= setTimeout(() => this.drawStreams(), Math.max(PATIENCE, 3 * this.took));
    }
  }

  /** Draw the program's plots. */
  drawStreams() {
    clearTimeout(this.waitingPoints);
    this.waitingPoints = undefined;
    if (this.element.hidden) return;
    const begin = performance.now();
    const found = this.player.page.streams.curves();
    for (const [name, { margins }] of found) if (margins && !this.playsClip) found.delete(name);
    for (const [name, { plot }] of this.streams) {
      if (found.has(name)) continue;
      plot.clear();
      plot.element.remove();
      this.streams.delete(name);
    }
    for (const [name, curves] of found) {
      const plot = this.streams.get(name)?.plot ?? this.addStream(name, curves);
      this.streams.set(name, { plot, curves });
      plot.show(
        curves.times,
        curves.lines.map((line, i) => ({
          name: line,
          colour: COLOURS[i % COLOURS.length],
          values: curves.values[i],
          limits: curves.margins ? [0] : [],
          red: curves.margins && i === 0,
          digits: curves.margins ? 1 : null,
          sign: curves.margins ? "mm" : "",
        })),
      );
    }
    this.setTime();
    this.took = performance.now() - begin;
  }

  addStream(name: string, { margins }: Curves) {
    const plot = new Plot(name, (time) => this.player.loaded && this.player.seek(time), true);
    plot.element.classList.add("stream");
    this.element[margins ? "prepend" : "append"](plot.element);
    return plot;
  }

  later() {
    if (!this.element.hidden) this.waiting ??= setTimeout(() => this.update(), PATIENCE);
  }

  update() {
    clearTimeout(this.waiting);
    this.waiting = undefined;
    const { motion, page } = this.player;
    if (this.element.hidden) return;
    this.element.classList.toggle("bare", !motion);
    // Drawn again, because their axes have the colours of the theme.
    for (const { plot } of this.streams.values()) plot.clear();
    this.drawStreams();
    if (!motion) {
      [this.joints, this.places].forEach((plot) => plot.clear());
      return this.giveWay();
    }
    const { units } = page.panel.settings;
    const columns = this.coordinates.map(({ column }) => column);
    // Those that the filter of the panel names, else those that move most.
    const sought = page.panel.joints.search.value.trim();
    const named = this.coordinates.filter(({ joint }) => matches(joint, sought)).map(({ column }) => column);
    const shown = sought ? named.slice(0, MOST_LINES) : busiest(motion, columns, MOST_LINES);
    const times = sampleTimes(motion, MOST_TIMES);
    const rows = times.map((time) => motion.at(time));
    this.drawn = this.coordinates.filter(({ column }) => shown.includes(column));
    this.joints.show(
      times,
      this.drawn.map(({ joint, column, lower, upper, unit }, i) => {
        const { scale, digits, sign } = unitOf(unit, units);
        const values = rows.map((row) => row[column] * scale);
        const limits = [lower, upper].map((limit) => (limit === null ? null : limit * scale));
        return { name: joint, colour: COLOURS[i % COLOURS.length], values, limits, digits, sign };
      }),
    );
    this.skeleton ??= new OffScreen(page.robot);
    // A straight line in joint values is a curve in space, so the path is sampled between the configurations too.
    const few = evenTimes(motion, MOST_PLACES);
    const [way] = this.skeleton.ways(motion, few, [page.robot.linkOf(this.frame)]);
    const { scale, digits, sign } = unitOf("m", units);
    this.places.show(
      few,
      (["x", "y", "z"] as const).map((axis) => {
        const values = way.map((place) => place[axis] * scale);
        return { name: axis, colour: AXES[axis], values, limits: [], digits, sign };
      }),
      `${this.frame} in ${page.robot.about.root}`,
    );
    this.setTime();
    this.giveWay();
  }

  get playsClip() {
    return this.player.loaded && this.player.playback === this.player.program;
  }

  /** The frame that is plotted: the one that the panel shows. */
  get frame() {
    return this.player.page.pick.selection.read;
  }

  /** Close plots that the program has opened if the picture has less than half the height, or shows a person too. */
  giveWay() {
    const { figure, page } = this.player;
    const small = 2 * page.pane.clientHeight < (page.pane.parentElement as HTMLElement).clientHeight;
    if (!this.asked && (small || figure)) this.open(false);
  }

  setTime() {
    const { motion, time, page } = this.player;
    if (this.element.hidden) return;
    for (const { plot, curves } of this.streams.values()) {
      const { times, values } = curves;
      const now = this.playsClip ? time : (times.at(-1) ?? 0);
      const at = Math.max(0, firstWhere(times.length, (i) => times[i] > now) - 1);
      plot.setTime(now, (line) => values[line][at] ?? NaN);
    }
    if (!motion || !this.skeleton || !this.drawn) return;
    const { units } = page.panel.settings;
    const q = motion.at(time);
    const drawn = this.drawn;
    this.joints.setTime(time, (line) => q[drawn[line].column] * unitOf(drawn[line].unit, units).scale);
    this.skeleton.apply(q);
    const pose = this.skeleton.pose(page.robot.linkOf(this.frame));
    this.places.setTime(time, (line) => pose.elements[12 + line] * unitOf("m", units).scale);
  }
}
