import { wrapped } from "../math/numbers.ts";
import {
  angleBetween,
  cross,
  direction,
  distance,
  dot,
  minus,
  norm,
  plus,
  product,
  rotX,
  rotY,
  rotZ,
  times,
  transposed,
  turned,
  type Pose,
  type Rotation,
  type Vector,
} from "../math/rotations.ts";
import { Answer, TripleLimb, rigidRotation } from "./limb.ts";
import type { ArmNumbers, Errors, Family } from "./limbs.ts";

/** A pose of the hand: its orientation, and the position of the frame relative to the shoulder. */
interface HandPose {
  R: Rotation;
  place: Vector;
}

/** The circle of possible elbow positions, relative to the shoulder, for a position of the frame and forearm axis n. */
class ElbowCircle {
  n: Vector;
  along: number;
  across: number;
  v: Vector;
  radius: number;
  beta: number;

  /**
   * @param place of the frame, relative to the shoulder
   * @param forearm direction of the forearm, not zero
   * @param hand position of the frame relative to the elbow, in the axes of the hand
   * @param onAxis the distance [m] up to which the shoulder counts as on the axis of the circle
   */
  constructor(
    readonly place: Vector,
    forearm: Vector,
    hand: Vector,
    onAxis: number,
  ) {
    this.n = direction(forearm);
    const middle = minus(place, times(hand[0], this.n));
    /** The centre of the circle is at along · n + across · v. */
    this.along = dot(middle, this.n);
    const v = minus(middle, times(this.along, this.n));
    this.across = norm(v);
    // With the shoulder on the axis, any direction normal to n will do.
    this.v = direction(this.across <= onAxis ? acrossTo(this.n) : v);
    this.radius = Math.hypot(hand[1], hand[2]);
    this.beta = Math.atan2(hand[2], hand[1]);
  }

  /** The least and the largest distance of the circle from the shoulder. */
  get reach() {
    const { along, across, radius } = this;
    return [Math.hypot(along, across - radius), Math.hypot(along, across + radius)];
  }

  /** The pose of the hand with the elbow at an angle on the circle, measured from the side of the shoulder. */
  handAt(angle: number): HandPose {
    const { n, v, place } = this;
    const k = plus(times(Math.cos(angle), v), times(Math.sin(angle), cross(n, v)));
    const o = cross(n, k);
    const [c, s] = [Math.cos(this.beta), Math.sin(this.beta)];
    const [y, z] = [minus(times(c, k), times(s, o)), plus(times(s, k), times(c, o))];
    return { R: [n[0], y[0], z[0], n[1], y[1], z[1], n[2], y[2], z[2]], place };
  }
}

/** A vector normal to a unit vector. */
function acrossTo(n: Vector): Vector {
  const s: Vector = Math.abs(n[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0];
  return minus(s, times(dot(s, n), n));
}

// How far [m] the elbow may be from a position that the arm can reach, and how far from the axis of ShoulderPitch it may
// be to count as on it.
const REACHED = 1e-11;
const ON_AXIS = 1e-12;
// The sine of ElbowRoll up to which the axes of ElbowYaw and WristYaw count as one.
const PARALLEL = 1e-12;
// The angle below which the elbow's two places on its circle count as one.
const ONE_TURN = 1e-7;

/**
 * The arm. A pose of the hand that five joints can make has four real branches; a position of the hand with a direction of
 * the forearm has up to eight; for a position alone, arm_place.ts chooses one of infinitely many. With e the elbow in the
 * upper arm and h the frame relative to the elbow in the axes of the hand,
 *
 *     R = Ry(q₁) Rz(q₂) Rx(q₃) Rz(q₄) Rx(q₅),  p = shoulder + Ry(q₁) Rz(q₂) e + R h.
 */
export class Arm extends TripleLimb<ArmNumbers, HandPose> {
  shoulder: Vector;
  elbow: Vector;
  hand: Vector;
  upperArm: number;

  constructor(numbers: ArmNumbers) {
    super(numbers);
    const { shoulder, elbow_x, elbow_y, place } = this.geometry;
    this.shoulder = shoulder;
    this.elbow = [elbow_x, elbow_y, 0];
    this.hand = place;
    this.upperArm = Math.hypot(elbow_x, elbow_y);
  }

  /** All branches for the pose of its frame in the torso. */
  solve(T: Pose, reference: number[], enforce = true) {
    const answer = new Answer(this, reference, enforce);
    let R = rigidRotation(T);
    if (!R) return answer.setReason("NOT_RIGID");
    if (this.geometry.turned !== 0) R = product(R, transposed(this.frameRotation));
    const place = this.fromShoulder([T[3], T[7], T[11]]);
    if (this.isTooFar(place, answer)) return answer;
    this.#addBranches({ R, place }, answer);
    return answer.finish();
  }

  /**
   * All branches for the position of the frame in the torso and the direction of the forearm, the frame's x axis. The
   * elbow is where its circle meets the sphere about the shoulder; the orientation of the hand follows from that.
   *
   * @param forearm not zero
   */
  solveDirection(target: Vector, forearm: Vector, reference: number[], enforce = true) {
    const answer = new Answer(this, reference, enforce);
    const place = this.fromShoulder(target);
    if (this.isTooFar(place, answer)) return answer;
    const circle = new ElbowCircle(place, forearm, this.hand, ON_AXIS);
    const { upperArm } = this;
    const [near, far] = circle.reach;
    if (near > upperArm + REACHED || far < upperArm - REACHED) return answer.setReason("NOT_ENOUGH_JOINTS");
    const ahead = Math.max(0, (upperArm - near) * (upperArm + near));
    const behind = Math.max(0, (far - upperArm) * (far + upperArm));
    const turn = 2 * Math.atan2(Math.sqrt(ahead), Math.sqrt(behind));
    this.#addBranches(circle.handAt(turn), answer);
    if (turn > ONE_TURN && turn < Math.PI - ONE_TURN) this.#addBranches(circle.handAt(-turn), answer);
    return answer.finish();
  }

  /** @param place in the torso */
  fromShoulder(place: Vector) {
    return minus(place, this.shoulder);
  }

  /**
   * Whether the stretched arm is too short for a position, or the folded arm too long; if so, the answer says so.
   *
   * @param place relative to the shoulder
   */
  isTooFar(place: Vector, answer: Answer) {
    const lower = norm(this.hand);
    const far = norm(place);
    const beyond = Math.max(far - this.upperArm - lower, Math.abs(this.upperArm - lower) - far);
    if (beyond <= ON_AXIS) return false;
    answer.setReason("OUT_OF_REACH", -1, beyond);
    return true;
  }

  /** The pose of the hand by forward kinematics. */
  forward(q: number[]): HandPose {
    const U = shoulderRotation(q);
    const B = product(product(rotX(q[2]), rotZ(q[3])), rotX(q[4]));
    return { R: product(U, B), place: turned(U, plus(turned(B, this.hand), this.elbow)) };
  }

  /** Add the branches for a pose of the hand, if the arm can reach its position of the elbow. */
  #addBranches(hand: HandPose, answer: Answer) {
    const w = minus(hand.place, turned(hand.R, this.hand));
    if (!(Math.abs(norm(w) - this.upperArm) <= REACHED)) {
      answer.setReason("NOT_ENOUGH_JOINTS");
      return;
    }
    const aside = Math.hypot(w[0], w[2]);
    const epsilon = Math.atan2(this.elbow[1], this.elbow[0]);
    const q = [0, 0, 0, 0, 0];
    if (aside <= ON_AXIS) {
      q[1] = wrapped(Math.atan2(w[1], aside) - epsilon);
      // The elbow is on the axis of ShoulderPitch, about which the arm can turn.
      this.addFamilies(hand, 0, [this.lower[0], this.upper[0]], "SHOULDER_AXIS", q, answer);
      return;
    }
    for (const side of [1, -1]) {
      q[0] = Math.atan2(-side * w[2], side * w[0]);
      q[1] = wrapped(Math.atan2(w[1], side * aside) - epsilon);
      this.addTriples(hand, q, answer);
    }
  }

  /**
   * Write the angles q₃ to q₅ from the hand's orientation relative to the upper arm, B = Rx(q₃) Rz(q₄) Rx(q₅). The angles
   * q₃ and q₄ follow from the first column of B, (cos q₄, cos q₃ sin q₄, sin q₃ sin q₄).
   */
  turnTriple({ R }: HandPose, q: number[], answer: Answer): Family {
    const B = product(transposed(shoulderRotation(q)), R);
    const sine = Math.hypot(B[3], B[6]);
    q[3] = Math.atan2(sine, B[0]);
    if (sine <= PARALLEL) {
      const sign = B[0] > 0 ? 1 : -1;
      this.lockPair([2, 4], Math.atan2(sign * B[7] - B[5], sign * B[4] + B[8]), sign, answer, q);
      return "ELBOW_LOCK";
    }
    q[2] = Math.atan2(B[6], B[3]);
    q[4] = Math.atan2(B[3] * B[7] - B[6] * B[4], B[3] * B[8] - B[6] * B[5]);
    return "NONE";
  }

  /** Rx(q₃ + π) Rz(−q₄) Rx(q₅ + π) */
  toOtherTriple(q: number[]) {
    [q[2], q[3], q[4]] = [wrapped(q[2] + Math.PI), -q[3], wrapped(q[4] + Math.PI)];
  }

  errors({ R, place }: HandPose, q: number[]): Errors {
    const made = this.forward(q);
    return [distance(made.place, place), angleBetween(made.R, R)];
  }
}

/** Ry(q₁) Rz(q₂) */
function shoulderRotation(q: number[]) {
  return product(rotY(q[0]), rotZ(q[1]));
}
