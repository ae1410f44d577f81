import { mirrored } from "../values/configurations.ts";
import { div, element, iconButton, menu, toolbar } from "./element.ts";
import type { Panel } from "./panel.ts";

/** The head of the panel: the name of the robot, its degrees of freedom and notes, and the settings of the page. */
export class Head {
  element: HTMLElement;

  constructor({ page, settings, keys }: Panel) {
    const { about } = page.robot;
    const freedoms = about.coordinates.length;
    const help = element("button", { type: "button" }, "Keys …");
    const opener = iconButton("settings", "Settings", () => {});
    const opacity = element("input", { type: "range", min: "0.1", max: "1", step: "0.05", value: "1" });
    opacity.ariaLabel = "Opacity";
    opacity.style.setProperty("--to", "100%");
    opacity.oninput = () => {
      opacity.style.setProperty("--to", `${(Number(opacity.value) - 0.1) / 0.009}%`);
      page.studio.setOpacity(Number(opacity.value));
    };
    const clear = element("fieldset", {}, element("legend", {}, "Opacity"), opacity);
    const contrast = page.toggles.buttons.get("contrast") as HTMLElement;
    const choices = menu(opener, "Settings", ...settings.fields(), clear, div("row", contrast, help));
    help.onclick = () => {
      choices.hidePopover();
      keys.help();
    };
    this.element = element(
      "header",
      {},
      div(
        "robot",
        element("h1", { title: about.name }, about.name),
        element(
          "p",
          {},
          element("span", { className: "freedoms" }, `${freedoms} degree${freedoms === 1 ? "" : "s"} of freedom`),
          element("span", { className: "state" }),
        ),
      ),
      opener,
      choices,
      element("p", { className: "notes", hidden: about.notes.length === 0 }, about.notes.join("; ")),
    );
  }
}

// How long [ms] a message stays that needs no action, and how many are shown at once.
const [STAY, MOST] = [6000, 3];

/** The lines under the picture that say what a command did, or why it did nothing. */
export class Messages {
  lines = element("span");
  /** The failures that stay until the user closes them, or for a while after the next message. */
  failures: HTMLElement[] = [];

  constructor(readonly box: HTMLElement) {}

  /** @param options a message about a failure (`bad`) stays until the user closes it */
  say(text: string, { bad = false }: { bad?: boolean } = {}) {
    const line = element("p", { className: bad ? "bad" : "" }, text);
    const [same] = [...this.lines.children].filter(({ textContent }) => textContent === text);
    same?.remove();
    this.lines.append(line);
    if (this.lines.childElementCount > MOST) this.lines.children[0].remove();
    if (!this.box.hasChildNodes()) {
      this.box.append(
        this.lines,
        iconButton("close", "Close the message", () => this.close()),
      );
    }
    for (const leaving of bad ? this.failures : [...this.failures, line]) setTimeout(() => this.remove(leaving), STAY);
    this.failures = bad ? [line] : [];
    this.mark();
  }

  remove(line: Element) {
    line.remove();
    if (this.lines.childElementCount === 0) this.close();
    this.mark();
  }

  mark() {
    this.box.classList.toggle("bad", this.lines.querySelector(".bad") !== null);
  }

  close() {
    this.lines.replaceChildren();
    this.box.replaceChildren();
    this.mark();
  }
}

/** The toolbar for the whole configuration: undo, reset, mirror, copy and others. */
export class Tools {
  undo = iconButton("undo", "Undo", () => this.panel.past.undo(), "Ctrl+Z", "Undo");
  redo = iconButton("redo", "Redo", () => this.panel.past.redo(), "Ctrl+Shift+Z", "Redo");
  reset = iconButton("reset", "Reset to the beginning", () => this.panel.reset(), "", "Reset");
  element: HTMLDivElement;

  constructor(readonly panel: Panel) {
    const { page, past, exchange } = panel;
    const { about } = page.robot;
    past.addEventListener("changed", () => this.refresh());
    const mirror = iconButton("mirror", "Mirror left and right", () => this.mirror(), "", "Mirror");
    mirror.hidden = about.mirror.length === 0;
    const copy = iconButton("copy", "Copy the configuration", () => {}, "", "Copy");
    const link = () => {
      formats.hidePopover();
      panel.address.copy();
    };
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
      element("button", { type: "button", onclick: link }, "Link", element("small", {}, "to this state of the page")),
    );
    const paste = iconButton("paste", "Paste a configuration", () => exchange.paste(), "Ctrl+V", "Paste");
    const group = (...buttons: Node[]) => div("group", ...buttons);
    const bar = toolbar(
      div("tools"),
      "Configuration",
      group(copy, paste, mirror),
      group(this.undo, this.redo, this.reset),
    );
    this.element = element("div", {}, bar, formats);
    this.refresh();
  }

  refresh() {
    const { history } = this.panel.past;
    // They come with the first change.
    const isFresh = history.past.length + history.future.length === 0;
    for (const made of [this.undo, this.redo, this.reset]) made.hidden = isFresh;
    // aria-disabled, not disabled: a disabled button would lose the focus.
    this.undo.setAttribute("aria-disabled", String(history.past.length === 0));
    this.redo.setAttribute("aria-disabled", String(history.future.length === 0));
  }

  mirror() {
    const { robot, stance } = this.panel.page;
    const up = stance.up ? [stance.up[0], -stance.up[1], stance.up[2]] : null;
    stance.jump(mirrored(robot.about, stance.q), up);
  }
}
