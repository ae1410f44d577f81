import "./controls.css";
import type { App } from "../app.ts";
import { clamp } from "../math/numbers.ts";
import type { Control } from "../types.ts";
import { format, spoken, type Unit } from "../values/units.ts";
import { button, div, element, select } from "./element.ts";
import { Changes } from "../reports.ts";
import { NumberRow } from "./number_row.ts";

type Of<Kind extends Control["kind"]> = Extract<Control, { kind: Kind }>;

/** The elements of a control, and the function that shows its value in them. */
interface Made {
  elements: HTMLElement[];
  show(value: any): void;
}

/** A control in the panel. */
class Row {
  value = this.control.value;
  /** Number of changes in this page. */
  count = 0;
  made = (MAKERS[this.control.kind] as (row: Row, control: Control) => Made)(this, this.control);
  element = div(`control ${this.control.kind}`, ...this.made.elements);

  constructor(
    readonly controls: Controls,
    readonly control: Control,
  ) {
    if (control.kind === "slider") this.element.classList.add("joint");
    this.show(control.value);
  }

  show(value: Control["value"]) {
    this.value = value;
    this.made.show(value);
  }

  /** Set the value on behalf of the user. */
  change(value: Control["value"]) {
    if (value !== this.value) this.controls.change(this, value);
  }
}

/** A number of a program, in a unit that the page does not know, with steps of about a hundredth of its range. */
function unitFor({ low, high, unit }: Of<"slider">): Unit {
  const power = Math.floor(Math.log10((high - low) / 50));
  const digits = clamp(1 - power, 0, 9);
  return { name: unit, sign: unit, scale: 1, digits, step: 10 ** power, open: [low, high] };
}

class Slider extends NumberRow {
  unit: Unit;

  constructor(
    readonly row: Row,
    control: Of<"slider">,
  ) {
    super(control.name, [control.low, control.high]);
    this.unit = unitFor(control);
    this.number.ariaLabel = control.name;
    this.sign.textContent = control.unit;
    [this.low.textContent, this.high.textContent] = this.ends.map((end) => format(end, this.unit));
  }

  set(value: number) {
    this.row.change(value);
  }
}

function makeSlider(row: Row, control: Of<"slider">): Made {
  const slider = new Slider(row, control);
  return { elements: slider.parts, show: (value) => slider.show(value, spoken(value, slider.unit)) };
}

function makeSelect(row: Row, { name, options }: Of<"select">): Made {
  const list = select(name, options, () => row.change(list.value));
  return { elements: [labelled(name, list)], show: (value) => (list.value = value) };
}

function makeText(row: Row, { name, edited }: Of<"text">): Made {
  if (!edited) {
    const text = element("output", {});
    return { elements: [labelled(name, text)], show: (value) => (text.textContent = value) };
  }
  const field = element("input", { type: "text", autocomplete: "off", ariaLabel: name });
  const commit = () => row.change(field.value);
  field.onblur = commit;
  field.onkeydown = ({ key }) => {
    if (key === "Enter") commit();
    if (key === "Escape") field.value = String(row.value);
  };
  // What the user is typing stays.
  const show = (value: string) => {
    if (document.activeElement !== field || !field.value) field.value = value;
  };
  return { elements: [labelled(name, field)], show };
}

function labelled(name: string, control: HTMLElement) {
  return element("label", { title: name }, element("span", {}, name), control);
}

const MAKERS: { [Kind in Control["kind"]]: (row: Row, control: Of<Kind>) => Made } = {
  button: (row, { name }) => ({
    elements: [button(name, () => row.change((row.value as number) + 1))],
    show: () => {},
  }),
  slider: makeSlider,
  select: makeSelect,
  text: makeText,
};

/**
 * The section with the controls of the program. They are disabled while no program is connected. Event of the page:
 * "placed", as of a target, when the user has changed a value.
 */
export class Controls {
  rows: Row[] = [];
  /** The values that were chosen in this page. */
  changes = new Changes<Row, Control["value"]>(this.page, (row) => this.send(row));
  list = element("fieldset", {}, element("legend", {}, "Program"));
  note = element("p", {}, "These work while their program is connected.");
  element = element("section", { className: "controls", ariaLabel: "Program", hidden: true }, this.list, this.note);

  constructor(readonly page: App) {
    const refresh = () => {
      const isLive = document.body.dataset.live === "live";
      this.list.disabled = !isLive;
      this.note.hidden = isLive;
    };
    new MutationObserver(refresh).observe(document.body, { attributeFilter: ["data-live"] });
    refresh();
  }

  /** Show these controls and no others; those that are as before, but for their values, keep their elements. */
  show(controls: Control[]) {
    const likeness = ({ value, source, ...rest }: Control) => JSON.stringify(rest);
    const known = new Map(this.rows.map((row) => [likeness(row.control), row]));
    const rows = controls.map((control) => {
      const row = known.get(likeness(control)) ?? new Row(this, control);
      const { name, value, source } = control;
      const isNews = this.page.reports.isNews(`control ${name}`, { value, source }, row.count);
      // The program gets what the user has just changed, and thus sends it back.
      if (isNews && row.value !== value && !this.changes.waiting.has(row)) row.show(value);
      return row;
    });
    const isSame = rows.length === this.rows.length && rows.every((row, i) => row === this.rows[i]);
    this.rows = rows;
    if (!isSame) this.list.replaceChildren(this.list.children[0], ...rows.map((row) => row.element));
    this.element.hidden = rows.length === 0;
  }

  /** Set a value on behalf of the user; the program is told within 1/30 s. */
  change(row: Row, value: Control["value"]) {
    const { name, kind } = row.control;
    if (kind !== "button" && !this.changes.kept.has(name)) this.changes.note(name, row.value, false);
    row.show(value);
    row.count += 1;
    if (kind === "button") return this.send(row);
    this.changes.later(row);
    this.changes.note(name, value, true);
  }

  /** Set the values to earlier ones. */
  restore(chosen: Controls["changes"]["kept"]) {
    this.changes.restore(chosen, (name, value) => {
      const row = this.rows.find(({ control }) => control.name === name);
      if (row) this.change(row, value);
    });
  }

  send({ control, value, count }: Row) {
    this.page.send({ kind: "control", name: control.name, value, source: `${this.page.reports.source} ${count}` });
  }
}
