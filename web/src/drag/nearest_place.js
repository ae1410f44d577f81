// The search goes so many ways, and ends with steps of LAST_STEP [m], or after so many tries.
const WAYS = 16;
const TRIES = 100;
export const LAST_STEP = 1e-4;

/** @type {(a: number[], b: number[]) => number} */
export const between = (a, b) => Math.hypot(...a.map((value, k) => value - b[k]));

/**
 * Unit vectors all around in the plane of two directions that are at right angles.
 *
 * @param {number[]} right
 * @param {number[]} up
 */
export function directionsAround(right, up) {
  return Array.from({ length: WAYS }, (_, i) => {
    const angle = (i * 2 * Math.PI) / WAYS;
    return right.map((value, k) => Math.cos(angle) * value + Math.sin(angle) * up[k]);
  });
}

/**
 * The reachable place nearest to a target: from one that is reached in steps in a plane, each way, until they are a tenth
 * of a millimetre or too many were tried for one move of the pointer.
 *
 * @param {number[]} target
 * @param {number[]} from a place that is reached
 * @param {number[][]} directions unit vectors in the plane
 * @param {(place: number[]) => boolean} isReached
 */
export function nearestPlace(target, from, directions, isReached) {
  let best = from;
  let step = between(best, target);
  let left = TRIES;
  while (step > LAST_STEP && left > 0) {
    const away = between(best, target);
    const found = directions
      .map((direction) => best.map((value, k) => value + step * direction[k]))
      .map((place) => ({ place, away: between(place, target) }))
      .filter((tried) => tried.away < away)
      .sort((a, b) => a.away - b.away)
      .find(({ place }) => left-- > 0 && isReached(place));
    if (found) best = found.place;
    else step *= 0.5;
  }
  return best;
}
