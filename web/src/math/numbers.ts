/**
 * The value at x of what is linear between the places `at`, and constant outside of them.
 *
 * @param at ascending
 */
export function interpolate(at: readonly number[], values: readonly number[], x: number) {
  const right = at.findIndex((bend) => bend >= x);
  if (right === 0) return values[0];
  if (right < 0) return values[values.length - 1];
  const share = (x - at[right - 1]) / (at[right] - at[right - 1]);
  return values[right - 1] + share * (values[right] - values[right - 1]);
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

/**
 * An angle from within (−3π, 3π] taken into (−π, π].
 *
 * @param angle [rad]
 */
export function wrapped(angle: number) {
  if (angle > Math.PI) return angle - 2 * Math.PI;
  return angle <= -Math.PI ? angle + 2 * Math.PI : angle;
}

/**
 * The same angle with the whole turns that bring it within half a turn of another, into (near − π, near + π].
 *
 * @param angle [rad]
 * @param near [rad]
 */
export function turnedTowards(angle: number, near: number) {
  return angle + 2 * Math.PI * Math.floor((near - angle) / (2 * Math.PI) + 0.5);
}

/**
 * @param angles [rad]
 * @param near [rad]
 */
export function allTurnedTowards(angles: readonly number[], near: readonly number[]) {
  return angles.map((angle, i) => turnedTowards(angle, near[i]));
}
