import { LIMB_CLASSES } from "../ik/limbs.js";
import { Ghosts, clearGhosts } from "../scene/ghosts.js";
import { HandleKeys } from "./handle_keys.js";
import { Handles } from "./handles.js";
import { JointDrag } from "./joint_drag.js";
import { LimbDrag } from "./limb_drag.js";
import { Pointer } from "./pointer.js";
import { Rings } from "./rings.js";
import { TurnDrag } from "./turn_drag.js";

/** @typedef {import("./types.js").Gesture} Gesture */
/** @typedef {import("./types.js").Limb} Limb */

/**
 * Taking hold of the robot: of a handle on a hand, a foot or the gaze, which the limb follows, of a ring that turns a hand
 * or a foot, or of a link, which its joint follows. While something is held the trunk stays where it is; when it is let go the robot stands on the floor
 * again. Event of the app: "gesture" with `held`, when something is taken hold of and when it is let go: all that happens
 * in between is one change.
 */
export class Drag {
  /**
   * @param {import("../app.js").App} app
   * @param {HTMLElement} pane
   * @param {HTMLElement} line where what stops a drag is said
   * @param {HTMLElement} bar of the buttons that take handles by keyboard
   */
  constructor(app, pane, line, bar) {
    this.app = app;
    this.line = line;
    /** What is held, and what was before it. @type {{ gesture: Gesture } & import("../stance.js").Snapshot | null} */
    this.held = null;
    /** Whether a link may be taken hold of. */
    this.movesJoints = false;
    /** @type {Limb[]} */
    this.limbs = app.robot.about.limbs.map((limb) => new /** @type {any} */ (LIMB_CLASSES)[limb.kind](limb));
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

  /** @param {boolean} on whether the handles are there */
  show(on) {
    this.marks.show(on);
    this.rings.refresh();
    this.keys.show(on);
  }

  /**
   * @param {import("./types.js").Handle} handle
   * @param {import("three").Ray | null} ray
   */
  takeHandle(handle, ray = null) {
    this.begin(() => new LimbDrag(this.app, this.limbs, this.ghosts, handle, ray));
  }

  /**
   * @param {NonNullable<ReturnType<typeof import("./joint_drag.js").motionOf>>} motion
   * @param {import("three").Vector3} point
   * @param {import("three").Ray} ray
   */
  takeJoint(motion, point, ray) {
    this.begin(() => new JointDrag(this.app, motion, point, ray));
  }

  /**
   * @param {Pick<import("./rings.js").Ring, "handle" | "axis">} ring
   * @param {{ point: import("three").Vector3, ray: import("three").Ray } | null} pointer on it
   */
  takeRing(ring, pointer = null) {
    this.begin(() => new TurnDrag(this.app, this.limbs, ring, pointer));
  }

  /** @param {() => Gesture} make */
  begin(make) {
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

  /**
   * @param {import("three").Ray} ray
   * @param {{ level: boolean }} options
   */
  move(ray, options) {
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

  /** @param {boolean} held */
  announce(held) {
    this.app.dispatchEvent(new CustomEvent("gesture", { detail: { held } }));
  }

  /** @param {string} text */
  say(text) {
    if (this.line.textContent !== text) this.line.textContent = text;
    this.line.hidden = text === "";
  }
}
