import { button, element } from "./element.js";
import "./robots.css";

/** @typedef {import("../scene/other_robots.js").Other} Other */

/**
 * The robots of a scene that has several: each is looked at by a button, and those that were added are seen or hidden. The
 * panel moves its own one; the program that added the others moves them.
 */
export class Robots {
  /** @param {import("./panel.js").Panel} panel */
  constructor(panel) {
    this.panel = panel;
    this.app = panel.app;
    this.list = element("ul");
    const { name } = this.app.robot.about;
    const note = element("p", {}, `The panel moves ${name}; the program that added the others moves them.`);
    this.element = element(
      "section",
      { className: "robots", ariaLabel: "Robots in the scene" },
      element("h2", {}, "Robots"),
      this.list,
      note,
    );
    this.app.addEventListener("robots", () => this.draw());
    this.draw();
  }

  draw() {
    const { others, robot } = this.app;
    const added = [...others.robots].sort(([a], [b]) => a - b);
    this.element.hidden = added.length === 0;
    const names = [robot.about.name, ...added.map(([, { name }]) => name)];
    /** @type {(name: string, number: number) => string} */
    const title = (name, number) => (names.filter((one) => one === name).length > 1 ? `${name} (${number + 1})` : name);
    this.list.replaceChildren(
      this.row(robot, element("span", {}, title(robot.about.name, 0))),
      ...added.map(([number, other]) => this.added(other, title(other.name, number))),
    );
  }

  /**
   * @param {Other} other
   * @param {string} name
   */
  added(other, name) {
    const box = element("input", { type: "checkbox", checked: other.visible, ariaLabel: `Show ${name}` });
    box.onchange = () => this.app.others.show(other, box.checked);
    return this.row(other.shown.robot, element("label", {}, box, element("span", {}, name)));
  }

  /**
   * @param {import("../robot/robot.js").Robot} robot
   * @param {HTMLElement} label
   */
  row(robot, label) {
    const freedoms = robot.about.coordinates.length;
    const name = label.textContent ?? "";
    label.title = `${name}: ${robot.about.name}, ${freedoms} degree${freedoms === 1 ? "" : "s"} of freedom`;
    const look = button("Look at", () => this.look(robot));
    look.ariaLabel = `Look at ${name}`;
    return element("li", {}, label, look);
  }

  /**
   * Fill the view with one robot, from the side that is looked from.
   *
   * @param {import("../robot/robot.js").Robot} robot
   */
  look(robot) {
    const { app, panel } = this;
    const presets = app.robot.about.cameras.filter(({ links }) => links.length === 0);
    const preset =
      presets.find(({ name }) => name === app.view) ?? presets.find(({ name }) => name === "three-quarter");
    app.stance.settle();
    robot.root.updateWorldMatrix(true, true);
    app.look(preset, { box: () => robot.box([]) });
    panel.address.later();
  }
}
