import { allTurnedTowards, clamp, interpolate, squaredDistance, turnedTowards } from "../math/numbers.ts";
import { LIMIT, ROUNDING } from "./tolerances.ts";
import type { Answer } from "./answer.ts";
import type { LimbNumbers, Violation } from "./types.ts";

// What a member of a family costs that is outside the limits, far more than any distance from the reference.
const OUTSIDE = 1e3;

/**
 * What the closed forms of all limbs share: joints, limits, and what is done where two joints turn about one line.
 *
 * These files are Python's nao_kin.ik once more, for the page: the same equations, which docs/inverse_kinematics.md
 * derives, and the same order of branches, reasons and families.
 */
export class Limb<Numbers extends LimbNumbers> {
  kind: Numbers["kind"];
  side: string;
  frame: string;
  torso: string;
  joints: string[];
  columns: number[];
  multiplier: number[];
  offset: number[];
  lower: number[];
  upper: number[];
  table;
  geometry: Numbers["geometry"];
  frameRotation;

  constructor(numbers: Numbers) {
    this.kind = numbers.kind;
    this.side = numbers.side;
    this.frame = numbers.frame;
    this.torso = numbers.torso;
    this.joints = numbers.joints;
    this.columns = numbers.columns;
    this.multiplier = numbers.multiplier;
    this.offset = numbers.offset;
    this.lower = numbers.lower.map((value) => value ?? -Infinity);
    this.upper = numbers.upper.map((value) => value ?? Infinity);
    this.table = numbers.table;
    this.geometry = numbers.geometry;
    // Of the frame in the link that carries it.
    this.frameRotation = numbers.geometry.rotation;
  }

  /** Values of the joints in a configuration. */
  values(q: ArrayLike<number>) {
    return this.columns.map((column, i) => this.multiplier[i] * q[column] + this.offset[i]);
  }

  /** A configuration with these values of the joints. */
  merged(q: number[], values: number[]) {
    const merged = [...q];
    this.columns.forEach((column, i) => (merged[column] = (values[i] - this.offset[i]) / this.multiplier[i]));
    return merged;
  }

  /** Whether a joint is outside its own range, whatever the table says. */
  isOutside(joint: number, value: number) {
    return value < this.lower[joint] - LIMIT || value > this.upper[joint] + LIMIT;
  }

  /** The range that one joint has at a value of another; open without a table. */
  tableRange(of: number): [number, number] {
    if (!this.table) return [-Infinity, Infinity];
    const { at, lower, upper } = this.table;
    return [interpolate(at, lower, of), interpolate(at, upper, of)];
  }

  /** How far each joint is outside its range; the table counts for a joint that is inside its own. */
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

  /** How far the joint that is farthest outside its limits is outside them; less than 0 where all are inside. */
  excess(values: number[]) {
    return Math.max(-1, ...this.violations(values).map(({ outside }) => outside));
  }

  /** Whether all joints are inside their limits, the table included. */
  isInside(values: number[]) {
    if (values.some((value, joint) => this.isOutside(joint, value))) return false;
    if (!this.table) return true;
    const [low, high] = this.tableRange(values[this.table.of]);
    const value = values[this.table.joint];
    return low - LIMIT <= value && value <= high + LIMIT;
  }

  /**
   * Two joints about one line, of which only first + sign · third = total is determined: the pair nearest to the
   * reference, inside the ranges if there is one, is written into the values.
   *
   * @param total [rad]
   * @param answer what is asked
   */
  lockPair([i, j]: [number, number], total: number, sign: 1 | -1, { reference, enforce }: Answer, values: number[]) {
    if (!enforce) {
      // What the reference has too much, up to whole turns, is shared by both.
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

  /**
   * What a member of a family is away from the reference; far more where it is outside the limits.
   *
   * @param answer what is asked
   */
  familyCost(values: number[], { reference, enforce }: Answer) {
    const outside = enforce ? this.excess(values) : 0;
    const near = enforce ? values : allTurnedTowards(values, reference);
    return outside <= ROUNDING ? squaredDistance(reference, near) : OUTSIDE * (1 + outside);
  }
}

function violation(reason: Violation["reason"], joint: number, value: number, low: number, high: number): Violation {
  return { reason, joint, value, low, high, outside: Math.max(low - value, value - high) };
}
