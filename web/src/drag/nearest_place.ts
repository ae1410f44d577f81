import { distance, plus, times } from "../math/vectors.ts";
import type { Vector } from "../math/types.ts";

// The search goes so many ways, and ends with steps of LAST_STEP [m], or after so many tries.
const WAYS = 16;
const TRIES = 100;
export const LAST_STEP = 1e-4;

/** Unit vectors all around in the plane of two directions that are at right angles. */
export function directionsAround(right: Vector, up: Vector) {
  return Array.from({ length: WAYS }, (_, i) => {
    const angle = (i * 2 * Math.PI) / WAYS;
    return plus(times(Math.cos(angle), right), times(Math.sin(angle), up));
  });
}

/**
 * The reachable place nearest to a target: from one that is reached in steps in a plane, each way, until they are a tenth
 * of a millimetre or too many were tried for one move of the pointer.
 *
 * @param from a place that is reached
 * @param directions unit vectors in the plane
 */
export function nearestPlace(
  target: Vector,
  from: Vector,
  directions: Vector[],
  isReached: (place: Vector) => boolean,
) {
  let best = from;
  let step = distance(best, target);
  let left = TRIES;
  while (step > LAST_STEP && left > 0) {
    const away = distance(best, target);
    const found = directions
      .map((direction) => plus(best, times(step, direction)))
      .map((place) => ({ place, away: distance(place, target) }))
      .filter((tried) => tried.away < away)
      .sort((a, b) => a.away - b.away)
      .find(({ place }) => left-- > 0 && isReached(place));
    if (found) best = found.place;
    else step *= 0.5;
  }
  return best;
}
