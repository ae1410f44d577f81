import type { About } from "../types.ts";

// Values whose difference is smaller are equal [rad, m]: those of a clip have 32 bits.
const SAME = 1e-6;

/** How much each coordinate of q differs between two configurations, the largest first, without those that are equal. */
export function differences(about: Pick<About, "coordinates">, from: ArrayLike<number>, to: ArrayLike<number>) {
  return about.coordinates
    .map(({ joint, column, unit }) => ({ joint, unit, value: to[column] - from[column] }))
    .filter(({ value }) => Math.abs(value) > SAME)
    .sort((a, b) => Math.abs(b.value) - Math.abs(a.value));
}
