import type { App } from "../app.ts";
import { paintFloor } from "../scene/floor.ts";
import type { Snapshot } from "../stance.ts";
import { Address } from "./address.ts";
import { element } from "./element.ts";
import { Exchange } from "./exchange.ts";
import { Joints, Postures } from "./joints.ts";
import { Keys, bindViewKeys, giveHint } from "./keys.ts";
import { Layout } from "./layout.ts";
import { Past } from "./past.ts";
import { Readout } from "./readout.ts";
import { Robots } from "./robots.ts";
import { Settings } from "./settings.ts";
import { Head, Messages, Tools } from "./tools.ts";

/** A section of the panel: its element, and its update with the robot's configuration if it needs one. */
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
  start: Snapshot;
  address: Address;
  layout: Layout;
  keys: Keys;
  joints: Joints;
  readout: Readout;
  /** From top to bottom; the read-out stays below the sections that scroll. */
  sections: Section[];

  constructor(
    readonly page: App,
    aside: HTMLElement,
  ) {
    this.settings = new Settings(page.role === "");
    this.exchange = new Exchange(page, this.messages);
    this.past = new Past(page);
    this.start = page.stance.snapshot();
    this.address = new Address(this);
    this.layout = new Layout(aside, document.getElementById("view") as HTMLElement, this.settings);
    this.keys = new Keys(this);
    this.joints = new Joints(this);
    this.readout = new Readout(this);
    this.sections = [new Head(this), new Robots(this), new Tools(this), new Postures(this), page.controls, this.joints];
    const body = element(
      "div",
      { className: "body", tabIndex: -1 },
      ...this.sections.map((section) => section.element),
    );
    this.sections.push(this.readout);
    aside.replaceChildren(this.layout.separator, body, this.readout.element);
    this.layout.announce();
    this.settings.addEventListener("units", () => {
      this.joints.relabel();
      this.refresh();
      page.pick.hover.tip.refresh();
      page.pick.measure.draw();
      page.balance.draw();
      page.viewer.set_dirty();
    });
    bindViewKeys(page);
    const paint = () => paintFloor(page.studio);
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

  // The whole scene has arrived.
  complete() {
    // Only once: a page that reconnects to its program keeps its state.
    if (this.address.isOpen) return;
    this.start = this.page.stance.snapshot();
    this.address.open();
    giveHint(this);
  }

  reset() {
    this.page.stance.jump([...this.start.q], this.start.up);
  }

  refresh() {
    for (const section of this.sections) section.refresh?.();
  }
}
