import { button, element } from "./element.js";

/** Buttons for the robot's named postures. */
export class Postures {
  /** @param {import("./panel.js").Panel} panel */
  constructor({ app }) {
    const buttons = app.robot.about.postures.map(({ name }) => button(name, () => app.stance.posture(name)));
    this.element = element("section", { className: "postures", ariaLabel: "Postures" }, ...buttons);
  }
}
