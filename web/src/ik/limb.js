// @ts-nocheck
import { FAMILY_SEARCH, TOLERANCES } from "./tolerances.js";
import { allTurnedTowards, clamp, interpolate, squaredDistance, turnedTowards } from "../math/numbers.js";

// What the closed forms of all limbs share: limits, the order of the branches, and why there are none.
//
// These files are Python's nao_kin.ik once more, for the page: the same equations, which docs/inverse_kinematics.md
// derives, and the same order of branches, reasons and families. The numbers of a limb come from `nk.ik.limbs`. They
// need neither the page nor three.js. Poses are sixteen numbers, rotations nine, row by row.
export class Limb {
  constructor(numbers) {
    Object.assign(this, numbers);
    this.lower = numbers.lower.map((value) => value ?? -Infinity);
    this.upper = numbers.upper.map((value) => value ?? Infinity);
  }

  // Values of the joints in a configuration.
  values(q) {
    return this.columns.map((column, i) => this.multiplier[i] * q[column] + this.offset[i]);
  }

  // A configuration with these values of the joints.
  merged(q, values) {
    const merged = [...q];
    this.columns.forEach((column, i) => (merged[column] = (values[i] - this.offset[i]) / this.multiplier[i]));
    return merged;
  }

  isOutside(joint, value) {
    const { LIMIT } = TOLERANCES;
    return value < this.lower[joint] - LIMIT || value > this.upper[joint] + LIMIT;
  }

  // The range of the joint that depends on another, at a value of the latter; constant outside the table.
  tableRange(of) {
    const { at, lower, upper } = this.table;
    return [interpolate(at, lower, of), interpolate(at, upper, of)];
  }

  // How far each joint is below its range and above it; the table counts for a joint that is inside its own range.
  violations(values) {
    const found = values.map((value, joint) => {
      const [low, high] = [this.lower[joint], this.upper[joint]];
      return { reason: "JOINT_LIMIT", joint, value, low, high };
    });
    if (this.table && !this.isOutside(this.table.joint, values[this.table.joint])) {
      const { joint, of } = this.table;
      const [low, high] = this.tableRange(values[of]);
      found.push({ reason: "COUPLED_LIMIT", joint, value: values[joint], low, high });
    }
    return found.map((entry) => ({ ...entry, outside: Math.max(entry.low - entry.value, entry.value - entry.high) }));
  }

  // How far the joint that is farthest outside its limits is outside them; less than 0 where all are inside.
  excess(values) {
    return Math.max(-1, ...this.violations(values).map(({ outside }) => outside));
  }

  isInside(values) {
    if (values.some((value, joint) => this.isOutside(joint, value))) return false;
    if (!this.table) return true;
    const [low, high] = this.tableRange(values[this.table.of]);
    const value = values[this.table.joint];
    return low - TOLERANCES.LIMIT <= value && value <= high + TOLERANCES.LIMIT;
  }

  // Two joints about one line, of which only first + sign · third = total is determined: the pair nearest to the
  // reference, inside the ranges if there is one, is written into the values.
  lockPair([i, j], total, sign, { reference, enforce }, values) {
    if (!enforce) {
      // What the reference has too much, up to whole turns, is shared by both.
      const half = 0.5 * turnedTowards(reference[i] + sign * reference[j] - total, 0);
      [values[i], values[j]] = [reference[i] - half, reference[j] - sign * half];
      return;
    }
    const [low1, high1, low3, high3] = [this.lower[i], this.upper[i], this.lower[j], this.upper[j]];
    const { LIMIT } = TOLERANCES;
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
      if (outside < bestOutside - LIMIT || (outside < bestOutside + LIMIT && away < best)) {
        [bestOutside, best] = [outside, away];
        [values[i], values[j]] = [first, third];
      }
    }
  }

  // Of a family with one parameter, the value with the smallest cost: on a grid, then by halving; null if all are infinite.
  // The reference's own value is tried too: what is met within rounding does not change a member that fits.
  leastCost(low, high, own, cost) {
    const { STEPS, HALVINGS } = FAMILY_SEARCH;
    const step = (high - low) / STEPS;
    let [best, at] = [Infinity, low];
    const attempt = (value) => {
      const tried = cost(value);
      if (tried < best) [best, at] = [tried, value];
    };
    attempt(clamp(own, low, high));
    for (let i = 0; i <= STEPS; i++) attempt(low + step * i);
    let width = step;
    for (let i = 0; i < HALVINGS; i++) {
      const around = [Math.max(low, at - width), Math.min(high, at + width)];
      around.forEach(attempt);
      width *= 0.5;
    }
    return cost(at) === Infinity ? null : at;
  }

  // What a member of a family is away from the reference; far more where it is outside the limits.
  familyCost(values, { reference, enforce }) {
    const outside = enforce ? this.excess(values) : 0;
    const near = enforce ? values : allTurnedTowards(values, reference);
    return outside <= TOLERANCES.LIMIT ? squaredDistance(reference, near) : 1e3 * (1 + outside);
  }
}

// The rotation of a frame in the link that carries it, as a limb's geometry has it.
export const rotationOfFrame = ({ a00, a01, a02, a10, a11, a12, a20, a21, a22 }) => [
  a00,
  a01,
  a02,
  a10,
  a11,
  a12,
  a20,
  a21,
  a22,
];
