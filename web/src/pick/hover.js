import { Highlight } from "./highlight.js";
import { Tip } from "./tip.js";

/** What the pointer is over: a tinted link, and its tip. */
export class Hover {
  /**
   * @param {import("../app.js").App} app
   * @param {import("./picker.js").Picker} picker
   * @param {HTMLElement} view
   */
  constructor(app, picker, view) {
    this.app = app;
    this.picker = picker;
    this.highlight = new Highlight(app.robot);
    this.tip = new Tip(app, view);
    /** @type {{ clientX: number, clientY: number } | null} */
    this.waiting = null;
    app.addEventListener("settled", () => this.tip.refresh());
  }

  /**
   * Look, before the next picture, what is under the pointer; of more places in between the last counts.
   *
   * @param {{ clientX: number, clientY: number }} place
   */
  follow({ clientX, clientY }) {
    const isWaiting = this.waiting !== null;
    this.waiting = { clientX, clientY };
    if (!isWaiting) requestAnimationFrame(() => this.look());
  }

  look() {
    if (!this.waiting) return;
    const place = this.waiting;
    this.waiting = null;
    this.show(this.picker.at(place)?.link ?? null, place);
  }

  /**
   * @param {number | null} link
   * @param {{ clientX: number, clientY: number }} place
   */
  show(link, place) {
    this.waiting = null;
    this.tip.show(link, place);
    if (this.highlight.show(link)) this.app.viewer.set_dirty();
  }

  clear() {
    this.show(null, { clientX: 0, clientY: 0 });
  }
}
