// @ts-nocheck
import { Answer } from "./answer.js";
import { Limb, rotationOfFrame } from "./limb.js";
import { rigid } from "./rigid.js";
import { cross, dot, wrapped } from "../math/numbers.js";
import { angleBetween, product, rotX, rotY, rotZ, transposed, turned } from "../math/rotations.js";

// The arm: four real branches for a pose of the hand that five joints can make, up to eight for its place and the
// direction of the forearm, and one of many for its place alone. With e the elbow in the upper arm and h the frame from
// the elbow in the axes of the hand,
//
//     R = Ry(q₁) Rz(q₂) Rx(q₃) Rz(q₄) Rx(q₅),  p = shoulder + Ry(q₁) Rz(q₂) e + R h.
export class Arm extends Limb {
  constructor(numbers) {
    super(numbers);
    const { x, y, z, elbow_x, elbow_y, hand_x, hand_y, hand_z } = this.geometry;
    this.shoulder = [x, y, z];
    this.elbow = [elbow_x, elbow_y, 0];
    this.hand = [hand_x, hand_y, hand_z];
    this.upperArm = Math.hypot(elbow_x, elbow_y);
  }

  // All branches for the pose of its frame in the torso.
  solve(T, reference, enforce = true) {
    const answer = new Answer(this, reference, enforce);
    let R = rigid(T);
    if (!R) return answer.blame("NOT_RIGID");
    if (this.geometry.turned !== 0) R = product(R, transposed(rotationOfFrame(this.geometry)));
    const place = this.fromShoulder([T[3], T[7], T[11]]);
    if (this.isTooFar(place, answer)) return answer;
    this.enterBranches({ R, place }, answer);
    return answer.concluded();
  }

  // All branches for the place of the frame and the direction of the forearm, its x axis, which is not zero: where the
  // circle of the elbow meets the sphere about the shoulder, the hand's whole orientation follows.
  solveDirection(target, direction, reference, enforce = true) {
    const answer = new Answer(this, reference, enforce);
    const place = this.fromShoulder(target);
    if (this.isTooFar(place, answer)) return answer;
    const circle = this.circle(place, direction);
    const { along, across, radius } = circle;
    const { upperArm } = this;
    const [near, far] = [Math.hypot(along, across - radius), Math.hypot(along, across + radius)];
    const { REACHED, ONE_TURN } = Arm;
    if (near > upperArm + REACHED || far < upperArm - REACHED) return answer.blame("NOT_ENOUGH_JOINTS");
    const ahead = Math.max(0, (upperArm - near) * (upperArm + near));
    const behind = Math.max(0, (far - upperArm) * (far + upperArm));
    const turn = 2 * Math.atan2(Math.sqrt(ahead), Math.sqrt(behind));
    this.enterBranches(this.handOn(circle, turn), answer);
    if (turn > ONE_TURN && turn < Math.PI - ONE_TURN) this.enterBranches(this.handOn(circle, -turn), answer);
    return answer.concluded();
  }

  fromShoulder(place) {
    return place.map((value, k) => value - this.shoulder[k]);
  }

  isTooFar(place, answer) {
    const lower = Math.hypot(...this.hand);
    const far = Math.hypot(...place);
    const beyond = Math.max(far - this.upperArm - lower, Math.abs(this.upperArm - lower) - far);
    if (beyond <= Arm.ON_AXIS) return false;
    answer.blame("OUT_OF_REACH", -1, beyond);
    return true;
  }

  // Where the elbow is, seen from the shoulder, when the forearm lies along n and the frame stands at its place: v points
  // across towards the middle of the circle, which is so far along n and across it.
  circle(place, direction) {
    const length = Math.hypot(...direction);
    const n = direction.map((value) => value / length);
    const u = place.map((value, k) => value - this.hand[0] * n[k]);
    const along = dot(u, n);
    let v = u.map((value, k) => value - along * n[k]);
    const across = Math.hypot(...v);
    if (across <= Arm.ON_AXIS) {
      // Any direction across will do.
      const s = Math.abs(n[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0];
      v = s.map((value, k) => value - dot(s, n) * n[k]);
    }
    const size = Math.hypot(...v);
    v = v.map((value) => value / size);
    return { place, n, v, along, across, radius: Math.hypot(this.hand[1], this.hand[2]) };
  }

  // The pose of the hand with which the elbow is at an angle on its circle, from the side of the shoulder.
  handOn({ place, n, v }, turn) {
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    const nv = cross(n, v);
    const k = v.map((value, i) => c * value + s * nv[i]);
    const o = cross(n, k);
    const beta = Math.atan2(this.hand[2], this.hand[1]);
    const [cb, sb] = [Math.cos(beta), Math.sin(beta)];
    const R = [0, 1, 2].flatMap((i) => [n[i], cb * k[i] - sb * o[i], sb * k[i] + cb * o[i]]);
    return { R, place };
  }

  // Enter the branches for a pose of the hand seen from the shoulder, if the elbow is where the arm can have it.
  enterBranches({ R, place }, answer) {
    const arm = turned(R, this.hand);
    const w = place.map((value, k) => value - arm[k]);
    if (!(Math.abs(Math.hypot(...w) - this.upperArm) <= Arm.REACHED)) {
      answer.blame("NOT_ENOUGH_JOINTS");
      return;
    }
    const aside = Math.hypot(w[0], w[2]);
    const epsilon = Math.atan2(this.elbow[1], this.elbow[0]);
    const q = [0, 0, 0, 0, 0];
    if (aside <= Arm.ON_AXIS) {
      q[1] = wrapped(Math.atan2(w[1], aside) - epsilon);
      for (const other of [false, true]) this.aboutShoulderAxis({ R, place }, q, other, answer);
      return;
    }
    for (const side of [1, -1]) {
      q[0] = Math.atan2(-side * w[2], side * w[0]);
      q[1] = wrapped(Math.atan2(w[1], side * aside) - epsilon);
      const family = this.turnElbow(R, q, answer);
      for (const other of family === "NONE" ? [false, true] : [false]) {
        if (other) Arm.otherTriple(q);
        if (answer.admits(q)) answer.enter(q, this.errors({ R, place }, q), family);
      }
    }
  }

  // The angles q₃ to q₅ from what the shoulder leaves of the hand's orientation, B = Rx(q₃) Rz(q₄) Rx(q₅); returns their
  // family. The first turn is taken from the first column of B, (cos q₄, cos q₃ sin q₄, sin q₃ sin q₄).
  turnElbow(R, q, options) {
    const B = product(transposed(Arm.shoulder(q)), R);
    const sine = Math.hypot(B[3], B[6]);
    q[3] = Math.atan2(sine, B[0]);
    if (sine <= Arm.PARALLEL) {
      const sign = B[0] > 0 ? 1 : -1;
      this.lockPair([2, 4], Math.atan2(sign * B[7] - B[5], sign * B[4] + B[8]), sign, options, q);
      return "ELBOW_LOCK";
    }
    q[2] = Math.atan2(B[6], B[3]);
    q[4] = Math.atan2(B[3] * B[7] - B[6] * B[4], B[3] * B[8] - B[6] * B[5]);
    return "NONE";
  }

  // Enter the member of a family with the elbow on the axis of ShoulderPitch, about which the arm may turn.
  aboutShoulderAxis(hand, q, other, answer) {
    const own = answer.reference[0];
    const [low, high] = answer.enforce ? [this.lower[0], this.upper[0]] : [own - Math.PI, own + Math.PI];
    const cost = (pitch) => {
      q[0] = pitch;
      const family = this.turnElbow(hand.R, q, answer);
      if (other && family !== "NONE") return Infinity; // the two triples belong to one family
      if (other) Arm.otherTriple(q);
      return this.familyCost(q, answer);
    };
    if (this.leastCost(low, high, own, cost) === null) return;
    if (answer.admits(q)) answer.enter(q, this.errors(hand, q), "SHOULDER_AXIS");
  }

  // How far the frame is from its target by forward kinematics: distance [m] and angle [rad].
  errors({ R, place }, q) {
    const made = this.forward(q);
    return [Math.hypot(...made.place.map((value, k) => value - place[k])), angleBetween(made.R, R)];
  }

  // Orientation of the hand and place of the frame, seen from the shoulder.
  forward(q) {
    const U = Arm.shoulder(q);
    const B = product(product(rotX(q[2]), rotZ(q[3])), rotX(q[4]));
    const hand = turned(B, this.hand);
    return {
      R: product(U, B),
      place: turned(
        U,
        hand.map((value, k) => value + this.elbow[k]),
      ),
    };
  }
}

// Ry(q₁) Rz(q₂)
Arm.shoulder = (q) => product(rotY(q[0]), rotZ(q[1]));

// The angles that make the same orientation: Rx(q₃ + π) Rz(−q₄) Rx(q₅ + π).
Arm.otherTriple = (q) => {
  [q[2], q[3], q[4]] = [wrapped(q[2] + Math.PI), -q[3], wrapped(q[4] + Math.PI)];
};

// How far [m] the elbow may be from where the arm can have it, and from the axis of ShoulderPitch to be on it; the sine of
// ElbowRoll up to which the axes of ElbowYaw and WristYaw are one; the angle below which the elbow's two places on its
// circle are one.
Object.assign(Arm, { REACHED: 1e-11, ON_AXIS: 1e-12, PARALLEL: 1e-12, ONE_TURN: 1e-7 });
