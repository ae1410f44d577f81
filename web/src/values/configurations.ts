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

/** The configuration mirrored between left and right; a floating base stays. */
export function mirrored({ mirror }: Pick<About, "mirror">, q: ArrayLike<number>) {
  const image = Array.from(q);
  // Adding zero turns a negative zero into zero.
  for (const { column, of, multiplier, offset } of mirror) image[column] = multiplier * q[of] + offset + 0;
  return image;
}

/** Put values that rounding moved out of their ranges back on the limits; values farther outside stay. */
export function unrounded(about: Pick<About, "coordinates" | "tables">, q: number[], rounding: number) {
  const values = [...q];
  for (const coordinate of about.coordinates) {
    const [low, high] = rangeOf(about, coordinate, values);
    const inside = clamp(values[coordinate.column], low, high);
    if (Math.abs(inside - values[coordinate.column]) <= rounding) values[coordinate.column] = inside;
  }
  return values;
}

const dictionary = ({ coordinates }: About, q: ArrayLike<number>) =>
  `{${coordinates.map(({ joint, column }) => `${JSON.stringify(joint)}: ${q[column]}`).join(", ")}}`;

const names = ({ naoqi }: About) => JSON.stringify(naoqi).replaceAll(",", ", ");

function angles({ naoqi, joints }: About, q: ArrayLike<number>) {
  const values = naoqi.map((name) => {
    const joint = joints.find((candidate) => candidate.name === name);
    return joint ? joint.multiplier * q[joint.column] + joint.offset : 0;
  });
  return `[${values.join(", ")}]`;
}

const field = (text: string) => (/[",;\t\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** The formats in which a configuration is copied. Numbers have all their digits, in rad, m and shares. */
export const FORMATS: Record<
  string,
  {
    title: string;
    hint: string;
    /** Whether only a robot with the joints of NAOqi has it. */
    naoqi?: true;
    write(about: About, q: ArrayLike<number>, isInside?: boolean): string;
  }
> = {
  json: {
    title: "JSON",
    hint: "{joint: rad}",
    write: (about, q) => `${dictionary(about, q)}\n`,
  },
  csv: {
    title: "CSV",
    hint: "for nao-kin fk and view",
    write: ({ coordinates }, q) =>
      `${coordinates.map(({ joint }) => field(joint)).join(",")}\n${coordinates.map(({ column }) => q[column]).join(",")}\n`,
  },
  python: {
    title: "Python",
    hint: "q = nao.configuration({…})",
    write: (about, q, isInside = true) =>
      `q = nao.configuration(${dictionary(about, q)}${isInside ? "" : ', limits="ignore"'})\n`,
  },
  setAngles: {
    title: "setAngles",
    hint: "NAOqi, at a tenth of full speed",
    naoqi: true,
    write: (about, q) => `motion.setAngles(${names(about)}, ${angles(about, q)}, 0.1)\n`,
  },
};

// Values whose difference is smaller are equal [rad, m]: those of a clip have 32 bits.
const SAME = 1e-6;

/** How much each coordinate of q differs between two configurations, the largest first, without those that are equal. */
export function differences(about: Pick<About, "coordinates">, from: ArrayLike<number>, to: ArrayLike<number>) {
  return about.coordinates
    .map(({ joint, column, unit }) => ({ joint, unit, value: to[column] - from[column] }))
    .filter(({ value }) => Math.abs(value) > SAME)
    .sort((a, b) => Math.abs(b.value) - Math.abs(a.value));
}
