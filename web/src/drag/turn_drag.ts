import { clamp } from "../math/numbers.ts";
import { THREE } from "../three.ts";
import { FOLLOWERS } from "./follow.ts";
import { SweptAngle } from "./swept_angle.ts";
import { triples } from "./triples.ts";
import type { Gesture, Handle, Limb } from "./types.ts";
import type { App } from "../app.ts";
import type { Axis } from "./rings.ts";
import type { Rotation } from "../math/types.ts";

// The way to an angle is gone in steps [rad], the last of which is halved so often where it is not reached; a pointer so
// near to the axis [px] says no angle.
const [STEP, HALVINGS, NEAR_AXIS] = [0.05, 8, 10];

/**
 * A ring that is held, by the pointer or by keys: the limb turns its frame about the axis of the ring, at its place, as far
 * as it can.
 */
export class TurnDrag implements Gesture {
  limb;
  follower;
  axis;
  wanted: number;
  before;
  angle: SweptAngle | undefined;
  reached: number;

  /** @param pointer on the ring, in the world, if one takes hold of it */
  constructor(
    readonly app: App,
    limbs: Limb[],
    { handle, axis }: { handle: Handle; axis: Axis },
    pointer: { point: THREE.Vector3; ray: THREE.Ray } | null,
  ) {
    this.limb = handle.limb;
    const { robot, pick } = app;
    const poseOf = (frame: string) => robot.poseIn(frame, this.limb.torso);
    this.follower = new FOLLOWERS[this.limb.kind](this.limb, (frame) => poseOf(frame).transpose().toArray(), limbs);
    const own = new THREE.Vector3(...axis.axis);
    this.axis = own.clone().transformDirection(poseOf(this.limb.frame));
    this.wanted = this.reached = 0;
    if (!pointer) return;
    const node = robot.frameNode(this.limb.frame);
    const line = {
      origin: node.getWorldPosition(new THREE.Vector3()).toArray(),
      direction: own.transformDirection(node.matrixWorld).toArray(),
    };
    const least = NEAR_AXIS * pick.viewport.metresPerPixel(pointer.point);
    this.before = triples(pointer.ray);
    this.angle = new SweptAngle(line, pointer.point.toArray(), this.before.origin, least);
  }

  move(ray: THREE.Ray) {
    const now = triples(ray);
    if (this.angle && this.before) this.wanted += this.angle.between(this.before, now);
    this.before = now;
    return this.turn();
  }

  /**
   * Go on from where the frame is.
   *
   * @param angle [rad]
   */
  step(angle: number) {
    this.wanted = this.reached + angle;
    return this.turn();
  }

  /** Turn as far towards the angle wanted as the limb can; gives what there is to say. */
  turn() {
    const { app } = this;
    let { q } = app.stance;
    let says = "";
    let step = STEP;
    while (this.reached !== this.wanted && step > STEP / 2 ** HALVINGS) {
      const next = this.reached + clamp(this.wanted - this.reached, -step, step);
      const followed = this.follower.turn?.(this.rotation(next), q);
      if (followed?.q) [q, this.reached] = [followed.q, next];
      else step *= 0.5;
      says = followed?.says ?? "";
    }
    app.stance.set(q);
    app.stance.settle();
    return says && `${this.limb.frame}: ${says}`;
  }

  end() {}

  /** The turn by an angle in the torso's frame, row by row. */
  rotation(angle: number): Rotation {
    const { elements: m } = new THREE.Matrix4().makeRotationAxis(this.axis, angle);
    return [m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]];
  }
}
