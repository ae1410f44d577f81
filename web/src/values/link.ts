import { readKeys, writeKeys, type KeysShown } from "../timeline/key_text.ts";
import type { About } from "../types.ts";
import { quoted } from "./names.ts";
import { NoConfiguration, withValues } from "./reading.ts";
import type { Choice } from "./units.ts";

// The pieces that a link is made of.

// Links give joints to a millionth: of a radian, that moves no hand by a micrometre.
export const ROUNDING = 1e-6;

export const NUMBER = /^-?\d{1,9}(\.\d{1,17})?$/;

export const rounded = (value: number, digits: number = 6) =>
  value
    .toFixed(digits)
    .replace(/\.?0+$/, "")
    .replace(/^-0$/, "0");

/** @returns what is before the sign, and after it */
export function splitAt(text: string, sign: string): [string, string] {
  const at = text.indexOf(sign);
  return at < 0 ? [text, ""] : [text.slice(0, at), text.slice(at + 1)];
}

export function decoded(text: string) {
  try {
    return decodeURIComponent(text);
  } catch {
    throw new NoConfiguration(`${quoted(text)} is no text of a link`);
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
    throw new NoConfiguration(`${what} is ${quoted(text)}, expected ${count} numbers`);
  }
  return parts.map(Number);
}

function oneOf(name: string, valid: readonly string[], kind: string) {
  if (!valid.includes(name)) throw new NoConfiguration(`unknown ${kind} ${quoted(name)}`);
  return name;
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
    const start = state.q ?? [...about.neutral];
    for (const { column } of about.coordinates) start[column] = 0;
    return { q: withValues(about, start, written) };
  },
  base(value, { about, state }) {
    const numbers = numbersOf(value, 7, "base");
    if (!about.floating) throw new NoConfiguration("a base that moves, which this robot does not have");
    if (!(Math.hypot(...numbers.slice(3)) > 1e-3)) throw new NoConfiguration("a base with no orientation");
    return { q: [...numbers, ...(state.q ?? about.neutral).slice(7)] };
  },
  up(value) {
    const up = numbersOf(value, 3, "up");
    if (!(Math.hypot(...up) > 1e-3)) throw new NoConfiguration("up is no direction");
    return { up };
  },
  camera(value, { about }) {
    if (value.includes(",")) {
      const places = numbersOf(value, 6, "camera");
      if (places.every((x, i) => Math.abs(x - places[(i + 3) % 6]) < 1e-3)) {
        throw new NoConfiguration("a camera that looks at itself");
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
      throw new NoConfiguration(`units are ${quoted(value)}, expected deg or rad, and mm or m`);
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
 * @param text what stands after the #
 * @throws {NoConfiguration}
 */
export function readLink(about: About, toggles: readonly string[], text: string): Partial<State> {
  if (text.length > LONGEST) {
    throw new NoConfiguration(`a link of ${text.length} characters, expected at most ${LONGEST}`);
  }
  const parts = new Map(text.split("&").map((part) => splitAt(part, "=") as [string, string]));
  const version = parts.get("v");
  if (version !== VERSION) {
    throw new NoConfiguration(
      version === undefined
        ? `${quoted(text)} is no state of this page`
        : `a link of version ${quoted(version)}, this page reads ${VERSION}`,
    );
  }
  const state: Partial<State> = {};
  for (const [key, value] of parts) {
    if (key === "v") continue;
    if (!Object.hasOwn(READERS, key)) throw new NoConfiguration(`nothing is called ${quoted(key)} in a link`);
    Object.assign(state, READERS[key](value, { about, toggles, state }));
  }
  return state;
}
