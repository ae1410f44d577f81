import { rollPitchYaw } from "../math/roll_pitch_yaw.js";
import { unitOf, withUnit } from "../values/units.js";
import { element } from "./element.js";
import { frameOptions } from "./frame_options.js";

const LENGTHS = ["x", "y", "z"];
const ANGLES = ["roll", "pitch", "yaw"];

/** Where a frame is. */
export class Readout {
  /** @param {import("./panel.js").Panel} panel */
  constructor(panel) {
    this.panel = panel;
    const { about } = panel.app.robot;
    this.select = element("select", { ariaLabel: "Frame" }, ...frameOptions(about));
    this.select.onchange = () => {
      this.refresh();
      panel.address.later();
    };
    /** @type {Map<string, HTMLOutputElement>} */
    this.numbers = new Map();
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

  /**
   * @param {string} name
   * @param {number} value
   * @param {import("../values/units.js").Unit} unit
   * @param {string} exact
   */
  show(name, value, unit, exact) {
    const output = /** @type {HTMLOutputElement} */ (this.numbers.get(name));
    const digits = unit.sign === "°" ? 2 : unit.digits;
    output.textContent = withUnit(value, unit, digits);
    output.title = exact;
    output.dataset.value = String(value);
  }
}
