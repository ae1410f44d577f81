import { Hover } from "./hover.ts";
import { Measure } from "./measure.ts";
import { Picker } from "./picker.ts";
import { Selection } from "./selection.ts";
import { Viewport } from "./viewport.ts";
import type { App } from "../app.ts";

/** What the pointer is over, what is selected, and what is measured. */
export class Pick {
  viewport: Viewport;
  picker: Picker;
  hover: Hover;
  selection: Selection;
  measure: Measure;

  constructor(app: App, pane: HTMLElement) {
    this.viewport = new Viewport(app.viewer, pane);
    this.picker = new Picker(app.robot, this.viewport);
    this.hover = new Hover(app, this.picker, pane);
    this.selection = new Selection(app);
    this.measure = new Measure(app);
  }
}
