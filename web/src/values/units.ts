import { fixed } from "../math/numbers.ts";
import { decimal } from "./literals.ts";

/**
 * How a kind of number is shown and typed.
 *
 * `scale` times a value in rad, m or shares is the number shown; `step` is what an arrow key adds to it, ten times that
 * with Shift, a tenth with Ctrl or Alt. `open` is the range of a slider whose joint has no limits.
 */
export interface Unit {
  name: string;
  sign: string;
  scale: number;
  digits: number;
  step: number;
  open: [number, number];
}

/** Which unit stands for angles and which for lengths. */
export interface Choice {
  angle: "deg" | "rad";
  length: "mm" | "m";
}

const UNITS: Record<"deg" | "rad" | "mm" | "m" | "percent", Unit> = {
  deg: { name: "degrees", sign: "°", scale: 180 / Math.PI, digits: 1, step: 1, open: [-Math.PI, Math.PI] },
  rad: { name: "radians", sign: "rad", scale: 1, digits: 3, step: 0.01, open: [-Math.PI, Math.PI] },
  mm: { name: "millimetres", sign: "mm", scale: 1000, digits: 1, step: 1, open: [-1, 1] },
  m: { name: "metres", sign: "m", scale: 1, digits: 4, step: 0.001, open: [-1, 1] },
  percent: { name: "percent", sign: "%", scale: 100, digits: 0, step: 1, open: [0, 1] },
};

export const USUAL: Choice = { angle: "deg", length: "mm" };

// The largest number of characters of a typed number.
const LONGEST = 40;

/**
 * The unit in which coordinates of one kind are shown.
 *
 * @param kind the coordinate's unit in Python: "rad", "m" or "1"
 */
export function unitOf(kind: string, choice: Choice) {
  if (kind === "1") return UNITS.percent;
  return UNITS[kind === "m" ? choice.length : choice.angle];
}

/**
 * Write a value as a number without its unit.
 *
 * @param value in rad, m or as a share
 */
export const format = (value: number, { scale, digits: usual }: Unit, digits: number = usual) =>
  fixed(value * scale, digits);

/** Write a value with its unit. */
export const withUnit = (value: number, unit: Unit, digits?: number) =>
  `${format(value, unit, digits)}${unit.sign === "°" ? "" : " "}${unit.sign}`;

/** Write a value with its unit, with a space that does not break. */
export const spoken = (value: number, unit: Unit, digits?: number) =>
  withUnit(value, unit, digits).replace(" ", "\u00a0");

/** The value of a typed number; NaN if it is not a number. A decimal comma is read as a point. */
export function parse(text: string, unit: Unit) {
  const trimmed = text.trim();
  if (trimmed.length > LONGEST) return NaN;
  const sign = unit.sign.toLowerCase();
  const number = (trimmed.toLowerCase().endsWith(sign) ? trimmed.slice(0, -sign.length).trim() : trimmed)
    .replace(",", ".")
    .replaceAll("−", "-");
  const value = decimal(number) / unit.scale;
  return Number.isFinite(value) ? value : NaN;
}

/** A value changed by some steps, without rounding noise. */
export const stepped = (value: number, steps: number, { scale, step }: Unit) =>
  Number((value * scale + steps * step).toFixed(9)) / scale;

const STEPS: Record<string, number> = {
  ...{ ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1 },
  ...{ PageUp: 10, PageDown: -10, Home: -Infinity, End: Infinity },
};

/** The number of steps of a key, NaN for a key without any; ±Infinity is an end of the range. */
export function stepsOfKey({
  key,
  shiftKey,
  ctrlKey,
  altKey,
}: Pick<KeyboardEvent, "key" | `${"shift" | "ctrl" | "alt"}Key`>) {
  if (!Object.hasOwn(STEPS, key)) return NaN;
  const factor = shiftKey ? 10 : ctrlKey || altKey ? 0.1 : 1;
  return key.startsWith("Arrow") ? STEPS[key] * factor : STEPS[key];
}
