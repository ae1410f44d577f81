/** Directions spread evenly over the sphere, one after another, by the golden angle. */
export function directions(count: number) {
  const spread = new Float64Array(3 * count);
  const golden = Math.PI * (3 - Math.sqrt(5));
  for (let i = 0; i < count; i++) {
    const z = 1 - (2 * i + 1) / count;
    const radius = Math.sqrt(1 - z * z);
    spread.set([radius * Math.cos(golden * i), radius * Math.sin(golden * i), z], 3 * i);
  }
  return spread;
}

/**
 * Of many points those that lie farthest in some direction: with enough directions, what can touch a floor.
 *
 * @param points x, y, z of one after another
 * @param towards likewise
 */
export function extremes(points: Float64Array, towards: Float64Array) {
  const found: Set<number> = new Set();
  for (let k = 0; k < towards.length && points.length > 0; k += 3) {
    let [best, most] = [0, -Infinity];
    for (let i = 0; i < points.length; i += 3) {
      const height = towards[k] * points[i] + towards[k + 1] * points[i + 1] + towards[k + 2] * points[i + 2];
      if (height > most) [best, most] = [i, height];
    }
    found.add(best);
  }
  return Float64Array.from([...found].flatMap((i) => [points[i], points[i + 1], points[i + 2]]));
}
