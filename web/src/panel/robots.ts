import "./robots.css";
import type { Robot } from "../robot/robot.ts";
import type { Other } from "../scene/other_robots.ts";
import { button, element } from "./element.ts";
import type { Panel } from "./panel.ts";

/**
 * The list of robots if a scene has several: a button looks at each, and a check box shows or hides each added robot. The
 * panel moves its own robot; the program that added the others moves them.
 */
export class Robots {
  page: Panel["page"];
  list = element("ul");
  element: HTMLElement;

  constructor(readonly panel: Panel) {
    this.page = panel.page;
    const { name } = this.page.robot.about;
    const note = element("p", {}, `The panel moves ${name}; the program that added the others moves them.`);
    this.element = element(
      "section",
      { className: "robots", ariaLabel: "Robots in the scene" },
      element("h2", {}, "Robots"),
      this.list,
      note,
    );
    this.page.addEventListener("robots", () => this.draw());
    this.draw();
  }

  draw() {
    const { others, robot } = this.page;
    const added = [...others.robots].sort(([a], [b]) => a - b);
    this.element.hidden = added.length === 0;
    const names = [robot.about.name, ...added.map(([, { name }]) => name)];
    const title: (name: string, number: number) => string = (name, number) =>
      names.filter((one) => one === name).length > 1 ? `${name} (${number + 1})` : name;
    this.list.replaceChildren(
      this.row(robot, element("span", {}, title(robot.about.name, 0))),
      ...added.map(([number, other]) => this.added(other, title(other.name, number))),
    );
  }

  added(other: Other, name: string) {
    const box = element("input", { type: "checkbox", checked: other.visible, ariaLabel: `Show ${name}` });
    box.onchange = () => this.page.others.show(other, box.checked);
    return this.row(other.shown.robot, element("label", {}, box, element("span", {}, name)));
  }

  row(robot: Robot, label: HTMLElement) {
    const freedoms = robot.about.coordinates.length;
    const name = label.textContent ?? "";
    label.title = `${name}: ${robot.about.name}, ${freedoms} degree${freedoms === 1 ? "" : "s"} of freedom`;
    const look = button("Look at", () => this.look(robot));
    look.ariaLabel = `Look at ${name}`;
    return element("li", {}, label, look);
  }

  /** Fill the view with one robot, from the current direction. */
  look(robot: Robot) {
    const { page, panel } = this;
    const presets = page.robot.about.cameras.filter(({ links }) => links.length === 0);
    const preset =
      presets.find(({ name }) => name === page.view) ?? presets.find(({ name }) => name === "three-quarter");
    page.stance.settle();
    robot.root.updateWorldMatrix(true, true);
    page.look(preset, { box: () => robot.box([]) });
    panel.address.later();
  }
}
