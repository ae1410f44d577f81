import type { App } from "../app.ts";
import type { Targets } from "../drag/targets.ts";
import type { Controls } from "./controls.ts";
import type { Snapshot } from "../stance.ts";
import type { Edited } from "../timeline/editor.ts";

/** The state that undo restores: the configuration, targets and controls that were moved, and the key frames if any. */
type State = Snapshot & { edited?: Edited; placed: Targets["changes"]["kept"]; chosen: Controls["changes"]["kept"] };

// Steps by keys, such as arrows on a slider: presses in the same place within SERIES [ms] of each other are one step of undo.
const STEPPING = /^(Arrow|Page)/;
const MODIFIER = /^(Alt|Control|Meta|Shift)/;
const SERIES = 600;

/**
 * Undo and redo of the changes that this page made to the robot, to targets, to controls and to the key frames. All changes
 * while a pointer or a key is down, during a drag, or in a series of arrow keys are one step.
 *
 * Events: "changed".
 */
export class Past extends EventTarget {
  history = new History<State>();
  now = this.snapshot;
  /** The state before the current step. */
  before: State | null = null;
  /** The keys, pointers, drag and series that keep the step open. */
  held = new Set<string>();
  /** Where the last key made one of several steps. */
  series: EventTarget | null = null;
  timer = 0;

  constructor(readonly page: App) {
    super();
    page.addEventListener("settled", (event) => this.settled((event as CustomEvent).detail.own));
    page.addEventListener("placed", (event) => this.settled((event as CustomEvent).detail.own));
    page.player.addEventListener("edited", () => this.settled(true));
    // So that undo of a drag that begins before the next picture also restores the selected key.
    page.player.addEventListener("selected", () => this.settled(false));
    page.addEventListener("gesture", (event) => {
      if ((event as CustomEvent).detail.held) this.held.add("gesture");
      else if (this.held.delete("gesture")) this.keep();
    });
    const on = <Type extends keyof WindowEventMap>(type: Type, act: (event: WindowEventMap[Type]) => void) =>
      window.addEventListener(type, act, { capture: true });
    on("pointerdown", ({ pointerId }) => {
      // A press ends what is held by keyboard.
      this.held.delete("gesture");
      this.begin(`pointer ${pointerId}`);
    });
    on("pointerup", ({ pointerId }) => this.end(`pointer ${pointerId}`));
    on("pointercancel", ({ pointerId }) => this.end(`pointer ${pointerId}`));
    on("keydown", ({ code, target }) => {
      if (!MODIFIER.test(code)) this.begin(`key ${code}`, STEPPING.test(code) ? target : null);
    });
    on("keyup", ({ code, key }) => {
      // On a Mac, keys pressed with ⌘ send no keyup; they count as released when ⌘ is.
      if (key === "Meta") for (const what of this.held) if (what.startsWith("key ")) this.held.delete(what);
      this.end(`key ${code}`);
    });
    window.addEventListener("blur", () => this.letGo());
  }

  /** @param place where a key makes one of several steps; null for other keys and for pointers */
  begin(what: string, place: EventTarget | null = null) {
    clearTimeout(this.timer);
    const goesOn = this.held.delete("series") && place === this.series;
    if (!goesOn) this.finish();
    this.held.add(what);
    this.series = place;
  }

  end(what: string) {
    if (this.held.delete(what) && this.series) {
      this.held.add("series");
      clearTimeout(this.timer);
      this.timer = window.setTimeout(() => this.held.delete("series") && this.finish(), SERIES);
    }
    // The effect of the event, such as a click, comes after it and belongs to the same step.
    setTimeout(() => this.finish());
  }

  // Keys and pointers that are released in another window send no event here.
  letGo() {
    this.held.clear();
    this.finish();
  }

  get snapshot(): State {
    const { controls, player, stance, targets } = this.page;
    const [placed, chosen] = [targets.changes.kept, controls.changes.kept];
    return { ...stance.snapshot(), edited: player.editor?.edited, placed, chosen };
  }

  /** @param own whether this page made the change, and not the program or a clip */
  settled(own: boolean) {
    const now = this.snapshot;
    if (own && !same(now, this.now)) {
      this.before ??= this.now;
      if (this.held.size === 0) setTimeout(() => this.finish());
    }
    this.now = now;
  }

  finish() {
    if (this.held.size === 0) this.keep();
  }

  /** End the step. */
  keep() {
    this.page.stance.settle();
    // The snapshot includes the selected key frame and the time shown.
    this.now = this.snapshot;
    if (this.before && !same(this.before, this.now)) {
      this.history.push(this.before);
      this.dispatchEvent(new Event("changed"));
    }
    this.before = null;
  }

  undo() {
    this.letGo();
    this.show(this.history.undo(this.now));
  }

  redo() {
    this.letGo();
    this.show(this.history.redo(this.now));
  }

  show(state: State | undefined) {
    if (!state) return;
    const { controls, player, stance, targets } = this.page;
    if (state.edited && state.edited.frames !== player.editor.frames) player.editor.restore(state.edited);
    targets.restore(state.placed);
    controls.restore(state.chosen);
    stance.jump(state.q, state.up);
    stance.settle();
    // Undo and redo are not steps themselves.
    this.now = this.snapshot;
    this.before = null;
    this.dispatchEvent(new Event("changed"));
  }
}

function same(a: State, b: State) {
  return (
    a.edited?.frames === b.edited?.frames &&
    a.q.every((value, i) => value === b.q[i]) &&
    String(a.up) === String(b.up) &&
    String([...a.placed]) === String([...b.placed]) &&
    String([...a.chosen]) === String([...b.chosen])
  );
}

/** The past and future states for undo and redo. */
export class History<Item> {
  past: Item[] = [];
  future: Item[] = [];

  /** @param most steps that can be undone; older ones are forgotten */
  constructor(readonly most: number = 200) {}

  /** Keep the state before a step; undone steps can no longer be redone. */
  push(before: Item) {
    this.past.push(before);
    if (this.past.length > this.most) this.past.shift();
    this.future = [];
  }

  /** The state before the last step; undefined if there is none. */
  undo(now: Item) {
    const state = this.past.pop();
    if (state !== undefined) this.future.push(now);
    return state;
  }

  /** The state that was undone last; undefined if there is none. */
  redo(now: Item) {
    const state = this.future.pop();
    if (state !== undefined) this.past.push(now);
    return state;
  }
}
