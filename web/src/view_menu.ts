import type { App } from "./app.ts";
import { button, div, element, place, toolbar } from "./panel/element.ts";
import { saveFilm } from "./record/film.ts";
import { saveScreenshot } from "./record/pictures.ts";
import { paintFloor } from "./scene/floor.ts";
import { clearGhosts, keepGhost } from "./scene/ghosts.ts";
import { entry } from "./scene/legend.ts";
import { chainColours } from "./scene/link_colours.ts";
import { matches } from "./values/names.ts";

// How many cameras have a button over the picture.
const FIRST = 4;

/** The View menu: overlays, frames, further cameras, ghosts, pictures and videos. */
export class ViewMenu {
  /** Which frames are drawn if a button is pressed. */
  choices: Map<HTMLButtonElement, string[]> = new Map();
  search = element("input", { type: "search", placeholder: "Search frames", ariaLabel: "Search frames to draw" });
  found = element("output");
  sheet = div("sheet", section("Show", this.page.toggles.bar), this.frames(), ...this.cameras(), this.rest());
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

  /** Mark the button of the frames that are drawn. */
  refresh() {
    const { frames, toggles } = this.page;
    const drawn = String(toggles.shown.frames ? frames.names : []);
    for (const [made, names] of this.choices) made.setAttribute("aria-pressed", String(String(names) === drawn));
  }

  frames() {
    const { frames, effectors } = this.page.robot.about;
    // Frames of one link are one place under several names.
    const places = (sought: string) => {
      const fitting = frames.filter(({ name }) => matches(name, sought));
      return fitting.filter(({ link }, i) => fitting.findIndex((other) => other.link === link) === i);
    };
    const all = { All: places("").map(({ name }) => name), Effectors: effectors, None: [] };
    for (const [text, names] of Object.entries(all)) {
      const made = button(text, () => {
        this.find("");
        this.choose(names);
      });
      this.choices.set(made, names);
    }
    this.search.oninput = () => {
      const names = this.search.value.trim() ? places(this.search.value).map(({ name }) => name) : [];
      this.find(this.search.value, names.length);
      this.choose(names);
    };
    return section("Frames", row(...this.choices.keys()), div("search", this.search, this.found));
  }

  /** Say how many frames fit what is sought. */
  find(sought: string, count: number = 0) {
    if (this.search.value !== sought) this.search.value = sought;
    this.found.textContent = sought.trim() ? `${count || "no"} place${count === 1 ? "" : "s"}` : "";
  }

  choose(names: string[]) {
    this.page.chooseFrames({ names, size: null });
    this.page.toggles.tell("frames");
  }

  /** Put the first cameras over the picture, and the others into a section of the menu. */
  cameras() {
    const { page } = this;
    const all = page.robot.about.cameras.map(({ name }) => button(name, () => page.camera(name)));
    toolbar(document.getElementById("cameras") as HTMLElement, "Cameras", ...all.slice(0, FIRST));
    return all.length > FIRST ? [section("Look from", row(...all.slice(FIRST)))] : [];
  }

  rest() {
    const { page } = this;
    const keep = button("Keep as ghost", () => keepGhost(page));
    const remove = button("Remove ghost", () => {
      clearGhosts(page);
      keep.focus();
    });
    const refresh = () => (remove.hidden = page.ghosts.copies.length === 0);
    page.addEventListener("shown", refresh);
    refresh();
    const save = (what: (page: App) => Promise<void>) => () => {
      this.menu.open = false;
      return what(page);
    };
    const files = [button("Picture", save(saveScreenshot)), button("Video", save(saveFilm))];
    return div("", section("Compare", row(keep, remove)), section("Save", row(...files)));
  }
}

function section(title: string, ...children: Node[]) {
  return element("section", {}, element("h2", {}, title), ...children);
}

function row(...children: Node[]) {
  return div("row", ...children);
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
      legend.set("ghosts", on && ghosts.entries.length > 0 ? ghosts.entries : []);
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
        this.tell(name);
      });
      made.dataset.shown = name;
      this.buttons.set(name, made);
      // Frames are chosen below these buttons, and the contrast in the settings.
      if (!["frames", "contrast"].includes(name)) this.bar.append(made);
    }
    page.addEventListener("targets", () => this.refresh());
  }

  /** Tell the program whether an overlay is on. */
  tell(name: string) {
    this.page.send({ kind: "shown", shown: { [name]: this.shown[name] }, source: this.page.reports.source });
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
