import { wrapped } from "../math/numbers.ts";
import { product, rotX, rotY, transposed, turned } from "../math/rotations.ts";
import { distance, norm } from "../math/vectors.ts";
import { Answer } from "./answer.ts";
import type { Pose, Rotation, Vector } from "../math/types.ts";
import type { FootPose, Leg } from "./leg.ts";

/**
 * Five joints for a given HipYawPitch: all branches that keep the ankle's place and the normal of the sole of a pose. How
 * far the foot is turned about that normal comes with each as `yaw`.
 *
 * @param T of its frame in the torso
 * @param hipYawPitch [rad]
 */
export function standWith(leg: Leg, T: Pose, hipYawPitch: number, reference: number[]) {
  const answer = new Answer(leg, reference, true);
  const foot = leg.footPose(T);
  if (!foot) return answer.blame("NOT_RIGID");
  if (leg.isTooFar(foot, answer)) return answer;
  answer.short = foot.short;
  // The ankle from the hip, and the sole's normal, in the axes that HipYawPitch turns.
  const back = rotY(-hipYawPitch);
  const [x, y, z] = turned(back, foot.place);
  const normal = turned(back, normalOf(foot.F));
  for (const knee of leg.triangle.knees(norm(foot.place))) {
    const [lx, lz] = leg.triangle.ankleFromHip(knee);
    for (const side of [-1, 1]) {
      const height = side * Math.hypot(y, z);
      const rho = Math.atan2(-side * y, side * z);
      const pitch = Math.atan2(lz * x - lx * height, lx * x + lz * height);
      const [mx, my, mz] = turned(transposed(product(rotX(rho), rotY(pitch + knee))), normal);
      for (const way of [1, -1]) {
        const ankle = [Math.atan2(way * mx, way * mz), Math.atan2(-my, way * Math.hypot(mx, mz))];
        const q = [hipYawPitch, wrapped(leg.geometry.kappa + rho), pitch, knee, ...ankle];
        if (answer.admits(q)) enter(foot, leg.forward(q), q, answer);
      }
    }
  }
  return answer.concluded();
}

/**
 * Enter a branch with its errors: the distance of the ankle [m], and of the sole's normal as a chord.
 *
 * @param made by forward kinematics
 */
function enter(foot: FootPose, made: FootPose, q: number[], answer: Answer) {
  const chord = distance(normalOf(made.F), normalOf(foot.F));
  answer.enter(q, [distance(made.place, foot.place), chord], "NONE", yawBetween(foot.F, made.F));
}

/** @returns of the sole */
function normalOf(F: Rotation): Vector {
  return [F[2], F[5], F[8]];
}

/** The turn about the common normal of two soles from one foot to the other. */
function yawBetween(from: Rotation, to: Rotation) {
  const E = product(transposed(from), to);
  return Math.atan2(E[3] - E[1], E[0] + E[4]);
}
