import { rollPitchYaw } from "../math/roll_pitch_yaw.ts";
import { unitOf, withUnit, type Unit } from "../values/units.ts";
import { element } from "./element.ts";
import { frameOptions } from "./frame_options.ts";
import type { Panel } from "./panel.ts";

const LENGTHS = ["x", "y", "z"];
const ANGLES = ["roll", "pitch", "yaw"];

/** Where a frame is. */
export class Readout {
  select: HTMLSelectElement;
  numbers: Map<string, HTMLOutputElement> = new Map();
  element: HTMLElement;

  constructor(readonly panel: Panel) {
    const { about } = panel.app.robot;
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
    const { app, settings } = this.panel;
    const link = app.robot.frames.get(this.select.value);
    if (link === undefined) return;
    const pose = app.robot.pose(link);
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
