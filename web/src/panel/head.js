import { element } from "./element.js";

/** The name of the robot, and what is to be known of it at once. */
export class Head {
  /** @param {import("./panel.js").Panel} panel */
  constructor({ app }) {
    const { about } = app.robot;
    const freedoms = about.coordinates.length;
    this.element = element(
      "header",
      {},
      element("h1", {}, about.name),
      element(
        "p",
        {},
        `${freedoms} degree${freedoms === 1 ? "" : "s"} of freedom`,
        element("span", { className: "state" }),
      ),
      element("p", { className: "notes", hidden: about.notes.length === 0 }, about.notes.join("; ")),
    );
  }

  refresh() {}
}
