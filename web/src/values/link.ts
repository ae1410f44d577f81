import { KeyFrames, LATEST, type Key } from "../timeline/key_frames.ts";
import type { About } from "../types.ts";
import { unrounded } from "./configurations.ts";
import { Refused } from "./literals.ts";
import { quoted } from "./names.ts";
import { jointsAtZero, withValues } from "./reading.ts";
import type { Choice } from "./units.ts";

// Links give joints to a millionth: of a radian, that moves no hand by a micrometre.
export const ROUNDING = 1e-6;

const NUMBER = /^-?\d{1,9}(\.\d{1,17})?$/;

const rounded = (value: number, digits: number = 6) =>
  value
    .toFixed(digits)
    .replace(/\.?0+$/, "")
    .replace(/^-0$/, "0");

/** What is before the sign, and after it. */
function splitAt(text: string, sign: string): [string, string] {
  const at = text.indexOf(sign);
  return at < 0 ? [text, ""] : [text.slice(0, at), text.slice(at + 1)];
}

function decoded(text: string) {
  try {
    return decodeURIComponent(text);
  } catch {
    throw new Refused(`${quoted(text)} is no text of a link`);
  }
}

/** All that a link to a page says. */
interface State {
  q: number[];
  /** the vertical in the root's frame, null for what the robot stands on by itself */
  up: number[] | null;
  /** a preset, or the places of the camera and of what it looks at */
  camera: string | number[];
  /** what is drawn over the robot */
  shown: string[];
  units: Choice;
  /** whose pose is read out */
  frame: string;
  /** the key frames, if there are any */
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

/** A configuration with its base elsewhere. */
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
    if (!about.floating) throw new Refused("a base that moves, which this robot does not have");
    return { q: withBase(state.q ?? about.neutral, numbers) };
  },
  up(value) {
    const up = numbersOf(value, 3, "up");
    if (!(Math.hypot(...up) > 1e-3)) throw new Refused("up is no direction");
    return { up };
  },
  camera(value, { about }) {
    if (value.includes(",")) {
      const places = numbersOf(value, 6, "camera");
      if (places.every((x, i) => Math.abs(x - places[(i + 3) % 6]) < 1e-3)) {
        throw new Refused("a camera that looks at itself");
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
    shown: value ? value.split(",").map((name) => oneOf(decoded(name), toggles, "thing to show")) : [],
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
 * What stands after the # of a link. Joints at zero are left out, as `nao.configuration({…})` does; and key frames, where
 * there is no room for them.
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
 * What a link says; what it leaves out is not in the answer.
 *
 * @param toggles that a link may name
 * @throws {Refused}
 */
export function readLink(about: About, toggles: readonly string[], text: string): Partial<State> {
  if (text.length > LONGEST) {
    throw new Refused(`a link of ${text.length} characters, expected at most ${LONGEST}`);
  }
  const parts = new Map(text.split("&").map((part) => splitAt(part, "=") as [string, string]));
  const version = parts.get("v");
  if (version !== VERSION) {
    throw new Refused(
      version === undefined
        ? `${quoted(text)} is no state of this page`
        : `a link of version ${quoted(version)}, this page reads ${VERSION}`,
    );
  }
  const state: Partial<State> = {};
  for (const [key, value] of parts) {
    if (key === "v") continue;
    if (!Object.hasOwn(READERS, key)) throw new Refused(`nothing is called ${quoted(key)} in a link`);
    Object.assign(state, READERS[key](value, { about, toggles, state }));
  }
  return state;
}

/** key frames, and the time that is on show [s] */
interface KeysShown {
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
const LONGEST_KEYS = 9000;

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
    throw new Refused(`key frames ${hasBase ? "with" : "without"} a base that moves, unlike this robot`);
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
    if (!(now > before)) throw new Refused(`a key frame at ${at} s behind one at ${before} s`);
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
    if (!WHOLE.test(part)) throw new Refused(`${quoted(part)} is no value of a key frame`);
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
