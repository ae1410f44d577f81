// @ts-nocheck
// The value at x of what is linear between the places `at`, and constant outside of them.
export function interpolate(at, values, x) {
  const right = at.findIndex((bend) => bend >= x);
  if (right === 0) return values[0];
  if (right < 0) return values[values.length - 1];
  const share = (x - at[right - 1]) / (at[right] - at[right - 1]);
  return values[right - 1] + share * (values[right] - values[right - 1]);
}

export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

export const squaredDistance = (a, b) => a.reduce((sum, value, i) => sum + (b[i] - value) ** 2, 0);

// An angle from within (−3π, 3π] taken into (−π, π].
export function wrapped(angle) {
  if (angle > Math.PI) return angle - 2 * Math.PI;
  return angle <= -Math.PI ? angle + 2 * Math.PI : angle;
}

// The same angle with the whole turns that bring it within half a turn of another.
export const turnedTowards = (value, near) => value + 2 * Math.PI * Math.floor((near - value) / (2 * Math.PI) + 0.5);

export const allTurnedTowards = (values, near) => values.map((value, i) => turnedTowards(value, near[i]));

export const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);

export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
