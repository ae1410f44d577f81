import { mirrored, randomWithin } from "../values/configurations.ts";
import { element, iconButton } from "./element.ts";
import { menu } from "./menu.ts";
import type { Panel } from "./panel.ts";

/** The bar of what is done to the whole configuration. */
export class Tools {
  undo: HTMLButtonElement;
  redo: HTMLButtonElement;
  element: HTMLDivElement;

  constructor(readonly panel: Panel) {
    const { app, past, exchange } = panel;
    const { about } = app.robot;
    this.undo = iconButton("undo", "Undo", () => past.undo(), "Ctrl+Z");
    this.redo = iconButton("redo", "Redo", () => past.redo(), "Ctrl+Shift+Z");
    past.addEventListener("changed", () => this.refresh());
    const reset = iconButton("reset", "Back to the beginning", () => panel.reset());
    const mirror = iconButton("mirror", "Mirror left and right", () => this.mirror());
    const random = iconButton("random", "Random within the limits", () =>
      app.stance.jump(randomWithin(about, app.stance.q)),
    );
    mirror.hidden = about.mirror.length === 0;
    const copy = iconButton("copy", "Copy the configuration", () => {});
    const formats = menu(
      copy,
      "Copy as",
      ...exchange.formats.map(([name, { title, hint }]) => {
        const take = () => {
          formats.hidePopover();
          exchange.copyConfiguration(name);
        };
        return element("button", { type: "button", onclick: take }, title, element("small", {}, hint));
      }),
    );
    const paste = iconButton("paste", "Paste a configuration", () => exchange.paste(), "Ctrl+V");
    const link = iconButton("link", "Copy a link to this state", () => panel.address.copy());
    const group = (...buttons: Node[]) => element("div", { className: "group" }, ...buttons);
    this.element = element(
      "div",
      { className: "tools" },
      group(this.undo, this.redo),
      group(reset, mirror, random),
      group(copy, paste, link),
      formats,
    );
    this.element.setAttribute("role", "group");
    this.element.setAttribute("aria-label", "Configuration");
    this.refresh();
  }

  refresh() {
    const { history } = this.panel.past;
    // A disabled button would lose the focus to nothing.
    this.undo.setAttribute("aria-disabled", String(history.past.length === 0));
    this.redo.setAttribute("aria-disabled", String(history.future.length === 0));
  }

  mirror() {
    const { robot, stance } = this.panel.app;
    const up = stance.up ? [stance.up[0], -stance.up[1], stance.up[2]] : null;
    stance.jump(mirrored(robot.about, stance.q), up);
  }
}
