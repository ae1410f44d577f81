import { History } from "../values/history.js";

/** @typedef {{ q: number[], up: ArrayLike<number> | null }} Stance how the robot was */

/**
 * Undo and redo of what this page did to the robot. All that happens while a pointer or a key is down is one step.
 *
 * Events: "changed".
 */
export class Past extends EventTarget {
  /**
   * @param {import("../app.js").App} app
   * @param {AbortSignal} signal
   */
  constructor(app, signal) {
    super();
    this.app = app;
    /** @type {History<Stance>} */
    this.history = new History();
    this.now = this.stance();
    /** What was before the step that is under way. @type {Stance | null} */
    this.before = null;
    this.held = new Set();
    app.addEventListener("settled", (event) => this.settled(/** @type {CustomEvent} */ (event).detail.own), { signal });
    const begin = (/** @type {string} */ what) => {
      this.finish();
      this.held.add(what);
    };
    // What the event itself does, a click for one, comes after it and belongs to the same step.
    const end = (/** @type {string} */ what) => {
      this.held.delete(what);
      setTimeout(() => this.finish());
    };
    const options = { signal, capture: true };
    window.addEventListener("pointerdown", ({ pointerId }) => begin(`pointer ${pointerId}`), options);
    window.addEventListener("pointerup", ({ pointerId }) => end(`pointer ${pointerId}`), options);
    window.addEventListener("pointercancel", ({ pointerId }) => end(`pointer ${pointerId}`), options);
    window.addEventListener("keydown", ({ code }) => begin(`key ${code}`), options);
    window.addEventListener("keyup", ({ code }) => end(`key ${code}`), options);
    window.addEventListener("blur", () => this.letGo(), { signal });
  }

  stance() {
    return { q: [...this.app.q], up: this.app.up };
  }

  // Keys and pointers that go up in another window are not heard of.
  letGo() {
    this.held.clear();
    this.finish();
  }

  /** @param {boolean} own whether this page moved the robot, rather than the program behind it or a clip */
  settled(own) {
    const now = this.stance();
    if (own && !same(now, this.now)) {
      this.before ??= this.now;
      if (this.held.size === 0) setTimeout(() => this.finish());
    }
    this.now = now;
  }

  finish() {
    if (this.held.size > 0) return;
    this.app.settle();
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

  /** @param {Stance | undefined} stance */
  show(stance) {
    if (!stance) return;
    this.app.jump(stance.q, stance.up);
    // It is no step of its own.
    this.now = stance;
    this.app.settle();
    this.dispatchEvent(new Event("changed"));
  }
}

/**
 * @param {Stance} a
 * @param {Stance} b
 */
function same(a, b) {
  return a.q.every((value, i) => value === b.q[i]) && String(a.up) === String(b.up);
}
