import { unitOf, withUnit } from "../values/units.js";
import { element } from "./element.js";

/** @typedef {import("../values/units.js").Choice} Choice */
/** @typedef {{ value: number, text: string, title: string }} Shown */

/** A row of numbers with their names: a rounded text each, the exact value in its tip and its data. */
export class Numbers {
  /** @param {string[]} names */
  constructor(names) {
    // Read on demand, not at every step of a motion.
    this.outputs = names.map(() => element("output", { ariaLive: "off" }));
    this.box = element(
      "div",
      { className: "numbers" },
      ...names.map((name, i) => element("div", {}, element("span", {}, name), this.outputs[i])),
    );
    this.box.style.setProperty("--columns", String(names.length > 4 ? 3 : names.length));
  }

  /** @param {Shown[]} shown */
  show(shown) {
    shown.forEach(({ value, text, title }, i) => {
      const output = this.outputs[i];
      // −0.0 is 0.0.
      output.textContent = text.replace(/^-(0(\.0*)?)(?![\d.])/, "$1");
      output.title = title;
      output.dataset.value = String(value);
    });
  }

  /** @type {(value: number, choice: Choice) => Shown} */
  static length(value, choice) {
    return { value, text: withUnit(value, unitOf("m", choice)), title: `${value} m` };
  }

  /** @type {(value: number, choice: Choice) => Shown} */
  static angle(value, choice) {
    const unit = unitOf("rad", choice);
    return { value, text: withUnit(value, unit, unit.digits + 1), title: `${value} rad` };
  }

  /** @type {(value: number) => Shown} */
  static share(value) {
    return { value, text: value.toFixed(5), title: String(value) };
  }
}
