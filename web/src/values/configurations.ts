import { clamp, interpolate } from "../math/numbers.ts";
import type { About, Coordinate } from "../types.ts";

/** The range of a coordinate, coupled limits included, in a configuration. */
export function rangeOf(
  { tables }: Pick<About, "tables">,
  { column, lower, upper }: Coordinate,
  q: ArrayLike<number>,
): [number, number] {
  let [low, high] = [lower ?? -Infinity, upper ?? Infinity];
  for (const table of tables.filter(({ joint }) => joint === column)) {
    low = Math.max(low, interpolate(table.at, table.lower, q[table.of]));
    high = Math.min(high, interpolate(table.at, table.upper, q[table.of]));
  }
  return [low, high];
}

/** The configuration seen in a mirror between left and right; a floating base stays. */
export function mirrored({ mirror }: Pick<About, "mirror">, q: ArrayLike<number>) {
  const image = Array.from(q);
  // Adding zero takes the sign off a negative zero.
  for (const { column, of, multiplier, offset } of mirror) image[column] = multiplier * q[of] + offset + 0;
  return image;
}

/**
 * A configuration inside all limits, coupled ones included, each joint uniform in its range; one without limits is
 * uniform in half a turn to either side. A floating base stays.
 *
 * @param random uniform in [0, 1)
 */
export function randomWithin(
  about: Pick<About, "coordinates" | "tables">,
  q: ArrayLike<number>,
  random: () => number = Math.random,
) {
  const values = Array.from(q);
  const shares = about.coordinates.map((coordinate) => {
    const share = random();
    const low = coordinate.lower ?? (coordinate.upper === null ? -Math.PI : coordinate.upper - Math.PI);
    values[coordinate.column] = low + share * ((coordinate.upper ?? low + 2 * Math.PI) - low);
    return share;
  });
  const coupled = new Set(about.tables.map(({ joint }) => joint));
  about.coordinates.forEach((coordinate, i) => {
    if (!coupled.has(coordinate.column)) return;
    const [low, high] = rangeOf(about, coordinate, values);
    values[coordinate.column] = clamp(
      low + shares[i] * (high - low),
      coordinate.lower ?? low,
      coordinate.upper ?? high,
    );
  });
  return values;
}

/** Values that rounding took out of their ranges, on the limits again; those further outside stay there. */
export function unrounded(about: Pick<About, "coordinates" | "tables">, q: number[], rounding: number) {
  const values = [...q];
  for (const coordinate of about.coordinates) {
    const [low, high] = rangeOf(about, coordinate, values);
    const inside = clamp(values[coordinate.column], low, high);
    if (Math.abs(inside - values[coordinate.column]) <= rounding) values[coordinate.column] = inside;
  }
  return values;
}
