import type { Pick } from "../pick/pick.ts";
import type { Robot } from "../robot/robot.ts";
import { rollPitchYaw } from "../math/rotations.ts";
import { poseNumbers } from "../pick/facts.ts";
import { THREE } from "../three.ts";
import type { About } from "../types.ts";
import { unitOf, withUnit, type Choice, type Unit } from "../values/units.ts";
import { element } from "./element.ts";
import type { Panel } from "./panel.ts";
import { choose, frameSelect, nameOf, type SelectionSection } from "./selection.ts";

/** The parts of the page that are used here. */
interface Page extends EventTarget {
  readonly pick: Pick;
  readonly robot: Robot;
}

/**
 * All frames for a list to choose from, the effectors first.
 *
 * @param prefix of the values, which are the names
 */
export function frameOptions(about: About, prefix: string = "") {
  const others = about.frames.map(({ name }) => name).filter((name) => !about.effectors.includes(name));
  return [group("effectors", about.effectors, prefix), group("all frames", others, prefix)];
}

function group(label: string, names: string[], prefix: string) {
  const made = element("optgroup", { label });
  made.append(...names.map((name) => element("option", { value: `${prefix}${name}` }, name)));
  return made;
}

interface Shown {
  value: number;
  text: string;
  title: string;
}

/** A row of numbers with their names: a rounded text each, the exact value in its tip and its data. */
export class Numbers {
  outputs: HTMLOutputElement[];
  box: HTMLDivElement;

  constructor(names: string[]) {
    // Read on demand, not at every step of a motion.
    this.outputs = names.map(() => element("output", { ariaLive: "off" }));
    this.box = element(
      "div",
      { className: "numbers" },
      ...names.map((name, i) => element("div", {}, element("span", {}, name), this.outputs[i])),
    );
    this.box.style.setProperty("--columns", String(names.length > 4 ? 3 : names.length));
  }

  show(shown: Shown[]) {
    shown.forEach(({ value, text, title }, i) => {
      const output = this.outputs[i];
      // −0.0 is 0.0.
      output.textContent = text.replace(/^-(0(\.0*)?)(?![\d.])/, "$1");
      output.title = title;
      output.dataset.value = String(value);
    });
  }

  static length(value: number, choice: Choice): Shown {
    return { value, text: withUnit(value, unitOf("m", choice)), title: `${value} m` };
  }

  static angle(value: number, choice: Choice): Shown {
    const unit = unitOf("rad", choice);
    return { value, text: withUnit(value, unit, unit.digits + 1), title: `${value} rad` };
  }

  static share(value: number): Shown {
    return { value, text: value.toFixed(5), title: String(value) };
  }
}

const LENGTHS = ["x", "y", "z"];
const ANGLES = ["roll", "pitch", "yaw"];

/** Where a frame is. */
export class Readout {
  select: HTMLSelectElement;
  numbers: Map<string, HTMLOutputElement> = new Map();
  element: HTMLElement;

  constructor(readonly panel: Panel) {
    const { about } = panel.page.robot;
    this.select = element("select", { ariaLabel: "Frame" }, ...frameOptions(about));
    this.select.onchange = () => {
      this.refresh();
      panel.address.later();
    };
    const cells = [...LENGTHS, ...ANGLES].map((name) => {
      const output = element("output", { ariaLabel: name });
      // Read on demand, not at every step of a motion.
      output.setAttribute("aria-live", "off");
      this.numbers.set(name, output);
      return element("div", {}, element("span", {}, name), output);
    });
    this.element = element(
      "section",
      { className: "readout", ariaLabel: "Pose of a frame" },
      element("div", { className: "which" }, this.select, element("span", {}, `in ${about.root}`)),
      element("div", { className: "numbers" }, ...cells),
    );
  }

  refresh() {
    const { page, settings } = this.panel;
    const link = page.robot.frames.get(this.select.value);
    if (link === undefined) return;
    const pose = page.robot.pose(link);
    const lengths = unitOf("m", settings.units);
    const angles = unitOf("rad", settings.units);
    const turns = rollPitchYaw(pose);
    LENGTHS.forEach((name, i) => this.show(name, pose.elements[12 + i], lengths, `${pose.elements[12 + i]} m`));
    ANGLES.forEach((name, i) => this.show(name, turns[i], angles, `${turns[i]} rad`));
  }

  show(name: string, value: number, unit: Unit, exact: string) {
    const output = this.numbers.get(name) as HTMLOutputElement;
    const digits = unit.sign === "°" ? 2 : unit.digits;
    output.textContent = withUnit(value, unit, digits);
    output.title = exact;
    output.dataset.value = String(value);
  }
}

/** What is measured between two frames, or points of the surface: in numbers, and chosen without a pointer. */
export class MeasureCard {
  picking = element("button", { type: "button", title: "Two clicks on the robot; Escape ends it" }, "Measure");
  clear = element("button", { type: "button" }, "Clear");
  ends: HTMLSelectElement[];
  lengths = new Numbers(["distance", "dx", "dy", "dz"]);
  angle = new Numbers(["angle"]);
  relative = new Numbers(["x", "y", "z", "roll", "pitch", "yaw"]);
  relativeTitle = element("p", { className: "title" });
  frames: HTMLDivElement;
  results: HTMLDivElement;
  box: HTMLDivElement;

  /** @param selection that knows the reference */
  constructor(
    readonly page: Page,
    readonly selection: SelectionSection,
  ) {
    const { measure } = page.pick;
    this.picking.onclick = () => measure.setPicking(!measure.picking);
    this.clear.onclick = () => measure.clear();
    this.ends = ["Measure from", "Measure to"].map((label, i) => {
      const select = frameSelect(label, page.robot.about, [["", "a point or frame"]]);
      select.onchange = () => measure.set(i, select.value === "" ? null : { kind: "frame", name: nameOf(select) });
      return select;
    });
    this.frames = element("div", {}, this.angle.box, this.relativeTitle, this.relative.box);
    this.results = element("div", { className: "results" }, this.lengths.box, this.frames);
    const [from, to] = this.ends;
    const buttons = element("div", { className: "copies" }, this.picking, this.clear);
    const which = element("div", { className: "which" }, from, element("span", {}, "to"), to);
    this.box = element("div", { className: "measure" }, buttons, which, this.results);
    page.addEventListener("measured", () => {
      const details = this.box.closest("details");
      if (details && measure.active) details.open = true;
      this.refresh();
    });
  }

  refresh() {
    const { measure } = this.page.pick;
    const { about } = this.page.robot;
    this.picking.setAttribute("aria-pressed", String(measure.picking));
    this.clear.hidden = !measure.active;
    measure.ends.forEach((end, i) => {
      const select = this.ends[i];
      choose(select, end?.kind === "frame" ? end.name : null);
      const text = end?.kind === "point" ? `a point on ${about.links[end.link].name}` : "a point or frame";
      if (select.options[0].text !== text) select.options[0].text = text;
    });
    const [a, b] = measure.ends;
    this.results.hidden = !a || !b;
    if (!a || !b) return;
    const [T_root_a, T_root_b] = [measure.pose(a), measure.pose(b)];
    const [from, to] = [T_root_a, T_root_b].map((pose) => new THREE.Vector3().setFromMatrixPosition(pose));
    const toReference = this.selection.referencePose().invert();
    const difference = to.applyMatrix4(toReference).sub(from.applyMatrix4(toReference));
    this.lengths.show(this.selection.poseShown([difference.length(), ...difference.toArray()], []));
    this.frames.hidden = a.kind !== "frame" || b.kind !== "frame";
    if (a.kind !== "frame" || b.kind !== "frame") return;
    const { position, rpy, angle } = poseNumbers(T_root_a.invert().multiply(T_root_b));
    this.angle.show(this.selection.poseShown([], [angle]));
    this.relativeTitle.textContent = `${b.name} in ${a.name}`;
    this.relative.show(this.selection.poseShown(position, rpy));
  }
}
