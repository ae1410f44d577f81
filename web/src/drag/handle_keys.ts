import "./handle_keys.css";
import { fixed } from "../math/numbers.ts";
import { element } from "../panel/element.ts";
import type { Drag } from "./drag.ts";
import type { Axis } from "../scene/shapes.ts";
import { degrees } from "./stops.ts";

/** What a button grabs: a handle or a target. */
type Holdable = Drag["holdables"][number];

// How far an arrow key moves a handle [m], without and with Shift; how far a letter turns its frame [rad].
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

/**
 * The handles by keyboard: a button for each, visible while one of them has the focus. Arrow keys grab a handle and move it
 * in the plane that faces the camera; X, Y and Z turn its frame about its axes, as its rings do. Enter lets it go, and
 * Escape restores the state before.
 */
export class HandleKeys {
  /** How the handle is held: "move", or the name of the axis that it is turned about. */
  grip = "";
  shown = true;

  constructor(
    readonly drag: Drag,
    public bar: HTMLElement,
  ) {
    this.refresh();
  }

  /** Make the buttons again; the one with the focus keeps it. */
  refresh() {
    const { bar, drag } = this;
    const focus = bar.contains(document.activeElement) ? document.activeElement?.textContent : null;
    if (focus && this.grip) drag.end();
    this.grip = "";
    const hint = "Arrow keys move it by 1 mm, with Shift by 10 mm; X, Y, Z turn it by 1°, with Shift the other way";
    const buttons = drag.holdables.map((held) => {
      const button = element("button", { type: "button" }, held.name);
      button.setAttribute("aria-describedby", "handle-keys");
      button.onfocus = () => held.light(true);
      button.onblur = () => this.leave(button, held);
      button.onkeydown = (event) => this.key(event, button, held);
      return button;
    });
    bar.replaceChildren(
      element("span", { className: "hint", id: "handle-keys" }, `${hint}; Enter lets go, Escape undoes the move`),
      ...buttons,
    );
    if (focus) buttons.find(({ textContent }) => textContent === focus)?.focus();
    this.show(this.shown);
  }

  show(on: boolean) {
    this.shown = on;
    this.bar.hidden = !on || !this.drag.possible;
  }

  key(event: KeyboardEvent, button: HTMLButtonElement, held: Holdable) {
    const { drag } = this;
    const isHolding = button.getAttribute("aria-pressed") === "true";
    const arrow = Object.hasOwn(ARROWS, event.key) ? ARROWS[event.key] : null;
    const letter = event.key.toLowerCase();
    if ((arrow || "xyz".includes(letter)) && !event.altKey && !event.ctrlKey && !event.metaKey) {
      if (drag.held && !isHolding) return;
      if (arrow) this.move(button, held, arrow, event.shiftKey ? LARGE : STEP);
      else this.turn(button, held, letter, event.shiftKey ? -TURN : TURN);
    } else if (event.key === "Enter") {
      if (isHolding) this.letGo(button);
      else if (!drag.held) this.takeToMove(button, held);
    } else if (event.key === "Escape" && isHolding) {
      drag.cancel();
      this.letGo(button);
    } else return;
    event.preventDefault();
  }

  move(button: HTMLButtonElement, held: Holdable, [right, up]: [number, number], length: number) {
    const { drag } = this;
    this.takeToMove(button, held);
    const gesture = drag.held?.gesture as ReturnType<Holdable["toMove"]>;
    const says = gesture.step(length * right, length * up);
    const place = gesture.place.map((value) => fixed(1000 * value, 0)).join(", ");
    drag.say(`${says || held.name}, at ${place} mm in ${held.base}`);
  }

  turn(button: HTMLButtonElement, held: Holdable, name: string, angle: number) {
    const { drag } = this;
    const { name: frame, turns } = held;
    const axis = turns.find((one) => one.name === name);
    if (!axis) {
      drag.say(turns.length > 0 ? `${frame} turns about ${namesOf(turns, " and ")}` : `${frame} has no ring to turn`);
      return;
    }
    if (this.grip !== name) {
      drag.begin(() => held.toTurn(axis));
      this.hold(button, name);
    }
    const gesture = drag.held?.gesture as ReturnType<Holdable["toTurn"]>;
    const says = gesture.step(angle);
    drag.say(`${says ? `${says};` : frame} turned by ${degrees(gesture.reached, 1)} about ${name}`);
  }

  takeToMove(button: HTMLButtonElement, held: Holdable) {
    if (this.grip === "move") return;
    this.drag.begin(() => held.toMove());
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

  leave(button: HTMLButtonElement, held: Holdable) {
    if (button.getAttribute("aria-pressed") === "true") this.letGo(button);
    held.light(false);
  }
}
