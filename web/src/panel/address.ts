import { THREE } from "../three.ts";
import { readLink, ROUNDING, writeLink } from "../values/link.ts";
import { unrounded } from "../values/configurations.ts";
import { Refused } from "../values/literals.ts";
import type { Panel } from "./panel.ts";

// How often [ms] the address is updated; browsers refuse more than a few hundred changes in half a minute.
const PAUSE = 500;
// Up to this distance from its preset the camera counts as at the preset, as a share of its distance from its target.
const SAME_PLACE = 1e-4;

const bare = () => location.href.split("#", 1)[0];

/** The state of the page, written in its address after the #, so that a link leads to it. */
export class Address {
  page = this.panel.page;
  timer = 0;
  isOpen = false;
  /** Where the last preset put the camera and the point that it looks at. */
  preset: number[] = [];

  constructor(readonly panel: Panel) {
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
    // The page may overwrite the address with its own state before this event arrives, so the event's address is used.
    window.addEventListener("hashchange", ({ newURL }) => this.apply(new URL(newURL).hash));
  }

  /** When the page is complete, show the state in its link, if it was opened by one. */
  open() {
    if (this.page.role !== "") return;
    const [entry] = performance.getEntriesByType("navigation");
    const isNew = (entry as PerformanceNavigationTiming | undefined)?.type === "navigate";
    // A live page that is reloaded shows the program's current state, not the state in its address.
    if (isNew || !this.page.connection.socket) this.apply();
    this.isOpen = true;
  }

  /** The position of the camera and the point that it looks at, with z up. */
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

  /** The part of the address after the #. */
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
    try {
      history.replaceState(history.state, "", `${bare()}#${this.text}`);
    } catch {
      // A document without an address of its own; its link can still be copied.
    }
  }

  copy() {
    return /^(https?|file):/.test(location.protocol)
      ? this.panel.exchange.copy(`${bare()}#${this.text}`, "Link")
      : this.panel.exchange.copy(`#${this.text}`, "End of a link (this page has no address of its own)");
  }

  /** Show the state in the address; if it cannot be read, nothing changes, and a message says so. */
  apply(hash: string = location.hash) {
    const { page, panel } = this;
    if (hash.length <= 1) return;
    let state: ReturnType<typeof readLink>;
    try {
      state = readLink(page.robot.about, Object.keys(page.toggles.shown), hash.slice(1));
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      return panel.messages.say(`The link cannot be opened: ${error.message}`, { bad: true });
    }
    const { q, up, camera, shown, units, frame } = state;
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

  look([x, y, z, tx, ty, tz]: number[]) {
    const { viewer } = this.page;
    this.page.camera("three-quarter");
    viewer.camera.position.copy(new THREE.Vector3(x, z, -y));
    viewer.controls.target.set(tx, tz, -ty);
    viewer.controls.update();
    viewer.set_dirty();
  }
}
