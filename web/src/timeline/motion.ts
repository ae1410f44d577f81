import { clamp, firstWhere } from "../math/numbers.ts";

/** The keys of one joint. */
export interface Track {
  name: string;
  times: number[];
  values: number[];
}

/** The largest number of keys of a joint that is read. */
export const MOST_ROWS = 50_000;

/**
 * Slopes of the monotone cubic through the keys of one number, as nao_kin.motion.smooth_slopes gives them: zero at the
 * first and the last key and where the straight lines beside a key differ in sign, else their weighted harmonic mean.
 *
 * Source: F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300–304.
 *
 * @param times strictly ascending
 */
function smoothSlopes(times: ArrayLike<number>, value: (key: number) => number): Float64Array {
  const slopes = new Float64Array(times.length);
  for (let key = 1; key < times.length - 1; key++) {
    const [before, after] = [times[key] - times[key - 1], times[key + 1] - times[key]];
    const rising = (value(key) - value(key - 1)) / before;
    const going = (value(key + 1) - value(key)) / after;
    if (!(Math.sign(rising) * Math.sign(going) > 0)) continue;
    const [w1, w2] = [before + 2 * after, 2 * before + after];
    slopes[key] = (w1 + w2) / (w1 / rising + w2 / going);
  }
  return slopes;
}

export type Interpolation = "linear" | "smooth";

/**
 * The u in [0, 1] with 3 u (1 − u)² a + 3 u² (1 − u) (1 − b) + u³ = x, as nao_kin.motion finds it: by Newton's method, and
 * by bisection where a step would leave the bracket.
 */
function bezierParameter(a: number, b: number, x: number) {
  let [u, low, high] = [x, 0, 1];
  for (let step = 0; step < 80; step++) {
    const miss = 3 * u * (1 - u) * ((1 - u) * a + u * (1 - b)) + u ** 3 - x;
    if (miss === 0) return u;
    if (miss < 0) low = u;
    else high = u;
    const slope = 3 * ((1 - u) ** 2 * a + 2 * u * (1 - u) * (1 - a - b) + u * u * b);
    const next = u - miss / slope;
    const last = u;
    u = next > low && next < high ? next : (low + high) / 2;
    if (Math.abs(u - last) <= 1e-15) break;
  }
  return u;
}

/**
 * Configurations at times and the interpolation between them: straight lines, the monotone cubic that is at rest at both
 * ends, or Bezier curves. Before the first and after the last time the robot stands still. A motion is immutable.
 *
 * Joints that share a motor are one number of a configuration, so they stay coupled.
 */
export class Motion {
  width = this.values.length / this.times.length;
  /** Slopes of each number at each time. */
  slopes: Float64Array[] = [];

  /**
   * @param times strictly ascending, at least one [s]
   * @param values the configurations, one after another
   * @param handles of Bezier curves: for each segment and number the two values P and Q of `controls`, and the lengths a and
   * b of the handles in time, as shares of the segment
   */
  constructor(
    readonly times: ArrayLike<number>,
    readonly values: ArrayLike<number>,
    readonly interpolation: Interpolation | "bezier" = "linear",
    readonly handles: ArrayLike<number> = [],
  ) {
    if (interpolation === "smooth") {
      for (let column = 0; column < this.width; column++) {
        this.slopes.push(smoothSlopes(times, (key) => values[key * this.width + column]));
      }
    }
  }

  /** @param rows one configuration for each time */
  static of(times: ArrayLike<number>, rows: readonly ArrayLike<number>[], interpolation?: Interpolation) {
    return new Motion(times, Float64Array.from(rows.flatMap((row) => Array.from(row))), interpolation);
  }

  get count() {
    return this.times.length;
  }

  get start() {
    return this.times[0];
  }

  get end() {
    return this.times[this.times.length - 1];
  }

  row(index: number) {
    return Array.from({ length: this.width }, (_, column) => this.values[index * this.width + column]);
  }

  /** The segment of a time: the time of a key belongs to the segment after it, the last time to the last segment. */
  segment(time: number) {
    const next = firstWhere(this.count, (i) => this.times[i] > time);
    return clamp(next - 1, 0, Math.max(this.count - 2, 0));
  }

  /** The configuration at a time. */
  at(time: number) {
    if (!(time > this.start)) return this.row(0);
    if (time >= this.end) return this.row(this.count - 1);
    const first = this.segment(time);
    const duration = this.times[first + 1] - this.times[first];
    const x = (time - this.times[first]) / duration;
    const q = this.row(first);
    for (let column = 0; column < this.width; column++) {
      const [p, r, rise] = this.controls(first, column);
      const u = this.interpolation === "bezier" ? this.parameter(first, column, x) : x;
      q[column] += u * (3 * (1 - u) * ((1 - u) * p + u * r) + u * u * rise);
    }
    return q;
  }

  parameter(segment: number, column: number, x: number) {
    const at = 4 * (segment * this.width + column);
    const [a, b] = [this.handles[at + 2], this.handles[at + 3]];
    return Math.abs(a - 1 / 3) < 1e-15 && Math.abs(b - 1 / 3) < 1e-15 ? x : bezierParameter(a, b, x);
  }

  /** The largest speed of a number in a segment [1/s], for motions of other curves than Bezier curves. */
  fastest(segment: number, column: number) {
    const [p, r, rise] = this.controls(segment, column);
    // A third of the derivative is a quadratic, which is largest at an end or at its vertex.
    const [a, b, c] = [p, r - p, rise - r];
    const turn = (a - b) / (a - 2 * b + c);
    const between = turn > 0 && turn < 1 ? (1 - turn) ** 2 * a + 2 * turn * (1 - turn) * b + turn ** 2 * c : 0;
    const most = Math.max(Math.abs(a), Math.abs(c), Math.abs(between));
    return (3 * most) / (this.times[segment + 1] - this.times[segment]);
  }

  /** A segment as a cubic in u from 0 to 1: 3 u (1 − u)² p + 3 u² (1 − u) r + u³ rise above its first value. */
  controls(segment: number, column: number): [number, number, number] {
    const from = segment * this.width + column;
    const rise = this.values[from + this.width] - this.values[from];
    if (this.interpolation === "linear") return [rise / 3, (2 * rise) / 3, rise];
    if (this.interpolation === "bezier") return [this.handles[4 * from], this.handles[4 * from + 1], rise];
    const third = (this.times[segment + 1] - this.times[segment]) / 3;
    const slopes = this.slopes[column];
    return [slopes[segment] * third, rise - slopes[segment + 1] * third, rise];
  }
}

/** Times to draw a motion at: its own if it has straight lines, else evenly spaced ones. */
export function sampleTimes(motion: Motion, most: number) {
  if (motion.count <= most && motion.interpolation === "linear") return Array.from(motion.times);
  return evenTimes(motion, most);
}

/** @param count number of times, from the motion's start to its end */
export function evenTimes({ start, end }: Motion, count: number) {
  return Array.from({ length: count }, (_, i) => (i === count - 1 ? end : start + ((end - start) * i) / (count - 1)));
}

/** The columns whose values have the largest ranges, in the order given. */
export function busiest({ values, width, count }: Motion, columns: readonly number[], most: number) {
  const ranges = columns.map((column) => {
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < count; i++) {
      const value = values[i * width + column];
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return { column, range: high - low };
  });
  const chosen = ranges
    .filter(({ range }) => range > 1e-6)
    .sort((a, b) => b.range - a.range)
    .slice(0, most)
    .map(({ column }) => column);
  return columns.filter((column) => chosen.includes(column));
}
