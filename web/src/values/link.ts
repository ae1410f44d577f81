import { KeyFrames, LATEST, type Key } from "../timeline/key_frames.ts";
import type { About } from "../types.ts";
import { unrounded } from "./configurations.ts";
import { Refused } from "./literals.ts";
import { quoted } from "./names.ts";
import { jointsAtZero, withValues } from "./reading.ts";
import type { Choice } from "./units.ts";

// Links round joint values to a millionth; a millionth of a radian moves no hand by a micrometre.
export const ROUNDING = 1e-6;

const NUMBER = /^-?\d{1,9}(\.\d{1,17})?$/;

const rounded = (value: number, digits: number = 6) =>
  value
    .toFixed(digits)
    .replace(/\.?0+$/, "")
    .replace(/^-0$/, "0");

/** The parts of a text before and after the sign. */
function splitAt(text: string, sign: string): [string, string] {
  const at = text.indexOf(sign);
  return at < 0 ? [text, ""] : [text.slice(0, at), text.slice(at + 1)];
}

function decoded(text: string) {
  try {
    return decodeURIComponent(text);
  } catch {
    throw new Refused(`${quoted(text)} is not valid in a link`);
  }
}

/** The state of a page that a link holds. */
interface State {
  q: number[];
  /** The vertical in the root's frame; null to let the page place the robot on the floor. */
  up: number[] | null;
  /** A preset, or the position of the camera and the point that it looks at. */
  camera: string | number[];
  /** The overlays that are on. */
  shown: string[];
  units: Choice;
  /** The frame whose pose the panel shows. */
  frame: string;
  /** The key frames; null if there are none. */
  keys: KeysShown | null;
}

const VERSION = "1";
const LONGEST = 20_000;

function numbersOf(text: string, count: number, what: string) {
  const parts = text.split(",");
  if (parts.length !== count || !parts.every((part) => NUMBER.test(part))) {
    throw new Refused(`${what} is ${quoted(text)}, expected ${count} numbers`);
  }
  return parts.map(Number);
}

function oneOf(name: string, valid: readonly string[], kind: string) {
  if (!valid.includes(name)) throw new Refused(`unknown ${kind} ${quoted(name)}`);
  return name;
}

/** A configuration with another pose of its base. */
function withBase(q: number[], base: number[]) {
  if (!(Math.hypot(...base.slice(3)) > 1e-3)) throw new Refused("a base with no orientation");
  return [...base, ...q.slice(base.length)];
}

interface Reading {
  about: About;
  toggles: readonly string[];
  state: Partial<State>;
}

const READERS: Record<string, (value: string, reading: Reading) => Partial<State>> = {
  q(value, { about, state }) {
    const written = (value ? value.split(",") : []).map((part) => {
      const [name, number] = splitAt(part, ":");
      return { name: decoded(name), value: NUMBER.test(number) ? Number(number) : decoded(number), line: 0 };
    });
    return { q: withValues(about, jointsAtZero(about, state.q ?? about.neutral), written) };
  },
  base(value, { about, state }) {
    const numbers = numbersOf(value, 7, "base");
    if (!about.floating) throw new Refused("the link has a floating base, which this robot does not have");
    return { q: withBase(state.q ?? about.neutral, numbers) };
  },
  up(value) {
    const up = numbersOf(value, 3, "up");
    if (!(Math.hypot(...up) > 1e-3)) throw new Refused("up is zero, which is no direction");
    return { up };
  },
  camera(value, { about }) {
    if (value.includes(",")) {
      const places = numbersOf(value, 6, "camera");
      if (places.every((x, i) => Math.abs(x - places[(i + 3) % 6]) < 1e-3)) {
        throw new Refused("the camera looks at its own position");
      }
      return { camera: places };
    }
    return {
      camera: oneOf(
        decoded(value),
        about.cameras.map(({ name }) => name),
        "camera",
      ),
    };
  },
  show: (value, { toggles }) => ({
    shown: value ? value.split(",").map((name) => oneOf(decoded(name), toggles, "overlay")) : [],
  }),
  units(value) {
    const [angle, length] = splitAt(value, ",");
    if ((angle !== "deg" && angle !== "rad") || (length !== "mm" && length !== "m")) {
      throw new Refused(`units are ${quoted(value)}, expected deg or rad, and mm or m`);
    }
    return { units: { angle, length } };
  },
  frame: (value, { about }) => ({
    frame: oneOf(
      decoded(value),
      about.frames.map(({ name }) => name),
      "frame",
    ),
  }),
  keys: (value, { about }) => ({ keys: readKeys(about, value) }),
};

/**
 * Write the part of a link after the #. Joints at zero are left out, as in `nao.configuration({…})`; key frames are left out
 * if they are too long.
 */
export function writeLink(about: About, { q, up, camera, shown, units, frame, keys }: State) {
  const joints = about.coordinates
    .filter(({ column }) => Number(rounded(q[column])) !== 0)
    .map(({ joint, column }) => `${encodeURIComponent(joint)}:${rounded(q[column])}`);
  const parts = [`v=${VERSION}`, `q=${joints.join(",")}`];
  if (about.floating) {
    parts.push(
      `base=${q
        .slice(0, 7)
        .map((x) => rounded(x))
        .join(",")}`,
    );
  }
  if (up) parts.push(`up=${up.map((x) => rounded(x)).join(",")}`);
  const view = typeof camera === "string" ? encodeURIComponent(camera) : camera.map((x) => rounded(x, 4)).join(",");
  parts.push(`camera=${view}`, `show=${shown.map(encodeURIComponent).join(",")}`);
  parts.push(`units=${units.angle},${units.length}`, `frame=${encodeURIComponent(frame)}`);
  const written = keys && writeKeys(about, keys);
  if (written) parts.push(`keys=${written}`);
  return parts.join("&");
}

/**
 * Read the state in a link; fields that the link leaves out are not in the result.
 *
 * @param toggles the overlays that a link may name
 * @throws {Refused}
 */
export function readLink(about: About, toggles: readonly string[], text: string): Partial<State> {
  if (text.length > LONGEST) {
    throw new Refused(`a link of ${text.length} characters, expected at most ${LONGEST}`);
  }
  const parts: Map<string, string> = new Map();
  for (const [key, value] of text.split("&").map((part) => splitAt(part, "="))) {
    if (parts.has(key)) throw new Refused(`the link has the field ${quoted(key)} twice`);
    parts.set(key, value);
  }
  const version = parts.get("v");
  if (version !== VERSION) {
    throw new Refused(
      version === undefined
        ? `${quoted(text)} is not a state of this page`
        : `the link has version ${quoted(version)}, but this page reads version ${VERSION}`,
    );
  }
  const state: Partial<State> = {};
  for (const [key, value] of parts) {
    if (key === "v") continue;
    if (!Object.hasOwn(READERS, key)) throw new Refused(`unknown field ${quoted(key)} in the link`);
    Object.assign(state, READERS[key](value, { about, toggles, state }));
  }
  return state;
}

/** The key frames, and the time shown [s]. */
interface KeysShown {
  frames: KeyFrames;
  time: number;
}

// The format of key frames in a link:
//
//   linear:1.5:HeadYaw,LKneePitch;0:5yc4,-7ps;1.5:,8w
//
// First the interpolation, the time shown, and the joints that are ever nonzero. Then for each key its time and the values
// of these joints, in millionths of a radian or metre in base 36; an empty value is that of the key before.

/** The largest number of key frames in a link, and of their characters: enough for sixty that move all joints of a NAO. */
export const MOST_LINKED = 60;
const LONGEST_KEYS = 9000;

// Stands for the pose of a floating base in the list of joints; in a joint's name this sign would be written as %40.
const BASE = "@";
const BASE_COLUMNS = [0, 1, 2, 3, 4, 5, 6];

const WHOLE = /^-?[0-9a-z]{1,8}$/;

/** @returns null if they are too long for a link */
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
  return text.length > LONGEST_KEYS ? null : text;
}

/** @throws {Refused} */
export function readKeys(about: About, text: string): KeysShown {
  const [head, ...rows] = text.split(";");
  const [interpolation, time, list, ...more] = head.split(":");
  if ((interpolation !== "linear" && interpolation !== "smooth") || list === undefined || more.length > 0) {
    throw new Refused(`key frames begin with ${quoted(head)}, expected linear or smooth, a time and joints`);
  }
  if (rows.length === 0 || rows.length > MOST_LINKED) {
    throw new Refused(`${rows.length} key frames, a link has 1 to ${MOST_LINKED}`);
  }
  const names = list === "" ? [] : list.split(",");
  const hasBase = names[0] === BASE;
  if (hasBase !== about.floating) {
    throw new Refused(`key frames ${hasBase ? "with" : "without"} a floating base, unlike this robot`);
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
    if (!(now > before)) throw new Refused(`a key frame at ${at} s follows one at ${before} s`);
    keys.push({ time: now, q: configuration(about, hasBase, joints, values) });
  }
  return { frames: new KeyFrames(keys, interpolation), time: timeOf(time) };
}

function timeOf(text: string) {
  const time = NUMBER.test(text) ? Number(text) : NaN;
  if (!(time >= 0 && time <= LATEST)) {
    throw new Refused(`the time of a key frame is ${quoted(text)}, expected 0 to ${LATEST} s`);
  }
  return time;
}

function changed(before: number[], parts: string[], at: string) {
  if (parts.length !== before.length) {
    throw new Refused(`the key frame at ${quoted(at)} has ${parts.length} values, expected ${before.length}`);
  }
  return parts.map((part, i) => {
    if (part === "") return before[i];
    if (!WHOLE.test(part)) throw new Refused(`${quoted(part)} is not a value of a key frame`);
    return Number.parseInt(part, 36);
  });
}

function configuration(about: About, hasBase: boolean, joints: string[], whole: number[]) {
  const values = whole.map((value) => Number((value * ROUNDING).toFixed(6)));
  const zero = jointsAtZero(about, about.neutral);
  const start = hasBase ? withBase(zero, values.splice(0, BASE_COLUMNS.length)) : zero;
  const written = joints.map((name, i) => ({ name, value: values[i], line: 0 }));
  return unrounded(about, withValues(about, start, written), ROUNDING);
}
