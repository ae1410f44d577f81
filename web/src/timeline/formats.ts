import { interpolate } from "../math/numbers.ts";
import type { About, Coordinate } from "../types.ts";
import { Refused } from "../values/literals.ts";
import { isHand, quoted, unknown } from "../values/names.ts";
import { MOST_ROWS, Motion, type Track } from "./motion.ts";

/** The motion of these tracks. @throws {Refused} joints that the robot does not have, or that are given twice */
export function motionOf(robot: Pick<About, "joints">, tracks: Track[], q: ArrayLike<number>) {
  const names = robot.joints.map(({ name }) => name);
  const seen = new Set();
  for (const { name } of tracks) {
    if (!names.includes(name)) throw new Refused(unknown(name, names));
    if (seen.has(name)) throw new Refused(`joint ${quoted(name)} is given twice`);
    seen.add(name);
  }
  if (tracks.length === 0) throw new Refused("no joints; expected a column for each joint that moves");
  const shared = tracks.every(({ times }) => String(times) === String(tracks[0].times));
  const times = shared ? tracks[0].times : [...new Set(tracks.flatMap((track) => track.times))].sort((a, b) => a - b);
  if (times.length > MOST_ROWS) throw new Refused(`${times.length} times, more than ${MOST_ROWS}`);
  return assembled(robot, tracks, times, q);
}

/** @param times of all tracks together */
function assembled({ joints }: Pick<About, "joints">, tracks: Track[], times: number[], q: ArrayLike<number>) {
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
  return new Motion(times, values);
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
