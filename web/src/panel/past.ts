import type { PageWith } from "../app.ts";
import type { Targets } from "../drag/targets.ts";
import type { Snapshot } from "../stance.ts";
import type { Edited } from "../timeline/editor.ts";

type Page = PageWith<"player" | "stance" | "targets">;

/** What undo gives back: how the robot was, the targets that were moved, and the key frames; none before there are any. */
type State = Snapshot & { edited?: Edited; placed: Targets["placed"] };

/**
 * Undo and redo of what this page did to the robot, to targets and to the key frames. All that happens while a pointer or a key is down
 * is one step.
 *
 * Events: "changed".
 */
export class Past extends EventTarget {
  history = new History<State>();
  now: State;
  /** What was before the step that is under way. */
  before: State | null = null;
  held = new Set<string>();

  constructor(readonly page: Page) {
    super();
    this.now = this.snapshot;
    page.addEventListener("settled", (event) => this.settled((event as CustomEvent).detail.own));
    page.addEventListener("placed", (event) => this.settled((event as CustomEvent).detail.own));
    page.player.addEventListener("edited", () => this.settled(true));
    // Undo of a drag that begins before the next picture gives the selection back, too.
    page.player.addEventListener("selected", () => this.settled(false));
    const begin = (what: string) => {
      this.finish();
      this.held.add(what);
    };
    // What the event itself does, a click for one, comes after it and belongs to the same step.
    const end = (what: string) => {
      this.held.delete(what);
      setTimeout(() => this.finish());
    };
    const options = { capture: true };
    window.addEventListener("pointerdown", ({ pointerId }) => begin(`pointer ${pointerId}`), options);
    window.addEventListener("pointerup", ({ pointerId }) => end(`pointer ${pointerId}`), options);
    window.addEventListener("pointercancel", ({ pointerId }) => end(`pointer ${pointerId}`), options);
    window.addEventListener("keydown", ({ code }) => begin(`key ${code}`), options);
    window.addEventListener(
      "keyup",
      ({ code, key }) => {
        // On a Mac no key goes up that went down with ⌘, until ⌘ itself does.
        if (key === "Meta") for (const what of this.held) if (what.startsWith("key ")) this.held.delete(what);
        end(`key ${code}`);
      },
      options,
    );
    window.addEventListener("blur", () => this.letGo());
  }

  // Keys and pointers that go up in another window are not heard of.
  letGo() {
    this.held.clear();
    this.finish();
  }

  get snapshot(): State {
    const { player, stance, targets } = this.page;
    return { ...stance.snapshot(), edited: player.editor?.edited, placed: targets.placed };
  }

  /** @param own whether this page made the change, rather than the program behind it or a clip */
  settled(own: boolean) {
    const now = this.snapshot;
    if (own && !same(now, this.now)) {
      this.before ??= this.now;
      if (this.held.size === 0) setTimeout(() => this.finish());
    }
    this.now = now;
  }

  finish() {
    if (this.held.size > 0) return;
    this.page.stance.settle();
    // With the key frame that is selected, and the time on show.
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
    const { player, stance, targets } = this.page;
    if (state.edited && state.edited.frames !== player.editor.frames) player.editor.restore(state.edited);
    targets.restore(state.placed);
    stance.jump(state.q, state.up);
    stance.settle();
    // It is no step of its own.
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
    String([...a.placed]) === String([...b.placed])
  );
}

/** What was before, and what was taken back: undo and redo of any state. */
export class History<State> {
  past: State[] = [];
  future: State[] = [];

  /** @param most steps that can be taken back; older ones are forgotten */
  constructor(readonly most: number = 200) {}

  /** Keep what was before a step; what had been taken back is gone. */
  push(before: State) {
    this.past.push(before);
    if (this.past.length > this.most) this.past.shift();
    this.future = [];
  }

  /** The state before the last step; undefined where there is none. */
  undo(now: State) {
    const state = this.past.pop();
    if (state !== undefined) this.future.push(now);
    return state;
  }

  /** The state that was taken back last; undefined where there is none. */
  redo(now: State) {
    const state = this.future.pop();
    if (state !== undefined) this.past.push(now);
    return state;
  }
}
