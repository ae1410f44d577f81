import type { App } from "./app.ts";
import { button, element } from "./panel/element.ts";
import { paintFloor } from "./scene/floor.ts";
import { entry } from "./scene/legend.ts";
import { chainColours } from "./scene/link_colours.ts";

/** What may be drawn over the robot: the button's text, and what a new state does. */
const TOGGLES: Record<string, { text: string; show(page: App, on: boolean): void }> = {
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
        [...axes.show(on)].map(([kind, colour]) => entry(kind, colour)),
      ),
  },
  chains: {
    text: "Chains",
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
    show: ({ ghosts, legend }, on) => {
      ghosts.group.visible = on;
      legend.set("ghosts", on && ghosts.entries.length > 0 ? ["ghosts", ...ghosts.entries] : []);
    },
  },
  eye: {
    text: "Camera view",
    show: ({ eyes }, on) => eyes.show(on ? eyes.sight.select.value : null),
  },
  contrast: {
    text: "High contrast",
    show: ({ studio }, on) => {
      document.documentElement.dataset.contrast = on ? "high" : "";
      paintFloor(studio);
    },
  },
  handles: { text: "Handles", show: ({ drag }, on) => drag.show(on) },
};

/** The buttons of what may be drawn over the robot. */
export class Toggles {
  shown: Record<string, boolean>;
  buttons: Map<string, HTMLButtonElement> = new Map();
  bar = element("div", { className: "row", id: "shown" });

  constructor(readonly page: App) {
    this.shown = {
      ...{ frames: false, axes: false, chains: false, com: false, support: false, ghosts: true, eye: false },
      contrast: window.matchMedia("(forced-colors: active), (prefers-contrast: more)").matches,
      handles: page.role === "",
    };
    for (const [name, { text }] of Object.entries(TOGGLES)) {
      const flip = () => {
        this.set({ [name]: !this.shown[name] });
        page.send({ kind: "shown", shown: { [name]: this.shown[name] }, source: page.reports.source });
      };
      const made = button(text, flip);
      made.dataset.shown = name;
      this.buttons.set(name, made);
      this.bar.append(made);
    }
    this.offer("ghosts", false);
  }

  /** Whether there is anything to show, and so a button for it. */
  offer(name: string, on: boolean) {
    (this.buttons.get(name) as HTMLButtonElement).hidden = !on;
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
    this.set(this.shown);
  }
}
