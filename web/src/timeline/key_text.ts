import type { About } from "../types.ts";
import { unrounded } from "../values/configurations.ts";
import { NUMBER, ROUNDING, decoded, rounded, splitAt } from "../values/link.ts";
import { quoted } from "../values/names.ts";
import { NoConfiguration, withValues } from "../values/reading.ts";
import { KeyFrames, LATEST, type Key } from "./key_frames.ts";

/** key frames, and the time that is on show [s] */
export interface KeysShown {
  frames: KeyFrames;
  time: number;
}

// Key frames as a link has them:
//
//   linear:1.5:HeadYaw,LKneePitch;0:5yc4,-7ps;1.5:,8w
//
// What lies between them, the time that is on show, and the joints that are anywhere but at zero; then each key, its time
// and the values of these joints: millionths of a radian or metre in base 36, nothing for that of the key before.

/** How many key frames a link has room for, and how many characters: sixty in which all joints of a NAO move fit. */
export const MOST_LINKED = 60;
const LONGEST = 9000;

// In the place of a joint's name, the pose of a floating base; no name has this sign, for it is written as %40.
const BASE = "@";
const BASE_COLUMNS = [0, 1, 2, 3, 4, 5, 6];

const WHOLE = /^-?[0-9a-z]{1,8}$/;

/** @returns null where a link has no room for them */
export function writeKeys(about: About, { frames: { keys, interpolation }, time }: KeysShown): string | null {
  if (keys.length > MOST_LINKED) return null;
  const whole = keys.map(({ q }) => q.map((value) => Math.round(value / ROUNDING)));
  const moved = about.coordinates.filter(({ column }) => whole.some((row) => row[column] !== 0));
  const columns = [...(about.floating ? BASE_COLUMNS : []), ...moved.map(({ column }) => column)];
  const names = [...(about.floating ? [BASE] : []), ...moved.map(({ joint }) => encodeURIComponent(joint))];
  const rows = keys.map(({ time: at }, i) => {
    const values = columns.map((column) =>
      whole[i][column] === (whole[i - 1]?.[column] ?? 0) ? "" : whole[i][column].toString(36),
    );
    return `${rounded(at)}:${values.join(",")}`;
  });
  const text = [`${interpolation}:${rounded(time)}:${names.join(",")}`, ...rows].join(";");
  return text.length > LONGEST ? null : text;
}

/** @throws {NoConfiguration} */
export function readKeys(about: About, text: string): KeysShown {
  const [head, ...rows] = text.split(";");
  const [interpolation, time, list, ...more] = head.split(":");
  if ((interpolation !== "linear" && interpolation !== "smooth") || list === undefined || more.length > 0) {
    throw new NoConfiguration(`key frames begin with ${quoted(head)}, expected linear or smooth, a time and joints`);
  }
  if (rows.length === 0 || rows.length > MOST_LINKED) {
    throw new NoConfiguration(`${rows.length} key frames, a link has 1 to ${MOST_LINKED}`);
  }
  const names = list === "" ? [] : list.split(",");
  const hasBase = names[0] === BASE;
  if (hasBase !== about.floating) {
    throw new NoConfiguration(`key frames ${hasBase ? "with" : "without"} a base that moves, unlike this robot`);
  }
  const joints = names.slice(hasBase ? 1 : 0).map(decoded);
  const count = joints.length + (hasBase ? BASE_COLUMNS.length : 0);
  let values: number[] = Array(count).fill(0);
  const keys: Key[] = [];
  for (const row of rows) {
    const [at, written] = splitAt(row, ":");
    values = changed(values, count === 0 && written === "" ? [] : written.split(","), at);
    const before = keys.at(-1)?.time ?? -Infinity;
    const now = timeOf(at);
    if (!(now > before)) throw new NoConfiguration(`a key frame at ${at} s behind one at ${before} s`);
    keys.push({ time: now, q: configuration(about, hasBase, joints, values) });
  }
  return { frames: new KeyFrames(keys, interpolation), time: timeOf(time) };
}

function timeOf(text: string) {
  const time = NUMBER.test(text) ? Number(text) : NaN;
  if (!(time >= 0 && time <= LATEST)) {
    throw new NoConfiguration(`the time of a key frame is ${quoted(text)}, expected 0 to ${LATEST} s`);
  }
  return time;
}

function changed(before: number[], parts: string[], at: string) {
  if (parts.length !== before.length) {
    throw new NoConfiguration(`the key frame at ${quoted(at)} has ${parts.length} values, expected ${before.length}`);
  }
  return parts.map((part, i) => {
    if (part === "") return before[i];
    if (!WHOLE.test(part)) throw new NoConfiguration(`${quoted(part)} is no value of a key frame`);
    return Number.parseInt(part, 36);
  });
}

function configuration(about: About, hasBase: boolean, joints: string[], whole: number[]) {
  const values = whole.map((value) => Number((value * ROUNDING).toFixed(6)));
  const start = [...about.neutral];
  for (const { column } of about.coordinates) start[column] = 0;
  if (hasBase) {
    const base = values.splice(0, BASE_COLUMNS.length);
    if (!(Math.hypot(...base.slice(3)) > 1e-3)) throw new NoConfiguration("a key frame whose base has no orientation");
    start.splice(0, base.length, ...base);
  }
  const written = joints.map((name, i) => ({ name, value: values[i], line: 0 }));
  return unrounded(about, withValues(about, start, written), ROUNDING);
}
