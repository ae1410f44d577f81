/**
 * The value at x of what is linear between the places `at`, and constant outside of them.
 *
 * @param {readonly number[]} at ascending
 * @param {readonly number[]} values
 * @param {number} x
 */
export function interpolate(at, values, x) {
  const right = at.findIndex((bend) => bend >= x);
  if (right === 0) return values[0];
  if (right < 0) return values[values.length - 1];
  const share = (x - at[right - 1]) / (at[right] - at[right - 1]);
  return values[right - 1] + share * (values[right] - values[right - 1]);
}

/**
 * The number nearest to a value in [low, high]; `high` where that is empty.
 *
 * @param {number} value
 * @param {number} low
 * @param {number} high
 */
export function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}

/**
 * @param {readonly number[]} a
 * @param {readonly number[]} b as long as a
 */
export function squaredDistance(a, b) {
  return a.reduce((sum, value, i) => sum + (b[i] - value) ** 2, 0);
}

/**
 * An angle from within (−3π, 3π] taken into (−π, π].
 *
 * @param {number} angle [rad]
 */
export function wrapped(angle) {
  if (angle > Math.PI) return angle - 2 * Math.PI;
  return angle <= -Math.PI ? angle + 2 * Math.PI : angle;
}

/**
 * The same angle with the whole turns that bring it within half a turn of another, into (near − π, near + π].
 *
 * @param {number} angle [rad]
 * @param {number} near [rad]
 */
export function turnedTowards(angle, near) {
  return angle + 2 * Math.PI * Math.floor((near - angle) / (2 * Math.PI) + 0.5);
}

/**
 * @param {readonly number[]} angles [rad]
 * @param {readonly number[]} near [rad]
 */
export function allTurnedTowards(angles, near) {
  return angles.map((angle, i) => turnedTowards(angle, near[i]));
}
