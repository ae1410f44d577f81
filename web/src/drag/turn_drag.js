import { clamp } from "../math/numbers.js";
import { THREE } from "../three.js";
import { FOLLOWERS } from "./follow.js";
import { SweptAngle } from "./swept_angle.js";
import { triples } from "./triples.js";

/** @typedef {import("./types.js").Gesture} Gesture */

// The way to an angle is gone in steps [rad], the last of which is halved so often where it is not reached; a pointer so
// near to the axis [px] says no angle.
const [STEP, HALVINGS, NEAR_AXIS] = [0.05, 8, 10];

/**
 * A ring that is held: the limb turns its frame about the axis of the ring, at its place, as far as it can.
 *
 * @implements {Gesture}
 */
export class TurnDrag {
  /**
   * @param {import("../app.js").App} app
   * @param {import("./types.js").Limb[]} limbs
   * @param {import("./rings.js").Ring} ring
   * @param {THREE.Vector3} point on the ring, in the world
   * @param {THREE.Ray} ray
   */
  constructor(app, limbs, { handle, axis, mesh }, point, ray) {
    this.app = app;
    this.limb = handle.limb;
    const { robot, pick } = app;
    const torso = robot.pose(robot.linkOf(this.limb.torso)).invert();
    /** @param {string} frame */
    const poseOf = (frame) => torso.clone().multiply(robot.pose(robot.linkOf(frame)));
    this.follower = new FOLLOWERS[this.limb.kind](this.limb, (frame) => poseOf(frame).transpose().toArray(), limbs);
    this.axis = axis.clone().transformDirection(poseOf(this.limb.frame));
    const line = {
      origin: mesh.getWorldPosition(new THREE.Vector3()).toArray(),
      direction: axis.clone().transformDirection(robot.frameNode(this.limb.frame).matrixWorld).toArray(),
    };
    const least = NEAR_AXIS * pick.viewport.metresPerPixel(point);
    this.before = triples(ray);
    this.angle = new SweptAngle(line, point.toArray(), this.before.origin, least);
    this.wanted = this.reached = 0;
  }

  /** @param {THREE.Ray} ray */
  move(ray) {
    const now = triples(ray);
    this.wanted += this.angle.between(this.before, now);
    this.before = now;
    const { app } = this;
    let { q } = app;
    let says = "";
    let step = STEP;
    while (this.reached !== this.wanted && step > STEP / 2 ** HALVINGS) {
      const next = this.reached + clamp(this.wanted - this.reached, -step, step);
      const followed = this.follower.turn?.(this.rotation(next), q);
      if (followed?.q) [q, this.reached] = [followed.q, next];
      else step *= 0.5;
      says = followed?.says ?? "";
    }
    app.set(q);
    app.settle();
    return says && `${this.limb.frame}: ${says}`;
  }

  end() {}

  /**
   * The turn by an angle in the torso's frame, row by row.
   *
   * @param {number} angle
   * @returns {import("../math/types.js").Rotation}
   */
  rotation(angle) {
    const { elements: m } = new THREE.Matrix4().makeRotationAxis(this.axis, angle);
    return [m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]];
  }
}
