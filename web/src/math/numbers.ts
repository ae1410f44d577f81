export const DEGREE = Math.PI / 180;

/**
 * The value at x of a function that is linear between the places `at` and constant outside them.
 *
 * @param at ascending
 */
export function interpolate(at: readonly number[], values: readonly number[], x: number) {
  const right = firstWhere(at.length, (i) => at[i] >= x);
  if (right === at.length) return values[right - 1];
  if (right === 0 || at[right] === x) return values[right];
  const share = (x - at[right - 1]) / (at[right] - at[right - 1]);
  return values[right - 1] + share * (values[right] - values[right - 1]);
}

/** The first index at which a condition holds that holds for all later indices too; `count` if it holds for none. */
export function firstWhere(count: number, holds: (index: number) => boolean) {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (holds(middle)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** The number in [low, high] nearest to a value; `high` if the interval is empty. */
export function clamp(value: number, low: number, high: number) {
  return Math.min(Math.max(value, low), high);
}

/** Write a rounded number with the minus sign −; zero has no sign. */
export const fixed = (value: number, digits: number) =>
  value
    .toFixed(digits)
    .replace(/^-(0(\.0*)?)$/, "$1")
    .replace("-", "−");

/** @param b as long as a */
export function squaredDistance(a: readonly number[], b: readonly number[]) {
  return a.reduce((sum, value, i) => sum + (b[i] - value) ** 2, 0);
}
