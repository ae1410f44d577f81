import { Motion } from "./motion.ts";

/**
 * The samples of a motion that suffice: straight lines between them stay within a tolerance of all others (Ramer,
 * Douglas and Peucker, each number for itself). Null where that takes more than some number of them.
 *
 * @param tolerance of every number
 */
export function thinned(motion: Motion, tolerance: number, most: number) {
  const { times, values, width, count } = motion;
  const kept = new Set([0, count - 1]);
  const open = [[0, count - 1]];
  for (let stretch = open.pop(); stretch; stretch = open.pop()) {
    const [first, last] = stretch;
    let [furthest, at] = [tolerance, -1];
    for (let i = first + 1; i < last; i++) {
      const share = (times[i] - times[first]) / (times[last] - times[first]);
      for (let column = 0; column < width; column++) {
        const [from, to] = [values[first * width + column], values[last * width + column]];
        const off = Math.abs(values[i * width + column] - from - share * (to - from));
        if (off > furthest) [furthest, at] = [off, i];
      }
    }
    if (at < 0) continue;
    kept.add(at);
    if (kept.size > most) return null;
    open.push([first, at], [at, last]);
  }
  const places = [...kept].sort((a, b) => a - b);
  return Motion.of(
    places.map((place) => times[place]),
    places.map((place) => motion.row(place)),
  );
}
