import { clamp } from "../math/numbers.ts";
import { format, parse, spoken, stepped, stepsOfKey, type Unit } from "../values/units.ts";
import { element } from "./element.ts";

let count = 0;

/** A number in the panel: a slider between its ends, and its text, which a click, Enter or a digit turns into a field. */
export abstract class NumberRow {
  value = NaN;
  slider: HTMLInputElement;
  text = element("span", { className: "number", onclick: () => this.edit() });
  number = element("input", { type: "text", inputMode: "decimal", autocomplete: "off", hidden: true });
  note = element("span", { className: "note", id: `note-${count++}`, role: "status" });
  title = element("span", { className: "name", title: this.name }, this.name);
  low = element("span", {});
  high = element("span", {});
  sign = element("span", { className: "unit" });
  parts: HTMLElement[];

  constructor(
    readonly name: string,
    readonly ends: [number, number],
  ) {
    const [min, max] = ends.map(String);
    this.slider = element("input", { type: "range", step: "any", min, max, ariaLabel: name });
    this.slider.oninput = () => this.set(Number(this.slider.value));
    this.slider.setAttribute("aria-keyshortcuts", "Enter");
    this.slider.onkeydown = (event) => this.begin(event);
    this.number.setAttribute("aria-describedby", this.note.id);
    this.number.onfocus = () => this.number.select();
    this.number.oninput = (event) => {
      // The browser's own undo may restore the number that was there before.
      const isUndone = (event as InputEvent).inputType === "historyUndo";
      this.isTyped = !isUndone || this.number.value !== format(this.value, this.unit);
      if (Number.isFinite(parse(this.number.value, this.unit))) this.showError("");
    };
    this.number.onkeydown = (event) => this.key(event);
    this.number.onblur = () => this.commit() && this.close();
    const limits = element("span", { className: "limits", ariaHidden: "true" }, this.low, this.high);
    this.parts = [this.title, this.slider, this.text, this.number, this.sign, limits, this.note];
  }

  abstract get unit(): Unit;

  /** Set the value on behalf of the user, who drags the slider. */
  abstract set(value: number): void;

  /** The same for a user who types or presses a key. */
  put(value: number) {
    this.set(value);
  }

  /** Whether the user is typing the number. Then the page does not overwrite it, and Ctrl+Z undoes the typing. */
  get isTyped() {
    return "typed" in this.number.dataset;
  }

  set isTyped(on: boolean) {
    this.number.toggleAttribute("data-typed", on);
  }

  /** Show the field instead of the text. */
  edit() {
    this.text.hidden = true;
    this.number.hidden = false;
    this.number.focus();
  }

  /** Show the text instead of the field. */
  close() {
    this.text.hidden = false;
    this.number.hidden = true;
  }

  /** The key that begins a number opens the field, in which it is then typed; other keys step. */
  begin(event: KeyboardEvent) {
    const { key, ctrlKey, altKey, metaKey } = event;
    if (!/^([\d.,+−-]|Enter)$/.test(key) || ctrlKey || altKey || metaKey) return this.step(event);
    if (key === "Enter") event.preventDefault();
    this.edit();
  }

  /** Change the value by the steps of a key, if it has any. */
  step(event: KeyboardEvent) {
    const steps = stepsOfKey(event);
    if (Number.isNaN(steps) || event.metaKey) return;
    event.preventDefault();
    const [low, high] = this.ends;
    const value = Number.isFinite(steps) ? stepped(this.value, steps, this.unit) : steps;
    // From outside the limits a step may go back inside, but never farther out.
    this.put(clamp(value, Math.min(low, this.value), Math.max(high, this.value)));
  }

  key(event: KeyboardEvent) {
    const isBack = event.key === "Escape";
    if (isBack) this.showValue();
    if (isBack || (event.key === "Enter" && this.commit())) {
      event.preventDefault();
      this.slider.focus();
    } else if (["ArrowUp", "ArrowDown", "PageUp", "PageDown"].includes(event.key)) {
      event.preventDefault();
      if (this.commit()) this.step(event);
    }
  }

  /** Set the typed number; returns false if the text is not a number. */
  commit() {
    if (!this.isTyped) return true;
    const { unit, number } = this;
    const [low, high] = this.ends;
    const value = parse(number.value, unit);
    if (!number.value.trim()) this.showValue();
    else if (Number.isNaN(value)) {
      this.showError(`not a number; expected ${spoken(low, unit)} to ${spoken(high, unit)}`);
      return false;
    } else {
      const inside = clamp(value, low, high);
      this.put(inside);
      this.showValue();
      if (inside !== value) this.note.textContent = `the limit is ${spoken(inside, unit)}`;
    }
    return true;
  }

  showValue() {
    this.isTyped = false;
    this.showError("");
    this.number.value = this.text.textContent = format(this.value, this.unit);
    // The number stays selected, so that typing replaces it.
    if (document.activeElement === this.number) this.number.select();
  }

  /** @param reason an empty text removes the message */
  showError(reason: string) {
    this.note.textContent = reason;
    if (reason) this.number.setAttribute("aria-invalid", "true");
    else this.number.removeAttribute("aria-invalid");
  }

  /** Where a value is on the slider. */
  share(value: number) {
    const [low, high] = this.ends;
    return `${((100 * (clamp(value, low, high) - low)) / (high - low || 1)).toFixed(2)}%`;
  }

  /** @param text of the value for screen readers */
  show(value: number, text: string) {
    const { slider } = this;
    // A number that is being typed is not overwritten.
    const isKept = this.isTyped && document.activeElement === this.number;
    const isNew = value !== this.value;
    this.value = value;
    if (isNew && !isKept) this.showValue();
    slider.value = String(value);
    // Filled from zero.
    const [from, to] = value < 0 ? [value, 0] : [0, value];
    slider.style.setProperty("--from", this.share(from));
    slider.style.setProperty("--to", this.share(to));
    slider.setAttribute("aria-valuetext", text);
  }
}
