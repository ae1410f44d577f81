import { interpolate } from "../math/numbers.js";

// How far one coordinate may go while all others stay. Pure: a robot's description and numbers.

/** @typedef {import("../types.js").About} About */

/**
 * What stops a coordinate: its own range, or that of another one which depends on it.
 *
 * @typedef {{ column: number, bound: number, upper: boolean, coupled: boolean }} Stop `column` and `bound` are of the
 *   coordinate whose range it is; `coupled` where a table says so
 */

/** @type {(stop: Stop, from: number) => number} */
const clampedBack = ({ bound, upper }, from) => (upper ? Math.max(bound, from) : Math.min(bound, from));

/**
 * The value nearest to the one wanted that a coordinate may go to, from where it is in a straight line, and what stops it.
 * One that is outside its range may come back, and go no farther out. A coordinate whose range depends on this one does
 * not yield: the way ends where its range would leave it out.
 *
 * @param {About} about
 * @param {ArrayLike<number>} q
 * @param {number} column
 * @param {number} wanted
 * @returns {{ value: number, stop: Stop | null }}
 */
export function farthest(about, q, column, wanted) {
  const from = q[column];
  const own = ownStop(about, q, column, wanted);
  let [value, stop] = own ? [clampedBack(own, from), /** @type {Stop | null} */ (own)] : [wanted, null];
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

/**
 * The bound of the coordinate itself that a value is beyond.
 *
 * @param {About} about
 * @param {ArrayLike<number>} q
 * @param {number} column
 * @param {number} wanted
 * @returns {Stop | null}
 */
function ownStop(about, q, column, wanted) {
  const coordinate = about.coordinates.find((candidate) => candidate.column === column);
  const tables = about.tables.filter(({ joint }) => joint === column);
  const upper = wanted > q[column];
  const bounds = [
    { bound: (upper ? coordinate?.upper : coordinate?.lower) ?? (upper ? Infinity : -Infinity), coupled: false },
    ...tables.map((table) => ({
      bound: interpolate(table.at, upper ? table.upper : table.lower, q[table.of]),
      coupled: true,
    })),
  ];
  const nearest = bounds.reduce((a, b) => ((upper ? b.bound < a.bound : b.bound > a.bound) ? b : a));
  const isBeyond = upper ? wanted > nearest.bound : wanted < nearest.bound;
  return isBeyond ? { column, upper, ...nearest } : null;
}

/**
 * The share of a way, from 0 to 1, up to which a partner stays inside a bound that is linear between the places `at`.
 * A partner that is outside already only keeps it from getting farther out.
 *
 * @param {number[]} at
 * @param {number[]} bounds
 * @param {number} from
 * @param {number} to
 * @param {number} partner
 * @param {boolean} upper
 */
function shareInside(at, bounds, from, to, partner, upper) {
  /** @param {number} share */
  const place = (share) => from + share * (to - from);
  const sign = upper ? 1 : -1;
  /** @param {number} share */
  const room = (share) => sign * (interpolate(at, bounds, place(share)) - partner);
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
