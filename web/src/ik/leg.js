// @ts-nocheck
import { Answer } from "./answer.js";
import { Limb, rotationOfFrame } from "./limb.js";
import { rigid } from "./rigid.js";
import { clamp, wrapped } from "../math/numbers.js";
import { angleBetween, product, rotX, rotY, transposed, turned } from "../math/rotations.js";

// The leg: eight real branches from the pose of the foot. With F the orientation of the foot and h the hip as the foot
// sees it from the ankle,
//
//     h = Rx(−q₆) w,  w = L₁ (−sin(q₄ + q₅), cos(q₄ + q₅)) + L₂ (−sin q₅, cos q₅)  in the plane of x and z,
//     F = Rx(κ) Ry(q₁) Rx(q₂ − κ) Ry(q₃) · Ry(q₄ + q₅) Rx(q₆).
export class Leg extends Limb {
  // All branches for the pose of its frame in the torso.
  solve(T, reference, enforce = true) {
    const answer = new Answer(this, reference, enforce);
    const foot = this.foot(T);
    if (!foot) return answer.blame("NOT_RIGID");
    const { thigh, tibia } = this.geometry;
    const far = Math.hypot(...foot.place);
    const [longest, shortest] = [thigh + tibia, Math.abs(thigh - tibia)];
    const { ROUNDING } = Leg;
    if (far > longest + ROUNDING || far < shortest - ROUNDING) {
      return answer.blame("OUT_OF_REACH", -1, far > longest ? far - longest : shortest - far);
    }
    const knees = this.knees(far);
    for (const knee of knees) this.bend(foot, knee, answer);
    return answer.concluded();
  }

  // The target: orientation of the foot and place of the ankle, seen from the hip, in axes turned by κ about x.
  foot(T) {
    const R = rigid(T);
    if (!R) return null;
    const { hip_x, hip_y, hip_z, cos_kappa, sin_kappa, x, y, z } = this.geometry;
    const F = this.geometry.turned === 0 ? R : product(R, transposed(rotationOfFrame(this.geometry)));
    const arm = turned(F, [x, y, z]);
    const ankle = [T[3] - hip_x - arm[0], T[7] - hip_y - arm[1], T[11] - hip_z - arm[2]];
    const K = [1, 0, 0, 0, cos_kappa, sin_kappa, 0, -sin_kappa, cos_kappa];
    return { F: product(K, F), place: turned(K, ankle) };
  }

  // The angles of the knee with hip and ankle so far apart; straight or folded it has one.
  knees(far) {
    const { thigh, tibia } = this.geometry;
    const [longest, shortest] = [thigh + tibia, Math.abs(thigh - tibia)];
    const stretched = Math.sqrt(Math.max(0, (longest - far) * (longest + far)));
    const folded = Math.sqrt(Math.max(0, (far - shortest) * (far + shortest)));
    const knee = 2 * Math.atan2(stretched, folded);
    if (knee < Leg.STRAIGHT) return [0];
    return knee > Math.PI - Leg.STRAIGHT ? [Math.PI] : [knee, -knee];
  }

  // Enter the branches with this angle of the knee.
  bend(foot, knee, answer) {
    const { F, place } = foot;
    const [hx, hy, hz] = turned(transposed(F), place).map((value) => -value);
    const height = Math.hypot(hy, hz);
    const [bx, bz] = this.shank(knee);
    const q = [0, 0, 0, knee, 0, 0];
    if (height <= Leg.ROUNDING) {
      q[4] = Math.atan2(-bz * hx, bx * hx);
      for (const other of [false, true]) this.aboutAnkleAxis(foot, q, other, answer);
      return;
    }
    for (const side of [1, -1]) {
      const wz = side * height;
      q[4] = Math.atan2(bx * wz - bz * hx, bx * hx + bz * wz);
      q[5] = Math.atan2(side * hy, side * hz);
      if (answer.enforce && height < Leg.NEAR_AXIS) this.putOnLimit(height, q);
      const family = this.turnHip(F, q, answer);
      for (const other of family === "NONE" ? [false, true] : [false]) {
        if (other) this.otherTriple(q);
        if (answer.admits(q)) answer.enter(q, this.errors(foot, q), family);
      }
    }
  }

  // The hip, seen from the ankle in the plane of the leg, with the ankle at zero.
  shank(knee) {
    const { thigh, tibia } = this.geometry;
    return [-thigh * Math.sin(knee), tibia + thigh * Math.cos(knee)];
  }

  // The range of AnkleRoll at an angle of AnklePitch.
  rollRange(pitch) {
    const [low, high] = [this.lower[5], this.upper[5]];
    if (!this.table) return [low, high];
    const bounds = this.tableRange(pitch);
    return [Math.max(low, bounds[0]), Math.max(low, Math.min(high, bounds[1]))];
  }

  // AnkleRoll onto its limit, where the hip is so near its axis that the foot hardly moves.
  putOnLimit(height, q) {
    const inside = clamp(q[5], ...this.rollRange(q[4]));
    if (Math.abs(inside - q[5]) * height < Leg.ROUNDING) q[5] = inside;
  }

  // The hip's angles from what knee and ankle leave of the foot's orientation, M = Ry(q₁) Rx(ρ) Ry(q₃) with ρ = q₂ − κ;
  // returns their family. The first turn is taken from the second column of M, (sin q₁ sin ρ, cos ρ, cos q₁ sin ρ).
  turnHip(F, q, options) {
    const M = product(F, transposed(Leg.ankle(q)));
    const sine = Math.hypot(M[1], M[7]);
    q[1] = wrapped(this.geometry.kappa + Math.atan2(sine, M[4]));
    if (sine <= Leg.PARALLEL) {
      const sign = M[4] > 0 ? 1 : -1;
      this.lockPair([0, 2], Math.atan2(sign * M[2] - M[6], M[0] + sign * M[8]), sign, options, q);
      return "HIP_LOCK";
    }
    q[0] = Math.atan2(M[1], M[7]);
    // Ry(−q₁) M, whose first row is (cos q₃, 0, sin q₃).
    q[2] = Math.atan2(M[7] * M[2] - M[1] * M[8], M[7] * M[0] - M[1] * M[6]);
    return "NONE";
  }

  // The hip's angles that make the same orientation: Ry(q₁ + π) Rx(−ρ) Ry(q₃ + π).
  otherTriple(q) {
    [q[0], q[1], q[2]] = [wrapped(q[0] + Math.PI), wrapped(2 * this.geometry.kappa - q[1]), wrapped(q[2] + Math.PI)];
  }

  // Enter the member of a family with the hip on the axis of AnkleRoll: every q₆ meets the pose with its own hip.
  aboutAnkleAxis(foot, q, other, answer) {
    const own = answer.reference[5];
    const [low, high] = answer.enforce ? this.rollRange(q[4]) : [own - Math.PI, own + Math.PI];
    const cost = (roll) => {
      q[5] = roll;
      const family = this.turnHip(foot.F, q, answer);
      if (other && family !== "NONE") return Infinity; // the two triples belong to one family
      if (other) this.otherTriple(q);
      return this.familyCost(q, answer);
    };
    if (this.leastCost(low, high, own, cost) === null) return;
    if (answer.admits(q)) answer.enter(q, this.errors(foot, q), "ANKLE_AXIS");
  }

  // Orientation of the foot and place of the ankle as `foot` has them, by forward kinematics.
  forward(q) {
    const { thigh, tibia, kappa } = this.geometry;
    const M = product(product(rotY(q[0]), rotX(q[1] - kappa)), rotY(q[2]));
    const place = turned(M, [-tibia * Math.sin(q[3]), 0, -thigh - tibia * Math.cos(q[3])]);
    return { F: product(M, Leg.ankle(q)), place };
  }

  // How far the frame is from its target: distance [m] and angle [rad].
  errors({ F, place }, q) {
    const made = this.forward(q);
    const { x, y, z } = this.geometry;
    const arm = turned(
      made.F.map((value, k) => value - F[k]),
      [x, y, z],
    );
    return [Math.hypot(...made.place.map((value, k) => value - place[k] + arm[k])), angleBetween(made.F, F)];
  }

  // Five joints for a given HipYawPitch: all branches that keep the ankle's place and the normal of the sole of a pose.
  // How far the foot is turned about that normal comes with each as `yaw`; of two legs on one hip motor one leg says
  // how the hip is, and this is what is left to the other.
  stand(T, hipYawPitch, reference) {
    const answer = new Answer(this, reference, true);
    const { F, place } = this.foot(T);
    const { thigh, tibia, kappa } = this.geometry;
    const far = Math.hypot(...place);
    const beyond = Math.max(far - thigh - tibia, Math.abs(thigh - tibia) - far);
    if (beyond > Leg.ROUNDING) return answer.blame("OUT_OF_REACH", -1, beyond);
    // The ankle from the hip, and the sole's normal, in the axes that HipYawPitch turns.
    const back = rotY(-hipYawPitch);
    const [x, y, z] = turned(back, place);
    const normal = turned(back, [F[2], F[5], F[8]]);
    for (const knee of this.knees(far)) {
      const [lx, lz] = [-tibia * Math.sin(knee), -thigh - tibia * Math.cos(knee)];
      for (const side of [-1, 1]) {
        const height = side * Math.hypot(y, z);
        const rho = Math.atan2(-side * y, side * z);
        const pitch = Math.atan2(lz * x - lx * height, lx * x + lz * height);
        const M = product(rotX(rho), rotY(pitch + knee));
        const [mx, my, mz] = turned(transposed(M), normal);
        for (const way of [1, -1]) {
          const ankle = [Math.atan2(way * mx, way * mz), Math.atan2(-my, way * Math.hypot(mx, mz))];
          const q = [hipYawPitch, wrapped(kappa + rho), pitch, knee, ...ankle];
          if (answer.admits(q)) answer.enter(q, this.standingErrors({ F, place }, q));
        }
      }
    }
    for (const branch of answer.branches) branch.yaw = this.yawOff(F, branch.values);
    return answer.concluded();
  }

  // Distance of the ankle [m], and of the sole's normal as a chord, from where they are to be.
  standingErrors({ F, place }, q) {
    const made = this.forward(q);
    const normal = [2, 5, 8].map((k) => made.F[k] - F[k]);
    return [Math.hypot(...made.place.map((value, k) => value - place[k])), Math.hypot(...normal)];
  }

  // The turn about the normal of the sole from a foot to the one that is made.
  yawOff(F, q) {
    const E = product(transposed(F), this.forward(q).F);
    return Math.atan2(E[3] - E[1], E[0] + E[4]);
  }
}

// Ry(q₄ + q₅) Rx(q₆)
Leg.ankle = (q) => product(rotY(q[3] + q[4]), rotX(q[5]));

// A distance [m] that rounding may add to the reach, and below which the hip is on the axis of AnkleRoll; the angle of
// the knee below which it is straight; the sine between two axes up to which they are parallel; the distance from the
// axis of AnkleRoll [m] within which rounding may put the roll outside its limits.
Object.assign(Leg, { ROUNDING: 1e-12, STRAIGHT: 1e-7, PARALLEL: 1e-12, NEAR_AXIS: 1e-5 });
