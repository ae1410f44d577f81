import type { App } from "../app.ts";
import type { Matrix4, Ray } from "three";
import { write } from "../panel/element.ts";
import { clearGhosts } from "../scene/ghosts.ts";
import { AXES, type Axis } from "../scene/shapes.ts";
import type { Snapshot } from "../stance.ts";
import type { Gesture, Grip, Hold } from "./gestures.ts";
import { HandleKeys } from "./handle_keys.ts";
import { Handles, nearest, turnsOf, type Pointed } from "./handles.ts";
import { JointDrag, type motionOf } from "./joint_drag.ts";
import { LimbDrag, TurnDrag } from "./limb_drag.ts";
import { Pointer } from "./pointer.ts";
import { TargetMove, TargetTurn } from "./targets.ts";

/**
 * Drags of the robot. You can drag a handle on a hand, a foot or the gaze, which the limb follows; a ring, which turns a
 * hand or a foot; a link of the selected limb, which its joint follows; and a target of the program. During a drag the trunk
 * stays where it is; afterwards the robot is placed on the floor again.
 *
 * Event of the page: "gesture", with `held` true when a drag begins and false when it ends. All changes in between are one
 * step of undo.
 */
export class Drag {
  /** The current gesture, the first gesture of the same hold, and the state before it. */
  held: ({ gesture: Gesture; first: Gesture; placed: Matrix4 } & Snapshot) | null = null;
  /** The grip that is highlighted because it is under the pointer or has the focus. */
  lit: Grip | null = null;
  marks = new Handles(this.page);
  pointer = new Pointer(this.page, this, this.pane);
  keys = new HandleKeys(this, this.bar);

  /**
   * @param line the element that shows what stops a drag
   * @param bar the bar of buttons for using the handles by keyboard
   */
  constructor(
    readonly page: App,
    readonly pane: HTMLElement,
    public line: HTMLElement,
    readonly bar: HTMLElement,
  ) {
    for (const event of ["targets", "handles"]) page.addEventListener(event, () => this.keys.refresh());
  }

  get handles() {
    return this.marks.list;
  }

  get rings() {
    return this.marks.rings;
  }

  /** Whether there is a handle to drag. */
  get possible() {
    return this.holdables.length > 0;
  }

  /**
   * What can be moved by keyboard, the handles and the targets of the program: its name, the frame in which its position is
   * announced, and the axes that it can turn about.
   */
  get holdables() {
    const { page } = this;
    const { floating, links, root } = page.robot.about;
    const first = floating ? links[0].name : root;
    const handles = this.handles.map((handle) => ({
      name: handle.limb.frame,
      base: handle.limb.kind === "base" ? "its place before" : first,
      turns: turnsOf(handle),
      light: (on: boolean) => this.light(on ? handle : null),
      toMove: () => new LimbDrag(page, handle, null),
      toTurn: (axis: Axis) => {
        page.pick.selection.select(handle.limb.frame);
        return new TurnDrag(page, handle, axis.axis, null);
      },
    }));
    const targets = page.targets.movable.map((target) => ({
      name: target.row.name,
      base: page.robot.about.root,
      turns: target.row.point ? [] : AXES,
      light: (on: boolean) => this.light(on ? target.knob : null),
      toMove: () => new TargetMove(page, target, null, null),
      toTurn: (axis: Axis) => new TargetTurn(page, target, axis, null),
    }));
    return [...handles, ...targets];
  }

  /** The camera, brought up to date with its control. */
  get camera() {
    return this.page.pick.viewport.camera;
  }

  show(on: boolean) {
    this.marks.show(on);
    this.page.targets.showGrips(on);
    this.keys.show(on);
    if (!on) this.light(null);
  }

  /**
   * The grip under the pointer and its point in the world. Targets come first, because a limb that follows a target has its
   * handle at the same place.
   */
  at(event: Pointed) {
    const handles = this.marks.shown ? this.handles : [];
    for (const grips of [this.page.targets.grips, handles, this.rings]) {
      const found = nearest(this.page.pick.viewport, event, grips);
      if (found) return found;
    }
    return null;
  }

  light(grip: Grip | null) {
    if (grip === this.lit) return;
    this.lit?.light(false);
    grip?.light(true);
    this.lit = grip;
    this.page.viewer.set_dirty();
  }

  take(grip: Grip, hold: Hold) {
    const { measure, selection } = this.page.pick;
    // The panel shows the pose of the limb that is held, unless it shows a measurement.
    if (grip.limb && !measure.active) selection.follow(grip.limb.frame);
    this.begin(() => grip.gesture(hold));
  }

  takeJoint(motion: NonNullable<ReturnType<typeof motionOf>>, hold: Hold) {
    this.begin(() => new JointDrag(this.page, motion, hold));
  }

  begin(make: () => Gesture) {
    this.page.stance.settle();
    if (this.held) {
      // By keyboard a handle can be moved and turned in one hold, which is one step of undo; Escape undoes all of it.
      this.held.gesture.end();
      this.held.gesture = make();
      return;
    }
    const gesture = make();
    const { robot, stance } = this.page;
    this.held = { ...stance.snapshot(), gesture, first: gesture, placed: robot.root.matrix.clone() };
    this.announce(true);
  }

  move(ray: Ray, options: { level: boolean }) {
    if (this.held) this.say(this.held.gesture.move(ray, options));
  }

  /** Let go. */
  end() {
    if (!this.held) return;
    const { page } = this;
    const { gesture } = this.held;
    gesture.end();
    this.held = null;
    this.say("");
    // The legend is cleared only now, because on a narrow page the picture then grows.
    if (page.ghosts.entries.length > 0 && page.ghosts.copies.length === 0) clearGhosts(page);
    const placed = page.robot.root.matrixWorld.clone();
    page.stance.restand();
    if (gesture.limb?.kind === "base") {
      page.stance.settle();
      page.studio.goWith(placed, page.robot.root.matrixWorld);
    }
    this.announce(false);
  }

  /** Let go, and restore the state before the drag. */
  cancel() {
    if (!this.held) return;
    const { q, up, first, placed } = this.held;
    const { robot, stance } = this.page;
    placed.decompose(robot.root.position, robot.root.quaternion, robot.root.scale);
    if (first.cancel) first.cancel();
    else stance.set(q, up);
    stance.settle();
    this.end();
  }

  announce(held: boolean) {
    this.page.dispatchEvent(new CustomEvent("gesture", { detail: { held } }));
  }

  say(text: string) {
    write(this.line, text);
  }
}
