import { element } from "../panel/element.js";
import "./handle_keys.css";

// How far an arrow key moves a handle [m], and with Shift.
const [STEP, LARGE] = [0.001, 0.01];

/** Right and up on the screen. @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/**
 * The handles by keyboard: a button for each, seen while the focus is among them. Arrow keys take hold of a handle and
 * move it in the plane that the camera faces, Enter lets it go, and Escape gives back what was before.
 */
export class HandleKeys {
  /**
   * @param {import("./drag.js").Drag} drag
   * @param {HTMLElement} bar
   */
  constructor(drag, bar) {
    this.drag = drag;
    this.bar = bar;
    const hint = "Arrow keys move it by 1 mm, with Shift by 10 mm; Enter lets go, Escape gives back";
    bar.replaceChildren(
      element("span", { className: "hint" }, hint),
      ...drag.handles.map((handle) => {
        const button = element("button", { type: "button", title: hint }, handle.limb.frame);
        button.onfocus = () => drag.marks.light(handle);
        button.onblur = () => this.leave(button);
        button.onkeydown = (event) => this.key(event, button, handle);
        return button;
      }),
    );
  }

  /** @param {boolean} on */
  show(on) {
    this.bar.hidden = !on || this.drag.handles.length === 0;
  }

  /**
   * @param {KeyboardEvent} event
   * @param {HTMLButtonElement} button
   * @param {import("./types.js").Handle} handle
   */
  key(event, button, handle) {
    const { drag } = this;
    const isHolding = button.getAttribute("aria-pressed") === "true";
    const arrow = Object.hasOwn(ARROWS, event.key) ? ARROWS[event.key] : null;
    if (arrow && !event.altKey && !event.ctrlKey && !event.metaKey) {
      if (drag.held && !isHolding) return;
      if (!isHolding) this.take(button, handle);
      const length = event.shiftKey ? LARGE : STEP;
      const gesture = /** @type {import("./limb_drag.js").LimbDrag} */ (drag.held?.gesture);
      const says = gesture.step(length * arrow[0], length * arrow[1]);
      const place = gesture.place.map((value) => (1000 * value).toFixed(0)).join(", ");
      drag.say(`${says || handle.limb.frame}, at ${place} mm in ${handle.limb.torso}`);
    } else if (event.key === "Enter" || event.key === " ") {
      if (isHolding) this.letGo(button);
      else if (!drag.held) this.take(button, handle);
    } else if (event.key === "Escape" && isHolding) {
      drag.cancel();
      this.letGo(button);
    } else return;
    event.preventDefault();
  }

  /**
   * @param {HTMLButtonElement} button
   * @param {import("./types.js").Handle} handle
   */
  take(button, handle) {
    this.drag.takeHandle(handle);
    button.setAttribute("aria-pressed", "true");
  }

  /** @param {HTMLButtonElement} button */
  letGo(button) {
    this.drag.end();
    button.setAttribute("aria-pressed", "false");
  }

  /** @param {HTMLButtonElement} button */
  leave(button) {
    if (button.getAttribute("aria-pressed") === "true") this.letGo(button);
    this.drag.marks.light(null);
  }
}
