import { angleBetween, product, rotY, rotZ, transposed } from "../math/rotations.ts";
import { Answer } from "./answer.ts";
import { Neck } from "./neck.ts";
import { rigidRotation } from "./rigid.ts";
import { VERIFIED } from "./tolerances.ts";
import type { Pose, Rotation } from "../math/types.ts";
import type { HeadNumbers } from "./types.ts";

/**
 * The head, for an orientation: R = Rz(yaw) Ry(pitch) is made where its second column has no z. What is not reached is
 * answered with the `nearest` joint values, by angle.
 */
export class Head extends Neck<HeadNumbers> {
  /** The joint values for an orientation of the frame in the torso, the rotation of a pose. */
  solve(T: Pose, reference: number[], enforce = true) {
    const answer = new Answer(this, reference, enforce);
    const R = rigidRotation(T);
    if (!R) return answer.blame("NOT_RIGID");
    const W = product(R, transposed(this.frameRotation));
    const q = [Math.atan2(-W[1], W[4]), Math.atan2(-W[6], W[8])];
    const error = orientationError(W, q);
    if (error > VERIFIED) answer.blame("NOT_ENOUGH_JOINTS");
    else if (answer.admits(q)) answer.enter(q, [0, error]);
    if (answer.branches.length === 0) {
      // The trace of Ry(−pitch) Rz(−yaw) R has one maximum.
      const bestPitch = (c: number, s: number) => Math.atan2(W[2] * c + W[5] * s - W[6], W[0] * c + W[3] * s + W[8]);
      answer.nearest = this.bestYaw((values) => orientationError(W, values), bestPitch, q[0], enforce);
    }
    return answer.concluded();
  }
}

/** The angle between Rz(yaw) Ry(pitch) and an orientation. */
function orientationError(W: Rotation, [yaw, pitch]: number[]) {
  return angleBetween(product(rotZ(yaw), rotY(pitch)), W);
}
