import "./readout.css";
import { fixed } from "../math/numbers.ts";
import { COPIES, poseNumbers, unitText } from "../pick/facts.ts";
import { THREE } from "../three.ts";
import type { Targets } from "../drag/targets.ts";
import type { About } from "../types.ts";
import { unitOf, withUnit, type Choice } from "../values/units.ts";
import { differences } from "../values/configurations.ts";
import { BodyState } from "./body_state.ts";
import { button, div, element, iconButton } from "./element.ts";
import type { Panel } from "./panel.ts";

/**
 * A select with all frames, the effectors first, after some entries that are not frames.
 *
 * @param places value and text of the entries that are not frames
 */
function frameSelect(label: string, about: About, places: [string, string][] = []) {
  const others = about.frames.map(({ name }) => name).filter((name) => !about.effectors.includes(name));
  const group = (title: string, names: string[]) => {
    const made = element("optgroup", { label: title });
    // The prefix tells a frame from the other entries: a frame may be named "floor".
    made.append(...names.map((name) => element("option", { value: `frame:${name}` }, name)));
    return made;
  };
  const select = element("select", { ariaLabel: label });
  select.append(...places.map(([value, text]) => element("option", { value }, text)));
  select.append(group("effectors", about.effectors), group("all frames", others));
  return select;
}

const nameOf = ({ value }: HTMLSelectElement) => value.slice("frame:".length);

interface Shown {
  name: string;
  value: number;
  text: string;
  title: string;
}

const length = (name: string, value: number, choice: Choice): Shown => ({
  name,
  value,
  text: withUnit(value, unitOf("m", choice)),
  title: `${value} m`,
});

function angle(name: string, value: number, choice: Choice): Shown {
  const unit = unitOf("rad", choice);
  return { name, value, text: withUnit(value, unit, unit.digits + 1), title: `${value} rad` };
}

const share = (name: string, value: number): Shown => ({
  name,
  value,
  text: fixed(value, 5),
  title: String(value),
});

/** Rows of named numbers: each shows a rounded text, and its tool tip and data hold the exact value. */
class Numbers {
  cells = Array.from({ length: this.count }, () => ({
    name: element("span", { ariaHidden: "true" }),
    // Screen readers read it on demand, not at every step of a motion.
    output: element("output", { ariaLive: "off" }),
  }));
  box = div("numbers", ...this.cells.map(({ name, output }) => element("div", {}, name, output)));

  constructor(
    readonly count: number,
    columns: number,
  ) {
    this.box.style.setProperty("--columns", String(columns));
  }

  /** @param shown null leaves a cell empty */
  show(shown: (Shown | null)[]) {
    this.cells.forEach(({ name, output }, i) => {
      const cell = shown[i];
      name.textContent = cell?.name ?? "";
      output.ariaLabel = cell?.name ?? null;
      // Write −0.0 as 0.0.
      output.textContent = cell?.text.replace(/^-(0(\.0*)?)(?![\d.])/, "$1") ?? "";
      output.title = cell?.title ?? "";
      output.dataset.value = String(cell?.value ?? "");
    });
  }
}

/** The card under the panel that shows what was clicked last: the pose of a frame in another one, or a measurement. */
export class Readout {
  /** Whether it shows a measurement. */
  measuring = false;
  /** Whether the frame is the root of a robot that stands. */
  isRoot = false;
  /** Whether it shows the rotation in more forms. */
  open = false;
  frame: HTMLSelectElement;
  reference: HTMLSelectElement;
  ends: HTMLSelectElement[];
  measure: HTMLButtonElement;
  more = iconButton("more", "Quaternion, axis and angle, copying, centre of mass", () => {
    this.open = !this.open;
    this.refresh();
  });
  /** The elements for measuring only. */
  line: HTMLElement[];
  numbers = new Numbers(6, 3);
  rotation = new Numbers(8, 4);
  state = new BodyState(this.panel);
  centre = new Numbers(6, 3);
  /** The difference to a ghost or to the last posture: the joints that differ most, and the way of the frame. */
  difference = new Numbers(6, 3);
  compared = element("h3");
  apart = div("apart", this.compared, this.difference.box);
  /** More of a pose: the rotation in other forms, the buttons that copy it, and the centre of mass. */
  rest = element(
    "div",
    { className: "rest", id: "rest-of-pose" },
    this.rotation.box,
    div(
      "copies",
      "Copy",
      ...COPIES.map(({ name, title, text }) => {
        const copy = button(name, () => void this.panel.exchange.copy(text(poseNumbers(this.pose)), name));
        copy.title = title;
        return copy;
      }),
    ),
    this.centre.box,
  );
  element: HTMLElement;

  constructor(readonly panel: Panel) {
    const { page } = panel;
    const { about } = page.robot;
    const { selection, measure } = page.pick;
    this.frame = frameSelect("Frame", about);
    this.frame.onchange = () => selection.select(nameOf(this.frame));
    const places: [string, string][] = [["root", about.root]];
    if (!about.floating) places.push(["floor", "floor"]);
    this.reference = frameSelect("Reference frame", about, places);
    this.reference.onchange = () => this.refresh();
    this.ends = ["Measure from", "Measure to"].map((label, i) => {
      const select = frameSelect(label, about, [["", ""]]);
      select.onchange = () => measure.set(i, select.value === "" ? null : { kind: "frame", name: nameOf(select) });
      return select;
    });
    this.measure = iconButton("measure", "Measure", () =>
      this.measuring ? measure.clear() : measure.setPicking(true),
    );
    this.measure.title = "Measure: two clicks on the robot; Escape ends it";
    this.more.setAttribute("aria-controls", this.rest.id);
    const [from, to] = this.ends;
    this.line = [from, element("span", {}, "to"), to];
    const place = element("label", {}, "in", this.reference);
    this.element = element(
      "section",
      { className: "readout", ariaLabel: "Pose of a frame, or a measurement" },
      div("which", this.frame, ...this.line, place, element("div", {}, this.measure, this.more)),
      this.numbers.box,
      this.apart,
      this.rest,
      this.state.element,
    );
    const follow = (measuring: boolean) => {
      this.measuring = measuring;
      // The root would have the same pose in itself for ever.
      const wasRoot = this.isRoot;
      this.isRoot = !about.floating && selection.read === about.root;
      const { value } = this.reference;
      if (this.isRoot !== wasRoot && value === (wasRoot ? "floor" : "root")) {
        this.reference.value = wasRoot ? "root" : "floor";
      }
      this.refresh();
    };
    page.addEventListener("selected", () => follow(false));
    page.addEventListener("measured", () => follow(measure.active));
    page.addEventListener("shown", () => this.refresh());
    this.refresh();
  }

  /** Pose of the reference frame in the robot's root. */
  get T_root_reference() {
    const { robot } = this.panel.page;
    return this.referenceIn((link) => robot.pose(link), robot.placement()) as THREE.Matrix4;
  }

  /** Pose of the frame in the reference. */
  get pose() {
    const { robot } = this.panel.page;
    return this.poseIn((link) => robot.pose(link), robot.placement()) as THREE.Matrix4;
  }

  /**
   * Pose of the reference frame in the root of a robot in any configuration.
   *
   * @param poses of the links in the root
   * @param place of the root in the scene; null if it is not known, and the result is null if that matters
   */
  private referenceIn(poses: (link: number) => THREE.Matrix4, place: THREE.Matrix4 | null) {
    const { value } = this.reference;
    if (value === "root") return new THREE.Matrix4();
    if (value === "floor") return place && place.clone().invert();
    return poses(this.panel.page.robot.linkOf(nameOf(this.reference)));
  }

  private poseIn(poses: (link: number) => THREE.Matrix4, place: THREE.Matrix4 | null) {
    const { robot, pick } = this.panel.page;
    const T_root_reference = this.referenceIn(poses, place);
    return T_root_reference && T_root_reference.invert().multiply(poses(robot.linkOf(pick.selection.read)));
  }

  refresh() {
    const { measuring, open } = this;
    this.element.classList.toggle("measuring", measuring);
    this.element.classList.toggle("open", open);
    this.measure.setAttribute("aria-pressed", String(measuring));
    this.more.setAttribute("aria-expanded", String(open));
    // A hidden element would lose the focus.
    if (!measuring && this.line.some((part) => part === document.activeElement)) this.measure.focus();
    for (const part of this.line) part.hidden = !measuring;
    for (const part of [this.frame, this.more]) part.hidden = measuring;
    this.rest.hidden = measuring || !open;
    if (measuring) this.showMeasured();
    else this.showPose();
    this.showDifference();
    this.state.refresh();
    if (!this.rest.hidden) this.showCentre();
  }

  showPose() {
    const { units } = this.panel.settings;
    this.frame.value = `frame:${this.panel.page.pick.selection.read}`;
    const { position, rpy, quaternion, axis, angle: turn } = poseNumbers(this.pose);
    this.numbers.show([
      ...["x", "y", "z"].map((name, i) => length(name, position[i], units)),
      ...["roll", "pitch", "yaw"].map((name, i) => angle(name, rpy[i], units)),
    ]);
    if (!this.open) return;
    this.rotation.show([
      ...quaternion.map((value, i) => share(`r${i}`, value)),
      angle("angle", turn, units),
      ...axis.map((value, i) => share(`e${i + 1}`, value)),
    ]);
  }

  /** Show the centre of mass in the reference frame, its margin, and how far the robot can be tilted. */
  showCentre() {
    const { page, settings } = this.panel;
    const centre = page.robot.com()?.applyMatrix4(this.T_root_reference.invert()).toArray() ?? null;
    const { margin, tilt } = this.state.hasFeet ? page.balance.stand : { margin: NaN, tilt: NaN };
    const tips = Number.isNaN(tilt) ? null : angle(`tips ${this.state.way}`.trim(), tilt, settings.units);
    if (tips) tips.title += ", the angle by which the robot can be tilted before it tips";
    this.centre.show([
      ...["x", "y", "z"].map((name, i) => centre && length(`CoM ${name}`, centre[i], settings.units)),
      Number.isNaN(margin) ? null : length("margin", margin, settings.units),
      tips,
    ]);
  }

  /** Show how far the frame is from the target of its name. */
  showMiss({ row, node }: Targets["list"][0]) {
    const { pick, robot } = this.panel.page;
    this.apart.hidden = this.measuring;
    const found = this.between(node.matrix, robot.pose(robot.linkOf(pick.selection.read)), !row.point);
    this.compared.textContent = `From the target of ${row.name}: ${found.flatMap((cell, i) => (cell && i < 2 ? cell.text : [])).join(", ")}`;
    this.difference.show(found);
  }

  /** The distance between the origins of two poses in the robot's root, the angle between their axes, and the way. */
  between(T_root_a: THREE.Matrix4, T_root_b: THREE.Matrix4, turns: boolean) {
    const { units } = this.panel.settings;
    const T_reference_root = this.T_root_reference.invert();
    const [from, to] = [T_root_a, T_root_b].map((T) =>
      new THREE.Vector3().setFromMatrixPosition(T_reference_root.clone().multiply(T)),
    );
    const way = to.sub(from);
    return [
      length("distance", way.length(), units),
      turns ? angle("angle", poseNumbers(T_root_a.clone().invert().multiply(T_root_b)).angle, units) : null,
      null,
      ...way.toArray().map((value, i) => length(["Δx", "Δy", "Δz"][i], value, units)),
    ];
  }

  /** Show how the robot differs from the ghost, or, with more of the pose, from the posture chosen last. */
  showDifference() {
    const { ghosts, pick, robot, stance, targets } = this.panel.page;
    const { units } = this.panel.settings;
    const posture = this.open ? stance.chosen : null;
    const compared = ghosts?.group.visible ? ghosts.compared : null;
    const aim = targets?.list.find((target) => target.row.name === pick.selection.read && targets.isAim(target));
    if (aim && !compared) return this.showMiss(aim);
    const [name, q] = compared ? ["the ghost", compared] : [posture?.name ?? "", posture?.q ?? null];
    const found = q ? differences(robot.about, q, robot.q) : [];
    this.apart.hidden = this.measuring || found.length === 0;
    if (this.apart.hidden || !q) return;
    ghosts.skeleton.apply(q);
    const [now, then] = [
      this.pose,
      this.poseIn((link) => ghosts.skeleton.pose(link), compared ? ghosts.place : null),
    ].map((T) => T && new THREE.Vector3().setFromMatrixPosition(T));
    const way = now && then ? now.sub(then) : null;
    const count = found.length === 1 ? "1 joint" : `${found.length} joints`;
    this.compared.textContent = `From ${name}: ${count}${way ? `, ${pick.selection.read} ${length("", way.length(), units).text}` : ""}`;
    this.compared.title = found.map(({ joint, unit, value }) => `${joint} ${unitText(value, unit, units)}`).join("\n");
    const largest = found.slice(0, 3).map(({ joint, unit, value }) => ({
      name: joint,
      value,
      text: unitText(value, unit, units),
      title: `${joint} ${value}`,
    }));
    this.difference.show([
      ...[0, 1, 2].map((i) => largest[i] ?? null),
      ...(way?.toArray() ?? []).map((value, i) => length(["Δx", "Δy", "Δz"][i], value, units)),
    ]);
  }

  showMeasured() {
    const { page } = this.panel;
    const { measure } = page.pick;
    measure.ends.forEach((end, i) => {
      const select = this.ends[i];
      const { link } = end?.kind === "point" ? end : { link: null };
      const text = link === null ? "click on a point" : `a point on ${page.robot.about.links[link].title}`;
      if (select.options[0].text !== text) select.options[0].text = text;
      select.value = end?.kind === "frame" ? `frame:${end.name}` : "";
    });
    const [a, b] = measure.ends;
    if (!a || !b) return this.numbers.show([]);
    this.numbers.show(this.between(measure.pose(a), measure.pose(b), a.kind === "frame" && b.kind === "frame"));
  }
}
