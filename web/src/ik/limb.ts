import { allTurnedTowards, clamp, interpolate, squaredDistance, turnedTowards } from "../math/numbers.ts";
import { product, transposed, type Matrix3, type Pose, type Rotation } from "../math/rotations.ts";
import type { Branch, Errors, Family, LimbNumbers, Nearest, Reason, Violation } from "./limbs.ts";

/** How far a joint may be outside its limits [rad]. */
export const LIMIT = 1e-6;

/** How far rounding may change an angle [rad]; a search exceeds a limit by no more. */
export const ROUNDING = 1e-9;

/** The largest errors of a solution [m, rad]. */
export const VERIFIED = 1e-10;

// The largest defect of a rotation matrix that is accepted, and the largest that is not corrected.
const RIGID = 1e-6;
const EXACT = 1e-14;

/** The rotation of a rigid transform, corrected by a step of R ← R (3 − RᵀR)/2; null if the transform is not rigid. */
export function rigidRotation(T: Pose): Rotation | null {
  const R: Rotation = [T[0], T[1], T[2], T[4], T[5], T[6], T[8], T[9], T[10]];
  const [a, b, c, d, e, f, g, h, i] = R;
  const left = product(transposed(R), R).map((value, k) => (k % 4 === 0 ? 1 : 0) - value);
  const defect = Math.max(...left.map(Math.abs));
  const determinant = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g);
  const below = Math.abs(T[12]) + Math.abs(T[13]) + Math.abs(T[14]) + Math.abs(T[15] - 1);
  // Written so that NaN is refused: comparisons with NaN are false.
  if (!(defect <= RIGID && Math.abs(determinant - 1) <= RIGID && below <= RIGID)) return null;
  if (!Number.isFinite(T[3] + T[7] + T[11])) return null;
  if (defect <= EXACT) return R;
  const step = product(R, left as Matrix3);
  return R.map((value, k) => value + 0.5 * step[k]) as Rotation;
}

// The search divides the range into steps, usually STEPS, and then halves its step HALVINGS times.
const STEPS = 180;
const HALVINGS = 48;

/**
 * Minimise the cost of a family of solutions over its parameter in [low, high], on a grid and then by halving. Null if all
 * costs are infinite. The reference's own value is tried first, so that a solution that fits exactly is not changed by
 * rounding.
 */
export function leastCost(
  low: number,
  high: number,
  own: number,
  cost: (value: number) => number,
  steps: number = STEPS,
) {
  const step = (high - low) / steps;
  let [best, at] = [Infinity, low];
  const attempt = (value: number) => {
    const tried = cost(value);
    if (tried < best) [best, at] = [tried, value];
  };
  attempt(clamp(own, low, high));
  for (let i = 0; i <= steps; i++) attempt(low + step * i);
  for (let [i, width] = [0, step]; i < HALVINGS; i++, width *= 0.5) {
    [Math.max(low, at - width), Math.min(high, at + width)].forEach(attempt);
  }
  // Evaluate the best value once more: the cost function writes the solution, and the last one written is used.
  return cost(at) === Infinity ? null : at;
}

/**
 * The answer of a closed form for one target: the branches, nearest to the reference first, or the reason why there is
 * none. If limits are the reason, `joint` is that of the branch which exceeds them least.
 */
export class Answer {
  branches: Branch[] = [];

  /** The joint values that come nearest if the head or a camera does not reach its target. */
  nearest: Nearest | undefined;

  /** Why there is no branch, or REACHED. */
  reason: Reason = "NOT_CONVERGED";
  joint = -1;
  needed = 0;
  limit = 0;

  /** How far the target was moved into reach [m]; the errors of the branches include this. */
  short = 0;

  /** How far the branch that gave the reason is outside the limits [rad]. */
  #excess = Infinity;

  constructor(
    readonly limb: Limb<LimbNumbers>,
    readonly reference: number[],
    public enforce: boolean,
  ) {}

  /**
   * Set the reason why there is no branch.
   *
   * @param joint index of the joint in the limb, or -1
   * @param needed the value that the joint would need [rad]; without one, how far the target is out of reach [m]
   * @param limit the end of the joint's range that it would exceed [rad]
   */
  setReason(reason: Reason, joint: number = -1, needed: number = 0, limit: number = 0) {
    this.reason = reason;
    this.joint = joint;
    this.needed = needed;
    this.limit = limit;
    return this;
  }

  /** Whether a branch is inside the limits; if not, it gives the reason unless an earlier branch was less far outside. */
  checkLimits(values: number[]) {
    if (!this.enforce || this.limb.isInside(values)) return true;
    const outside = this.limb.excess(values);
    if (outside < this.#excess) {
      this.#excess = outside;
      this.setLimitReason(values);
    }
    return false;
  }

  /** Give the joint that is farthest outside its limits as the reason. */
  setLimitReason(values: number[]) {
    const worst = this.limb.violations(values).reduce((a, b) => (b.outside > a.outside ? b : a));
    const { reason, joint, value, low, high } = worst;
    const zero = this.limb.zeros[joint];
    this.setReason(reason, joint, value + zero, (low - value > value - high ? low : high) + zero);
  }

  /**
   * Add a branch if its errors are small enough. Without limits, each joint is shifted by whole turns to within half a turn
   * of the reference.
   *
   * @param errors by forward kinematics
   */
  addBranch(values: number[], errors: Errors, family: Family = "NONE", yaw: number = 0) {
    if (!errors.every((error) => error <= VERIFIED)) return;
    const near = this.enforce ? [...values] : allTurnedTowards(values, this.reference);
    const withShort: Errors = [errors[0] + this.short, errors[1]];
    const distance = squaredDistance(this.reference, near);
    const branch = { values: near, errors: withShort, family, distance, yaw };
    let place = this.branches.length;
    while (place > 0 && this.branches[place - 1].distance > branch.distance) place--;
    this.branches.splice(place, 0, branch);
  }

  /** Set the reason REACHED if there is a branch. */
  finish() {
    return this.branches.length > 0 ? this.setReason("REACHED") : this;
  }
}

// The cost of a solution outside the limits, far more than any distance from the reference.
const OUTSIDE = 1e3;

/** The limb has the fields of its description, with open limits as ±Infinity. */
export interface Limb<Numbers extends LimbNumbers> extends Omit<LimbNumbers, "kind" | "lower" | "upper" | "geometry"> {
  kind: Numbers["kind"];
  geometry: Numbers["geometry"];
}

/**
 * The common base of the limbs' closed forms: joints, limits, and the choice of values if two joints turn about one line.
 *
 * These files repeat Python's nao_kin.ik for the page: the same equations, which docs/inverse_kinematics.md derives, and
 * the same order of branches, reasons and families.
 */
export class Limb<Numbers extends LimbNumbers> {
  lower: number[];
  upper: number[];
  /** The rotation of the frame in the link that carries it. */
  frameRotation: Matrix3;

  constructor(numbers: Numbers) {
    Object.assign(this, numbers);
    this.lower = numbers.lower.map((value) => value ?? -Infinity);
    this.upper = numbers.upper.map((value) => value ?? Infinity);
    this.frameRotation = numbers.geometry.rotation;
  }

  /** Values of the joints in a configuration, from the zeros of the closed form. */
  values(q: ArrayLike<number>) {
    return this.columns.map((column, i) => this.multiplier[i] * q[column] + this.offset[i]);
  }

  /** A configuration with these values of the joints. */
  merged(q: number[], values: number[]) {
    const merged = [...q];
    this.columns.forEach((column, i) => (merged[column] = (values[i] - this.offset[i]) / this.multiplier[i]));
    return merged;
  }

  /** Whether a joint is outside its own range; the coupled limits are not considered. */
  isOutside(joint: number, value: number) {
    return value < this.lower[joint] - LIMIT || value > this.upper[joint] + LIMIT;
  }

  /** The range of one joint at a value of another; without a table it is open. */
  tableRange(of: number): [number, number] {
    if (!this.table) return [-Infinity, Infinity];
    const { at, lower, upper } = this.table;
    return [interpolate(at, lower, of), interpolate(at, upper, of)];
  }

  /** How far each joint is outside its range; the coupled limits count for a joint that is inside its own range. */
  violations(values: number[]): Violation[] {
    const found = values.map((value, joint) =>
      violation("JOINT_LIMIT", joint, value, this.lower[joint], this.upper[joint]),
    );
    if (this.table && !this.isOutside(this.table.joint, values[this.table.joint])) {
      const { joint, of } = this.table;
      found.push(violation("COUPLED_LIMIT", joint, values[joint], ...this.tableRange(values[of])));
    }
    return found;
  }

  /** How far the worst joint is outside its limits; negative if all joints are inside. */
  excess(values: number[]) {
    return Math.max(-1, ...this.violations(values).map(({ outside }) => outside));
  }

  /** Whether all joints are inside their limits, including the coupled ones. */
  isInside(values: number[]) {
    if (values.some((value, joint) => this.isOutside(joint, value))) return false;
    if (!this.table) return true;
    const [low, high] = this.tableRange(values[this.table.of]);
    const value = values[this.table.joint];
    return low - LIMIT <= value && value <= high + LIMIT;
  }

  /**
   * Write the values of two joints that turn about one line, for which only first + sign · third = total is determined:
   * the pair nearest to the reference, inside the ranges if possible.
   */
  lockPair([i, j]: [number, number], total: number, sign: 1 | -1, { reference, enforce }: Answer, values: number[]) {
    if (!enforce) {
      // The excess of the reference over the total, up to whole turns, is shared equally by both joints.
      const half = 0.5 * turnedTowards(reference[i] + sign * reference[j] - total, 0);
      [values[i], values[j]] = [reference[i] - half, reference[j] - sign * half];
      return;
    }
    const [low1, high1, low3, high3] = [this.lower[i], this.upper[i], this.lower[j], this.upper[j]];
    let [bestOutside, best] = [Infinity, Infinity];
    for (let turns = -2; turns < 3; turns++) {
      // third = sign (total − first) + shift
      const shift = 2 * Math.PI * turns;
      const ends = [total - sign * (low3 - shift), total - sign * (high3 - shift)];
      const [low, high] = [Math.max(low1, Math.min(...ends)), Math.min(high1, Math.max(...ends))];
      const middle = 0.5 * (reference[i] + total + sign * (shift - reference[j]));
      const first = low <= high ? clamp(middle, low, high) : clamp(0.5 * (low + high), low1, high1);
      const third = sign * (total - first) + shift;
      const outside = Math.max(0, low3 - third, third - high3);
      const away = (first - reference[i]) ** 2 + (third - reference[j]) ** 2;
      if (outside < bestOutside - ROUNDING || (outside < bestOutside + ROUNDING && away < best)) {
        [bestOutside, best] = [outside, away];
        [values[i], values[j]] = [first, third];
      }
    }
  }

  /** The cost of a solution: its distance from the reference, and far more if it is outside the limits. */
  familyCost(values: number[], { reference, enforce }: Answer) {
    const outside = enforce ? this.excess(values) : 0;
    const near = enforce ? values : allTurnedTowards(values, reference);
    return outside <= ROUNDING ? squaredDistance(reference, near) : OUTSIDE * (1 + outside);
  }
}

function violation(reason: Violation["reason"], joint: number, value: number, low: number, high: number): Violation {
  return { reason, joint, value, low, high, outside: Math.max(low - value, value - high) };
}

/** A limb that ends its closed form with three joints whose axes meet: the hip of a leg, or elbow and wrist of an arm. */
export abstract class TripleLimb<Numbers extends LimbNumbers, Target> extends Limb<Numbers> {
  /**
   * Write the angles of the triple that meet the target, given the other joints.
   *
   * @returns the family that the solution belongs to if two axes of the triple are one line, else NONE
   */
  abstract turnTriple(target: Target, q: number[], answer: Answer): Family;

  /** Write the other angles of the triple with the same orientation. */
  abstract toOtherTriple(q: number[]): void;

  /** How far the frame is from its target by forward kinematics. */
  abstract errors(target: Target, q: number[]): Errors;

  /** Add the branches with these values of the other joints. */
  addTriples(target: Target, q: number[], answer: Answer) {
    const family = this.turnTriple(target, q, answer);
    for (const other of family === "NONE" ? [false, true] : [false]) {
      if (other) this.toOtherTriple(q);
      if (answer.checkLimits(q)) answer.addBranch(q, this.errors(target, q), family);
    }
  }

  /**
   * Add the best members of the two families of solutions in which every value of a joint meets the target, each value with
   * its own angles of the triple.
   *
   * @param range of the joint
   */
  addFamilies(target: Target, joint: number, range: [number, number], family: Family, q: number[], answer: Answer) {
    const own = answer.reference[joint];
    const [low, high] = answer.enforce ? range : [own - Math.PI, own + Math.PI];
    for (const other of [false, true]) {
      const cost = (value: number) => {
        q[joint] = value;
        const locked = this.turnTriple(target, q, answer) !== "NONE";
        if (other && locked) return Infinity; // the two triples belong to one family
        if (other) this.toOtherTriple(q);
        return this.familyCost(q, answer);
      };
      if (leastCost(low, high, own, cost) === null) continue;
      if (answer.checkLimits(q)) answer.addBranch(q, this.errors(target, q), family);
    }
  }
}
