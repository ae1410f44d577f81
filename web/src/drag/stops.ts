import { fixed, interpolate } from "../math/numbers.ts";
import type { About, Coordinate } from "../types.ts";
import { rangeOf } from "../values/configurations.ts";

export const degrees: (angle: number, digits: number) => string = (angle, digits) =>
  `${fixed((angle * 180) / Math.PI, digits)}°`;

export function millimetres(metres: number) {
  const digits = metres < 0.001 ? 3 : metres < 0.01 ? 1 : 0;
  return `${(1000 * metres).toFixed(digits)} mm`;
}

// How far one coordinate may move while all others stay. These functions need only the robot's description.

/**
 * What stops a coordinate: its own range, or that of another coordinate which depends on it. `column` and `bound` belong to
 * the coordinate whose range it is; `coupled` is true for a coupled limit.
 */
export interface Stop {
  column: number;
  bound: number;
  upper: boolean;
  coupled: boolean;
}

const clampedBack: (stop: Stop, from: number) => number = ({ bound, upper }, from) =>
  upper ? Math.max(bound, from) : Math.min(bound, from);

/**
 * The value nearest to the wanted one that a coordinate can reach from its current value, and what stops it. A coordinate
 * that is outside its range may return but not go farther out. Another coordinate whose range depends on this one is not
 * moved: the motion ends where it would fall outside its range.
 */
export function farthest(
  about: About,
  q: ArrayLike<number>,
  column: number,
  wanted: number,
): { value: number; stop: Stop | null } {
  const from = q[column];
  const own = ownStop(about, q, column, wanted);
  let [value, stop] = own ? [clampedBack(own, from), own as Stop | null] : [wanted, null];
  for (const table of about.tables.filter(({ of }) => of === column)) {
    for (const upper of [false, true]) {
      const bounds = upper ? table.upper : table.lower;
      const share = shareInside(table.at, bounds, from, value, q[table.joint], upper);
      if (share >= 1) continue;
      value = from + share * (value - from);
      stop = { column: table.joint, bound: interpolate(table.at, bounds, value), upper, coupled: true };
    }
  }
  return { value, stop };
}

/** The coordinate's own bound that the wanted value exceeds; null if there is none. */
function ownStop(about: About, q: ArrayLike<number>, column: number, wanted: number): Stop | null {
  const coordinate = about.coordinates.find((candidate) => candidate.column === column) as Coordinate;
  const upper = wanted > q[column];
  const bound = rangeOf(about, coordinate, q)[upper ? 1 : 0];
  const isBeyond = upper ? wanted > bound : wanted < bound;
  return isBeyond ? { column, bound, upper, coupled: bound !== (upper ? coordinate.upper : coordinate.lower) } : null;
}

/**
 * The share of the motion, from 0 to 1, up to which the partner coordinate stays inside a bound that is linear between the
 * values `at`. If the partner is already outside, the motion ends where it would be farther outside.
 */
function shareInside(at: number[], bounds: number[], from: number, to: number, partner: number, upper: boolean) {
  const place = (share: number) => from + share * (to - from);
  const sign = upper ? 1 : -1;
  const room = (share: number) => sign * (interpolate(at, bounds, place(share)) - partner);
  const least = Math.min(0, room(0));
  const bends = at.map((bend) => (bend - from) / (to - from)).filter((share) => share > 0 && share < 1);
  let before = 0;
  for (const after of [...bends.sort((a, b) => a - b), 1]) {
    if (room(after) < least) {
      const [a, b] = [room(before) - least, room(after) - least];
      return before + (a > 0 ? (a / (a - b)) * (after - before) : 0);
    }
    before = after;
  }
  return 1;
}
