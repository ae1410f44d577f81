/** Milliseconds before the first try to connect again, and before all from the sixth on. */
const FIRST = 500;
const LONGEST = 10_000;

/**
 * How long to wait before trying again: twice as long each time, up to ten seconds.
 *
 * @param failures how often it has been tried in vain, from 0
 * @returns milliseconds
 */
export function delayAfter(failures: number): number {
  return Math.min(LONGEST, FIRST * 2 ** failures);
}
