import { clamp } from "../math/numbers.ts";
import {
  angleBetween,
  cross,
  dot,
  minus,
  norm,
  plus,
  product,
  rotY,
  rotZ,
  times,
  transposed,
  type Pose,
  type Rotation,
  type Vector,
} from "../math/rotations.ts";
import { Answer, LIMIT, Limb, VERIFIED, leastCost, rigidRotation } from "./limb.ts";
import type { Family, GazeNumbers, HeadNumbers, Nearest } from "./limbs.ts";

// Number of steps of the search for the nearest yaw.
const STEPS = 120;

/** HeadYaw and HeadPitch, R = Rz(yaw) Ry(pitch), and the search for the values that come nearest to a target. */
class Neck<Numbers extends HeadNumbers | GazeNumbers> extends Limb<Numbers> {
  /**
   * The joint values with the smallest error: a search over the yaw, with the best pitch for each yaw.
   *
   * @param bestPitch gives the best pitch for the cosine and sine of a yaw, ignoring the limits
   * @param near a yaw to try in addition to the even steps
   */
  bestYaw(
    errorOf: (values: number[]) => number,
    bestPitch: (c: number, s: number) => number,
    near: number,
    enforce: boolean,
  ): Nearest {
    const [low, high] = this.yawRange(enforce);
    const at = (yaw: number): Nearest => {
      const free = bestPitch(Math.cos(yaw), Math.sin(yaw));
      const [least, most] = [-Infinity, Infinity].map((pitch) => this.allowedPitch(yaw, pitch, enforce));
      const pitches = free < least || free > most ? [least, most] : [free];
      const tried = pitches.map((pitch) => ({ values: [yaw, pitch], error: errorOf([yaw, pitch]) }));
      return tried.reduce((a, b) => (a.error < b.error ? a : b));
    };
    return at(leastCost(low, high, near, (yaw) => at(yaw).error, STEPS) ?? low);
  }

  yawRange(enforce: boolean): [number, number] {
    return enforce ? [this.lower[0], this.upper[0]] : [-Math.PI, Math.PI];
  }

  /** The allowed pitch at a yaw that is nearest to a pitch. */
  allowedPitch(yaw: number, pitch: number, enforce: boolean) {
    if (!enforce) return pitch;
    const [low, high] = [this.lower[1], this.upper[1]];
    const [least, most] = this.tableRange(yaw).map((bound) => clamp(bound, low, high));
    return clamp(pitch, least, most);
  }
}

/**
 * The head, for an orientation. Rz(yaw) Ry(pitch) can make R if the z entry of R's second column is zero. For other
 * orientations the answer has the `nearest` joint values, by angle.
 */
export class Head extends Neck<HeadNumbers> {
  /** The joint values for an orientation of the frame in the torso, the rotation of a pose. */
  solve(T: Pose, reference: number[], enforce = true) {
    const answer = new Answer(this, reference, enforce);
    const R = rigidRotation(T);
    if (!R) return answer.setReason("NOT_RIGID");
    const W = product(R, transposed(this.frameRotation));
    const q = [Math.atan2(-W[1], W[4]), Math.atan2(-W[6], W[8])];
    const error = orientationError(W, q);
    if (error > VERIFIED) answer.setReason("NOT_ENOUGH_JOINTS");
    else if (answer.checkLimits(q)) answer.addBranch(q, [0, error]);
    if (answer.branches.length === 0) {
      // The pitch at which the trace of Ry(−pitch) Rz(−yaw) R has its only maximum.
      const bestPitch = (c: number, s: number) => Math.atan2(W[2] * c + W[5] * s - W[6], W[0] * c + W[3] * s + W[8]);
      answer.nearest = this.bestYaw((values) => orientationError(W, values), bestPitch, q[0], enforce);
    }
    return answer.finish();
  }
}

/** The angle between Rz(yaw) Ry(pitch) and an orientation. */
function orientationError(W: Rotation, [yaw, pitch]: number[]) {
  return angleBetween(product(rotZ(yaw), rotY(pitch)), W);
}

// A point nearer to the yaw's axis than this [m] is seen equally well with every yaw.
const ON_AXIS = 1e-12;
// The size of the grid over yaw and pitch, and the last step of the searches that start from it [rad].
const YAWS = 60;
const PITCHES = 40;
const LAST_STEP = 1e-10;

/**
 * The head, for a point that a camera looks at. The camera, at o in the head with the optical axis n, has a point P of the
 * torso in the centre of its image if P = neck + R (o + λ n) with λ > 0. For a point that it cannot look at, the answer has
 * the `nearest` joint values, by angle.
 */
export class Gaze extends Neck<GazeNumbers> {
  neck: Vector;
  /** o and n in the axes of the head. */
  place: Vector;
  axis: Vector;

  constructor(numbers: GazeNumbers) {
    super(numbers);
    const { neck, place, rotation } = this.geometry;
    this.neck = neck;
    this.place = place;
    this.axis = [rotation[0], rotation[3], rotation[6]];
  }

  /** The joint values with which the frame's x axis passes through a point in the torso. */
  solveGaze(target: Vector, reference: number[], enforce = true) {
    const answer = new Answer(this, reference, enforce);
    const P = minus(target, this.neck);
    const [far, aside] = [norm(P), Math.hypot(P[0], P[1])];
    // The position of the camera along its optical axis and normal to it.
    const along = dot(this.place, this.axis);
    const across = norm(cross(this.place, this.axis));
    const beyond = (far - across) * (far + across);
    const radius = norm(this.place);
    if (beyond < 0 || (along >= 0 && far <= radius)) {
      answer.setReason("OUT_OF_REACH", -1, (along >= 0 ? radius : across) - far);
    } else {
      for (const ahead of beyond === 0 ? [0] : [Math.sqrt(beyond), -Math.sqrt(beyond)]) {
        if (ahead > along) this.#look(P, aside, ahead - along, answer);
      }
    }
    if (answer.branches.length === 0 && far > 0) answer.nearest = this.#nearestGaze(P, enforce);
    return answer.finish();
  }

  /**
   * Add the branches that look at a point at the distance λ from the camera.
   *
   * @param P relative to the neck
   * @param aside distance of P from the yaw's axis
   */
  #look(P: Vector, aside: number, lambda: number, answer: Answer) {
    const [x, y, z] = P;
    const [u, v, w] = plus(this.place, times(lambda, this.axis));
    const add = (q: number[], family: Family) =>
      answer.checkLimits(q) && answer.addBranch(q, [0, this.#error(P, q)], family);
    if (Math.max(aside, Math.abs(v)) <= ON_AXIS) {
      const pitch = Math.atan2(-u * z, w * z);
      add([this.#freeYaw(pitch, answer.reference[0], answer.enforce), pitch], "YAW_AXIS");
      return;
    }
    const past = Math.abs(v) - aside;
    if (past > ON_AXIS) {
      // The camera looks past the yaw's axis at a larger distance than the point's.
      if (answer.joint < 0) answer.setReason("OUT_OF_REACH", -1, past);
      return;
    }
    const root = Math.sqrt(Math.max(0, -past * (aside + Math.abs(v))));
    for (const r of root > 0 ? [root, -root] : [0]) {
      add([Math.atan2(y * r - x * v, x * r + y * v), Math.atan2(w * r - u * z, u * r + w * z)], "NONE");
    }
  }

  /** The yaw nearest to the wanted one at which the pitch is allowed; the wanted yaw if there is none. */
  #freeYaw(pitch: number, wanted: number, enforce: boolean) {
    if (!enforce) return wanted;
    const best = clamp(wanted, this.lower[0], this.upper[0]);
    if (!this.table) return best;
    const allowed = (yaw: number, slack: number) => {
      const [low, high] = this.tableRange(yaw);
      return low - slack <= pitch && pitch <= high + slack;
    };
    if (allowed(best, 0)) return best;
    // The range is a polygon: the nearest yaw is at a corner, or where an edge has this pitch.
    const { at, lower, upper } = this.table;
    const yaws = [...at];
    for (let i = 1; i < at.length; i++) {
      for (const edge of [lower, upper]) {
        const share = (pitch - edge[i - 1]) / (edge[i] - edge[i - 1]);
        if (edge[i] !== edge[i - 1]) yaws.push(at[i - 1] + share * (at[i] - at[i - 1]));
      }
    }
    const inside = yaws.filter((yaw) => this.lower[0] <= yaw && yaw <= this.upper[0] && allowed(yaw, LIMIT));
    return inside.reduce((a, b) => (Math.abs(b - wanted) < Math.abs(a - wanted) ? b : a), inside[0] ?? best);
  }

  /**
   * The joint values that look nearest to a point: a descent from each local minimum of a grid.
   *
   * @param P relative to the neck
   */
  #nearestGaze(P: Vector, enforce: boolean) {
    const [low, high] = this.yawRange(enforce);
    const [least, most] = enforce ? [this.lower[1], this.upper[1]] : [-Math.PI, Math.PI];
    const look = (yaw: number, pitch: number): Nearest => {
      const inside = clamp(yaw, low, high);
      const values = [inside, this.allowedPitch(inside, pitch, enforce)];
      return { values, error: this.#error(P, values) };
    };
    const pitches = [...Array(PITCHES + 1).keys()].map((k) => least + ((most - least) * k) / PITCHES);
    const columns = [...Array(YAWS + 1).keys()].map((i) => {
      const looks = pitches.map((pitch) => look(low + ((high - low) * i) / YAWS, pitch));
      return looks.reduce((a, b) => (b.error < a.error ? b : a));
    });
    const errors = [Infinity, ...columns.map(({ error }) => error), Infinity];
    const valleys = columns.filter(({ error }, i) => error <= errors[i] && error <= errors[i + 2]);
    const ends = valleys.map((start) => lookDown(start, (high - low) / YAWS, look));
    return ends.reduce((a, b) => (b.error < a.error ? b : a));
  }

  /**
   * The angle between the optical axis and the direction from the camera to a point.
   *
   * @param P relative to the neck
   */
  #error(P: Vector, [yaw, pitch]: number[]) {
    const [c, s, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    // The point relative to the camera in the axes of the head, Ry(−pitch) Rz(−yaw) P − o.
    const x = c * P[0] + s * P[1];
    const seen = minus([cp * x - sp * P[2], c * P[1] - s * P[0], sp * x + cp * P[2]], this.place);
    return Math.atan2(norm(cross(seen, this.axis)), dot(seen, this.axis));
  }
}

/**
 * Descend to joint values that look nearer to the point, until the steps are tiny.
 *
 * @param look evaluates a yaw and a pitch, clamped to the limits
 */
function lookDown(start: Nearest, firstStep: number, look: (yaw: number, pitch: number) => Nearest) {
  let best = start;
  let step = firstStep;
  while (step > LAST_STEP) {
    const before = best;
    for (const dy of [-step, 0, step]) {
      for (const dp of [-step, 0, step]) {
        const found = look(best.values[0] + dy, best.values[1] + dp);
        if (found.error < best.error) best = found;
      }
    }
    if (best === before) step *= 0.5;
  }
  return best;
}
