import { Motion } from "./motion.ts";

/** a segment, which number is too fast, and the time [s] it would need */
interface Excess {
  segment: number;
  column: number;
  needs: number;
}

// Rounds in which a change of one segment may change the slopes, and so the speeds, of the next.
const MOST_ROUNDS = 30;

// A share by which a limit is passed without a word: times are rounded.
const ROUNDING = 1e-9;

/**
 * The segments that ask for more than a speed limit allows, each with the number that is worst.
 *
 * @param limits of each number of q [1/s]; null for none
 */
export function excesses(motion: Motion, limits: readonly (number | null)[]): Excess[] {
  const found = [];
  for (let segment = 0; segment < motion.count - 1; segment++) {
    let [worst, column] = [1, -1];
    limits.forEach((limit, i) => {
      if (limit === null || !(limit > 0)) return;
      const share = motion.fastest(segment, i) / limit;
      if (share > worst * (1 + ROUNDING)) [worst, column] = [share, i];
    });
    const needs = worst * (motion.times[segment + 1] - motion.times[segment]);
    if (column >= 0) found.push({ segment, column, needs });
  }
  return found;
}

/**
 * Times for the keys of a motion at which every speed limit is kept: segments that are too fast take as long as they
 * need, in whole milliseconds, and all behind them comes later.
 */
export function slowedTimes(motion: Motion, limits: readonly (number | null)[]): number[] {
  let slowed = motion;
  for (let round = 0; round < MOST_ROUNDS; round++) {
    const needed = new Map(excesses(slowed, limits).map(({ segment, needs }) => [segment, needs]));
    if (needed.size === 0) break;
    const times = [slowed.start];
    for (let segment = 0; segment < slowed.count - 1; segment++) {
      const width = slowed.times[segment + 1] - slowed.times[segment];
      const needs = needed.get(segment);
      const longer =
        needs === undefined ? width : Math.max(Math.ceil(needs * 1000), Math.floor(width * 1000) + 1) / 1000;
      times.push(times[segment] + longer);
    }
    const rounded = times.map((time) => Math.round(time * 1e6) / 1e6);
    slowed = new Motion(rounded, motion.values, motion.interpolation);
  }
  return Array.from(slowed.times);
}
