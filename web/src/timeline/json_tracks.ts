import { quoted } from "../values/names.ts";
import { DEGREE, MOST_ROWS, NoMotion, TIME_UNITS, isHand, type Track } from "./tracks.ts";

const FIELDS = ["format", "units", "interpolation", "joint_names", "times", "keys"];

/**
 * The joints of a JSON document, and what lies between their keys.
 *
 * @throws {NoMotion}
 */
export function fromJson(text: string) {
  const document = parsed(text);
  if (typeof document !== "object" || document === null || Array.isArray(document)) {
    throw new NoMotion("expected an object with joint_names, times and keys");
  }
  const { interpolation = "linear", joint_names: names, times, keys, units = {} } = document;
  if (interpolation === "bezier") {
    throw new NoMotion("Bézier curves are not read here; nao-kin motion convert --rate 50 samples them");
  }
  if (interpolation !== "linear" && interpolation !== "smooth") {
    throw new NoMotion(`interpolation is ${shown(interpolation)}, expected linear or smooth`);
  }
  for (const field of Object.keys(document)) {
    if (!FIELDS.includes(field) && document[field] !== null) throw new NoMotion(`unknown field ${quoted(field)}`);
  }
  for (const [field, list] of Object.entries({ joint_names: names, times, keys })) {
    if (!Array.isArray(list)) throw new NoMotion(`${field} is ${shown(list)}, expected a list`);
    if (list.length === 0) throw new NoMotion(`${field} is empty`);
    if (list.length > MOST_ROWS) {
      throw new NoMotion(`${field} has ${list.length} entries, more than ${MOST_ROWS}`);
    }
  }
  const scale = { time: unitOf(units, "time", TIME_UNITS), angle: unitOf(units, "angle", { rad: 1, deg: DEGREE }) };
  const nested = Array.isArray(times[0]);
  if (keys.length !== (nested ? names : times).length || (nested && times.length !== names.length)) {
    throw new NoMotion(
      `keys has ${keys.length} lists for ${nested ? `${names.length} joints` : `${times.length} times`}`,
    );
  }
  const width = nested ? null : names.length;
  const rows = keys.map((row: unknown, i: number) => numbers(row, `keys[${i}]`, width));
  const shared = nested ? null : numbers(times, "times", null);
  const tracks = names.map((name: unknown, joint: number) => {
    if (typeof name !== "string") throw new NoMotion(`joint_names[${joint}] is ${shown(name)}, expected a name`);
    const own = shared ?? numbers(times[joint], `times[${joint}]`, null);
    if (nested && own.length !== rows[joint].length) {
      throw new NoMotion(`${quoted(name)} has ${own.length} times and ${rows[joint].length} keys`);
    }
    const at = own.findIndex((time, i) => i > 0 && !(time > own[i - 1]));
    const where = nested ? `times[${joint}]` : "times";
    if (at > 0) throw new NoMotion(`${where}[${at}] is ${own[at]}, which does not come after ${own[at - 1]}`);
    if (own.length === 0) throw new NoMotion(`${quoted(name)} has no keys`);
    const values = nested ? rows[joint] : rows.map((row: number[]) => row[joint]);
    const factor = isHand(name) ? 1 : scale.angle;
    return {
      name,
      times: own.map((time) => time * scale.time),
      values: values.map((value: number) => value * factor),
    };
  });
  return { tracks: tracks as Track[], interpolation };
}

function parsed(text: string) {
  try {
    return JSON.parse(text);
  } catch (error) {
    const said = String((error as Error).message);
    const at = /position (\d+)/.exec(said);
    const line = at ? text.slice(0, Number(at[1])).split("\n").length : text.split("\n").length;
    throw new NoMotion(`line ${line}: malformed JSON`);
  }
}

function unitOf(units: any, quantity: string, known: Record<string, number>) {
  const unit = units?.[quantity] ?? Object.keys(known)[0];
  if (typeof unit === "string" && Object.hasOwn(known, unit)) return known[unit];
  throw new NoMotion(`unit of ${quantity} is ${shown(unit)}, expected ${Object.keys(known).join(" or ")}`);
}

function numbers(list: unknown, path: string, count: number | null): number[] {
  if (!Array.isArray(list)) throw new NoMotion(`${path} is ${shown(list)}, expected a list`);
  if (list.length > MOST_ROWS) throw new NoMotion(`${path} has ${list.length} numbers, more than ${MOST_ROWS}`);
  if (count !== null && list.length !== count) {
    throw new NoMotion(`${path} has ${list.length} numbers, expected ${count}`);
  }
  const at = list.findIndex((value) => typeof value !== "number" || !Number.isFinite(value));
  if (at >= 0) throw new NoMotion(`${path}[${at}] is ${shown(list[at])}, expected a finite number`);
  return list;
}

/** @param value from a file, for a message */
function shown(value: unknown) {
  if (value === undefined) return "missing";
  return quoted(typeof value === "string" ? value : (JSON.stringify(value) ?? String(value)).slice(0, 80));
}
