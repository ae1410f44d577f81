import { quoted, unknown } from "../values/names.ts";
import { fromCsv } from "./csv_tracks.ts";
import { fromJson } from "./json_tracks.ts";
import { Motion, type Interpolation } from "./motion.ts";
import { MOST_ROWS, NoMotion, type Track } from "./tracks.ts";
import type { About } from "../types.ts";

type Robot = Pick<About, "joints">;

/** Bytes of a file that is read at all. */
export const MOST_BYTES = 32_000_000;

// What Python's viewer takes for a place of a joint [rad, m].
const FURTHEST = 1e6;

/**
 * The motion in a CSV or JSON file as nao_kin.motion writes them.
 *
 * @param q where the joints are that the file does not name
 * @throws {NoMotion}
 */
export function readMotion(robot: Robot, text: string, q: ArrayLike<number>) {
  if (text.trim() === "") throw new NoMotion("empty; expected a motion in CSV or JSON");
  const { tracks, interpolation } = /^\s*[{[]/.test(text)
    ? fromJson(text)
    : { tracks: fromCsv(text), interpolation: "linear" };
  const names = robot.joints.map(({ name }) => name);
  const seen = new Set();
  for (const { name } of tracks) {
    if (!names.includes(name)) throw new NoMotion(unknown(name, names));
    if (seen.has(name)) throw new NoMotion(`joint ${quoted(name)} is given twice`);
    seen.add(name);
  }
  if (tracks.length === 0) throw new NoMotion("no joints; expected a column for each joint that moves");
  const shared = tracks.every(({ times }) => String(times) === String(tracks[0].times));
  if (interpolation === "smooth" && !shared) {
    throw new NoMotion("smooth joints with times of their own; nao-kin motion convert --rate 50 samples them");
  }
  const times = shared ? tracks[0].times : [...new Set(tracks.flatMap((track) => track.times))].sort((a, b) => a - b);
  if (times.length > MOST_ROWS) throw new NoMotion(`${times.length} times, more than ${MOST_ROWS}`);
  return assembled(robot, tracks, times, q, interpolation === "smooth" ? "smooth" : "linear");
}

/** @param times of all */
function assembled(
  { joints }: Robot,
  tracks: Track[],
  times: number[],
  q: ArrayLike<number>,
  interpolation: Interpolation,
) {
  const values = new Float64Array(times.length * q.length);
  times.forEach((_, i) => values.set(Array.from(q), i * q.length));
  /** Joints of one motor give it the mean of what each says. */
  const motors: Map<number, Float64Array[]> = new Map();
  for (const { name, times: own, values: keys } of tracks) {
    const joint = joints.find((candidate) => candidate.name === name);
    if (!joint || joint.multiplier === 0) continue;
    const all = own.length === times.length ? keys : straight(own, keys, times);
    const column = Float64Array.from(all, (value) => (value - joint.offset) / joint.multiplier);
    const beyond = all[column.findIndex((value) => !(Math.abs(value) <= FURTHEST))];
    if (beyond !== undefined) throw new NoMotion(`${quoted(name)} is ${beyond}, which is no place of a joint`);
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

/**
 * The values at ascending times of what is linear between keys, and constant outside of them.
 *
 * @param own times of the keys
 */
function straight(own: number[], keys: number[], times: number[]) {
  let next = 0;
  return times.map((time) => {
    while (next < own.length && own[next] < time) next += 1;
    if (next === own.length) return keys[next - 1];
    if (next === 0 || own[next] === time) return keys[next];
    const share = (time - own[next - 1]) / (own[next] - own[next - 1]);
    return keys[next - 1] + share * (keys[next] - keys[next - 1]);
  });
}
