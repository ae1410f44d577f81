import type { App } from "./app.ts";
import { button, element } from "./panel/element.ts";
import { paintFloor } from "./scene/floor.ts";
import { entry } from "./scene/legend.ts";
import { chainColours } from "./scene/link_colours.ts";

/** What may be drawn over the robot: the button's text, and what a new state does. */
interface Toggle {
  text: string;
  /** Whether it is there at the beginning; else it is not. */
  begins?(page: App): boolean;
  /** Whether there is anything to show, and so a button for it; else there always is. */
  isOffered?(page: App): boolean;
  show(page: App, on: boolean): void;
}

const TOGGLES: Record<string, Toggle> = {
  frames: {
    text: "Frames",
    show: ({ frames, menu }, on) => {
      frames.show(on);
      menu.refresh();
    },
  },
  axes: {
    text: "Joint axes",
    show: ({ axes, legend }, on) =>
      legend.set(
        "pairs",
        Array.from(axes.show(on), (pair) => entry(...pair)),
      ),
  },
  chains: {
    text: "Chains",
    isOffered: ({ robot }) => robot.about.chains.length > 1,
    show: ({ colours, legend, robot }, on) => {
      const { chains, links } = chainColours(robot.about);
      colours.setChains(on ? links : new Map());
      legend.set("chains", on ? chains.map(({ title, colour }) => entry(title, colour)) : []);
    },
  },
  com: { text: "Centre of mass", show: ({ balance }, on) => balance.show({ com: on }) },
  support: { text: "Support", show: ({ balance }, on) => balance.show({ support: on }) },
  ghosts: {
    text: "Ghosts",
    begins: () => true,
    isOffered: ({ ghosts }) => ghosts.copies.length > 0,
    show: ({ ghosts, legend }, on) => {
      ghosts.group.visible = on;
      legend.set("ghosts", on && ghosts.entries.length > 0 ? ["ghosts", ...ghosts.entries] : []);
    },
  },
  eye: {
    text: "Camera view",
    isOffered: ({ robot }) => robot.about.eyes.length > 0,
    show: ({ eyes }, on) => eyes.show(on ? eyes.sight.select.value : null),
  },
  contrast: {
    text: "High contrast",
    begins: () => matchMedia("(forced-colors: active), (prefers-contrast: more)").matches,
    show: ({ studio }, on) => {
      document.documentElement.dataset.contrast = on ? "high" : "";
      paintFloor(studio);
    },
  },
  handles: {
    text: "Handles",
    begins: ({ role }) => role === "",
    isOffered: ({ drag }) => drag.possible,
    show: ({ drag }, on) => drag.show(on),
  },
};

/** The buttons of what may be drawn over the robot. */
export class Toggles {
  shown: Record<string, boolean> = {};
  buttons: Map<string, HTMLButtonElement> = new Map();
  bar = element("div", { className: "row", id: "shown" });

  constructor(readonly page: App) {
    for (const [name, { text, begins }] of Object.entries(TOGGLES)) {
      this.shown[name] = begins?.(page) ?? false;
      const made = button(text, () => {
        this.set({ [name]: !this.shown[name] });
        page.send({ kind: "shown", shown: { [name]: this.shown[name] }, source: page.reports.source });
      });
      made.dataset.shown = name;
      this.buttons.set(name, made);
      this.bar.append(made);
    }
    page.addEventListener("targets", () => this.refresh());
  }

  /** Offer what there is. */
  refresh() {
    for (const [name, made] of this.buttons) made.hidden = TOGGLES[name].isOffered?.(this.page) === false;
  }

  set(changes: Record<string, boolean>) {
    for (const [name, on] of Object.entries(changes).filter(([key]) => Object.hasOwn(TOGGLES, key))) {
      this.shown[name] = on;
      TOGGLES[name].show(this.page, on);
      this.buttons.get(name)?.setAttribute("aria-pressed", String(on));
    }
    this.page.viewer.set_dirty();
    this.page.dispatchEvent(new Event("shown"));
  }

  /** Show everything as it is to be, when the robot has just come. */
  apply() {
    this.refresh();
    this.set(this.shown);
  }
}
