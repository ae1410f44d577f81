import { element } from "../panel/element.js";
import { turnsOf } from "./rings.js";
import { degrees } from "./sentence.js";
import "./handle_keys.css";

// How far an arrow key moves a handle [m], and with Shift; how far a letter turns its frame [rad].
const [STEP, LARGE] = [0.001, 0.01];
const TURN = Math.PI / 180;

/** Right and up on the screen. @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/**
 * @param {import("./rings.js").Axis[]} turns
 * @param {string} between
 */
const namesOf = (turns, between) => turns.map(({ name }) => name).join(between);

/** @param {import("./types.js").Handle} handle */
function titleOf(handle) {
  const turns = turnsOf(handle);
  const letters = namesOf(turns, ", ").toUpperCase();
  return [
    "Arrow keys move it by 1 mm, with Shift by 10 mm",
    ...(turns.length > 0 ? [`${letters} turn it by 1° about these axes of its frame, with Shift back`] : []),
    "Enter lets go, Escape gives back",
  ].join("; ");
}

/**
 * The handles by keyboard: a button for each, seen while the focus is among them. Arrow keys take hold of a handle and
 * move it in the plane that the camera faces, X, Y and Z turn its frame about its axes, as its rings do. Enter lets it go,
 * and Escape gives back what was before.
 */
export class HandleKeys {
  /**
   * @param {import("./drag.js").Drag} drag
   * @param {HTMLElement} bar
   */
  constructor(drag, bar) {
    this.drag = drag;
    this.bar = bar;
    /** What the handle that is held is held for: to be moved, or to be turned about an axis. */
    this.grip = "";
    const hint = "Arrow keys move it by 1 mm, with Shift by 10 mm; X, Y, Z turn it by 1°, with Shift back";
    bar.replaceChildren(
      element("span", { className: "hint" }, `${hint}; Enter lets go, Escape gives back`),
      ...drag.handles.map((handle) => {
        const button = element("button", { type: "button", title: titleOf(handle) }, handle.limb.frame);
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
    const letter = event.key.toLowerCase();
    if ((arrow || "xyz".includes(letter)) && !event.altKey && !event.ctrlKey && !event.metaKey) {
      if (drag.held && !isHolding) return;
      if (arrow) this.move(button, handle, arrow, event.shiftKey ? LARGE : STEP);
      else this.turn(button, handle, letter, event.shiftKey ? -TURN : TURN);
    } else if (event.key === "Enter" || event.key === " ") {
      if (isHolding) this.letGo(button);
      else if (!drag.held) this.takeToMove(button, handle);
    } else if (event.key === "Escape" && isHolding) {
      drag.cancel();
      this.letGo(button);
    } else return;
    event.preventDefault();
  }

  /**
   * @param {HTMLButtonElement} button
   * @param {import("./types.js").Handle} handle
   * @param {[number, number]} direction right and up on the screen
   * @param {number} length [m]
   */
  move(button, handle, [right, up], length) {
    const { drag } = this;
    this.takeToMove(button, handle);
    const gesture = /** @type {import("./limb_drag.js").LimbDrag} */ (drag.held?.gesture);
    const says = gesture.step(length * right, length * up);
    const place = gesture.place.map((value) => (1000 * value).toFixed(0)).join(", ");
    drag.say(`${says || handle.limb.frame}, at ${place} mm in ${handle.limb.torso}`);
  }

  /**
   * @param {HTMLButtonElement} button
   * @param {import("./types.js").Handle} handle
   * @param {string} name of the axis
   * @param {number} angle [rad]
   */
  turn(button, handle, name, angle) {
    const { drag } = this;
    const { frame } = handle.limb;
    const turns = turnsOf(handle);
    const axis = turns.find((one) => one.name === name);
    if (!axis) {
      drag.say(turns.length > 0 ? `${frame} turns about ${namesOf(turns, " and ")}` : `${frame} has no ring to turn`);
      return;
    }
    if (this.grip !== name) {
      this.drag.app.pick.selection.select(frame);
      drag.takeRing({ handle, axis });
      this.hold(button, name);
    }
    const gesture = /** @type {import("./turn_drag.js").TurnDrag} */ (drag.held?.gesture);
    const says = gesture.step(angle);
    drag.say(`${says ? `${says};` : frame} turned by ${degrees(gesture.reached, 1)} about ${name}`);
  }

  /**
   * @param {HTMLButtonElement} button
   * @param {import("./types.js").Handle} handle
   */
  takeToMove(button, handle) {
    if (this.grip === "move") return;
    this.drag.takeHandle(handle);
    this.hold(button, "move");
  }

  /**
   * @param {HTMLButtonElement} button
   * @param {string} grip
   */
  hold(button, grip) {
    this.grip = grip;
    button.setAttribute("aria-pressed", "true");
  }

  /** @param {HTMLButtonElement} button */
  letGo(button) {
    this.drag.end();
    this.grip = "";
    button.setAttribute("aria-pressed", "false");
  }

  /** @param {HTMLButtonElement} button */
  leave(button) {
    if (button.getAttribute("aria-pressed") === "true") this.letGo(button);
    this.drag.marks.light(null);
  }
}
