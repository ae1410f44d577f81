import "./selection.css";
import { COPIES, poseNumbers } from "../pick/facts.ts";
import { referencePose, type Pick } from "../pick/pick.ts";
import type { Robot } from "../robot/robot.ts";
import type { About } from "../types.ts";
import { copyText, element } from "./element.ts";
import { MeasureCard, Numbers, frameOptions } from "./readout.ts";
import type { Settings } from "./settings.ts";

/** The parts of the page that are used here. */
interface Page extends EventTarget {
  readonly pick: Pick;
  readonly robot: Robot;
}

type Reference = { kind: "root" } | { kind: "floor" } | { kind: "frame"; name: string };

/** The selected frame in the panel: its pose in any frame, to read and to copy; and what is measured. */
export class SelectionSection {
  frame: HTMLSelectElement;
  reference: HTMLSelectElement;
  numbers = new Numbers(["x", "y", "z", "roll", "pitch", "yaw"]);
  quaternion = new Numbers(["r0", "r1", "r2", "r3"]);
  turn = new Numbers(["angle", "e1", "e2", "e3"]);
  said = element("p", { className: "said" });
  copies: HTMLDivElement;
  pose: HTMLDivElement;
  measure: MeasureCard;
  element: HTMLDetailsElement;

  constructor(
    readonly page: Page,
    readonly settings: Settings,
  ) {
    const { about } = page.robot;
    this.frame = frameSelect("Selected frame", about, [["", "none selected"]]);
    this.frame.onchange = () => page.pick.selection.select(this.frame.value === "" ? null : nameOf(this.frame));
    // A name of a frame is a text in the list, never a value with a meaning of its own.
    const places: [string, string][] = [["root", about.root]];
    if (!about.floating) places.push(["floor", "the floor under the robot"]);
    this.reference = frameSelect("Reference frame", about, places);
    this.reference.onchange = () => this.refresh();
    this.said.setAttribute("role", "status");
    this.copies = element("div", { className: "copies" }, element("span", {}, "Copy"), ...this.copyButtons());
    this.pose = element(
      "div",
      { className: "pose" },
      this.numbers.box,
      this.quaternion.box,
      this.turn.box,
      this.copies,
    );
    this.measure = new MeasureCard(page, this);
    this.element = element(
      "details",
      { className: "selection" },
      element("summary", {}, "Frame and measure"),
      element("div", { className: "which" }, this.frame, element("span", {}, "in"), this.reference),
      this.pose,
      this.said,
      this.measure.box,
    );
    page.addEventListener("selected", () => {
      choose(this.frame, page.pick.selection.frame);
      if (page.pick.selection.frame !== null) this.element.open = true;
      this.refresh();
    });
    this.element.ontoggle = () => this.refresh();
    this.refresh();
  }

  copyButtons() {
    return COPIES.map(({ name, title, text }) => {
      const button = element("button", { type: "button", title }, name);
      button.onclick = async () => {
        const pose = this.selected();
        this.said.textContent = pose && (await copyText(text(poseNumbers(pose)), name)) ? `Copied: ${name}.` : "";
      };
      return button;
    });
  }

  get chosen(): Reference {
    const { value } = this.reference;
    return value === "root" || value === "floor" ? { kind: value } : { kind: "frame", name: nameOf(this.reference) };
  }

  /** Pose of what poses are given in, in the robot's root. */
  referencePose() {
    return referencePose(this.page.robot, this.chosen);
  }

  /** A position and angles in the units that the panel shows. */
  poseShown(position: number[], angles: number[]) {
    const { units } = this.settings;
    return [
      ...position.map((value) => Numbers.length(value, units)),
      ...angles.map((value) => Numbers.angle(value, units)),
    ];
  }

  /** Pose of the selected frame in the reference. */
  selected() {
    const { frame } = this.page.pick.selection;
    if (frame === null) return null;
    const { robot } = this.page;
    return this.referencePose()
      .invert()
      .multiply(robot.pose(robot.linkOf(frame)));
  }

  refresh() {
    if (!this.element.open) return;
    const pose = this.selected();
    this.pose.hidden = !pose;
    if (pose) {
      const { position, rpy, quaternion, axis, angle } = poseNumbers(pose);
      this.numbers.show(this.poseShown(position, rpy));
      this.quaternion.show(quaternion.map(Numbers.share));
      this.turn.show([Numbers.angle(angle, this.settings.units), ...axis.map(Numbers.share)]);
    }
    this.measure.refresh();
  }
}

/**
 * A list of all frames, after some places that are none.
 *
 * @param places value and text
 */
export function frameSelect(label: string, about: About, places: [string, string][]): HTMLSelectElement {
  const select = element("select", { ariaLabel: label });
  select.append(...places.map(([value, text]) => element("option", { value }, text)));
  // The value says that it is a frame: one may be called floor.
  select.append(...frameOptions(about, "frame:"));
  return select;
}

export function nameOf(select: HTMLSelectElement) {
  return select.value.slice("frame:".length);
}

/** @param frame null for the first place */
export function choose(select: HTMLSelectElement, frame: string | null) {
  if (frame === null) select.selectedIndex = 0;
  else select.value = `frame:${frame}`;
}
