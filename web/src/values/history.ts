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
