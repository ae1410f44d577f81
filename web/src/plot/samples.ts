import type { Motion } from "../timeline/motion.ts";

/** Times that show a motion: its own where straight lines lie between them, else evenly spaced ones. */
export function sampleTimes(motion: Motion, most: number) {
  if (motion.count <= most && motion.interpolation === "linear") return Array.from(motion.times);
  return evenTimes(motion, most);
}

/** @param count from its start to its end */
export function evenTimes({ start, end }: Motion, count: number) {
  return Array.from({ length: count }, (_, i) => (i === count - 1 ? end : start + ((end - start) * i) / (count - 1)));
}

/** Those of some numbers of a configuration that go furthest, in the order given. */
export function busiest({ values, width, count }: Motion, columns: readonly number[], most: number) {
  const ranges = columns.map((column) => {
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < count; i++) {
      const value = values[i * width + column];
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return { column, range: high - low };
  });
  const chosen = ranges
    .filter(({ range }) => range > 1e-6)
    .sort((a, b) => b.range - a.range)
    .slice(0, most)
    .map(({ column }) => column);
  return columns.filter((column) => chosen.includes(column));
}

/** The last of some ascending times that is not after a time; −1 where all are. */
export function indexAt(times: readonly number[], time: number) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
