import { button, element } from "./element.ts";
import type { Panel } from "./panel.ts";

/** Buttons for the robot's named postures. */
export class Postures {
  element: HTMLElement;

  constructor({ app }: Panel) {
    const buttons = app.robot.about.postures.map(({ name }) => button(name, () => app.stance.posture(name)));
    this.element = element("section", { className: "postures", ariaLabel: "Postures" }, ...buttons);
  }
}
