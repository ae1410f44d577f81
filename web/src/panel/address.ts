import { THREE } from "../three.ts";
import { MOST_LINKED, readLink, ROUNDING, writeKeys, writeLink } from "../values/link.ts";
import { unrounded } from "../values/configurations.ts";
import { Refused } from "../values/literals.ts";
import type { Panel } from "./panel.ts";

// How often [ms] the address follows; browsers refuse more than some hundred changes in half a minute.
const PAUSE = 500;
// How far the camera may be from where its preset put it, as a share of its distance, and still stand there.
const SAME_PLACE = 1e-4;

// How far the camera of a link, and what it looks at, may be from the robot, in sizes of the robot.
const FURTHEST = 60;

const bare = () => location.href.split("#", 1)[0];

/** The state of the page in its address, behind the #, so that a link leads to it. */
export class Address {
  page: Panel["page"];
  timer = 0;
  isOpen = false;
  /** Whether it was said that the address goes without the key frames. */
  saidSo = false;
  /** Where the preset chosen last has put the camera. */
  preset: number[] = [];

  constructor(readonly panel: Panel) {
    this.page = panel.page;
    const { page } = this;
    const later = () => this.later();
    const moved = () => {
      this.preset = this.places();
      this.later();
    };
    page.addEventListener("camera", moved);
    for (const name of ["settled", "shown", "selected"]) page.addEventListener(name, later);
    for (const name of ["pointerup", "wheel", "keyup"]) {
      page.pane.addEventListener(name, later, { passive: true });
    }
    panel.settings.addEventListener("units", later);
    for (const name of ["motion", "time"]) page.player.addEventListener(name, later);
    // The page may have written its own state over the address before it hears of the new one.
    window.addEventListener("hashchange", ({ newURL }) => this.apply(new URL(newURL).hash));
  }

  /** The page is all here: go where its link leads, if somebody followed one. */
  open() {
    if (this.page.role !== "") return;
    const [entry] = performance.getEntriesByType("navigation");
    const isNew = (entry as PerformanceNavigationTiming | undefined)?.type === "navigate";
    // A live page that is loaded again is where the program has it now, not where it was.
    if (isNew || !this.page.connection.socket) this.apply();
    this.isOpen = true;
  }

  /** Where the camera is, and what it looks at, with z up. */
  places() {
    const { camera, controls } = this.page.viewer;
    return [camera.position, controls.target].flatMap(({ x, y, z }) => [x, -z, y]);
  }

  get camera() {
    const { view } = this.page;
    const places = this.places();
    const distance = Math.hypot(places[0] - places[3], places[1] - places[4], places[2] - places[5]);
    const isThere = this.preset.every((x, i) => Math.abs(x - places[i]) < SAME_PLACE * distance);
    return isThere ? (view ?? "three-quarter") : places;
  }

  /** The key frames, and when they are shown; null where there are none. */
  get keys() {
    const { editor } = this.page.player;
    return editor.frames.count > 0 ? { frames: editor.frames, time: editor.now } : null;
  }

  /** What a link leaves out, to be said. */
  get without() {
    const { keys } = this;
    if (!keys || writeKeys(this.page.robot.about, keys) !== null) return "";
    const { count } = keys.frames;
    return `without the ${count} key frames, which are too long for a link (at most ${MOST_LINKED}, 9 kB); save them as a file`;
  }

  /** What stands behind the #. */
  get text() {
    const { page, panel } = this;
    const { shown, buttons } = page.toggles;
    return writeLink(page.robot.about, {
      q: [...page.stance.q],
      up: page.stance.up && Array.from(page.stance.up),
      camera: this.camera,
      shown: Object.keys(shown).filter((name) => shown[name] && !buttons.get(name)?.hidden),
      units: panel.settings.units,
      frame: page.pick.selection.read,
      keys: this.keys,
    });
  }

  later() {
    if (!this.isOpen || this.timer) return;
    this.timer = setTimeout(() => {
      this.timer = 0;
      this.write();
    }, PAUSE);
  }

  write() {
    // A clip would write a new address at every step.
    if (this.page.player.playback?.playing) return;
    const { without } = this;
    if (without && !this.saidSo) this.panel.messages.say(`The address of this page goes ${without}.`);
    this.saidSo = without !== "";
    try {
      history.replaceState(history.state, "", `${bare()}#${this.text}`);
    } catch {
      // A document without an address of its own; its link can still be copied.
    }
  }

  copy() {
    const { text, without } = this;
    const hasAddress = /^(https?|file):/.test(location.protocol);
    const kind = hasAddress ? "Link" : "End of a link to this page, which has no address of its own,";
    const what = without ? `${kind}, ${without},` : kind;
    return this.panel.exchange.copy(hasAddress ? `${bare()}#${text}` : `#${text}`, what);
  }

  /** Go where the address leads; where it leads nowhere a message says so, and nothing changes. */
  apply(hash: string = location.hash) {
    const text = hash.slice(1);
    if (!text) return;
    const { page, panel } = this;
    let state;
    try {
      // Links of 0.3 name a button "joints" too.
      state = readLink(page.robot.about, [...Object.keys(page.toggles.shown), "joints"], text);
      this.checkCamera(state);
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      panel.messages.say(`The link leads nowhere: ${error.message}`, { bad: true });
      return;
    }
    const { q, up, camera, shown, units, frame, keys } = state;
    if (keys) page.player.editor.take(keys.frames, keys.time);
    if (q) page.stance.jump(unrounded(page.robot.about, q, ROUNDING), up ?? null);
    else if (up) page.stance.jump([...page.stance.q], up);
    page.stance.settle();
    if (shown) {
      const offered = [...page.toggles.buttons].filter(([, { hidden }]) => !hidden);
      page.show(Object.fromEntries(offered.map(([name]) => [name, shown.includes(name)])));
    }
    if (units) panel.settings.setUnits(units);
    if (frame) page.pick.selection.follow(frame);
    if (typeof camera === "string") page.camera(camera);
    else if (camera) this.look(camera);
  }

  /** Refuse a place from which nothing of the robot is to be seen. */
  checkCamera({ camera, q = this.page.stance.q }: ReturnType<typeof readLink>) {
    const { robot, studio } = this.page;
    if (!Array.isArray(camera)) return;
    const base = robot.about.floating ? q.slice(0, 3) : [0, 0, 0];
    const away = Math.max(...[0, 3].map((at) => Math.hypot(...base.map((x, i) => camera[at + i] - x))));
    const most = FURTHEST * studio.size;
    if (away > most) {
      throw new Refused(`a camera ${away.toPrecision(2)} m from the robot, expected at most ${most.toFixed(0)} m`);
    }
  }

  look([x, y, z, tx, ty, tz]: number[]) {
    const { viewer } = this.page;
    this.page.camera("three-quarter");
    viewer.camera.position.copy(new THREE.Vector3(x, z, -y));
    viewer.controls.target.set(tx, tz, -ty);
    viewer.controls.update();
    viewer.set_dirty();
  }
}
