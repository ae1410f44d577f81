// A joint that is farther away than this [rad, m] is somewhere else: one arm that is moved makes no other posture.
const ELSEWHERE = 0.5;
// How much nearer another posture must be before it takes over from the one before.
const CLEARLY = 0.85;

/**
 * Number of the posture that a configuration is nearest to.
 *
 * @param postures at least one
 * @param before the one that it was nearest to a step earlier
 */
export function nearestPosture(q: ArrayLike<number>, postures: { q: number[] }[], before: number | null = null) {
  const distances = postures.map((posture) =>
    posture.q.reduce((sum, value, i) => sum + Math.min(Math.abs(value - q[i]), ELSEWHERE), 0),
  );
  const nearest = distances.indexOf(Math.min(...distances));
  return before !== null && distances[nearest] > CLEARLY * distances[before] ? before : nearest;
}
