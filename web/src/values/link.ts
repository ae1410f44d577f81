import type { About } from "../types.ts";
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
}

const VERSION = "1";

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

type Reading = { about: About; toggles: readonly string[]; state: Partial<State> };

const READERS: Record<string, (value: string, reading: Reading) => Partial<State>> = {
  q(value, { about, state }) {
    const written = (value ? value.split(",") : []).map((part) => {
      const [name, number] = splitAt(part, ":");
      return { name: decoded(name), value: NUMBER.test(number) ? Number(number) : decoded(number), line: 0 };
    });
    return { q: withValues(about, jointsAtZero(about, state.q ?? about.neutral), written) };
  },
  base(value, { about, state }) {
    const base = numbersOf(value, 7, "base");
    if (!about.floating) throw new Refused("the link has a floating base, which this robot does not have");
    if (!(Math.hypot(...base.slice(3)) > 1e-3)) throw new Refused("a base with no orientation");
    return { q: [...base, ...(state.q ?? about.neutral).slice(base.length)] };
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
};

/** Write the part of a link after the #. Joints at zero are left out, as in `nao.configuration({…})`. */
export function writeLink(about: About, { q, up, camera, shown, units, frame }: State) {
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
  return parts.join("&");
}

/**
 * Read the state in a link; fields that the link leaves out are not in the result.
 *
 * @param toggles the overlays that a link may name
 * @throws {Refused}
 */
export function readLink(about: About, toggles: readonly string[], text: string): Partial<State> {
  const parts = new Map(text.split("&").map((part) => splitAt(part, "=")));
  if (parts.get("v") !== VERSION) throw new Refused(`${quoted(text)} is not a state of this page`);
  const state: Partial<State> = {};
  for (const [key, value] of parts) {
    if (key === "v") continue;
    if (!Object.hasOwn(READERS, key)) throw new Refused(`unknown field ${quoted(key)} in the link`);
    Object.assign(state, READERS[key](value, { about, toggles, state }));
  }
  return state;
}
