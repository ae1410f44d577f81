import { element } from "./element.js";
import { Address } from "./address.js";
import { Exchange } from "./exchange.js";
import { Head } from "./head.js";
import { Joints } from "./joints.js";
import { Keys } from "./keys.js";
import { Layout } from "./layout.js";
import { Messages } from "./messages.js";
import { Past } from "./past.js";
import { Postures } from "./postures.js";
import { Readout } from "./readout.js";
import { SelectionSection } from "./selection.js";
import { Robots } from "./robots.js";
import { Settings } from "./settings.js";
import { Tools } from "./tools.js";
import { paintFloor } from "../scene/floor_colours.js";
import { bindViewKeys } from "./view_keys.js";

/**
 * A part of the panel: what it looks like, and how it follows the robot if it does.
 *
 * @typedef {{ element: HTMLElement, refresh?(): void }} Section
 */

/** The panel beside the view. */
export class Panel {
  /**
   * @param {import("../app.js").App} app
   * @param {HTMLElement} aside
   */
  constructor(app, aside) {
    this.app = app;
    this.settings = new Settings(app.role === "");
    this.messages = new Messages(/** @type {HTMLElement} */ (document.getElementById("message")));
    this.exchange = new Exchange(app, this.messages);
    this.past = new Past(app);
    this.start = app.stance.snapshot();
    this.address = new Address(this);
    this.layout = new Layout(aside, /** @type {HTMLElement} */ (document.getElementById("view")), this.settings);
    this.keys = new Keys(this);
    this.joints = new Joints(this);
    this.readout = new Readout(this);
    /** From top to bottom. @type {Section[]} */
    this.sections = [
      new Head(this),
      new Robots(this),
      new Tools(this),
      new Postures(this),
      this.joints,
      this.readout,
      new SelectionSection(app, this.settings),
    ];
    const body = element(
      "div",
      { className: "body", tabIndex: -1 },
      ...this.sections.map((section) => section.element),
    );
    aside.replaceChildren(this.layout.separator, body);
    this.layout.announce();
    this.settings.addEventListener("units", () => {
      this.joints.relabel();
      this.refresh();
      app.pick.hover.tip.refresh();
      app.pick.measure.draw();
      app.viewer.set_dirty();
    });
    bindViewKeys(app);
    const paint = () => paintFloor(app.studio);
    this.settings.addEventListener("theme", paint);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
    paint();
    const skip = /** @type {HTMLElement} */ (document.getElementById("skip"));
    skip.onclick = (event) => {
      event.preventDefault();
      this.layout.fold(false);
      this.joints.element.focus();
    };
  }

  // All of the scene is here.
  complete() {
    // A page that finds its program again begins no second time.
    if (this.address.isOpen) return;
    this.start = this.app.stance.snapshot();
    this.address.open();
  }

  reset() {
    this.app.stance.jump([...this.start.q], this.start.up);
  }

  refresh() {
    for (const section of this.sections) section.refresh?.();
  }
}
