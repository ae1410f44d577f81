// @ts-nocheck
import { Answer } from "./answer.js";
import { Limb, rotationOfFrame } from "./limb.js";
import { rigid } from "./rigid.js";
import { TOLERANCES } from "./tolerances.js";
import { clamp, wrapped } from "../math/numbers.js";
import { angleBetween, product, rotY, rotZ, transposed } from "../math/rotations.js";

// The head, for an orientation or for a point that a camera is to see: R = Rz(yaw) Ry(pitch). An orientation is made where
// its second column has no z. A camera at o in the head with the optical axis n sees a point P in the middle where
// P = R (o + λ n), λ > 0. What is not reached is answered with the `nearest` joint values, by angle.
export class Head extends Limb {
  constructor(numbers) {
    super(numbers);
    const { x, y, z, a00, a20, forward, up } = this.geometry;
    this.neck = [x, y, z];
    Object.assign(this, { nx: a00, nz: a20, ahead: forward, up });
  }

  // The joint values for an orientation of the frame in the torso, the rotation of a pose.
  solve(T, reference, enforce = true) {
    const answer = new Answer(this, reference, enforce);
    const R = rigid(T);
    if (!R) return answer.blame("NOT_RIGID");
    const W = product(R, transposed(rotationOfFrame(this.geometry)));
    const q = [Math.atan2(-W[1], W[4]), Math.atan2(-W[6], W[8])];
    const error = Head.orientationError(W, q);
    if (error > TOLERANCES.VERIFIED) answer.blame("NOT_ENOUGH_JOINTS");
    else if (answer.admits(q)) answer.enter(q, [0, error]);
    if (answer.branches.length === 0) {
      const errorOf = (values) => Head.orientationError(W, values);
      // The trace of Ry(−pitch) Rz(−yaw) R has one maximum.
      const bestPitch = (c, s) => Math.atan2(W[2] * c + W[5] * s - W[6], W[0] * c + W[3] * s + W[8]);
      answer.nearest = this.bestYaw(errorOf, bestPitch, enforce);
    }
    return answer.concluded();
  }

  // The joint values with which the frame's x axis passes through a point in the torso.
  solveGaze(target, reference, enforce = true) {
    const answer = new Answer(this, reference, enforce);
    const P = target.map((value, k) => value - this.neck[k]);
    const [far, aside] = [Math.hypot(...P), Math.hypot(P[0], P[1])];
    // The camera along its optical axis and across.
    const along = this.ahead * this.nx + this.up * this.nz;
    const across = this.ahead * this.nz - this.up * this.nx;
    const beyond = (far - Math.abs(across)) * (far + Math.abs(across));
    const radius = Math.hypot(this.ahead, this.up);
    if (beyond < 0 || (along >= 0 && far <= radius)) {
      answer.blame("OUT_OF_REACH", -1, (along >= 0 ? radius : Math.abs(across)) - far);
    } else {
      for (const ahead of beyond === 0 ? [0] : [Math.sqrt(beyond), -Math.sqrt(beyond)]) {
        if (ahead > along) this.look(P, aside, ahead - along, answer);
      }
    }
    if (answer.branches.length === 0 && far > 0) answer.nearest = this.nearestGaze(P, enforce);
    return answer.concluded();
  }

  // Enter the branches that have a point at a distance λ from the camera.
  look([x, y, z], aside, lambda, answer) {
    const [u, w] = [this.ahead + lambda * this.nx, this.up + lambda * this.nz];
    const enter = (q, family) => answer.admits(q) && answer.enter(q, [0, this.gazeError([x, y, z], q)], family);
    if (aside <= Head.ON_AXIS) {
      const pitch = Math.atan2(-u * z, w * z);
      enter([this.freeYaw(pitch, answer.reference[0], answer.enforce), pitch], "YAW_AXIS");
      return;
    }
    for (const side of [1, -1]) {
      const r = side * aside;
      enter([Math.atan2(side * y, side * x), Math.atan2(w * r - u * z, u * r + w * z)], "NONE");
    }
  }

  // The yaw nearest to the one wanted at which the pitch is allowed; the wanted one if it is nowhere.
  freeYaw(pitch, wanted, enforce) {
    if (!enforce) return wanted;
    const best = clamp(wanted, this.lower[0], this.upper[0]);
    if (!this.table) return best;
    const allowed = (yaw, slack) => {
      const [low, high] = this.tableRange(yaw);
      return low - slack <= pitch && pitch <= high + slack;
    };
    if (allowed(best, 0)) return best;
    // The range is a polygon: the nearest yaw is at a bend, or where an edge has the pitch.
    const { at, lower, upper } = this.table;
    const yaws = [...at];
    for (let i = 1; i < at.length; i++) {
      for (const edge of [lower, upper]) {
        const share = (pitch - edge[i - 1]) / (edge[i] - edge[i - 1]);
        if (edge[i] !== edge[i - 1]) yaws.push(at[i - 1] + share * (at[i] - at[i - 1]));
      }
    }
    const inside = yaws.filter((yaw) => this.lower[0] <= yaw && yaw <= this.upper[0] && allowed(yaw, TOLERANCES.LIMIT));
    return inside.reduce((a, b) => (Math.abs(b - wanted) < Math.abs(a - wanted) ? b : a), inside[0] ?? best);
  }

  // The yaw with the smallest error, by search, with the best pitch of each.
  bestYaw(errorOf, bestPitch, enforce) {
    const [low, high] = enforce ? [this.lower[0], this.upper[0]] : [-Math.PI, Math.PI];
    const at = (yaw) => {
      const free = bestPitch(Math.cos(yaw), Math.sin(yaw));
      const [least, most] = [-Infinity, Infinity].map((pitch) => this.allowedPitch(yaw, pitch, enforce));
      const pitches = free < least || free > most ? [least, most] : [free];
      const tried = pitches.map((pitch) => ({ values: [yaw, pitch], error: errorOf([yaw, pitch]) }));
      return tried.reduce((a, b) => (a.error < b.error ? a : b));
    };
    const { STEPS, DIVISIONS, GOLDEN } = Head;
    const step = (high - low) / STEPS;
    const grid = Array.from({ length: STEPS + 1 }, (_, i) => at(low + i * step));
    let best = grid.reduce((a, b) => (b.error < a.error ? b : a));
    let [left, right] = [Math.max(low, best.values[0] - step), Math.min(high, best.values[0] + step)];
    for (let i = 0; i < DIVISIONS; i++) {
      const width = GOLDEN * (right - left);
      const [one, two] = [at(right - width), at(left + width)];
      if (one.error < two.error) right = two.values[0];
      else left = one.values[0];
      const lesser = one.error < two.error ? one : two;
      if (lesser.error < best.error) best = lesser;
    }
    return best;
  }

  // With the point aside the best pitch is not quite the one above: look around, along the edge of the range too.
  nearestGaze(P, enforce) {
    const errorOf = (values) => this.gazeError(P, values);
    let best = this.bestYaw(errorOf, (c, s) => this.pitchTowards(P[0] * c + P[1] * s, P[2]), enforce);
    const [low, high] = enforce ? [this.lower[0], this.upper[0]] : [-Math.PI, Math.PI];
    let step = Head.FIRST_STEP;
    while (step > Head.LAST_STEP) {
      const before = best;
      for (const [dy, dp] of [
        [step, 0],
        [-step, 0],
        [0, step],
        [0, -step],
      ]) {
        const yaw = clamp(best.values[0] + dy, low, high);
        const values = [yaw, this.allowedPitch(yaw, best.values[1] + dp, enforce)];
        const error = errorOf(values);
        if (error < best.error) best = { values, error };
      }
      if (best === before) step *= 0.5;
    }
    return best;
  }

  // The pitch nearest to one that is allowed at a yaw.
  allowedPitch(yaw, pitch, enforce) {
    if (!enforce) return pitch;
    let [low, high] = [this.lower[1], this.upper[1]];
    if (this.table) {
      const bounds = this.tableRange(yaw);
      [low, high] = [clamp(bounds[0], low, high), clamp(bounds[1], low, high)];
    }
    return clamp(pitch, low, high);
  }

  // The pitch at which the camera, its axis in a vertical plane, looks as near as it can to a point near it: along (x, z)
  // as seen from the camera, which moves with the pitch; a few rounds settle it.
  pitchTowards(x, z) {
    const tilt = Math.atan2(-this.nz, this.nx);
    let pitch = Math.atan2(-z, x) - tilt;
    for (let i = 0; i < 30; i++) {
      const [c, s] = [Math.cos(pitch), Math.sin(pitch)];
      const [dx, dz] = [x - (c * this.ahead + s * this.up), z - (c * this.up - s * this.ahead)];
      pitch = wrapped(Math.atan2(-dz, dx) - tilt);
    }
    return pitch;
  }

  // The angle between the optical axis and the direction from the camera to a point seen from the neck.
  gazeError(P, [yaw, pitch]) {
    const [c, s, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    // The point as the head sees it, Ry(−pitch) Rz(−yaw) P, from the camera.
    const [x, y] = [c * P[0] + s * P[1], c * P[1] - s * P[0]];
    const [u, w] = [cp * x - sp * P[2] - this.ahead, sp * x + cp * P[2] - this.up];
    return Math.atan2(Math.hypot(w * this.nx - u * this.nz, y), u * this.nx + w * this.nz);
  }
}

// The angle between Rz(yaw) Ry(pitch) and an orientation.
Head.orientationError = (W, [yaw, pitch]) => angleBetween(product(rotZ(yaw), rotY(pitch)), W);

// Below ON_AXIS [m] from the yaw's axis, every yaw looks at a point as well as another. Steps of the search for the nearest
// yaw and divisions after it, and the steps [rad] of the search around it.
Object.assign(Head, {
  ON_AXIS: 1e-12,
  STEPS: 120,
  DIVISIONS: 60,
  FIRST_STEP: 0.02,
  LAST_STEP: 1e-10,
  GOLDEN: 0.5 * (Math.sqrt(5) - 1),
});
