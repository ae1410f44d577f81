import type { PageWith } from "../app.ts";
import { isOneLimb } from "../pick/facts.ts";
import type { Hit } from "../pick/pick.ts";
import type { Drag } from "./drag.ts";
import { motionOf } from "./joint_drag.ts";

type Page = PageWith<"pick" | "robot" | "stance" | "viewer">;

// A pointer that has come no farther [px] has not moved: a click, or a tap.
const [STILL, TAP] = [4, 10];

/**
 * Where a pointer went down, and on what; `take` is how the robot is taken hold of there, null where that is for the camera.
 */
interface Press {
  id: number;
  clientX: number;
  clientY: number;
  shift: boolean;
  /** Of the handle or the ring there. */
  frame: string | undefined;
  hit: Hit | null;
  take: (() => void) | null;
  still: boolean;
}

/**
 * What a pointer on the picture does. On a handle it takes hold of it, on a link of the selected limb of its joint; anywhere
 * else, with another button than the first, or with a key held down, it moves the camera, as meshcat's control has it. A
 * click selects, and measures when that is on or Shift is down.
 */
export class Pointer {
  press: Press | null = null;

  constructor(
    public page: Page,
    readonly drag: Drag,
    public pane: HTMLElement,
  ) {
    // Before the camera's own control, which listens on the canvas inside.
    pane.addEventListener("pointerdown", (event) => this.down(event), true);
    pane.addEventListener("pointermove", (event) => this.move(event));
    // What begins on the picture may end anywhere: the camera's control takes the pointer with it.
    window.addEventListener("pointerup", (event) => this.up(event));
    window.addEventListener("pointercancel", (event) => this.up(event));
    pane.addEventListener("pointerleave", (event) => this.leave(event));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  down(event: PointerEvent) {
    this.page.pick.hover.clear();
    // A second finger makes no tap of the first.
    if (this.press) this.press.still = false;
    if (this.drag.held || this.press || event.button !== 0 || !event.isPrimary) return;
    this.page.stance.settle();
    const { clientX, clientY, pointerId: id, shiftKey: shift } = event;
    const ray = this.page.pick.viewport.ray(event);
    const found = this.drag.at(event);
    const hit = found ? null : this.page.pick.picker.at(event);
    const motion = hit && this.mayMove(event, hit.link) ? motionOf(this.page.robot, hit.link, hit.point) : null;
    let take: Press["take"] = null;
    if (found) take = () => this.drag.take(found.grip, { point: found.point, ray });
    else if (hit && motion) take = () => this.drag.takeJoint(motion, { point: hit.point, ray });
    this.press = { id, clientX, clientY, shift, frame: found?.grip.limb?.frame, hit, take, still: true };
    if (!take) return;
    this.page.viewer.controls.enabled = false;
    this.pane.setPointerCapture(id);
    this.pane.style.cursor = "grabbing";
  }

  /** Whether a press on a link is for its joint, and not for the camera: its limb is selected. */
  mayMove({ altKey, ctrlKey, metaKey, shiftKey }: PointerEvent, link: number) {
    const { measure, selection } = this.page.pick;
    if (measure.picking || altKey || ctrlKey || metaKey || shiftKey) return false;
    return selection.link !== null && isOneLimb(this.page.robot.about, selection.link, link);
  }

  move(event: PointerEvent) {
    const { press, drag } = this;
    if (!press) {
      if (event.pointerType !== "touch" && event.buttons === 0) this.hover(event);
      return;
    }
    if (event.pointerId !== press.id) return;
    const way = Math.hypot(event.clientX - press.clientX, event.clientY - press.clientY);
    if (way > (event.pointerType === "touch" ? TAP : STILL)) press.still = false;
    if (press.still || !press.take) return;
    if (!drag.held) press.take();
    drag.move(this.page.pick.viewport.ray(event), { level: event.shiftKey });
  }

  up(event: PointerEvent) {
    const { press } = this;
    if (!press || event.pointerId !== press.id) return;
    this.release();
    this.drag.end();
    const isUp = event.type === "pointerup";
    if (isUp && press.still) this.click(press, event);
    const isOver = event.target instanceof Node && this.pane.contains(event.target);
    if (isUp && isOver && event.pointerType !== "touch") this.hover(event);
  }

  release() {
    this.press = null;
    this.page.viewer.controls.enabled = true;
    this.pane.style.cursor = "";
  }

  click({ frame, hit, shift }: Press, event: PointerEvent) {
    const { measure, selection, hover } = this.page.pick;
    if (measure.picking || shift) {
      if (frame) return measure.pick({ kind: "frame", name: frame });
      if (hit) return measure.pick({ kind: "point", link: hit.link, local: hit.local });
      if (measure.picking) return;
    }
    if (frame) selection.select(frame);
    else if (hit) selection.selectLink(hit.link);
    else selection.select(null);
    // A finger does not hover: what it is on is told when it taps.
    if (event.pointerType === "touch") hover.show(hit?.link ?? null, event);
  }

  hover(event: PointerEvent) {
    const { hover } = this.page.pick;
    const grip = this.drag.at(event)?.grip ?? null;
    this.drag.light(grip);
    const point = (on: boolean) => (this.pane.style.cursor = on ? "grab" : "");
    if (!grip) return hover.follow(event, (link) => point(link !== null && this.mayMove(event, link)));
    point(true);
    hover.clear();
  }

  leave({ pointerType }: PointerEvent) {
    // A finger that is lifted leaves too.
    if (this.press || pointerType === "touch") return;
    this.drag.light(null);
    this.page.pick.hover.clear();
  }

  // Escape gives back what is held, or else takes away what is measured, or else what is selected.
  key(event: KeyboardEvent) {
    if (event.key !== "Escape" || event.defaultPrevented) return;
    // What is open over the picture closes, and takes nothing along.
    if (event.target instanceof Element && event.target.closest("dialog, [popover]")) return;
    const { measure, selection } = this.page.pick;
    if (this.drag.held) {
      this.drag.cancel();
      if (this.press) this.press.take = null;
      this.page.viewer.controls.enabled = true;
      this.pane.style.cursor = "";
    } else if (event.target instanceof HTMLInputElement) return;
    else if (measure.active) measure.clear();
    else selection.select(null);
  }
}
