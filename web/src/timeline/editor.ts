import { clamp } from "../math/numbers.ts";
import { button, div, element, handleKey, iconButton, select } from "../panel/element.ts";
import { sampled } from "./formats.ts";
import { GAP, KeyFrames, LATEST, MOST_KEYS, excesses, slowedTimes } from "./key_frames.ts";
import type { Interpolation } from "./motion.ts";
import type { Player } from "./player.ts";
import { thinned } from "./recorder.ts";
import { Track } from "./track.ts";

/** The buttons over the track of key frames, and the message about motion between keys that is too fast. */
class KeyTools {
  add = element("button", { type: "button", className: "add", title: "Add key (K)" }, "Add key");
  ofKey: HTMLButtonElement[] = [
    iconButton("replace", "Replace by the current configuration", () => this.editor.replacing(), "", "Replace"),
    iconButton("copy", "Duplicate the key", () => this.editor.duplicating(), "", "Duplicate"),
    iconButton("trash", "Delete the key", () => this.editor.remove(this.editor.selected), "Del", "Delete"),
  ];
  interpolation = select("Interpolation", Object.entries({ linear: "Linear", smooth: "Smooth" }), () =>
    this.editor.interpolate(this.interpolation.value as Interpolation),
  );
  problem = element("span", { className: "problem", role: "status" });
  slow = button("Slow down", () => this.editor.slowDown());
  element: HTMLDivElement;

  constructor(readonly editor: Editor) {
    this.add.onclick = () => editor.adding();
    /** The buttons that act on the selected key. */
    this.interpolation.title = "Interpolation between the keys";
    const actions = [this.add, ...this.ofKey, this.interpolation];
    this.element = div("head", div("actions", ...actions), div("tooFast", this.problem, this.slow));
  }

  refresh(tooFast: { text: string }[]) {
    const { selected, frames } = this.editor;
    const more = tooFast.length > 1 ? `; ${tooFast.length - 1} more too fast` : "";
    const problem = tooFast.length > 0 ? `${tooFast[0].text}${more}` : "";
    // An unchanged text is not set again, because a screen reader would read it again.
    if (this.problem.textContent !== problem) this.problem.textContent = problem;
    this.slow.hidden = tooFast.length === 0;
    this.interpolation.value = frames.interpolation;
    // aria-disabled, not disabled: a disabled button would lose the focus.
    for (const tool of this.ofKey) tool.setAttribute("aria-disabled", String(selected < 0));
  }
}

/** The state of the key frames that undo restores. */
export interface Edited {
  frames: KeyFrames;
  selected: number;
  /** The time of the playhead. */
  time: number;
}

// How far [rad, m] key frames made from a clip may differ from it.
const TOLERANCE = (0.5 * Math.PI) / 180;

/** The editor of key frames: their track, and the buttons over it. */
export class Editor {
  frames = new KeyFrames();
  selected = -1;
  /** The key frames before the drag of a key, and the place of that key. */
  before = { frames: this.frames, selected: this.selected };
  element = element("section", { className: "keys", hidden: true, ariaLabel: "Key frames" });
  names = new Map(this.player.page.robot.about.coordinates.map(({ column, joint }) => [column, joint]));
  limits: (number | null)[] = this.player.page.stance.q.map(() => null);
  button = this.player.switch("key", "Key frames", () => this.open(!this.isOpen, true), "Key frames");
  track = new Track(this);
  tools = new KeyTools(this);

  constructor(public player: Player) {
    for (const { column, velocity } of player.page.robot.about.coordinates) this.limits[column] = velocity;
    this.element.append(this.tools.element, this.track.element);
    player.addEventListener("time", () => this.track.setTime(this.now));
    document.addEventListener("keydown", (event) => this.addKey(event));
    this.draw();
  }

  get isOpen() {
    return !this.element.hidden;
  }

  get edited(): Edited {
    return { frames: this.frames, selected: this.selected, time: this.now };
  }

  /** The time of the playhead. */
  get now() {
    return this.player.keys?.time ?? 0;
  }

  /**
   * @param byHand whether the user opens or closes the editor: if there are no keys yet, opening makes them from the clip,
   *   and closing returns to the clip
   */
  open(on: boolean, byHand: boolean = false) {
    if (this.isOpen === on) return;
    this.element.hidden = !on;
    this.button.setAttribute("aria-pressed", String(on));
    const { player } = this;
    player.bar.classList.toggle("editing", on);
    if (!byHand) return;
    if (on && this.frames.count === 0) this.takeClip();
    else player.change(on ? player.keys : (player.clip ?? player.keys));
  }

  take(frames: KeyFrames) {
    this.player.pause();
    this.open(true);
    this.apply(frames, 0, 0);
  }

  takeClip() {
    const motion = this.player.clip?.motion;
    if (!motion) return this.player.change(this.player.keys);
    const few = thinned(motion.interpolation === "linear" ? motion : sampled(motion), TOLERANCE, MOST_KEYS);
    if (!few) {
      this.open(false);
      this.player.say(`This clip needs more than ${MOST_KEYS} key frames, so it can be played but not edited.`, true);
      return;
    }
    const { time } = this.player;
    this.apply(KeyFrames.from(few), -1);
    this.player.seek(time);
    this.player.say(`${motion.count} configurations of the clip became ${few.count} key frames, within 0.5° of it.`);
  }

  // --- changes ---------------------------------------------------------------------------------------------------

  apply(frames: KeyFrames, selected: number, time: number = this.player.time) {
    this.frames = frames;
    this.selected = Math.min(selected, frames.count - 1);
    this.player.setKeys(frames.motion);
    if (this.player.keys) this.player.keys.time = time;
    this.draw();
    this.player.dispatchEvent(new Event("edited"));
  }

  restore({ frames, selected, time }: Edited) {
    this.open(true);
    this.apply(frames, selected, time);
  }

  addKey(event: KeyboardEvent) {
    if (!this.isOpen || event.key.toLowerCase() !== "k" || event.defaultPrevented) return;
    if (event.ctrlKey || event.metaKey || event.altKey || !this.player.page.panel.settings.keys) return;
    const { target } = event;
    if (target instanceof Element && target.closest('input:not([type="range"]), textarea, select, dialog')) return;
    event.preventDefault();
    this.adding();
  }

  adding() {
    if (this.frames.count >= MOST_KEYS) {
      return this.player.say(`There are already ${MOST_KEYS} key frames, the maximum.`, true);
    }
    const { page } = this.player;
    const time = this.frames.nextTime(this.now);
    if (time > LATEST && this.isFull()) return;
    this.player.pause();
    this.show(this.frames.adding(time, page.stance.q));
  }

  duplicating() {
    if (this.selected < 0 || this.frames.count >= MOST_KEYS || this.isFull()) return;
    this.show(this.frames.duplicating(this.selected));
  }

  /** Whether there is no room for a key after the last one; if so, a message says so. */
  isFull() {
    const last = this.frames.keys.at(-1)?.time ?? 0;
    if (last <= LATEST - GAP) return false;
    this.player.say("A key frame cannot be later than one hour.", true);
    return true;
  }

  replacing() {
    if (this.selected < 0) return;
    const frames = this.frames.replacing(this.selected, this.player.page.stance.q);
    this.show({ frames, place: this.selected });
  }

  remove(place: number) {
    if (place < 0) return;
    const focused = this.track.row.contains(document.activeElement);
    this.apply(this.frames.without(place), place);
    if (focused && this.frames.count === 0) this.tools.add.focus();
  }

  interpolate(interpolation: Interpolation) {
    this.apply(this.frames.interpolating(interpolation), this.selected);
    this.player.seek(this.now);
  }

  slowDown() {
    const { motion } = this.frames;
    if (!motion) return;
    this.apply(this.frames.retimed(slowedTimes(motion, this.limits)), this.selected);
    this.player.seek(this.selected < 0 ? this.now : this.frames.keys[this.selected].time);
  }

  // --- pointer and keyboard --------------------------------------------------------------------------------------

  seek(time: number) {
    this.selected = -1;
    this.player.seek(Math.round(time * 100) / 100);
    this.draw();
  }

  select(place: number) {
    this.selected = place;
    this.player.seek(this.frames.keys[place].time);
    this.player.dispatchEvent(new Event("selected"));
    this.draw();
    this.track.diamonds[place].focus();
  }

  /** A pointer grabs a key. */
  grab(place: number) {
    this.select(place);
    this.before = { frames: this.frames, selected: place };
  }

  /** The grabbed key is moved to a time. */
  drag(time: number) {
    this.show(this.before.frames.moving(this.before.selected, time));
  }

  /** Take over changed key frames, and show the one at a place. */
  show({ frames, place }: { frames: KeyFrames; place: number }) {
    this.apply(frames, place);
    this.player.seek(frames.keys[place].time);
  }

  /** A key of the keyboard is pressed on a key frame. */
  press(event: KeyboardEvent, place: number) {
    const step = event.shiftKey ? 0.01 : 0.1;
    const { track } = this;
    const last = this.frames.count - 1;
    const move = (by: number) => this.show(this.frames.moving(place, this.frames.keys[place].time + by));
    const go = (other: number) => () => this.select(clamp(other, 0, last));
    const remove = () => this.remove(place);
    handleKey(event, {
      ...{ ArrowLeft: () => move(-step), ArrowRight: () => move(step) },
      ...{ ArrowUp: go(place - 1), ArrowDown: go(place + 1), Home: go(0), End: go(last) },
      ...{ Enter: go(place), Delete: remove, Backspace: remove },
      ...{ "+": () => track.setZoom(2 * track.zoom), "-": () => track.setZoom(track.zoom / 2) },
    });
  }

  // --- drawing ---------------------------------------------------------------------------------------------------

  draw() {
    const { keys, motion } = this.frames;
    const found = motion ? excesses(motion, this.limits) : [];
    const tooFast = found.map(({ segment, column, needs }) => ({
      from: keys[segment].time,
      to: keys[segment + 1].time,
      text: `too fast: ${this.names.get(column)} needs ${needs.toFixed(2)} s`,
    }));
    this.track.draw(this.frames, this.selected, tooFast);
    this.track.setTime(this.now);
    this.tools.refresh(tooFast);
  }
}
