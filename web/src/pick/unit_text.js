import { UNITS } from "../panel/units.js";

/** @type {Record<string, { sign: string, scale: number, digits: number }>} */
const KNOWN = UNITS;

/**
 * A value of a coordinate as the panel writes it, with its unit.
 *
 * @param {number} value
 * @param {string} unit that the coordinate is described with
 */
export function unitText(value, unit) {
  const { scale, digits, sign } = KNOWN[unit] ?? KNOWN.rad;
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const number = (value * scale).toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1");
  return `${number}${sign === "°" ? "" : " "}${sign}`;
}
