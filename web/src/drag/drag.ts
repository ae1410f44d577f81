import type { App } from "../app.ts";
import type { Ray, Vector3 } from "three";
import { LIMB_CLASSES } from "../ik/limbs.ts";
import { Ghosts, clearGhosts } from "../scene/ghosts.ts";
import type { Snapshot } from "../stance.ts";
import type { Gesture, Handle, Limb } from "./follow.ts";
import { HandleKeys, type Holdable } from "./handle_keys.ts";
import { AXES, Handles, Rings, turnsOf, type Ring } from "./handles.ts";
import { JointDrag, type motionOf } from "./joint_drag.ts";
import { LimbDrag, TurnDrag } from "./limb_drag.ts";
import { Pointer } from "./pointer.ts";
import { TargetMove, TargetTurn } from "./target_drag.ts";
import type { Grip } from "./targets.ts";

/**
 * Taking hold of the robot: of a handle on a hand, a foot or the gaze, which the limb follows, of a ring that turns a hand
 * or a foot, of a link of the selected limb, which its joint follows, or of a target of the program. While something is held the trunk stays where it is; when it is let go the robot stands on the floor
 * again. Event of the page: "gesture" with `held`, when something is taken hold of and when it is let go: all that happens
 * in between is one change.
 */
export class Drag {
  /** What is held, and what was before it. */
  held: ({ gesture: Gesture } & Snapshot) | null = null;
  limbs: Limb[];
  marks: Handles;
  rings: Rings;
  ghosts: Ghosts;
  pointer: Pointer;
  keys: HandleKeys;

  /**
   * @param line where what stops a drag is said
   * @param bar of the buttons that take handles by keyboard
   */
  constructor(
    readonly page: App,
    pane: HTMLElement,
    public line: HTMLElement,
    bar: HTMLElement,
  ) {
    this.limbs = page.robot.about.limbs.map((limb) => new (LIMB_CLASSES as any)[limb.kind](limb));
    this.marks = new Handles(page, this.limbs);
    this.rings = new Rings(page, this.marks);
    this.ghosts = new Ghosts(page.robot);
    this.pointer = new Pointer(page, this, pane);
    this.keys = new HandleKeys(this, bar);
    page.addEventListener("targets", () => {
      page.toggles.offer("handles", this.possible);
      this.keys.refresh();
    });
  }

  get handles() {
    return this.marks.list;
  }

  /** Whether there is a handle to drag. */
  get possible() {
    return this.holdables.length > 0;
  }

  /** What can be taken hold of by keyboard: the handles, and the targets of the program. */
  get holdables(): Holdable[] {
    const { page, marks, limbs, ghosts } = this;
    const handles = this.handles.map((handle) => ({
      name: handle.limb.frame,
      base: handle.limb.torso,
      turns: turnsOf(handle),
      light: (on: boolean) => marks.light(on ? handle : null),
      toMove: () => new LimbDrag(page, limbs, ghosts, handle, null),
      toTurn: (axis: Ring["axis"]) => {
        page.pick.selection.select(handle.limb.frame);
        return new TurnDrag(page, limbs, { handle, axis }, null);
      },
    }));
    const targets = page.targets.movable.map((target) => ({
      name: target.row.name,
      base: page.robot.about.root,
      turns: target.row.point ? [] : AXES,
      light: (on: boolean) => page.targets.light(on ? target.knob : null),
      toMove: () => new TargetMove(page, target),
      toTurn: (axis: Ring["axis"]) => new TargetTurn(page, target, axis),
    }));
    return [...handles, ...targets];
  }

  /** The camera where its control has put it since the last picture. */
  get camera() {
    return this.page.pick.viewport.camera;
  }

  /** @param on whether the handles are there */
  show(on: boolean) {
    this.marks.show(on);
    this.rings.refresh();
    this.page.targets.showGrips(on);
    this.keys.show(on);
  }

  takeHandle(handle: Handle, ray: Ray) {
    this.read(handle);
    this.begin(() => new LimbDrag(this.page, this.limbs, this.ghosts, handle, ray));
  }

  takeJoint(motion: NonNullable<ReturnType<typeof motionOf>>, point: Vector3, ray: Ray) {
    this.begin(() => new JointDrag(this.page, motion, point, ray));
  }

  /** @param pointer on it */
  takeRing(ring: Pick<Ring, "handle" | "axis">, pointer: { point: Vector3; ray: Ray }) {
    this.read(ring.handle);
    this.begin(() => new TurnDrag(this.page, this.limbs, ring, pointer));
  }

  // The panel reads what is held, unless it reads what is measured.
  read({ limb }: Handle) {
    const { measure, selection } = this.page.pick;
    if (!measure.active) selection.follow(limb.frame);
  }

  /** @param pointer on it */
  takeTarget({ target, axis, turns }: Grip, pointer: { point: Vector3; ray: Ray }) {
    this.begin(() =>
      axis && turns
        ? new TargetTurn(this.page, target, axis, pointer)
        : new TargetMove(this.page, target, axis, pointer),
    );
  }

  begin(make: () => Gesture) {
    this.page.stance.settle();
    if (this.held) {
      // By keyboard a handle is moved and turned in one hold: letting go is one change, and Escape gives back all of it.
      this.held.gesture.end();
      this.held.gesture = make();
      return;
    }
    this.held = { ...this.page.stance.snapshot(), gesture: make() };
    this.announce(true);
  }

  move(ray: Ray, options: { level: boolean }) {
    if (this.held) this.say(this.held.gesture.move(ray, options));
  }

  /** Let go. */
  end() {
    if (!this.held) return;
    const { page } = this;
    this.held.gesture.end();
    this.held = null;
    this.say("");
    // The legend goes only now: on a narrow page the picture grows by it.
    if (page.ghosts.entries.length > 0 && page.ghosts.copies.length === 0) clearGhosts(page);
    page.stance.restand();
    this.announce(false);
  }

  /** Let go, and give back what was there before. */
  cancel() {
    if (!this.held) return;
    const { q, up, gesture } = this.held;
    const { stance } = this.page;
    if (gesture.cancel) gesture.cancel();
    else stance.set(q, up);
    stance.settle();
    this.end();
  }

  announce(held: boolean) {
    this.page.dispatchEvent(new CustomEvent("gesture", { detail: { held } }));
  }

  say(text: string) {
    if (this.line.textContent !== text) this.line.textContent = text;
    this.line.hidden = text === "";
  }
}
