import "./postures.css";
import type { Snapshot } from "../stance.ts";
import { button, div, element, iconButton, menu, toolbar } from "./element.ts";
import type { Panel } from "./panel.ts";
import { remember } from "./settings.ts";

/** A configuration that the user kept under a name. */
type Pose = Snapshot & { name: string };

// The longest name.
const LONGEST = 40;

/**
 * Buttons for the robot's named postures, and for the poses that the user keeps under a name. The browser stores these by the
 * name of the robot, if that is allowed; otherwise they are kept until the page is closed.
 */
export class Postures {
  poses: Pose[] = [];
  name = element("input", { type: "text", maxLength: LONGEST, autocomplete: "off", ariaLabel: "Name of the pose" });
  problem = element("p", { className: "problem", role: "status" });
  list = element("ul", {});
  opener = element(
    "button",
    { type: "button", className: "keep", title: "Keep the configuration as a pose" },
    "+ Pose",
  );
  sheet: HTMLDivElement;
  element: HTMLElement;

  constructor(readonly panel: Panel) {
    const keep = element("form", {}, this.name, element("button", {}, "Keep"));
    keep.onsubmit = (event) => {
      event.preventDefault();
      this.keep(this.name.value.trim());
    };
    this.name.placeholder = "Name";
    this.name.oninput = () => (this.problem.textContent = "");
    this.sheet = menu(this.opener, "Own poses", keep, this.problem, this.list);
    this.sheet.classList.add("poses");
    this.sheet.addEventListener("toggle", () => {
      this.problem.textContent = "";
      if (this.sheet.matches(":popover-open")) this.name.focus();
    });
    this.element = element("div", {}, element("div"), this.sheet);
    // Another page of the same robot may keep or remove a pose.
    window.addEventListener("storage", () => this.draw());
    this.draw();
  }

  get key() {
    return `poses.${this.panel.page.robot.about.name}`;
  }

  /** Read the poses that the browser keeps; those that do not fit the robot are left out. */
  read() {
    const text = this.panel.settings.kept(this.key);
    if (text !== null) this.poses = readPoses(text, this.panel.page.robot.about.neutral.length);
  }

  write(poses: Pose[]) {
    this.poses = poses;
    remember(this.key, JSON.stringify(poses));
    this.draw();
  }

  keep(name: string) {
    const { page } = this.panel;
    this.read();
    const others = this.poses.filter((pose) => pose.name !== name);
    if (!name) this.problem.textContent = "A pose needs a name.";
    else if (page.robot.about.postures.some((posture) => posture.name === name)) {
      this.problem.textContent = `${name} is a posture of the robot.`;
    } else {
      const { q, up } = page.stance.snapshot();
      this.write([...others, { name, q, up: up && Array.from(up) }]);
      this.name.value = "";
      this.sheet.hidePopover();
    }
    if (this.problem.textContent) this.name.focus();
  }

  remove(name: string) {
    this.read();
    this.write(this.poses.filter((pose) => pose.name !== name));
    this.name.focus();
  }

  draw() {
    this.read();
    const { page } = this.panel;
    const postures = page.robot.about.postures.map(({ name }) => button(name, () => page.stance.posture(name)));
    const poses = this.poses.map((pose) => {
      const made = button(pose.name, () => page.stance.choose(pose.name, pose));
      made.classList.add("own");
      return made;
    });
    const bar = toolbar(div("postures"), "Postures", ...postures, ...poses, this.opener);
    this.element.firstElementChild?.replaceWith(bar);
    this.list.replaceChildren(
      ...this.poses.map(({ name }) => {
        const remove = iconButton("trash", `Remove ${name}`, () => this.remove(name));
        return element("li", {}, element("span", { title: name }, name), remove);
      }),
    );
  }
}

/**
 * Read poses as the browser keeps them.
 *
 * @param width number of values of a configuration
 */
export function readPoses(text: string, width: number): Pose[] {
  try {
    const poses: Pose[] = JSON.parse(text);
    return poses.filter((pose) => pose?.name && Array.isArray(pose.q) && pose.q.length === width);
  } catch {
    return [];
  }
}
