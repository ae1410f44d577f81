/**
 * The value at x of what is linear between the places `at`, and constant outside of them.
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

/** The first number from 0 on at which something is so that stays so from there on; `count` where it is nowhere. */
export function firstWhere(count: number, isSo: (index: number) => boolean) {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (isSo(middle)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** The number nearest to a value in [low, high]; `high` where that is empty. */
export function clamp(value: number, low: number, high: number) {
  return Math.min(Math.max(value, low), high);
}

/** A number as people write it: rounded, with the true minus sign; no zero has a sign. */
export const fixed = (value: number, digits: number) =>
  value
    .toFixed(digits)
    .replace(/^-(0(\.0*)?)$/, "$1")
    .replace("-", "−");

/** @param b as long as a */
export function squaredDistance(a: readonly number[], b: readonly number[]) {
  return a.reduce((sum, value, i) => sum + (b[i] - value) ** 2, 0);
}

/** An angle from within (−3π, 3π] taken into (−π, π]. */
export function wrapped(angle: number) {
  if (angle > Math.PI) return angle - 2 * Math.PI;
  return angle <= -Math.PI ? angle + 2 * Math.PI : angle;
}

/** The same angle with the whole turns that bring it within half a turn of another, into (near − π, near + π]. */
export function turnedTowards(angle: number, near: number) {
  return angle + 2 * Math.PI * Math.floor((near - angle) / (2 * Math.PI) + 0.5);
}

export function allTurnedTowards(angles: readonly number[], near: readonly number[]) {
  return angles.map((angle, i) => turnedTowards(angle, near[i]));
}
