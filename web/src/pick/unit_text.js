import { spoken, unitOf } from "../values/units.js";

/**
 * A value of a coordinate as the panel writes it, with its unit.
 *
 * @param {number} value
 * @param {string} kind "rad", "m" or "1", as the coordinate is described
 * @param {import("../values/units.js").Choice} choice
 */
export function unitText(value, kind, choice) {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  return spoken(value, unitOf(kind, choice));
}
