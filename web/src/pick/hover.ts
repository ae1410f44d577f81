import { Highlight } from "./highlight.ts";
import { Tip } from "./tip.ts";
import type { App } from "../app.ts";
import type { Picker } from "./picker.ts";

/** What the pointer is over: a tinted link, and its tip. */
export class Hover {
  highlight: Highlight;
  tip: Tip;
  waiting: { clientX: number; clientY: number } | null = null;

  constructor(
    readonly app: App,
    readonly picker: Picker,
    view: HTMLElement,
  ) {
    this.highlight = new Highlight(app.robot);
    this.tip = new Tip(app, view);
    app.addEventListener("settled", () => this.tip.refresh());
  }

  /** Look, before the next picture, what is under the pointer; of more places in between the last counts. */
  follow({ clientX, clientY }: { clientX: number; clientY: number }) {
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

  show(link: number | null, place: { clientX: number; clientY: number }) {
    this.waiting = null;
    this.tip.show(link, place);
    if (this.highlight.show(link)) this.app.viewer.set_dirty();
  }

  clear() {
    this.show(null, { clientX: 0, clientY: 0 });
  }
}
