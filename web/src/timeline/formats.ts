import { DEGREE, interpolate } from "../math/numbers.ts";
import type { About, Coordinate } from "../types.ts";
import { Refused, decimal, readRecords } from "../values/literals.ts";
import { isHand, quoted, unknown } from "../values/names.ts";
import { MOST_ROWS, Motion, TIME_UNITS, type Interpolation, type Track } from "./motion.ts";

const HEADING = /^([^[\]()]*?)\s*(?:[[(]\s*([^[\]()]*?)\s*[\])])?$/;
const HAND_UNITS: Record<string, number> = { 1: 1, "%": 0.01 };
const ANGLE_UNITS: Record<string, number> = { rad: 1, deg: DEGREE, "°": DEGREE, m: 1 };

/**
 * Read the joints of a CSV table: a header with units, a column of times, and a column for each joint.
 *
 * @throws {Refused}
 */
function fromCsv(text: string) {
  let rows = 0;
  for (let at = text.indexOf("\n"); at >= 0; at = text.indexOf("\n", at + 1)) rows += 1;
  if (rows > MOST_ROWS) throw new Refused(`${rows} rows, more than ${MOST_ROWS}`);
  const [header, ...records] = readRecords(text);
  if (!header) throw new Refused("empty; expected a header with a column of times");
  const headings = header.fields.map((heading, i) => headingOf(heading, `line ${header.line}, column ${i + 1}`));
  const clocks = headings.filter(({ isTime }) => isTime);
  if (clocks.length !== 1) {
    throw new Refused(`line ${header.line}: ${clocks.length} columns of times, expected one, headed time [s]`);
  }
  if (records.length === 0) throw new Refused(`line ${header.line}: a header and no keys`);
  const clock = headings.indexOf(clocks[0]);
  const tracks: Track[] = headings.map(({ name }) => ({ name, times: [], values: [] }));
  let last = -Infinity;
  for (const { fields, line } of records) {
    if (fields.length !== headings.length) {
      throw new Refused(`line ${line}: ${fields.length} values, the header names ${headings.length} columns`);
    }
    const cells = fields.map((field, column) => {
      const value = field === "" ? NaN : decimal(field) * headings[column].scale;
      if (Math.abs(value) < Infinity || field === "") return value;
      const { name } = headings[column];
      throw new Refused(`line ${line}, column ${column + 1}: ${name} is ${quoted(field)}, expected a finite number`);
    });
    const time = cells[clock];
    if (Number.isNaN(time)) throw new Refused(`line ${line}: a row without a time`);
    if (!(time > last)) throw new Refused(`line ${line}: time ${time} s does not come after ${last} s`);
    last = time;
    cells.forEach((value, column) => {
      if (Number.isNaN(value)) return;
      tracks[column].times.push(time);
      tracks[column].values.push(value);
    });
  }
  tracks.splice(clock, 1);
  const bare = tracks.find(({ times }) => times.length === 0);
  if (bare) throw new Refused(`${quoted(bare.name)} has no keys`);
  return tracks;
}

function headingOf(heading: string, place: string) {
  const [, name, unit] = HEADING.exec(heading.slice(0, 1000)) ?? [];
  if (name === undefined) throw new Refused(`${place}: heading ${quoted(heading)}, expected a name and [unit]`);
  const isTime = /^(time|t)$/i.test(name);
  const units = isTime ? TIME_UNITS : isHand(name) ? HAND_UNITS : ANGLE_UNITS;
  if (unit !== undefined && !Object.hasOwn(units, unit)) {
    const known = Object.keys(units).join(", ");
    throw new Refused(`${place}: unit ${quoted(unit)} of ${quoted(name)}, expected one of ${known}`);
  }
  return { name, isTime, scale: unit === undefined ? 1 : units[unit] };
}

const FIELDS = ["format", "units", "interpolation", "joint_names", "times", "keys"];

/**
 * Read the joints of a JSON document and their interpolation.
 *
 * @throws {Refused}
 */
function fromJson(text: string) {
  const document = parsed(text);
  if (typeof document !== "object" || document === null || Array.isArray(document)) {
    throw new Refused("expected an object with joint_names, times and keys");
  }
  const { interpolation = "linear", joint_names: names, times, keys, units = {} } = document;
  if (interpolation === "bezier") {
    throw new Refused("this page cannot read Bézier curves; sample them with nao-kin motion convert --rate 50");
  }
  if (interpolation !== "linear" && interpolation !== "smooth") {
    throw new Refused(`interpolation is ${shown(interpolation)}, expected linear or smooth`);
  }
  for (const field of Object.keys(document)) {
    if (!FIELDS.includes(field) && document[field] !== null) throw new Refused(`unknown field ${quoted(field)}`);
  }
  for (const [field, list] of Object.entries({ joint_names: names, times, keys })) {
    if (!Array.isArray(list)) throw new Refused(`${field} is ${shown(list)}, expected a list`);
    if (list.length === 0) throw new Refused(`${field} is empty`);
    if (list.length > MOST_ROWS) throw new Refused(`${field} has ${list.length} entries, more than ${MOST_ROWS}`);
  }
  const scale = { time: unitOf(units, "time", TIME_UNITS), angle: unitOf(units, "angle", { rad: 1, deg: DEGREE }) };
  const nested = Array.isArray(times[0]);
  if (keys.length !== (nested ? names : times).length || (nested && times.length !== names.length)) {
    const wanted = nested ? `${names.length} joints` : `${times.length} times`;
    throw new Refused(`keys has ${keys.length} lists for ${wanted}`);
  }
  const width = nested ? null : names.length;
  const rows = keys.map((row: unknown, i: number) => numbers(row, `keys[${i}]`, width));
  const shared = nested ? null : numbers(times, "times", null);
  const tracks = names.map((name: unknown, joint: number) => {
    if (typeof name !== "string") throw new Refused(`joint_names[${joint}] is ${shown(name)}, expected a name`);
    const own = shared ?? numbers(times[joint], `times[${joint}]`, null);
    if (nested && own.length !== rows[joint].length) {
      throw new Refused(`${quoted(name)} has ${own.length} times and ${rows[joint].length} keys`);
    }
    const at = own.findIndex((time, i) => i > 0 && !(time > own[i - 1]));
    const where = nested ? `times[${joint}]` : "times";
    if (at > 0) throw new Refused(`${where}[${at}] is ${own[at]}, which does not come after ${own[at - 1]}`);
    if (own.length === 0) throw new Refused(`${quoted(name)} has no keys`);
    const values = nested ? rows[joint] : rows.map((row: number[]) => row[joint]);
    const factor = isHand(name) ? 1 : scale.angle;
    return {
      name,
      times: own.map((time) => time * scale.time),
      values: values.map((value: number) => value * factor),
    };
  });
  return { tracks: tracks as Track[], interpolation: interpolation as "linear" | "smooth" };
}

function parsed(text: string) {
  try {
    return JSON.parse(text);
  } catch (error) {
    const said = String((error as Error).message);
    const at = /position (\d+)/.exec(said);
    const line = at ? text.slice(0, Number(at[1])).split("\n").length : text.split("\n").length;
    throw new Refused(`line ${line}: malformed JSON`);
  }
}

function unitOf(units: any, quantity: string, known: Record<string, number>) {
  const unit = units?.[quantity] ?? Object.keys(known)[0];
  if (typeof unit === "string" && Object.hasOwn(known, unit)) return known[unit];
  throw new Refused(`unit of ${quantity} is ${shown(unit)}, expected ${Object.keys(known).join(" or ")}`);
}

function numbers(list: unknown, path: string, count: number | null): number[] {
  if (!Array.isArray(list)) throw new Refused(`${path} is ${shown(list)}, expected a list`);
  if (list.length > MOST_ROWS) throw new Refused(`${path} has ${list.length} numbers, more than ${MOST_ROWS}`);
  if (count !== null && list.length !== count) {
    throw new Refused(`${path} has ${list.length} numbers, expected ${count}`);
  }
  const at = list.findIndex((value) => typeof value !== "number" || !Number.isFinite(value));
  if (at >= 0) throw new Refused(`${path}[${at}] is ${shown(list[at])}, expected a finite number`);
  return list;
}

/** Write a value of a file for a message. */
function shown(value: unknown) {
  if (value === undefined) return "missing";
  return quoted(typeof value === "string" ? value : (JSON.stringify(value) ?? String(value)).slice(0, 80));
}

/** The largest file that is read [bytes]. */
export const MOST_BYTES = 32_000_000;

/**
 * Read the motion in a CSV or JSON file, in the formats that nao_kin.motion writes.
 *
 * @param q the values of the joints that the file does not name
 * @throws {Refused}
 */
export function readMotion(robot: Pick<About, "joints">, text: string, q: ArrayLike<number>) {
  if (text.trim() === "") throw new Refused("empty; expected a motion in CSV or JSON");
  if (!/^\s*[{[]/.test(text)) return motionOf(robot, fromCsv(text), q);
  const { tracks, interpolation } = fromJson(text);
  return motionOf(robot, tracks, q, interpolation);
}

/** The motion of these tracks. @throws {Refused} joints that the robot does not have, or that are given twice */
export function motionOf(
  robot: Pick<About, "joints">,
  tracks: Track[],
  q: ArrayLike<number>,
  interpolation: "linear" | "smooth" = "linear",
) {
  const names = robot.joints.map(({ name }) => name);
  const seen = new Set();
  for (const { name } of tracks) {
    if (!names.includes(name)) throw new Refused(unknown(name, names));
    if (seen.has(name)) throw new Refused(`joint ${quoted(name)} is given twice`);
    seen.add(name);
  }
  if (tracks.length === 0) throw new Refused("no joints; expected a column for each joint that moves");
  const shared = tracks.every(({ times }) => String(times) === String(tracks[0].times));
  if (interpolation === "smooth" && !shared) {
    throw new Refused("smooth joints whose times differ; sample them with nao-kin motion convert --rate 50");
  }
  const times = shared ? tracks[0].times : [...new Set(tracks.flatMap((track) => track.times))].sort((a, b) => a - b);
  if (times.length > MOST_ROWS) throw new Refused(`${times.length} times, more than ${MOST_ROWS}`);
  return assembled(robot, tracks, times, q, interpolation);
}

/** @param times of all tracks together */
function assembled(
  { joints }: Pick<About, "joints">,
  tracks: Track[],
  times: number[],
  q: ArrayLike<number>,
  interpolation: Interpolation,
) {
  const values = new Float64Array(times.length * q.length);
  times.forEach((_, i) => values.set(Array.from(q), i * q.length));
  /** The values that the joints of a motor give it; it gets their mean. */
  const motors: Map<number, Float64Array[]> = new Map();
  for (const { name, times: own, values: keys } of tracks) {
    const joint = joints.find((candidate) => candidate.name === name);
    if (!joint || joint.multiplier === 0) continue;
    const all = own.length === times.length ? keys : times.map((time) => interpolate(own, keys, time));
    const column = Float64Array.from(all, (value) => (value - joint.offset) / joint.multiplier);
    motors.set(joint.column, [...(motors.get(joint.column) ?? []), column]);
  }
  for (const [column, sources] of motors) {
    for (let i = 0; i < times.length; i++) {
      const sum = sources.reduce((total, source) => total + source[i], 0);
      values[i * q.length + column] = sum / sources.length;
    }
  }
  return new Motion(times, values, interpolation);
}

/** Samples per second of a smooth motion in a format that has straight lines only. */
const SAMPLES = 50;

// A joint's name that the header of a CSV file cannot hold, or that would be read as its column of times.
const NO_HEADING = /[[\](),;\t\r\n"]|^\s|\s$|^(time|t)$/i;

const rowsOf = (coordinates: Coordinate[], { values, width, count }: Motion) =>
  Array.from({ length: count }, (_, i) => coordinates.map(({ column }) => values[i * width + column]));

/** Write the JSON file of nao_kin.motion, with all digits; Bezier curves are sampled. */
export function jsonText({ coordinates }: Pick<About, "coordinates">, curves: Motion) {
  const motion = curves.interpolation === "bezier" ? sampled(curves) : curves;
  const rows = rowsOf(coordinates, motion).map((row) => `  ${JSON.stringify(row)}`);
  return `{"format": "nao_kin motion",
 "units": {"time": "s", "angle": "rad"},
 "interpolation": "${motion.interpolation}",
 "joint_names": ${JSON.stringify(coordinates.map(({ joint }) => joint))},
 "times": ${JSON.stringify(Array.from(motion.times))},
 "keys": [
${rows.join(",\n")}]}
`;
}

/**
 * Write the CSV file of nao_kin.motion: seconds and radians, hands as shares. It has straight lines only, so a smooth
 * motion is sampled.
 *
 * @throws {Refused} a joint's name that a header cannot hold
 */
export function csvText({ coordinates }: Pick<About, "coordinates">, motion: Motion) {
  for (const { joint } of coordinates) {
    if (NO_HEADING.test(joint)) throw new Refused(`CSV cannot hold a joint's name such as “${joint.slice(0, 40)}”`);
  }
  const unit = (joint: string) => (isHand(joint) ? "1" : "rad");
  const straight = motion.interpolation === "linear" ? motion : sampled(motion);
  const rows = rowsOf(coordinates, straight).map((row, i) => [straight.times[i], ...row].join(","));
  const header = ["time [s]", ...coordinates.map(({ joint }) => `${joint} [${unit(joint)}]`)].join(",");
  return [header, ...rows, ""].join("\n");
}

export const WRITERS: Record<
  string,
  { type: string; write(robot: Pick<About, "coordinates">, motion: Motion): string }
> = {
  csv: { type: "text/csv", write: csvText },
  json: { type: "application/json", write: jsonText },
};

/** Sample a motion of curves to one of straight lines, which keeps the keys. */
export function sampled(motion: Motion) {
  const times = new Set(Array.from(motion.times));
  const steps = Math.floor((motion.end - motion.start) * SAMPLES);
  for (let step = 1; step <= steps; step++) {
    const time = motion.start + step / SAMPLES;
    // No sample next to a key, which is kept anyway.
    const key = motion.segment(time);
    const near = [key, key + 1].some((i) => Math.abs(motion.times[i] - time) < 1e-3);
    if (!near && time < motion.end) times.add(time);
  }
  const ascending = [...times].sort((a, b) => a - b);
  return Motion.of(
    ascending,
    ascending.map((time) => motion.at(time)),
  );
}
