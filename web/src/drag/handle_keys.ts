import "./handle_keys.css";
import { fixed } from "../math/numbers.ts";
import { element } from "../panel/element.ts";
import type { Drag } from "./drag.ts";
import type { Handle } from "./follow.ts";
import { turnsOf, type Axis } from "./handles.ts";
import type { LimbDrag, TurnDrag } from "./limb_drag.ts";
import { degrees } from "./stops.ts";

// How far an arrow key moves a handle [m], and with Shift; how far a letter turns its frame [rad].
const [STEP, LARGE] = [0.001, 0.01];
const TURN = Math.PI / 180;

/** Right and up on the screen. */
const ARROWS: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

const namesOf = (turns: Axis[], between: string) => turns.map(({ name }) => name).join(between);

function titleOf(handle: Handle) {
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
  /** What the handle that is held is held for: to be moved, or to be turned about an axis. */
  grip = "";

  constructor(
    readonly drag: Drag,
    public bar: HTMLElement,
  ) {
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

  show(on: boolean) {
    this.bar.hidden = !on || this.drag.handles.length === 0;
  }

  key(event: KeyboardEvent, button: HTMLButtonElement, handle: Handle) {
    const { drag } = this;
    const isHolding = button.getAttribute("aria-pressed") === "true";
    const arrow = Object.hasOwn(ARROWS, event.key) ? ARROWS[event.key] : null;
    const letter = event.key.toLowerCase();
    if ((arrow || "xyz".includes(letter)) && !event.altKey && !event.ctrlKey && !event.metaKey) {
      if (drag.held && !isHolding) return;
      if (arrow) this.move(button, handle, arrow, event.shiftKey ? LARGE : STEP);
      else this.turn(button, handle, letter, event.shiftKey ? -TURN : TURN);
    } else if (event.key === "Enter") {
      if (isHolding) this.letGo(button);
      else if (!drag.held) this.takeToMove(button, handle);
    } else if (event.key === "Escape" && isHolding) {
      drag.cancel();
      this.letGo(button);
    } else return;
    event.preventDefault();
  }

  /**
   * @param direction right and up on the screen
   * @param length [m]
   */
  move(button: HTMLButtonElement, handle: Handle, [right, up]: [number, number], length: number) {
    const { drag } = this;
    this.takeToMove(button, handle);
    const gesture = drag.held?.gesture as LimbDrag;
    const says = gesture.step(length * right, length * up);
    const place = gesture.place.map((value) => fixed(1000 * value, 0)).join(", ");
    drag.say(`${says || handle.limb.frame}, at ${place} mm in ${handle.limb.torso}`);
  }

  /**
   * @param name of the axis
   * @param angle [rad]
   */
  turn(button: HTMLButtonElement, handle: Handle, name: string, angle: number) {
    const { drag } = this;
    const { frame } = handle.limb;
    const turns = turnsOf(handle);
    const axis = turns.find((one) => one.name === name);
    if (!axis) {
      drag.say(turns.length > 0 ? `${frame} turns about ${namesOf(turns, " and ")}` : `${frame} has no ring to turn`);
      return;
    }
    if (this.grip !== name) {
      this.drag.page.pick.selection.select(frame);
      drag.takeRing({ handle, axis });
      this.hold(button, name);
    }
    const gesture = drag.held?.gesture as TurnDrag;
    const says = gesture.step(angle);
    drag.say(`${says ? `${says};` : frame} turned by ${degrees(gesture.reached, 1)} about ${name}`);
  }

  takeToMove(button: HTMLButtonElement, handle: Handle) {
    if (this.grip === "move") return;
    this.drag.takeHandle(handle);
    this.hold(button, "move");
  }

  hold(button: HTMLButtonElement, grip: string) {
    this.grip = grip;
    button.setAttribute("aria-pressed", "true");
  }

  letGo(button: HTMLButtonElement) {
    this.drag.end();
    this.grip = "";
    button.setAttribute("aria-pressed", "false");
  }

  leave(button: HTMLButtonElement) {
    if (button.getAttribute("aria-pressed") === "true") this.letGo(button);
    this.drag.marks.light(null);
  }
}
