import type { App } from "./app.ts";
import { button, div, element, menu as makeMenu, toolbar } from "./panel/element.ts";
import { jointOf } from "./pick/facts.ts";
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
  opener = element("button", { type: "button", className: "view" }, "View ▾");
  sheet = makeMenu(
    this.opener,
    "View",
    section("Show", this.page.toggles.bar),
    this.frames(),
    ...this.cameras(),
    this.rest(),
  );

  constructor(
    readonly page: App,
    top: HTMLElement,
  ) {
    this.sheet.classList.add("view");
    top.append(this.opener, this.sheet);
  }

  /** Mark the button of the frames that are drawn. */
  refresh() {
    const { frames, toggles } = this.page;
    const drawn = String(toggles.shown.frames ? frames.names : []);
    for (const [made, names] of this.choices) made.setAttribute("aria-pressed", String(String(names) === drawn));
  }

  frames() {
    const { robot } = this.page;
    const { about } = robot;
    // One name of each place on a body, the one by which the page calls it if there is one.
    const called = about.frames.filter(({ name, link }) => about.links[link].title === name);
    const place = (link: number) =>
      [jointOf(about, link)?.name, ...robot.pose(link).elements.map((x) => Math.round(1e6 * x) + 0)].join(" ");
    const places = (sought: string) => {
      const fitting = [...called, ...about.frames].filter(({ name }) => matches(name, sought));
      return [...new Map(fitting.reverse().map(({ name, link }) => [place(link), name])).values()].reverse();
    };
    for (const [text, names] of Object.entries({ All: places(""), Effectors: about.effectors, None: [] })) {
      const made = button(text, () => {
        this.search.value = "";
        this.choose(names);
      });
      this.choices.set(made, names);
    }
    this.search.oninput = () => this.choose(this.search.value.trim() ? places(this.search.value) : []);
    return section("Frames", row(...this.choices.keys()), div("search", this.search, this.found));
  }

  choose(names: string[]) {
    const { length } = names;
    this.found.textContent = this.search.value.trim() ? `${length || "no"} place${length === 1 ? "" : "s"}` : "";
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
    const keep = button("Keep as ghost", () => keepGhost(page, false));
    const beside = button("Keep beside", () => keepGhost(page, true));
    const remove = button("Remove ghost", () => {
      clearGhosts(page);
      keep.focus();
    });
    const refresh = () => (remove.hidden = page.ghosts.copies.length === 0);
    page.addEventListener("shown", refresh);
    refresh();
    const save = (what: (page: App) => Promise<void>) => () => {
      this.sheet.hidePopover();
      return what(page);
    };
    const files = [button("Picture", save(saveScreenshot)), button("Video", save(saveFilm))];
    return div("", section("Compare", row(keep, beside, remove)), section("Save", row(...files)));
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
  together: {
    text: "Move together",
    isOffered: ({ others }) => others.robots.size > 0,
    show: ({ others }, on) => {
      others.together = on;
      others.follow();
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
    for (const name of ["targets", "robots"]) page.addEventListener(name, () => this.refresh());
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
