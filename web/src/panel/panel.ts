import type { App } from "../app.ts";
import { paintFloor } from "../scene/floor.ts";
import { Address } from "./address.ts";
import { element, button, write } from "./element.ts";
import { Exchange } from "./exchange.ts";
import { Joints } from "./joints.ts";
import { Keys, bindViewKeys, giveHint, whole } from "./keys.ts";
import { Layout } from "./layout.ts";
import { Past } from "./past.ts";
import { Postures } from "./postures.ts";
import { Readout } from "./readout.ts";
import { Settings } from "./settings.ts";
import { Head, Messages, Tools } from "./tools.ts";
import "./robots.css";
import { poseNumbers, unitText } from "../pick/facts.ts";
import { THREE } from "../three.ts";
import type { Robot } from "../robot/robot.ts";
import type { Other } from "../scene/other_robots.ts";

/** A section of the panel: its element, and its update with the robot's configuration if it needs one. */
interface Section {
  element: HTMLElement;
  refresh?(): void;
}

/** The panel beside the view. */
export class Panel {
  settings = new Settings(this.page.role === "");
  messages = new Messages(document.getElementById("message") as HTMLElement);
  exchange = new Exchange(this.page, this.messages);
  past = new Past(this.page);
  start = this.page.stance.snapshot();
  address = new Address(this);
  layout = new Layout(this.aside, document.getElementById("view") as HTMLElement, this.settings);
  keys = new Keys(this);
  joints = new Joints(this);
  readout = new Readout(this);
  /** From top to bottom; the read-out stays below the sections that scroll. */
  sections: Section[];

  constructor(
    readonly page: App,
    readonly aside: HTMLElement,
  ) {
    const head = new Head(this);
    // On a phone the filter of the joints is in the head of the panel.
    const low = matchMedia("(max-width: 47.5em) and (max-aspect-ratio: 1/1), (max-height: 32em)");
    const place = () => {
      if (low.matches) head.element.firstElementChild?.after(this.joints.filters);
      else this.joints.element.prepend(this.joints.filters);
    };
    low.addEventListener("change", place);
    place();
    this.sections = [head, new Robots(this), new Tools(this), new Postures(this), page.controls, this.joints];
    const body = element(
      "div",
      { className: "body", tabIndex: -1 },
      ...this.sections.map((section) => section.element),
    );
    this.sections.push(this.readout);
    aside.replaceChildren(this.layout.separator, body, this.readout.element);
    this.layout.announce();
    this.settings.addEventListener("units", () => {
      this.joints.relabel();
      this.refresh();
      page.pick.hover.tip.refresh();
      page.pick.measure.draw();
      page.balance.draw();
      page.viewer.set_dirty();
    });
    bindViewKeys(page);
    const paint = () => paintFloor(page.studio);
    this.settings.addEventListener("theme", paint);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
    paint();
    const skip = document.getElementById("skip") as HTMLElement;
    skip.onclick = (event) => {
      event.preventDefault();
      this.layout.fold(false);
      this.joints.element.focus();
    };
  }

  // The whole scene has arrived.
  complete() {
    // Only once: a page that reconnects to its program keeps its state.
    if (this.address.isOpen) return;
    this.start = this.page.stance.snapshot();
    this.address.open();
    giveHint(this);
  }

  reset() {
    this.page.stance.jump([...this.start.q], this.start.up);
  }

  refresh() {
    for (const section of this.sections) section.refresh?.();
  }
}

/**
 * The list of robots if a scene has several: a button looks at each, and a check box shows or hides each added robot. A line
 * says how the selected frame differs from that of the panel's own robot.
 */
export class Robots {
  page = this.panel.page;
  list = element("ul");
  element: HTMLElement;
  lines: Map<Other, HTMLOutputElement> = new Map();

  constructor(readonly panel: Panel) {
    const { name } = this.page.robot.about;
    const note = element("p", {}, `The panel moves ${name}; “Move together” in View moves the others along.`);
    this.element = element(
      "section",
      { className: "robots", ariaLabel: "Robots in the scene" },
      element("h2", {}, "Robots"),
      this.list,
      note,
    );
    this.page.addEventListener("robots", () => this.draw());
    this.page.addEventListener("selected", () => this.refresh());
    this.draw();
  }

  /** Say how the selected frame, in the root of each added robot, differs from that of the page's own robot. */
  refresh() {
    const { pick, robot } = this.page;
    const { units } = this.panel.settings;
    const frame = pick.selection.read;
    for (const [{ shown }, line] of this.lines) {
      const other = shown.robot;
      line.hidden = !other.frames.has(frame);
      if (line.hidden) continue;
      const [T_root_own, T_root_other] = [robot, other].map((one) => one.pose(one.linkOf(frame)));
      const [from, to] = [T_root_own, T_root_other].map((T) => new THREE.Vector3().setFromMatrixPosition(T));
      const turn = poseNumbers(T_root_own.invert().multiply(T_root_other)).angle;
      write(line, `${frame}: ${unitText(to.distanceTo(from), "m", units)}, ${unitText(turn, "rad", units)} apart`);
      line.title = `${to.sub(from).toArray().join(", ")} m, ${turn} rad, in the roots of both`;
    }
  }

  draw() {
    const { others, robot } = this.page;
    const added = [...others.robots].sort(([a], [b]) => a - b);
    this.element.hidden = added.length === 0;
    const names = [robot.about.name, ...added.map(([, { name }]) => name)];
    const title: (name: string, number: number) => string = (name, number) =>
      names.filter((one) => one === name).length > 1 ? `${name} (${number + 1})` : name;
    this.lines.clear();
    this.list.replaceChildren(
      this.row(robot, element("span", {}, title(robot.about.name, 0))),
      ...added.map(([number, other]) => this.added(other, title(other.name, number))),
    );
    this.refresh();
  }

  added(other: Other, name: string) {
    const box = element("input", { type: "checkbox", checked: other.visible, ariaLabel: `Show ${name}` });
    box.onchange = () => this.page.others.show(other, box.checked);
    const row = this.row(other.shown.robot, element("label", {}, box, element("span", {}, name)));
    const line = element("output", { ariaLive: "off" });
    this.lines.set(other, line);
    row.append(line);
    return row;
  }

  row(robot: Robot, label: HTMLElement) {
    const name = label.textContent ?? "";
    label.title = robot.about.name;
    const look = button("Look at", () => this.look(robot));
    look.ariaLabel = `Look at ${name}`;
    return element("li", {}, label, look);
  }

  /** Fill the view with one robot, from the current direction. */
  look(robot: Robot) {
    const { page, panel } = this;
    page.stance.settle();
    robot.root.updateWorldMatrix(true, true);
    page.look(page.preset(whole(page)), { box: () => robot.box([]) });
    panel.address.later();
  }
}
