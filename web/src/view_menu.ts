import type { App } from "./app.ts";
import { button, div, element, place } from "./panel/element.ts";
import { saveFilm } from "./record/film.ts";
import { saveScreenshot } from "./record/pictures.ts";
import { paintFloor } from "./scene/floor.ts";
import { clearGhosts, keepGhost } from "./scene/ghosts.ts";
import { entry } from "./scene/legend.ts";
import { chainColours } from "./scene/link_colours.ts";

/** The View menu: frames, transparency, colours, ghosts, pictures and videos. */
export class ViewMenu {
  /** Length of the arrows, as the power of two by which the usual one is multiplied. */
  size = slider([-2, 2, 0.1], 0, (power) => {
    const { names, usual } = this.page.frames;
    this.page.chooseFrames({ names, size: usual * 2 ** power });
  });
  boxes: Map<string, HTMLInputElement> = new Map();
  sheet = div("sheet", section("Show", this.page.toggles.bar), this.frames(), this.robot(), this.pictures());
  summary = element("summary", {}, "View");
  menu = element("details", { className: "view-menu" }, this.summary, this.sheet);

  constructor(
    readonly page: App,
    top: HTMLElement,
  ) {
    top.append(this.menu);
    const put = () => place(this.sheet, this.summary);
    this.menu.addEventListener("toggle", put);
    window.addEventListener("resize", put);
    document.addEventListener("pointerdown", ({ target }) => {
      if (!this.menu.contains(target as Node)) this.menu.open = false;
    });
    this.menu.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !this.menu.open) return;
      this.menu.open = false;
      this.summary.focus();
      event.stopPropagation();
    });
  }

  /** Check the boxes of the frames that are drawn. */
  refresh() {
    const { frames, toggles } = this.page;
    const names = new Set(toggles.shown.frames ? frames.names : []);
    for (const [name, box] of this.boxes) box.checked = names.has(name);
    this.size.show(Math.log2((frames.size ?? frames.usual) / frames.usual));
  }

  frames() {
    const { about } = this.page.robot;
    const all = about.frames.map(({ name }) => name);
    const list = element("div", { className: "checks", role: "group", ariaLabel: "Frames drawn" });
    const toggle = this.page.toggles.buttons.get("frames") as HTMLElement;
    for (const name of all) {
      const box = element("input", { type: "checkbox" });
      box.onchange = () => this.choose(all.filter((frame) => this.boxes.get(frame)?.checked));
      this.boxes.set(name, box);
      list.append(element("label", { title: name }, box, element("span", {}, name)));
    }
    return element(
      "section",
      { className: "frames" },
      row(
        toggle,
        button("Effectors", () => this.choose(about.effectors)),
        button("All", () => this.choose(all)),
        button("None", () => this.choose([])),
      ),
      list,
      field("Size", this.size.input),
    );
  }

  choose(names: string[]) {
    this.page.chooseFrames({ names, size: null });
  }

  robot() {
    const { page } = this;
    const opacity = slider([0.1, 1, 0.05], 1, (share) => page.studio.setOpacity(share));
    const keep = button("Keep as ghost", () => keepGhost(page));
    const remove = button("Remove ghost", () => {
      clearGhosts(page);
      keep.focus();
    });
    const refresh = () => (remove.hidden = page.ghosts.copies.length === 0);
    page.addEventListener("shown", refresh);
    refresh();
    return section("Robot", field("Opacity", opacity.input), row(keep, remove));
  }

  pictures() {
    const { page } = this;
    const contrast = page.toggles.buttons.get("contrast") as HTMLElement;
    const shoot = (scale: number) => () => {
      this.menu.open = false;
      return saveScreenshot(page, scale);
    };
    const film = button("Video", () => {
      this.menu.open = false;
      return saveFilm(page);
    });
    return section("Page", row(contrast, button("Picture 1×", shoot(1)), button("Picture 2×", shoot(2)), film));
  }
}

function section(title: string, ...children: Node[]) {
  return element("section", {}, element("h2", {}, title), ...children);
}

function row(...children: Node[]) {
  return div("row", ...children);
}

/** A slider with a number, filled up to it; `then` is called when the user moves it. */
function slider([low, high, step]: number[], value: number, then: (value: number) => void) {
  const input = element("input", { type: "range", min: String(low), max: String(high), step: String(step) });
  const show = (to: number) => {
    input.value = String(to);
    input.style.setProperty("--to", `${(100 * (Number(input.value) - low)) / (high - low)}%`);
  };
  input.oninput = () => {
    show(Number(input.value));
    then(Number(input.value));
  };
  show(value);
  return { input, show };
}

function field(text: string, control: HTMLElement) {
  // Without this, a screen reader would read the options of a select as part of its name.
  control.ariaLabel = text;
  return element("label", { className: "field" }, text, control);
}

/** An overlay: the text of its button, and the function that shows or hides it. */
interface Toggle {
  text: string;
  /** Whether it is on at the beginning; without this function it is off. */
  begins?(page: App): boolean;
  /** Whether there is anything to show, and so a button for it; without this function there is always a button. */
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
  shapes: {
    text: "Collision shapes",
    isOffered: ({ bodyShapes }) => bodyShapes.shapes.length > 0,
    show: ({ bodyShapes }, on) => bodyShapes.showCollision(on),
  },
  inertia: {
    text: "Inertia",
    isOffered: ({ robot }) => robot.about.bodies.some(({ size }) => Math.max(...size) > 0),
    show: ({ bodyShapes }, on) => bodyShapes.showInertia(on),
  },
  collisions: {
    text: "Overlaps",
    isOffered: ({ collisions }) => collisions.pairs !== null,
    show: ({ collisions }, on) => collisions.show(on),
  },
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
  orthographic: { text: "Orthographic", show: (page, on) => page.setParallel(on) },
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

/** The buttons that switch the overlays. */
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

  /** Show the buttons of the overlays that have something to show. */
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

  /** Apply the state of all overlays, after the robot has been made. */
  apply() {
    this.refresh();
    this.set(this.shown);
  }
}
