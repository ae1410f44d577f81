import { clamp } from "../math/numbers.ts";
import {
  cross,
  direction,
  distance,
  dot,
  minus,
  plus,
  quaternionBetween,
  times,
  transposed,
  turned,
  type Rotation,
  type Vector,
} from "../math/rotations.ts";
import type { About, Coordinate } from "../types.ts";
import { rangeOf } from "../values/configurations.ts";
import type { Chain, Placed } from "./chain.ts";

/**
 * Something that the last link of a chain must meet, as numbers that should be zero, and their rates if the link turns with
 * the angular velocity `omega` while its origin moves with `v`, all in the base.
 */
export interface Task {
  chain: Chain;
  errors(placed: Placed): number[];
  rates(placed: Placed, omega: Vector, v: Vector): number[];
}

/** The link's origin is at a place. */
export function placeTask(chain: Chain, place: Vector, weight: number): Task {
  return {
    chain,
    errors: ({ p }) => times(weight, minus(p, place)),
    rates: (_, __, v) => times(weight, v),
  };
}

/**
 * The link has an orientation.
 *
 * The error is 2 sin(θ/2) times the axis of the rotation from the wanted orientation to the link's, which grows up to half a
 * turn, in the axes of the wanted orientation. With the unit quaternion (r₀, r) of that rotation it is 2 r, and its rate
 * r₀ ω + ω × r.
 *
 * @param weights of the turns about each axis of the wanted orientation [m/rad]
 */
export function turnTask(chain: Chain, wanted: Rotation, weights: Vector): Task {
  const back = transposed(wanted);
  // Found once for the rates of all joints.
  let [known, found] = [null as Placed | null, [] as number[]];
  const off = (placed: Placed) => {
    if (placed !== known) [known, found] = [placed, quaternionBetween(wanted, placed.R)];
    return found;
  };
  return {
    chain,
    errors: (placed) => off(placed).slice(1).map((value, i) => 2 * weights[i] * value), // prettier-ignore
    rates(placed, omega) {
      const [r0, ...r] = off(placed);
      const own = turned(back, omega);
      return plus(times(r0, own), cross(own, r as Vector)).map((value, i) => weights[i] * value);
    },
  };
}

/** The link's x axis points at a place. */
export function lookTask(chain: Chain, place: Vector): Task {
  const axis = ({ R }: Placed): Vector => [R[0], R[3], R[6]];
  return {
    chain,
    errors: (placed) => minus(axis(placed), direction(minus(place, placed.p))),
    rates(placed, omega, v) {
      const towards = direction(minus(place, placed.p));
      const across = minus(v, times(dot(v, towards), towards));
      return plus(cross(omega, axis(placed)), times(1 / distance(place, placed.p), across));
    },
  };
}

// The search ends after ROUNDS steps, or when a step changes no coordinate by more than SMALL [rad, m], or the sum of the
// squared errors by no more than SLOW of it. A coordinate is held if it is at a limit within AT [rad, m]. The damping begins with START, changes by FACTOR, and stays between LEAST and
// MOST.
const [ROUNDS, SMALL, SLOW, AT] = [60, 1e-8, 1e-5, 1e-6];
const [START, FACTOR, LEAST, MOST] = [1e-4, 8, 1e-16, 1e8];

/** A configuration found by `descend`; `held` are the columns of the coordinates that a limit keeps from going on. */
export interface Descended {
  q: number[];
  held: number[];
  cost: number;
}

/**
 * The configuration that meets tasks best inside the limits, in the sense of least squares, near to another configuration:
 * the Levenberg–Marquardt method with an active set of limits.
 *
 * No coordinate leaves its range, coupled limits included; one that is outside already goes no farther out.
 *
 * @param columns of the coordinates that may change
 * @param from where the search begins
 * @param rest weight of each coordinate's distance from there [m/rad, 1]
 */
export function descend(
  about: Pick<About, "coordinates" | "tables">,
  tasks: Task[],
  columns: number[],
  from: readonly number[],
  rest: number = 0,
): Descended {
  const stay = { at: from, weight: rest };
  const coordinates = columns.map((column) => about.coordinates.find((one) => one.column === column) as Coordinate);
  // How far the coordinates are outside at the start.
  const beyond = coordinates.map((coordinate) => {
    const [low, high] = rangeOf(about, coordinate, from);
    return [Math.max(0, low - from[coordinate.column]), Math.max(0, from[coordinate.column] - high)];
  });
  const rangesAt = (q: number[]) =>
    coordinates.map((coordinate, i) => {
      const [low, high] = rangeOf(about, coordinate, q);
      return [low - beyond[i][0], high + beyond[i][1]];
    });
  const inside = (q: number[]) => {
    // Twice, for the first may move the coordinate on which the range of another depends.
    for (let pass = 0; pass < 2; pass++) {
      rangesAt(q).forEach(([low, high], i) => (q[columns[i]] = clamp(q[columns[i]], low, high)));
    }
    return q;
  };
  let q = [...from];
  let { cost, gradient, normal } = evaluate(tasks, columns, q, stay);
  let damping = START;
  let held: number[] = [];
  for (let round = 0; round < ROUNDS; round++) {
    const room = rangesAt(q).map(([low, high], i) => [low - q[columns[i]], high - q[columns[i]]]);
    held = columns.filter((_, i) => (gradient[i] < 0 ? room[i][1] <= AT : gradient[i] > 0 && room[i][0] >= -AT));
    const before = cost;
    let change = 0;
    for (; damping <= MOST && change === 0; damping *= FACTOR) {
      const step = boundedStep(normal, gradient, damping, room);
      const next = inside(q.map((value, column) => value + (step[columns.indexOf(column)] ?? 0)));
      const tried = evaluate(tasks, columns, next, stay);
      if (!(tried.cost < cost)) continue;
      change = Math.max(...columns.map((column) => Math.abs(next[column] - q[column])));
      q = next;
      ({ cost, gradient, normal } = tried);
      damping = Math.max(damping / FACTOR ** 2, LEAST);
    }
    if (change <= SMALL || before - cost <= SLOW * before) break;
  }
  return { q, held, cost };
}

/** Half the sum of the squared errors, its gradient Jᵀe, and JᵀJ, for the coordinates of some columns. */
function evaluate(tasks: Task[], columns: number[], q: number[], stay: { at: readonly number[]; weight: number }) {
  const square = stay.weight ** 2;
  const away = columns.map((column) => q[column] - stay.at[column]);
  const gradient = away.map((value) => square * value);
  const normal = columns.map((_, i) => columns.map((__, k) => (i === k ? square : 0)));
  let cost = away.reduce((sum, value) => sum + 0.5 * square * value * value, 0);
  for (const task of tasks) {
    const placed = task.chain.forward(q);
    const errors = task.errors(placed);
    const rates: (number[] | undefined)[] = columns.map(() => undefined);
    for (const { joint, axis, origin } of placed.screws) {
      const k = columns.indexOf(joint.column);
      if (k < 0) continue;
      const along = times(joint.multiplier, axis);
      const [omega, v]: Vector[] = joint.slides ? [[0, 0, 0], along] : [along, cross(along, minus(placed.p, origin))];
      const own = task.rates(placed, omega, v);
      const before = rates[k];
      rates[k] = before ? own.map((value, i) => value + before[i]) : own;
    }
    errors.forEach((error) => (cost += 0.5 * error * error));
    rates.forEach((row, k) => {
      if (!row) return;
      row.forEach((rate, i) => (gradient[k] += rate * errors[i]));
      rates.forEach((other, l) => {
        if (other) row.forEach((rate, i) => (normal[k][l] += rate * other[i]));
      });
    });
  }
  return { cost, gradient, normal };
}

/**
 * The step d of (JᵀJ + λ I) d = −Jᵀe with each number in its room. A number that would leave its room is put at the end of
 * it, and the others are solved for again.
 */
function boundedStep(normal: number[][], gradient: number[], damping: number, room: number[][]) {
  const step = gradient.map(() => 0);
  let free = gradient
    .map((_, i) => i)
    .filter((i) => (gradient[i] < 0 ? room[i][1] > 0 : gradient[i] > 0 ? room[i][0] < 0 : true));
  while (free.length > 0) {
    const bound = step.map((_, i) => i).filter((i) => !free.includes(i));
    const right = free.map((i) => bound.reduce((sum, k) => sum - normal[i][k] * step[k], -gradient[i]));
    const found = solved(
      free.map((i) => free.map((k) => normal[i][k] + (i === k ? damping : 0))),
      right,
    );
    free.forEach((i, k) => (step[i] = clamp(found[k], ...(room[i] as [number, number]))));
    const within = free.filter((i, k) => step[i] === found[k]);
    if (within.length === free.length) break;
    free = within;
  }
  return step;
}

/** The solution of A x = b for a symmetric positive definite A, by its Cholesky factor; A is overwritten. */
function solved(A: number[][], b: number[]) {
  const n = b.length;
  const x = [...b];
  for (let i = 0; i < n; i++) {
    for (let k = 0; k <= i; k++) {
      let sum = A[i][k];
      for (let m = 0; m < k; m++) sum -= A[i][m] * A[k][m];
      A[i][k] = i === k ? Math.sqrt(Math.max(sum, Number.MIN_VALUE)) : sum / A[k][k];
    }
    for (let k = 0; k < i; k++) x[i] -= A[i][k] * x[k];
    x[i] /= A[i][i];
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let k = i + 1; k < n; k++) x[i] -= A[k][i] * x[k];
    x[i] /= A[i][i];
  }
  return x;
}
