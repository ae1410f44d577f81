import type { App } from "../app.ts";
import { paintFloor } from "../scene/floor.ts";
import { Address } from "./address.ts";
import { element } from "./element.ts";
import { Exchange } from "./exchange.ts";
import { Joints, Postures } from "./joints.ts";
import { Keys, bindViewKeys } from "./keys.ts";
import { Layout } from "./layout.ts";
import { Past } from "./past.ts";
import { Readout } from "./readout.ts";
import { Robots } from "./robots.ts";
import { SelectionSection } from "./selection.ts";
import { Settings } from "./settings.ts";
import { Head, Messages, Tools } from "./tools.ts";

/** A part of the panel: what it looks like, and how it follows the robot if it does. */
interface Section {
  element: HTMLElement;
  refresh?(): void;
}

/** The panel beside the view. */
export class Panel {
  settings: Settings;
  messages = new Messages(document.getElementById("message") as HTMLElement);
  exchange: Exchange;
  past: Past;
  start;
  address: Address;
  layout: Layout;
  keys: Keys;
  joints: Joints;
  readout: Readout;
  /** From top to bottom. */
  sections: Section[];

  constructor(
    readonly app: App,
    aside: HTMLElement,
  ) {
    this.settings = new Settings(app.role === "");
    this.exchange = new Exchange(app, this.messages);
    this.past = new Past(app);
    this.start = app.stance.snapshot();
    this.address = new Address(this);
    this.layout = new Layout(aside, document.getElementById("view") as HTMLElement, this.settings);
    this.keys = new Keys(this);
    this.joints = new Joints(this);
    this.readout = new Readout(this);
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
    const skip = document.getElementById("skip") as HTMLElement;
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
