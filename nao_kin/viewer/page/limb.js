"use strict";

const NaoKin = {};

// What the closed forms of all limbs share: limits, the order of the branches, and why there are none.
//
// These files are Python's nao_kin.ik once more, for the page: the same equations, which docs/inverse_kinematics.md
// derives, and the same order of branches, reasons and families. The numbers of a limb come from `nk.ik.limbs`. They
// need neither the page nor three.js. Poses are sixteen numbers, rotations nine, row by row.
NaoKin.Limb = class {
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
    const { LIMIT } = NaoKin.TOLERANCES;
    return value < this.lower[joint] - LIMIT || value > this.upper[joint] + LIMIT;
  }

  // The range of the joint that depends on another, at a value of the latter; constant outside the table.
  tableRange(of) {
    const { at, lower, upper } = this.table;
    return [NaoKin.interpolate(at, lower, of), NaoKin.interpolate(at, upper, of)];
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
    return low - NaoKin.TOLERANCES.LIMIT <= value && value <= high + NaoKin.TOLERANCES.LIMIT;
  }

  // Two joints about one line, of which only first + sign · third = total is determined: the pair nearest to the
  // reference, inside the ranges if there is one, is written into the values.
  lockPair([i, j], total, sign, { reference, enforce }, values) {
    if (!enforce) {
      // What the reference has too much, up to whole turns, is shared by both.
      const half = 0.5 * NaoKin.turnedTowards(reference[i] + sign * reference[j] - total, 0);
      [values[i], values[j]] = [reference[i] - half, reference[j] - sign * half];
      return;
    }
    const [low1, high1, low3, high3] = [this.lower[i], this.upper[i], this.lower[j], this.upper[j]];
    const { LIMIT } = NaoKin.TOLERANCES;
    let [bestOutside, best] = [Infinity, Infinity];
    for (let turns = -2; turns < 3; turns++) {
      // third = sign (total − first) + shift
      const shift = 2 * Math.PI * turns;
      const ends = [total - sign * (low3 - shift), total - sign * (high3 - shift)];
      const [low, high] = [Math.max(low1, Math.min(...ends)), Math.min(high1, Math.max(...ends))];
      const middle = 0.5 * (reference[i] + total + sign * (shift - reference[j]));
      const first = low <= high ? NaoKin.clamp(middle, low, high) : NaoKin.clamp(0.5 * (low + high), low1, high1);
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
    const { STEPS, HALVINGS } = NaoKin.FAMILY_SEARCH;
    const step = (high - low) / STEPS;
    let [best, at] = [Infinity, low];
    const attempt = (value) => {
      const tried = cost(value);
      if (tried < best) [best, at] = [tried, value];
    };
    attempt(NaoKin.clamp(own, low, high));
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
    const near = enforce ? values : NaoKin.allTurnedTowards(values, reference);
    return outside <= NaoKin.TOLERANCES.LIMIT ? NaoKin.squaredDistance(reference, near) : 1e3 * (1 + outside);
  }
};

// What a closed form answers for one target: the branches, nearest to the reference first, or the reason for none. The
// joint named is that of the branch that is least outside the limits; without one, `needed` is how far the target is out
// of reach [m].
NaoKin.Answer = class {
  constructor(limb, reference, enforce) {
    this.limb = limb;
    Object.assign(this, { reference, enforce, branches: [], excess: Infinity });
    this.blame("NOT_CONVERGED");
  }

  blame(reason, joint = -1, needed = 0, limit = 0) {
    Object.assign(this, { reason, joint, needed, limit });
    return this;
  }

  // Whether a branch is inside the limits; if not, it is reported where none before was less outside.
  admits(values) {
    if (!this.enforce || this.limb.isInside(values)) return true;
    const outside = this.limb.excess(values);
    if (outside < this.excess) {
      this.excess = outside;
      this.blameLimit(values);
    }
    return false;
  }

  // Report the joint that is farthest outside.
  blameLimit(values) {
    let worst = { outside: -Infinity };
    for (const entry of this.limb.violations(values)) if (entry.outside > worst.outside) worst = entry;
    const { reason, joint, value, low, high } = worst;
    this.blame(reason, joint, value, low - value > value - high ? low : high);
  }

  // Take a branch in, if forward kinematics, which gave these errors [m, rad], verifies it; without limits with the
  // whole turns that bring each joint within half a turn of the reference.
  enter(values, errors, family = "NONE") {
    if (!errors.every((error) => error <= NaoKin.TOLERANCES.VERIFIED)) return;
    const near = this.enforce ? [...values] : NaoKin.allTurnedTowards(values, this.reference);
    const branch = { values: near, errors, family, distance: NaoKin.squaredDistance(this.reference, near) };
    let place = this.branches.length;
    while (place > 0 && this.branches[place - 1].distance > branch.distance) place--;
    this.branches.splice(place, 0, branch);
  }

  concluded() {
    return this.branches.length > 0 ? this.blame("REACHED") : this;
  }
};

// LIMIT: how far a joint may be outside [rad]; VERIFIED: errors of a solution [m, rad]; RIGID: the defect of a rotation,
// and EXACT one that is left as it is.
NaoKin.TOLERANCES = { LIMIT: 1e-9, VERIFIED: 1e-10, RIGID: 1e-6, EXACT: 1e-14 };
NaoKin.FAMILY_SEARCH = { STEPS: 180, HALVINGS: 48 };

// The value at x of what is linear between the places `at`, and constant outside of them.
NaoKin.interpolate = (at, values, x) => {
  const right = at.findIndex((bend) => bend >= x);
  if (right === 0) return values[0];
  if (right < 0) return values[values.length - 1];
  const share = (x - at[right - 1]) / (at[right] - at[right - 1]);
  return values[right - 1] + share * (values[right] - values[right - 1]);
};

NaoKin.clamp = (value, low, high) => Math.min(Math.max(value, low), high);

NaoKin.squaredDistance = (a, b) => a.reduce((sum, value, i) => sum + (b[i] - value) ** 2, 0);

// An angle from within (−3π, 3π] taken into (−π, π].
NaoKin.wrapped = (angle) => {
  if (angle > Math.PI) return angle - 2 * Math.PI;
  return angle <= -Math.PI ? angle + 2 * Math.PI : angle;
};

// The same angle with the whole turns that bring it within half a turn of another.
NaoKin.turnedTowards = (value, near) => value + 2 * Math.PI * Math.floor((near - value) / (2 * Math.PI) + 0.5);

NaoKin.allTurnedTowards = (values, near) => values.map((value, i) => NaoKin.turnedTowards(value, near[i]));

// A product of two rotations.
NaoKin.product = (A, B) =>
  [0, 3, 6].flatMap((i) => [0, 1, 2].map((j) => A[i] * B[j] + A[i + 1] * B[j + 3] + A[i + 2] * B[j + 6]));

NaoKin.transposed = ([a, b, c, d, e, f, g, h, i]) => [a, d, g, b, e, h, c, f, i];

NaoKin.turned = (R, [x, y, z]) => [0, 3, 6].map((i) => R[i] * x + R[i + 1] * y + R[i + 2] * z);

NaoKin.rotX = (angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [1, 0, 0, 0, c, -s, 0, s, c];
};

NaoKin.rotY = (angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, 0, s, 0, 1, 0, -s, 0, c];
};

NaoKin.rotZ = (angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, -s, 0, s, c, 0, 0, 0, 1];
};

NaoKin.dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);

NaoKin.cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// The rotation of a frame in the link that carries it, as a limb's geometry has it.
NaoKin.rotationOfFrame = ({ a00, a01, a02, a10, a11, a12, a20, a21, a22 }) => [a00, a01, a02, a10, a11, a12, a20, a21, a22];

// The angle between two rotations from the differences of their entries, ‖R − F‖ = 2 √2 sin(angle / 2).
NaoKin.angleBetween = (R, F) => {
  const half = Math.sqrt(0.125 * NaoKin.squaredDistance(R, F));
  // Of a small angle the sine is the angle itself.
  return half < 1e-9 ? 2 * half : 2 * Math.asin(Math.min(1, half));
};

// The rotation of a rigid transform, brought nearer to one by a step of R ← R (3 − RᵀR)/2; null if it is none.
NaoKin.rigid = (T) => {
  const R = [T[0], T[1], T[2], T[4], T[5], T[6], T[8], T[9], T[10]];
  const [a, b, c, d, e, f, g, h, i] = R;
  const left = NaoKin.product(NaoKin.transposed(R), R).map((value, k) => (k % 4 === 0 ? 1 : 0) - value);
  const defect = Math.max(...left.map(Math.abs));
  const determinant = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g);
  const below = Math.abs(T[12]) + Math.abs(T[13]) + Math.abs(T[14]) + Math.abs(T[15] - 1);
  // Comparisons with NaN are false.
  const { RIGID, EXACT } = NaoKin.TOLERANCES;
  if (!(defect <= RIGID && Math.abs(determinant - 1) <= RIGID && below <= RIGID)) return null;
  if (!Number.isFinite(T[3] + T[7] + T[11])) return null;
  if (defect <= EXACT) return R;
  return NaoKin.product(R, left).map((value, k) => R[k] + 0.5 * value);
};
