/**
 * What was before, and what was taken back: undo and redo of any state.
 *
 * @template State
 */
export class History {
  /** @param {number} most steps that can be taken back; older ones are forgotten */
  constructor(most = 200) {
    this.most = most;
    /** @type {State[]} */
    this.past = [];
    /** @type {State[]} */
    this.future = [];
  }

  /**
   * Keep what was before a step; what had been taken back is gone.
   *
   * @param {State} before
   */
  push(before) {
    this.past.push(before);
    if (this.past.length > this.most) this.past.shift();
    this.future = [];
  }

  /**
   * The state before the last step; undefined where there is none.
   *
   * @param {State} now
   */
  undo(now) {
    const state = this.past.pop();
    if (state !== undefined) this.future.push(now);
    return state;
  }

  /**
   * The state that was taken back last; undefined where there is none.
   *
   * @param {State} now
   */
  redo(now) {
    const state = this.future.pop();
    if (state !== undefined) this.past.push(now);
    return state;
  }
}
