import type { App } from "../app.ts";
import { isOneLimb } from "../pick/facts.ts";
import type { Hit } from "../pick/pick.ts";
import type { Drag } from "./drag.ts";
import { motionOf } from "./joint_drag.ts";

// A pointer that moves no farther than this [px] clicks (mouse) or taps (finger).
const [STILL, TAP] = [4, 10];

/**
 * Where a pointer went down, and what is there; `take` begins a drag, and is null if the press is for the camera.
 */
interface Press {
  id: number;
  clientX: number;
  clientY: number;
  shift: boolean;
  /** The frame of the handle, ring or label there. */
  frame: string | undefined;
  hit: Hit | null;
  take: (() => void) | null;
  still: boolean;
  /** The latest event of the pointer. */
  last: PointerEvent;
}

/**
 * Handles the pointer on the picture. On a handle it drags the handle, and on a link of the selected limb the link's joint.
 * Elsewhere, with another mouse button, or with a modifier key, it moves the camera by meshcat's control. Two fingers always
 * move the camera. A click selects; if measuring is on or Shift is down, it measures.
 */
export class Pointer {
  press: Press | null = null;

  constructor(
    public page: App,
    readonly drag: Drag,
    public pane: HTMLElement,
  ) {
    // In the capture phase, so before the camera's own control, which listens on the pane too.
    pane.addEventListener("pointerdown", (event) => this.down(event), true);
    pane.addEventListener("pointermove", (event) => this.move(event));
    // A press that begins on the picture may end anywhere, because the camera's control captures the pointer.
    window.addEventListener("pointerup", (event) => this.up(event));
    window.addEventListener("pointercancel", (event) => this.up(event));
    pane.addEventListener("pointerleave", (event) => this.leave(event));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  down(event: PointerEvent) {
    this.page.pick.hover.clear();
    if (this.press && event.pointerId !== this.press.id && event.pointerType === "touch") this.pinch(this.press);
    if (this.drag.held || this.press || event.button !== 0 || !event.isPrimary) return;
    this.page.stance.settle();
    const { clientX, clientY, pointerId: id, shiftKey: shift } = event;
    const ray = this.page.pick.viewport.ray(event);
    const found = this.drag.at(event);
    const frame = found?.grip.limb?.frame ?? this.labelled(event);
    const hit = found || frame ? null : this.page.pick.picker.at(event);
    const motion = hit && this.mayMove(event, hit.link) ? motionOf(this.page.robot, hit.link, hit.point) : null;
    let take: Press["take"] = null;
    if (found) take = () => this.drag.take(found.grip, { point: found.point, ray });
    else if (hit && motion) take = () => this.drag.takeJoint(motion, { point: hit.point, ray });
    this.press = { id, clientX, clientY, shift, frame, hit, take, still: true, last: event };
    if (!take) return;
    this.page.viewer.controls.enabled = false;
    this.pane.setPointerCapture(id);
    this.pane.style.cursor = "grabbing";
  }

  /** The frame whose label or triad is there. */
  labelled(event: PointerEvent) {
    const text = this.page.labels.at(event);
    return this.page.frames.names.find((name) => name === text);
  }

  // A second finger: the first one is no tap, and what it drags is put back. Both go to the camera's control, which ignored
  // the first finger while it was to drag, and therefore gets its press now.
  pinch(press: Press) {
    press.still = false;
    if (!press.take || press.last.pointerType !== "touch") return;
    press.take = null;
    this.drag.cancel();
    this.freeCamera();
    const { pointerId, clientX, clientY } = press.last;
    const again = new PointerEvent("pointerdown", {
      pointerId,
      clientX,
      clientY,
      pointerType: "touch",
      isPrimary: true,
    });
    this.pane.dispatchEvent(again);
  }

  /** Whether a press on a link moves its joint and not the camera: its limb must be selected, and no modifier key down. */
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
    press.last = event;
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
    this.freeCamera();
  }

  freeCamera() {
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
    // A finger cannot hover, so the tip is shown on a tap.
    if (event.pointerType === "touch") hover.show(hit?.link ?? null, event);
  }

  hover(event: PointerEvent) {
    const { hover } = this.page.pick;
    const grip = this.drag.at(event)?.grip ?? null;
    this.drag.light(grip);
    const point = (on: boolean) => (this.pane.style.cursor = on ? "grab" : "");
    if (!grip && this.labelled(event)) {
      hover.clear();
      this.pane.style.cursor = "pointer";
      return;
    }
    if (!grip) return hover.follow(event, (link) => point(link !== null && this.mayMove(event, link)));
    point(true);
    hover.clear();
  }

  leave({ pointerType }: PointerEvent) {
    // A lifted finger sends this event too.
    if (this.press || pointerType === "touch") return;
    this.drag.light(null);
    this.page.pick.hover.clear();
  }

  // Escape undoes a drag; without one it clears the measurement, and without that the selection.
  key(event: KeyboardEvent) {
    if (event.key !== "Escape" || event.defaultPrevented) return;
    // In an open dialog or menu, Escape only closes it.
    if (event.target instanceof Element && event.target.closest("dialog, [popover]")) return;
    const { measure, selection } = this.page.pick;
    if (this.drag.held) {
      this.drag.cancel();
      if (this.press) this.press.take = null;
      this.freeCamera();
    } else if (event.target instanceof HTMLInputElement) return;
    else if (measure.active) measure.clear();
    else selection.select(null);
  }
}
