import { clamp } from "../math/numbers.ts";

// The search goes over so many steps of the range, and then halves its step so many times.
const STEPS = 180;
const HALVINGS = 48;

/**
 * Of a family with one parameter in [low, high] the value with the smallest cost: on a grid, then by halving; null if all
 * are infinite. The reference's own value is tried too: what is met within rounding does not change a member that fits.
 *
 * @param own the reference's value
 */
export function leastCost(low: number, high: number, own: number, cost: (value: number) => number) {
  const step = (high - low) / STEPS;
  let [best, at] = [Infinity, low];
  const attempt = (value: number) => {
    const tried = cost(value);
    if (tried < best) [best, at] = [tried, value];
  };
  attempt(clamp(own, low, high));
  for (let i = 0; i <= STEPS; i++) attempt(low + step * i);
  let width = step;
  for (let i = 0; i < HALVINGS; i++) {
    const around = [Math.max(low, at - width), Math.min(high, at + width)];
    around.forEach(attempt);
    width *= 0.5;
  }
  // Once more, for the cost writes its member down, and the best is to be the last.
  return cost(at) === Infinity ? null : at;
}
