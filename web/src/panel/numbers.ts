import { unitOf, withUnit, type Choice } from "../values/units.ts";
import { element } from "./element.ts";

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
