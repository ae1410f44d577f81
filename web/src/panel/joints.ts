import { clamp } from "../math/numbers.ts";
import { joints as carriers } from "../pick/facts.ts";
import type { Coordinate, Driven } from "../types.ts";
import { matches } from "../values/names.ts";
import { format, spoken, unitOf } from "../values/units.ts";
import { div, element, write } from "./element.ts";
import { NumberRow } from "./number_row.ts";
import type { Panel } from "./panel.ts";

// Width of a slider's thumb, and the distance from its middle within which a finger grabs it [px].
const [THUMB, FINGER] = [22, 22];

/** A range of the coordinate as one of the joint. */
function ofJoint({ multiplier, offset }: Driven, range: [number, number]): [number, number] {
  const [a, b] = range.map((value) => (multiplier === 0 ? 0 : multiplier * value) + offset);
  return a <= b ? [a, b] : [b, a];
}

/** One joint of the panel. */
class JointRow extends NumberRow {
  coordinate: Coordinate;
  isCoupled: boolean;
  element = div("joint", ...this.parts);

  /** @param partner the joint that shares its motor, if there is one */
  constructor(
    readonly panel: Panel,
    readonly joint: Driven,
    partner: string,
  ) {
    const { about } = panel.page.robot;
    const coordinate = about.coordinates.find(({ column }) => column === joint.column) as Coordinate;
    const { open } = unitOf(coordinate.unit, panel.settings.units);
    super(joint.name, ofJoint(joint, [coordinate.lower ?? open[0], coordinate.upper ?? open[1]]));
    this.coordinate = coordinate;
    this.isCoupled = about.tables.some((table) => table.joint === joint.column);
    if (partner) this.title.append(element("i", { title: `Shares one motor with ${partner}` }, "⚭"));
    this.element.dataset.joint = joint.name;
    this.element.onpointerdown = (event) => this.hold(event);
    this.element.ondblclick = ({ target }) => {
      if (target !== this.number && target !== this.text) this.reset();
    };
    // Also for the keyboard: the row whose slider or number it has reached.
    const light = (on: boolean) => panel.page.pick.hover.showJoint(on ? joint.name : null);
    this.element.onpointerenter = ({ pointerType }) => pointerType !== "touch" && light(true);
    this.element.onpointerleave = () => light(false);
    this.element.addEventListener("focusin", () => this.element.querySelector(":focus-visible") && light(true));
    this.element.addEventListener("focusout", () => light(false));
    this.slider.onkeydown = (event) => {
      const isReset = ["Delete", "Backspace"].includes(event.key);
      if (isReset) event.preventDefault();
      if (isReset) this.reset();
      else this.begin(event);
    };
    this.relabel();
  }

  get unit() {
    return unitOf(this.coordinate.unit, this.panel.settings.units);
  }

  set(value: number) {
    const { multiplier, offset, column } = this.joint;
    if (multiplier !== 0) this.panel.page.stance.move(column, (value - offset) / multiplier);
  }

  put(value: number) {
    this.set(value);
    this.panel.page.stance.settle();
  }

  /**
   * Move the slider with a finger on its thumb, starting from the current value. The slider itself ignores touches, which
   * go to the row, because it would jump to the place where a swipe over the panel begins. If the swipe turns out to scroll
   * the panel, the old value is restored.
   */
  hold({ clientX, clientY, isPrimary, pointerId, target }: PointerEvent) {
    const { element: row, ends, joint, slider, value } = this;
    const { stance } = this.panel.page;
    const [low, high] = ends;
    const { left, top, bottom, width } = slider.getBoundingClientRect();
    const perPixel = (high - low) / (width - THUMB);
    const thumb = left + THUMB / 2 + (clamp(value, low, high) - low) / perPixel;
    const isOn = Math.abs(clientX - thumb) <= FINGER && clientY > top && clientY < bottom;
    if (target === slider || !isPrimary || !isOn) return;
    const before = stance.q[joint.column];
    row.setPointerCapture(pointerId);
    row.onpointermove = (event) => {
      const wanted = value + (event.clientX - clientX) * perPixel;
      this.set(clamp(wanted, Math.min(low, value), Math.max(high, value)));
    };
    row.onpointercancel = () => stance.move(joint.column, before);
    row.onlostpointercapture = () => (row.onpointermove = row.onpointercancel = null);
  }

  /** Restore the value of the posture chosen last, or of the neutral configuration. */
  reset() {
    const { robot, stance } = this.panel.page;
    const { column } = this.joint;
    stance.move(column, (stance.chosen?.q ?? robot.about.neutral)[column]);
    stance.settle();
  }

  // --- display -------------------------------------------------------------------------------------------------

  // Write the row again, after the unit has changed.
  relabel() {
    this.isTyped = false;
    const { unit, ends, coordinate } = this;
    this.number.ariaLabel = `${this.joint.name} in ${unit.name}`;
    this.sign.textContent = unit.sign;
    const isOpen = [coordinate.lower === null, coordinate.upper === null];
    [this.low, this.high].forEach((end, i) => {
      end.textContent = isOpen[i] ? "" : format(ends[i], unit);
    });
    this.value = NaN;
  }

  refresh(q: ArrayLike<number>, isOutside: boolean) {
    const { slider, joint, unit } = this;
    const value = joint.multiplier * q[joint.column] + joint.offset;
    if (value === this.value && !this.isCoupled) return;
    const range = ofJoint(joint, this.panel.page.robot.range(this.coordinate, q));
    this.show(value, this.said(value, range, isOutside));
    if (this.isCoupled) {
      slider.style.setProperty("--low", this.share(range[0]));
      slider.style.setProperty("--high", this.share(range[1]));
    }
    this.element.classList.toggle("outside", isOutside);
    const [low, high] = range.map((x) => spoken(clamp(x, -1e6, 1e6), unit));
    this.element.title = isOutside ? `outside ${low} … ${high}` : "";
  }

  said(value: number, range: [number, number], isOutside: boolean) {
    const { unit, ends, coordinate } = this;
    const between = ([low, high]: [number, number]) => `from ${spoken(low, unit)} to ${spoken(high, unit)}`;
    const parts = [spoken(value, unit)];
    if (coordinate.lower !== null && coordinate.upper !== null) parts.push(between(ends));
    if (this.isCoupled) parts.push(`here ${between(range)}`);
    if (isOutside) parts.push("outside its limits");
    return parts.join(", ");
  }
}

/** The joints by chain, one slider each, and a field that filters them. */
export class Joints {
  rows: JointRow[] = [];
  chains: { rows: JointRow[]; details: HTMLDetailsElement }[];
  search = element("input", { type: "search", placeholder: "Filter joints", ariaLabel: "Filter joints" });
  count = element("output", { className: "count" });
  filters = div("search", this.search, this.count);
  none = element("p", { role: "status", hidden: true });
  element: HTMLElement;
  /** The row of the joint that carries the selected frame. */
  marked: JointRow | undefined;

  constructor(readonly panel: Panel) {
    const { chains } = panel.page.robot.about;
    const shown = chains.flatMap(({ joints }) => joints).filter(({ follows }) => follows);
    const followers = new Map(shown.map(({ name, follows }) => [follows, name]));
    this.chains = chains.map(({ title, joints }) => {
      const rows = joints.map((joint) => {
        const row = new JointRow(panel, joint, joint.follows || followers.get(joint.name) || "");
        this.rows.push(row);
        return row;
      });
      const summary = element("summary", {}, title);
      return { rows, details: element("details", { open: true }, summary, ...rows.map((row) => row.element)) };
    });
    this.search.oninput = () => this.filter();
    this.search.onkeydown = (event) => {
      if (event.key !== "Escape" || !this.search.value) return;
      event.preventDefault();
      this.search.value = "";
      this.filter();
    };
    this.element = element(
      "section",
      { className: "joints", id: "joints", tabIndex: -1, ariaLabel: "Joints" },
      this.filters,
      this.none,
      ...this.chains.map(({ details }) => details),
    );
    this.element.hidden = this.rows.length === 0;
    panel.page.addEventListener("selected", () => this.mark());
    this.filter();
  }

  /** Mark the last joint that carries the selected frame, and scroll to it. */
  mark() {
    const { pick, robot } = this.panel.page;
    const { frame, link, read } = pick.selection;
    const names = link === null ? [] : carriers(robot.about, link).map(({ name }) => name);
    const rows = names.flatMap((name) => this.rows.find(({ joint }) => joint.name === name) ?? []);
    this.marked?.element.removeAttribute("aria-current");
    this.marked = rows.at(-1);
    const row = this.marked?.element;
    row?.setAttribute("aria-current", "true");
    // The read-out may have chosen another frame since.
    if (!row || read !== frame) return;
    if (row.hidden) this.search.value = "";
    this.filter();
    (row.parentElement as HTMLDetailsElement).open = true;
    row.scrollIntoView({ block: "nearest" });
  }

  filter() {
    const sought = this.search.value.trim();
    let found = 0;
    for (const { rows, details } of this.chains) {
      const here = rows.filter((row) => (row.element.hidden = !matches(row.joint.name, sought)) === false);
      details.hidden = here.length === 0;
      if (sought && here.length > 0) details.open = true;
      found += here.length;
    }
    write(this.none, found === 0 ? `No joint is called “${sought}”.` : "");
    const all = this.rows.length;
    this.count.textContent = sought ? `${found} of ${all}` : "";
  }

  refresh() {
    const { robot, shown } = this.panel.page;
    for (const row of this.rows) row.refresh(robot.q, shown.outside.has(row.joint.column));
  }

  relabel() {
    for (const row of this.rows) row.relabel();
    this.refresh();
  }
}
