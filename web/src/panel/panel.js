// @ts-nocheck
import { rollPitchYaw } from "../math/roll_pitch_yaw.js";
import { element } from "./element.js";
import { SelectionSection } from "./selection.js";
import { DECIMAL, UNITS } from "./units.js";

// The panel beside the view: postures, one slider per joint, and where an effector is.
export class Panel {
  constructor(app, aside) {
    this.app = app;
    this.robot = app.robot;
    const { about } = this.robot;
    this.rows = [];
    const shown = about.chains.flatMap(({ joints }) => joints).filter(({ follows }) => follows);
    this.followers = new Map(shown.map(({ name, follows }) => [follows, name]));
    this.state = element("span", { className: "state" });
    const freedoms = about.coordinates.length;
    const notes = element("p", { className: "notes", hidden: about.notes.length === 0 }, about.notes.join("; "));
    aside.replaceChildren(
      element(
        "header",
        {},
        element("h1", {}, about.name),
        element("p", {}, `${freedoms} degree${freedoms === 1 ? "" : "s"} of freedom`, this.state),
        notes,
      ),
      this.postures(about),
      element("section", { className: "joints" }, ...about.chains.map((chain) => this.chain(chain))),
      this.readout(about),
      new SelectionSection(app).section,
    );
  }

  postures(about) {
    const buttons = about.postures.map((posture) =>
      element("button", { type: "button", onclick: () => this.app.posture(posture.name) }, posture.name),
    );
    return element("section", { className: "postures", ariaLabel: "Postures" }, ...buttons);
  }

  chain({ title, joints }) {
    const summary = element("summary", {}, title);
    return element("details", { open: true }, summary, ...joints.map((joint) => this.row(joint)));
  }

  row(joint) {
    const coordinate = this.robot.about.coordinates.find(({ column }) => column === joint.column);
    const unit = UNITS[coordinate.unit] ?? UNITS.rad;
    const bounds = [coordinate.lower ?? unit.open[0], coordinate.upper ?? unit.open[1]]
      .map((value) => joint.multiplier * value + joint.offset)
      .sort((a, b) => a - b);
    const slider = element("input", {
      type: "range",
      step: "any",
      min: bounds[0],
      max: bounds[1],
      ariaLabel: joint.name,
    });
    const number = element("input", { type: "text", inputMode: "decimal", ariaLabel: `${joint.name} in ${unit.name}` });
    const label = element("span", { className: "name" }, joint.name);
    const partner = joint.follows || this.followers.get(joint.name);
    if (partner) label.append(element("i", { title: `One motor with ${partner}` }, "⚭"));
    const row = element(
      "label",
      { className: "joint" },
      label,
      slider,
      number,
      element("span", { className: "unit" }, unit.sign),
    );
    row.dataset.joint = joint.name;
    const set = (value) => {
      const coordinateValue =
        joint.multiplier === 0 ? this.app.q[joint.column] : (value - joint.offset) / joint.multiplier;
      this.app.move(joint.column, coordinateValue);
    };
    slider.oninput = () => set(Number(slider.value));
    number.onfocus = () => number.select();
    number.onchange = () => {
      const text = number.value.trim().replace(",", ".");
      const value = DECIMAL.test(text) ? Number(text) / unit.scale : NaN;
      if (Number.isFinite(value)) set(Math.min(Math.max(value, bounds[0]), bounds[1]));
      this.refresh(number);
    };
    // A handler that gives false takes the key away from the field: braces, so that this one gives nothing.
    number.onkeydown = ({ key }) => {
      if (key === "Enter") number.blur();
    };
    this.rows.push({ joint, coordinate, unit, slider, number, row, bounds });
    return row;
  }

  readout(about) {
    const option = (name) => element("option", { value: name }, name);
    const group = (label, names) => {
      const made = element("optgroup", { label });
      made.append(...names.map(option));
      return made;
    };
    const others = about.frames.map(({ name }) => name).filter((name) => !about.effectors.includes(name));
    this.select = element(
      "select",
      { ariaLabel: "Frame" },
      group("effectors", about.effectors),
      group("all frames", others),
    );
    this.select.onchange = () => this.refresh();
    this.numbers = new Map();
    const cells = ["x", "y", "z", "roll", "pitch", "yaw"].map((name) => {
      const output = element("output");
      this.numbers.set(name, output);
      return element("div", {}, element("span", {}, name), output);
    });
    return element(
      "section",
      { className: "readout" },
      element("div", { className: "which" }, this.select, element("span", {}, `in ${about.root}`)),
      element("div", { className: "numbers" }, ...cells),
    );
  }

  // What is being typed is left alone, unless it is `finished`.
  refresh(finished = null) {
    const { q } = this.app;
    const outside = this.robot.outside(q);
    for (const { joint, coordinate, unit, slider, number, row, bounds } of this.rows) {
      const value = joint.multiplier * q[joint.column] + joint.offset;
      slider.value = value;
      if (document.activeElement !== number || number === finished) {
        number.value = (value * unit.scale).toFixed(unit.digits).replace(/^-(0(\.0*)?)$/, "$1");
      }
      const share = (x) =>
        `${(100 * (Math.min(Math.max(x, bounds[0]), bounds[1]) - bounds[0])) / (bounds[1] - bounds[0] || 1)}%`;
      const [from, to] = [share(0), share(value)];
      slider.style.setProperty("--from", parseFloat(from) < parseFloat(to) ? from : to);
      slider.style.setProperty("--to", parseFloat(from) < parseFloat(to) ? to : from);
      const isOutside = outside.has(joint.column);
      row.classList.toggle("outside", isOutside);
      const [low, high] = this.robot.range(coordinate, q).map((x) => (x * unit.scale).toFixed(unit.digits));
      row.title = isOutside ? `outside ${low} … ${high} ${unit.sign}` : "";
    }
    this.locate();
  }

  locate() {
    const link = this.robot.frames.get(this.select.value);
    if (link === undefined) return;
    const pose = this.robot.pose(link);
    const [x, y, z] = [12, 13, 14].map((i) => pose.elements[i]);
    const angles = rollPitchYaw(pose);
    const show = (name, value, text, exact) => {
      const output = this.numbers.get(name);
      output.textContent = text.replace(/^-(0(\.0*)?)( |°|$)/, "$1$3");
      output.title = exact;
      output.dataset.value = value;
    };
    for (const [name, value] of [
      ["x", x],
      ["y", y],
      ["z", z],
    ]) {
      show(name, value, `${(1000 * value).toFixed(1)} mm`, `${value} m`);
    }
    ["roll", "pitch", "yaw"].forEach((name, i) =>
      show(name, angles[i], `${((angles[i] * 180) / Math.PI).toFixed(2)}°`, `${angles[i]} rad`),
    );
  }
}
