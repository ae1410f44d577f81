import { element, iconButton } from "./element.ts";
import { menu } from "./menu.ts";
import type { Panel } from "./panel.ts";

/** The name of the robot, what is to be known of it at once, and the settings of the page. */
export class Head {
  element: HTMLElement;

  constructor({ app, settings, keys }: Panel) {
    const { about } = app.robot;
    const freedoms = about.coordinates.length;
    const help = element("button", { type: "button" }, "Keys …");
    const opener = iconButton("settings", "Settings", () => {});
    const choices = menu(opener, "Settings", ...settings.fields(), help);
    help.onclick = () => {
      choices.hidePopover();
      keys.help();
    };
    this.element = element(
      "header",
      {},
      element(
        "div",
        { className: "robot" },
        element("h1", { title: about.name }, about.name),
        element(
          "p",
          {},
          `${freedoms} degree${freedoms === 1 ? "" : "s"} of freedom`,
          element("span", { className: "state" }),
        ),
      ),
      opener,
      choices,
      element("p", { className: "notes", hidden: about.notes.length === 0 }, about.notes.join("; ")),
    );
  }
}
