import { clamp, wrapped } from "../math/numbers.ts";
import {
  angleBetween,
  distance,
  minus,
  norm,
  plus,
  product,
  rotX,
  rotY,
  times,
  transposed,
  turned,
  type Matrix3,
  type Pose,
  type Rotation,
  type Vector,
} from "../math/rotations.ts";
import { Answer, TripleLimb, rigidRotation } from "./limb.ts";
import type { Errors, Family, LegNumbers } from "./limbs.ts";

// How far [m] rounding may put a target out of reach.
const ROUNDING = 1e-12;
// The ankle of a straight leg may be out of reach by this [m], in a rounded pose for instance.
const STRETCHED = 1e-6;
// The angle of the knee below which it is straight.
const STRAIGHT = 1e-7;

/** The triangle of hip, knee and ankle, in the plane of the leg. */
class LegTriangle {
  longest: number;
  shortest: number;

  constructor(
    public thigh: number,
    public tibia: number,
  ) {
    /** The largest and the least distance of hip and ankle. */
    this.longest = thigh + tibia;
    this.shortest = Math.abs(thigh - tibia);
  }

  /** The distance of hip and ankle, moved into the leg's range if it is outside by at most `STRETCHED`. */
  reached(far: number) {
    const reached = Math.min(Math.max(far, this.shortest), this.longest);
    const short = Math.abs(far - reached);
    return short <= ROUNDING || short > STRETCHED ? far : reached;
  }

  /** By how much a distance of hip and ankle is too large or too small [m]; 0 if the leg can reach it. */
  beyond(far: number) {
    const beyond = Math.max(far - this.longest, this.shortest - far);
    return beyond > ROUNDING ? beyond : 0;
  }

  /**
   * The angles of the knee for a distance of hip and ankle, by the law of cosines for the half angle, which loses no digits
   * at either end. A straight or folded leg has one angle, any other two.
   */
  knees(far: number) {
    const { longest, shortest } = this;
    const stretched = Math.sqrt(Math.max(0, (longest - far) * (longest + far)));
    const folded = Math.sqrt(Math.max(0, (far - shortest) * (far + shortest)));
    const knee = 2 * Math.atan2(stretched, folded);
    if (knee < STRAIGHT) return [0];
    return knee > Math.PI - STRAIGHT ? [Math.PI] : [knee, -knee];
  }

  /** x and z of the ankle relative to the hip, in the axes of the thigh. */
  ankleFromHip(knee: number) {
    return [-this.tibia * Math.sin(knee), -this.thigh - this.tibia * Math.cos(knee)];
  }

  /** x and z of the hip relative to the ankle, in the axes of the foot, with the ankle joints at zero. */
  hipFromAnkle(knee: number) {
    return [-this.thigh * Math.sin(knee), this.tibia + this.thigh * Math.cos(knee)];
  }
}

/**
 * Add a branch with its errors: the distance of the ankle [m], and of the sole's normal as a chord.
 *
 * @param made by forward kinematics
 */
function addStanding(foot: FootPose, made: FootPose, q: number[], answer: Answer) {
  const chord = distance(normalOf(made.F), normalOf(foot.F));
  answer.addBranch(q, [distance(made.place, foot.place), chord], "NONE", yawBetween(foot.F, made.F));
}

/** The normal of the sole. */
function normalOf(F: Rotation): Vector {
  return [F[2], F[5], F[8]];
}

/** The angle about the common normal of two soles that turns one foot to the other. */
function yawBetween(from: Rotation, to: Rotation) {
  const E = product(transposed(from), to);
  return Math.atan2(E[3] - E[1], E[0] + E[4]);
}

// The distance [m] below which the hip counts as on the axis of AnkleRoll, and by which a foot may move to meet a limit.
const ON_AXIS = 1e-12;
// The distance [m] from the axis of AnkleRoll within which rounding may put the roll outside its limits.
const NEAR_AXIS = 1e-5;
// The sine between two axes up to which they are parallel.
const PARALLEL = 1e-12;

/**
 * A pose of the foot: its orientation, and the position of the ankle relative to the hip, in axes turned by κ about x. A
 * target slightly out of the straight leg's reach is moved into reach; `short` is the distance of that move.
 */
interface FootPose {
  F: Rotation;
  place: Vector;
  short: number;
}

/**
 * The leg: eight real branches for a pose of the foot. With F the orientation of the foot, and h the hip relative to the
 * ankle in the axes of the foot,
 *
 *     h = Rx(−q₆) w,  w = L₁ (−sin(q₄ + q₅), cos(q₄ + q₅)) + L₂ (−sin q₅, cos q₅)  in the plane of x and z,
 *     F = Rx(κ) Ry(q₁) Rx(q₂ − κ) Ry(q₃) · Ry(q₄ + q₅) Rx(q₆).
 */
export class Leg extends TripleLimb<LegNumbers, FootPose> {
  triangle: LegTriangle;
  hip: Vector;
  sole: Vector;

  constructor(numbers: LegNumbers) {
    super(numbers);
    const { thigh, tibia, hip, place } = this.geometry;
    this.triangle = new LegTriangle(thigh, tibia);
    this.hip = hip;
    // The frame relative to the ankle, in the axes of the foot.
    this.sole = place;
  }

  /** All branches for the pose of its frame in the torso. */
  solve(T: Pose, reference: number[], enforce = true) {
    const answer = new Answer(this, reference, enforce);
    const foot = this.reachedPose(T, answer);
    if (!foot) return answer;
    for (const knee of this.triangle.knees(norm(foot.place))) this.#bend(foot, knee, answer);
    return answer.finish();
  }

  /**
   * All branches with a given HipYawPitch that keep the position of the ankle and the normal of the sole. When two legs
   * share a hip motor and one leg determines its angle, these are the other leg's branches. `yaw` of a branch is the angle
   * by which the foot turns about that normal.
   */
  stand(T: Pose, hipYawPitch: number, reference: number[]) {
    const answer = new Answer(this, reference, true);
    const foot = this.reachedPose(T, answer);
    if (!foot) return answer;
    // The ankle relative to the hip, and the sole's normal, in the axes after HipYawPitch.
    const back = rotY(-hipYawPitch);
    const [x, y, z] = turned(back, foot.place);
    const normal = turned(back, normalOf(foot.F));
    for (const knee of this.triangle.knees(norm(foot.place))) {
      const [lx, lz] = this.triangle.ankleFromHip(knee);
      for (const side of [-1, 1]) {
        const height = side * Math.hypot(y, z);
        const rho = Math.atan2(-side * y, side * z);
        const pitch = Math.atan2(lz * x - lx * height, lx * x + lz * height);
        const [mx, my, mz] = turned(transposed(product(rotX(rho), rotY(pitch + knee))), normal);
        for (const way of [1, -1]) {
          const ankle = [Math.atan2(way * mx, way * mz), Math.atan2(-my, way * Math.hypot(mx, mz))];
          const q = [hipYawPitch, wrapped(this.geometry.kappa + rho), pitch, knee, ...ankle];
          if (answer.checkLimits(q)) addStanding(foot, this.forward(q), q, answer);
        }
      }
    }
    return answer.finish();
  }

  /** The pose of the foot from the pose of its frame in the torso; null if that is no rigid transform. */
  footPose(T: Pose): FootPose | null {
    const R = rigidRotation(T);
    if (!R) return null;
    const F = this.geometry.turned === 0 ? R : product(R, transposed(this.frameRotation));
    const ankle = minus(minus([T[3], T[7], T[11]], this.hip), turned(F, this.sole));
    const { cos_kappa: c, sin_kappa: s } = this.geometry;
    const K: Rotation = [1, 0, 0, 0, c, s, 0, -s, c];
    const place = turned(K, ankle);
    const far = norm(place);
    const reached = this.triangle.reached(far);
    if (reached === far || far === 0) return { F: product(K, F), place, short: 0 };
    return { F: product(K, F), place: times(reached / far, place), short: Math.abs(far - reached) };
  }

  /** The pose of the foot by forward kinematics. */
  forward(q: number[]): FootPose {
    const M = product(product(rotY(q[0]), rotX(q[1] - this.geometry.kappa)), rotY(q[2]));
    const [lx, lz] = this.triangle.ankleFromHip(q[3]);
    return { F: product(M, ankleRotation(q)), place: turned(M, [lx, 0, lz]), short: 0 };
  }

  /** The pose of the foot; null if that is no rigid transform or out of reach, which the answer then gives as the reason. */
  reachedPose(T: Pose, answer: Answer) {
    const foot = this.footPose(T);
    if (!foot) answer.setReason("NOT_RIGID");
    const beyond = foot ? this.triangle.beyond(norm(foot.place)) : 0;
    if (beyond > 0) answer.setReason("OUT_OF_REACH", -1, beyond);
    answer.short = foot?.short ?? 0;
    return beyond > 0 ? null : foot;
  }

  /** Add the branches with this angle of the knee. */
  #bend(foot: FootPose, knee: number, answer: Answer) {
    const { F, place } = foot;
    const [hx, hy, hz] = times(-1, turned(transposed(F), place));
    const height = Math.hypot(hy, hz);
    const [bx, bz] = this.triangle.hipFromAnkle(knee);
    const q = [0, 0, 0, knee, 0, 0];
    if (height <= ON_AXIS) {
      q[4] = Math.atan2(-bz * hx, bx * hx);
      // The hip is on the axis of AnkleRoll: every q₆ meets the pose.
      this.addFamilies(foot, 5, this.#rollRange(q[4]), "ANKLE_AXIS", q, answer);
      return;
    }
    for (const side of [1, -1]) {
      const wz = side * height;
      q[4] = Math.atan2(bx * wz - bz * hx, bx * hx + bz * wz);
      q[5] = Math.atan2(side * hy, side * hz);
      if (answer.enforce && height < NEAR_AXIS) this.#putOnLimit(height, q);
      this.addTriples(foot, q, answer);
    }
  }

  /** The range of AnkleRoll at an angle of AnklePitch. */
  #rollRange(pitch: number): [number, number] {
    const [low, high] = [this.lower[5], this.upper[5]];
    const [least, most] = this.tableRange(pitch);
    return [Math.max(low, least), Math.max(low, Math.min(high, most))];
  }

  /**
   * Put AnkleRoll on its limit if the hip is so near to the joint's axis that the foot hardly moves.
   *
   * @param height of the hip over that axis
   */
  #putOnLimit(height: number, q: number[]) {
    const inside = clamp(q[5], ...this.#rollRange(q[4]));
    if (Math.abs(inside - q[5]) * height < ON_AXIS) q[5] = inside;
  }

  /**
   * Write the hip's angles from the orientation that the hip must make, given knee and ankle: M = Ry(q₁) Rx(ρ) Ry(q₃) with
   * ρ = q₂ − κ. The angles q₁ and ρ follow from the second column of M, (sin q₁ sin ρ, cos ρ, cos q₁ sin ρ).
   */
  turnTriple({ F }: FootPose, q: number[], answer: Answer): Family {
    const M = product(F, transposed(ankleRotation(q)));
    const sine = Math.hypot(M[1], M[7]);
    q[1] = wrapped(this.geometry.kappa + Math.atan2(sine, M[4]));
    if (sine <= PARALLEL) {
      const sign = M[4] > 0 ? 1 : -1;
      this.lockPair([0, 2], Math.atan2(sign * M[2] - M[6], M[0] + sign * M[8]), sign, answer, q);
      return "HIP_LOCK";
    }
    q[0] = Math.atan2(M[1], M[7]);
    // Ry(−q₁) M, whose first row is (cos q₃, 0, sin q₃).
    q[2] = Math.atan2(M[7] * M[2] - M[1] * M[8], M[7] * M[0] - M[1] * M[6]);
    return "NONE";
  }

  /** Ry(q₁ + π) Rx(−ρ) Ry(q₃ + π) */
  toOtherTriple(q: number[]) {
    [q[0], q[1], q[2]] = [wrapped(q[0] + Math.PI), wrapped(2 * this.geometry.kappa - q[1]), wrapped(q[2] + Math.PI)];
  }

  errors({ F, place }: FootPose, q: number[]): Errors {
    const made = this.forward(q);
    const turnedOff = made.F.map((value, k) => value - F[k]) as Matrix3;
    const off = plus(minus(made.place, place), turned(turnedOff, this.sole));
    return [norm(off), angleBetween(made.F, F)];
  }
}

/** Ry(q₄ + q₅) Rx(q₆) */
function ankleRotation(q: number[]) {
  return product(rotY(q[3] + q[4]), rotX(q[5]));
}
