import type { Ray, Vector3 } from "three";
import type { App } from "../app.ts";
import { LIMB_CLASSES } from "../ik/limbs.ts";
import { Ghosts, clearGhosts } from "../scene/ghosts.ts";
import type { Snapshot } from "../stance.ts";
import type { Gesture, Handle, Limb } from "./follow.ts";
import { HandleKeys } from "./handle_keys.ts";
import { Handles, Rings, type Ring } from "./handles.ts";
import { JointDrag, type motionOf } from "./joint_drag.ts";
import { LimbDrag, TurnDrag } from "./limb_drag.ts";
import { Pointer } from "./pointer.ts";

/**
 * Taking hold of the robot: of a handle on a hand, a foot or the gaze, which the limb follows, of a ring that turns a hand
 * or a foot, or of a link, which its joint follows. While something is held the trunk stays where it is; when it is let go the robot stands on the floor
 * again. Event of the app: "gesture" with `held`, when something is taken hold of and when it is let go: all that happens
 * in between is one change.
 */
export class Drag {
  /** What is held, and what was before it. */
  held: ({ gesture: Gesture } & Snapshot) | null = null;
  /** Whether a link may be taken hold of. */
  movesJoints = false;
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
    readonly app: App,
    pane: HTMLElement,
    public line: HTMLElement,
    bar: HTMLElement,
  ) {
    this.limbs = app.robot.about.limbs.map((limb) => new (LIMB_CLASSES as any)[limb.kind](limb));
    this.marks = new Handles(app, this.limbs);
    this.rings = new Rings(app, this.marks);
    this.ghosts = new Ghosts(app.robot);
    this.pointer = new Pointer(app, this, pane);
    this.keys = new HandleKeys(this, bar);
  }

  get handles() {
    return this.marks.list;
  }

  /** Whether there is a handle to drag. */
  get possible() {
    return this.handles.length > 0;
  }

  /** The camera where its control has put it since the last picture. */
  get camera() {
    return this.app.pick.viewport.camera;
  }

  /** @param on whether the handles are there */
  show(on: boolean) {
    this.marks.show(on);
    this.rings.refresh();
    this.keys.show(on);
  }

  takeHandle(handle: Handle, ray: Ray | null = null) {
    this.begin(() => new LimbDrag(this.app, this.limbs, this.ghosts, handle, ray));
  }

  takeJoint(motion: NonNullable<ReturnType<typeof motionOf>>, point: Vector3, ray: Ray) {
    this.begin(() => new JointDrag(this.app, motion, point, ray));
  }

  /** @param pointer on it */
  takeRing(ring: Pick<Ring, "handle" | "axis">, pointer: { point: Vector3; ray: Ray } | null = null) {
    this.begin(() => new TurnDrag(this.app, this.limbs, ring, pointer));
  }

  begin(make: () => Gesture) {
    this.app.stance.settle();
    if (this.held) {
      // By keyboard a handle is moved and turned in one hold: letting go is one change, and Escape gives back all of it.
      this.held.gesture.end();
      this.held.gesture = make();
      return;
    }
    this.held = { ...this.app.stance.snapshot(), gesture: make() };
    this.announce(true);
  }

  move(ray: Ray, options: { level: boolean }) {
    if (this.held) this.say(this.held.gesture.move(ray, options));
  }

  /** Let go. */
  end() {
    if (!this.held) return;
    const { app } = this;
    this.held.gesture.end();
    this.held = null;
    this.say("");
    // The legend goes only now: on a narrow page the picture grows by it.
    if (app.ghosts.entries.length > 0 && app.ghosts.copies.length === 0) clearGhosts(app);
    app.stance.restand();
    this.announce(false);
  }

  /** Let go, and give back the configuration that was there before. */
  cancel() {
    if (!this.held) return;
    const { q, up } = this.held;
    const { stance } = this.app;
    stance.set(q, up);
    stance.settle();
    this.end();
  }

  announce(held: boolean) {
    this.app.dispatchEvent(new CustomEvent("gesture", { detail: { held } }));
  }

  say(text: string) {
    if (this.line.textContent !== text) this.line.textContent = text;
    this.line.hidden = text === "";
  }
}
