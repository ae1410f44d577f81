import { Hover } from "./hover.js";
import { Measure } from "./measure.js";
import { Picker } from "./picker.js";
import { Selection } from "./selection.js";
import { Viewport } from "./viewport.js";

/** What the pointer is over, what is selected, and what is measured. */
export class Pick {
  /**
   * @param {import("../app.js").App} app
   * @param {HTMLElement} pane
   */
  constructor(app, pane) {
    this.viewport = new Viewport(app.viewer, pane);
    this.picker = new Picker(app.robot, this.viewport);
    this.hover = new Hover(app, this.picker, pane);
    this.selection = new Selection(app);
    this.measure = new Measure(app);
  }
}
