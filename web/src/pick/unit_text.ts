import { spoken, unitOf, type Choice } from "../values/units.ts";

/**
 * A value of a coordinate as the panel writes it, with its unit.
 *
 * @param kind "rad", "m" or "1", as the coordinate is described
 */
export function unitText(value: number, kind: string, choice: Choice) {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  return spoken(value, unitOf(kind, choice));
}
