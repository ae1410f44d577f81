import type { About } from "../types.ts";
import { Call, Entries, Refused, decimal, isName, readRecords, readStatements, type Value } from "./literals.ts";
import { isHand, quoted, unknown } from "./names.ts";

/** A joint's value as it was written, and its line, 0 if it is unknown. */
interface Written {
  name: string;
  value: Value;
  line: number;
}

// The longest text that is read: about thirty times the length of a NAO's configuration.
const LONGEST = 100_000;

// How far the values of two joints that share a motor may differ, as in nao_kin.robot.
const COUPLING_TOLERANCE = 1e-6;

// Values farther outside the limits than this, or from zero without limits, are refused [rad, m].
const FURTHEST = 2 * Math.PI;
const FURTHEST_OPEN = 1000;

/**
 * Set some joints of a configuration to new values.
 *
 * @throws {Refused} an unknown joint, a joint given twice, a value that is not a number, two joints of one motor with
 *   different values, a value far outside the limits
 */
export function withValues(about: About, q: ArrayLike<number>, written: Written[]) {
  const joints = new Map(about.joints.map((joint) => [joint.name, joint]));
  const set: Map<number, { name: string; value: number }> = new Map();
  const seen = new Set();
  const result = Array.from(q);
  for (const { name, value, line } of written) {
    const fail = (reason: string) => new Refused(`${line ? `line ${line}: ` : ""}${reason}`);
    const joint = joints.get(name);
    if (!joint) throw fail(unknown(name, [...joints.keys()]));
    if (seen.has(name)) throw fail(`joint ${quoted(name)} is given twice`);
    seen.add(name);
    if (typeof value !== "number" || !Number.isFinite(value)) {
      throw fail(`${name} is ${shown(value)}, expected a finite number`);
    }
    // A joint with multiplier 0 does not move, so its value is ignored.
    if (joint.multiplier === 0) continue;
    const coordinate = (value - joint.offset) / joint.multiplier;
    const before = set.get(joint.column);
    if (before && Math.abs(before.value - coordinate) * Math.abs(joint.multiplier) > COUPLING_TOLERANCE) {
      throw fail(`${before.name} and ${name} share one motor, and their values disagree`);
    }
    if (!before) {
      checkSize(about, joint.column, coordinate, name, value, fail);
      set.set(joint.column, { name, value: coordinate });
      result[joint.column] = coordinate;
    }
  }
  return result;
}

/** A configuration with all joints at zero; a floating base stays. */
export function jointsAtZero({ coordinates }: Pick<About, "coordinates">, q: ArrayLike<number>) {
  const zero = Array.from(q);
  for (const { column } of coordinates) zero[column] = 0;
  return zero;
}

/** @param value of the coordinate */
function checkSize(
  about: About,
  column: number,
  value: number,
  name: string,
  given: number,
  fail: (reason: string) => Error,
) {
  const coordinate = about.coordinates.find((candidate) => candidate.column === column);
  const low = coordinate?.lower ?? -FURTHEST_OPEN;
  const high = coordinate?.upper ?? FURTHEST_OPEN;
  if (value >= low - FURTHEST && value <= high + FURTHEST) return;
  const unit = coordinate?.unit === "1" ? "" : ` ${coordinate?.unit}`;
  const degrees = unit === " rad" && Math.abs(value) <= 360 ? "; values are radians, this looks like degrees" : "";
  throw fail(`${name} is ${given}${unit}, far outside its limits${degrees}`);
}

function fromEntries({ list }: Entries) {
  return list.map(({ key, value, line }) => ({ name: key, value, line }));
}

function fromCsv(text: string): Written[] {
  const [header, ...rows] = readRecords(text);
  if (rows.length === 0) {
    throw new Refused("names without values; expected JSON, CSV, Python or NAOqi");
  }
  const [{ fields, line }] = rows;
  if (rows.length > 1) throw new Refused(`${rows.length} rows of values, expected one`);
  if (fields.length !== header.fields.length) {
    throw new Refused(`line ${line}: ${fields.length} values, the header names ${header.fields.length} joints`);
  }
  return header.fields.map((name, i) => ({
    name,
    value: Number.isNaN(decimal(fields[i])) ? fields[i] : decimal(fields[i]),
    line: name === "" ? header.line : line,
  }));
}

const CALLS: Record<
  string,
  (about: About, call: Call) => { kind: string; written: Written[]; others: "stay" | "zero" }
> = {
  configuration(_, { name, given: [joints], line }) {
    if (!(joints instanceof Entries)) throw new Refused(`line ${line}: ${name} without {joint: value}`);
    return { kind: "Python", written: fromEntries(joints), others: "zero" };
  },
  setAngles(about, call) {
    const { names, angles, line } = namesAndAngles(about, call);
    return { kind: "setAngles", written: paired(names, angles, line), others: "stay" };
  },
  angleInterpolation(about, call) {
    const { names, angles, line } = namesAndAngles(about, call);
    const absolute = call.named.get("isAbsolute") ?? call.given[3];
    if (absolute !== undefined && isName(absolute) && absolute.name === "False") {
      throw new Refused(`line ${line}: angleInterpolation with relative angles, expected absolute ones`);
    }
    // Each joint has a list of keys; a single key may stand without one.
    const keys = names.length === 1 && !Array.isArray(angles[0]) ? [angles] : angles;
    const single = keys.map((key, i) => {
      if (!Array.isArray(key)) return key;
      if (key.length !== 1) {
        throw new Refused(`line ${line}: ${key.length} keys for ${quoted(names[i] ?? "")}, expected one`);
      }
      return key[0];
    });
    return { kind: "angleInterpolation", written: paired(names, single, line), others: "stay" };
  },
};

/** The joints that a name of NAOqi stands for, in NAOqi's order, as in nao_kin.naoqi.names. */
function jointsOf({ naoqi, chains, joints }: About, name: string): string[] {
  const within = (titles: string[]) =>
    titles.flatMap((title) => chains.find((chain) => chain.title === title)?.joints.map((joint) => joint.name) ?? []);
  if (joints.some((joint) => joint.name === name)) return [name];
  switch (name) {
    case "Body":
    case "JointActuators":
      return naoqi;
    case "Joints":
      return naoqi.filter((joint) => !isHand(joint));
    case "Actuators":
      return naoqi.filter(isHand);
    case "Arms":
    case "Legs":
      return within([`L${name.slice(0, -1)}`, `R${name.slice(0, -1)}`]);
    default:
      return chains.some(({ title }) => title === name) ? within([name]) : [name];
  }
}

/** The list in an array of NumPy; any other value is returned unchanged. */
const unwrapped = (value: Value) => (value instanceof Call && value.name === "array" ? value.given[0] : value);

/** The joint names and the angles of a call of NAOqi. */
function namesAndAngles(about: About, { name, given, named, line }: Call) {
  const first = named.get("names") ?? given[0];
  const second = unwrapped(named.get("angles") ?? named.get("angleLists") ?? given[1]);
  const list = Array.isArray(first) ? first : [first];
  const names = list.flatMap((entry) => {
    if (typeof entry !== "string") throw new Refused(`line ${line}: ${name} without the names of joints`);
    return jointsOf(about, entry);
  });
  if (second === undefined) throw new Refused(`line ${line}: ${name} without angles`);
  return { names, angles: Array.isArray(second) ? second : [second], line };
}

function paired(names: string[], values: Value[], line: number) {
  if (values.length !== names.length) {
    throw new Refused(`line ${line}: ${names.length} names and ${values.length} angles`);
  }
  return names.map((name, i) => ({ name, value: values[i], line }));
}

function shown(value: Value) {
  if (typeof value === "string") return quoted(value);
  if (typeof value === "number") return Number.isNaN(value) ? "not a number" : "a number too large for floating point";
  if (isName(value)) return value.name.slice(0, 40);
  return Array.isArray(value) ? "a list" : value instanceof Call ? `a call of ${quoted(value.name)}` : "an object";
}

/** The numbers of a list or array that contains only numbers, or a single row of them; else an empty list. */
function rowOf(value: Value): Value[] {
  const list = unwrapped(value);
  if (!Array.isArray(list)) return [];
  if (list.length === 1 && Array.isArray(list[0])) return rowOf(list[0]);
  return list.every((entry) => typeof entry === "number") ? list : [];
}

/** Read values without names: the robot's joint values in the order of q, or the values of NAOqi's Body. */
function numbered({ coordinates, naoqi }: About, values: Value[]) {
  const own = coordinates.map(({ joint }) => joint);
  const names = values.length === own.length ? own : naoqi;
  if (values.length !== names.length) {
    const body = naoqi.length ? ` (q) or ${naoqi.length} (NAOqi's Body)` : "";
    throw new Refused(`a list of ${values.length} numbers, expected ${own.length}${body}`);
  }
  return { kind: "a list", written: paired(names, values, 0), others: "stay" as const };
}

function recognised(about: About, text: string): { kind: string; written: Written[]; others: "stay" | "zero" } {
  // A first line without these characters is the header of a CSV; a joint's name contains them only in quotes.
  const first = text.trimStart().split("\n", 1)[0];
  if (/^[\d\s.,;e+-]+$/i.test(text)) return numbered(about, readStatements(`[${text}]`)[0] as Value[]);
  if (!/[[{(=]|^(#|(import|from)\b)/.test(first)) {
    return { kind: "CSV", written: fromCsv(text), others: "stay" };
  }
  const values = readStatements(text.replace(/^\s*(?:import|from)\s[^\n]*$/gm, ""));
  const calls = values.filter((value) => value instanceof Call);
  const call = calls.findLast(({ name }) => Object.hasOwn(CALLS, name));
  if (call) return CALLS[call.name](about, call);
  const last = values.at(-1);
  const whole = Array.isArray(last) && last.length === 1 ? last[0] : last;
  if (whole instanceof Entries) return { kind: "JSON", written: fromEntries(whole), others: "stay" };
  if (Array.isArray(whole) && whole.length > 1 && whole.every((value) => value instanceof Entries)) {
    throw new Refused(`a list of ${whole.length} configurations, expected one`);
  }
  const numbers = values.map(rowOf).findLast((row) => row.length > 0);
  if (numbers) return numbered(about, numbers);
  const known = Object.keys(CALLS).join(", ");
  const found = calls.at(-1);
  if (found) throw new Refused(`line ${found.line}: a call of ${quoted(found.name)}, expected one of ${known}`);
  throw new Refused(`no joint values found; expected JSON, CSV, a list of numbers, or a call of ${known}`);
}

/**
 * Read the configuration in a text: JSON, CSV, Python or a call of NAOqi.
 *
 * Joints that the text does not name keep their values; with `configuration({…})` they are at zero, as in Python.
 *
 * @param q the configuration shown
 * @throws {Refused}
 */
export function readConfiguration(
  about: About,
  q: ArrayLike<number>,
  text: string,
): { q: number[]; kind: string; count: number } {
  if (text.length > LONGEST) {
    throw new Refused(`a text of ${text.length} characters; a configuration has at most ${LONGEST}`);
  }
  const trimmed = text
    .replace(/^\uFEFF/, "")
    .replaceAll("−", "-")
    .trimEnd();
  if (!trimmed.trim()) throw new Refused("an empty text; expected joint names and values");
  const { kind, written, others } = recognised(about, trimmed);
  return { q: withValues(about, others === "zero" ? jointsAtZero(about, q) : q, written), kind, count: written.length };
}
