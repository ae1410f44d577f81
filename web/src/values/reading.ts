import type { About } from "../types.ts";
import type { Track } from "../timeline/motion.ts";
import { Call, Refused, decimal, readRecords, readStatements, type Entry, type Value } from "./literals.ts";
import { isHand, quoted, unknown } from "./names.ts";

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
export function withValues(about: About, q: ArrayLike<number>, written: Entry[]) {
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
      const { lower, upper, unit } = about.coordinates.find(({ column }) => column === joint.column) ?? {};
      const low = lower ?? -FURTHEST_OPEN;
      const high = upper ?? FURTHEST_OPEN;
      if (!(coordinate >= low - FURTHEST && coordinate <= high + FURTHEST)) {
        const degrees =
          unit === "rad" && Math.abs(coordinate) <= 360 ? "; values are radians, this looks like degrees" : "";
        throw fail(`${name} is ${value}${unit === "1" ? "" : ` ${unit}`}, far outside its limits${degrees}`);
      }
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

/** What a text has: values of joints, or the keys of a motion. */
interface Read {
  kind: string;
  written: Entry[];
  others?: "zero";
  tracks?: Track[];
}

function fromCsv(text: string): Entry[] {
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

const KNOWN = /^(configuration|setAngles|angleInterpolation(WithSpeed|Bezier)?)$/;

function fromCall(about: About, call: Call): Read {
  const { name, line } = call;
  const fail = (reason: string) => new Refused(`line ${line}: ${reason}`);
  if (name === "configuration") {
    const [joints] = call.given;
    if (!(joints instanceof Call)) throw fail(`${name} without {joint: value}`);
    return { kind: "Python", written: joints.named, others: "zero" };
  }
  const given = call.argument(0, "names", "jointNames");
  const names = (Array.isArray(given) ? given : [given]).flatMap((entry) => {
    if (typeof entry !== "string") throw fail(`${name} without the names of joints`);
    return jointsOf(about, entry);
  });
  const [anglesAt, timesAt] = name.endsWith("Bezier") ? [2, 1] : [1, 2];
  const angles = call.argument(anglesAt, "angles", "angleLists", "targetAngles", "controlPoints");
  if (angles === undefined) throw fail(`${name} without angles`);
  const absolute = call.argument(3, "isAbsolute");
  if (name === "angleInterpolation" && (absolute === 0 || shown(absolute ?? 1) === "False")) {
    throw fail(`${name} with relative angles, expected absolute ones`);
  }
  // Each joint has a list of keys; a single key may stand without one, and so may the list of a single joint.
  const perJoint = (value: Value) =>
    names.length === 1 && !(Array.isArray(value) && Array.isArray(value[0])) ? [value] : value;
  const lists = perJoint(angles);
  if (!Array.isArray(lists) || lists.length !== names.length) {
    throw fail(`${names.length} names and ${Array.isArray(lists) ? lists.length : 1} angles`);
  }
  // A key of Choregraphe is a list of the angle and two handles of a curve.
  const keys = lists.map((list) =>
    (Array.isArray(list) ? list : [list]).map((key) => (Array.isArray(key) ? key[0] : key)),
  );
  if (keys.every(({ length }) => length === 1)) {
    return { kind: name, written: names.map((joint, i) => ({ name: joint, value: keys[i][0], line })) };
  }
  const times = perJoint(call.argument(timesAt, "timeLists", "times") ?? []);
  const tracks = names.map((joint, i) => {
    const own = Array.isArray(times) ? times[i] : undefined;
    const values = keys[i];
    const isAscending = isNumbers(own) && own.every((time, at) => at === 0 || time > own[at - 1]);
    if (!isAscending || !isNumbers(values) || own.length !== values.length) {
      throw fail(`${values.length} keys of ${quoted(joint)}, expected numbers and as many ascending times`);
    }
    return { name: joint, times: own, values };
  });
  return { kind: name, written: [], tracks };
}

const isDictionary = (value: Value | undefined) => value instanceof Call && value.name === "dict";
const isNumbers = (value: Value | undefined): value is number[] =>
  Array.isArray(value) && value.every((entry) => typeof entry === "number" && Number.isFinite(entry));

/** The joints that a name of NAOqi stands for, in NAOqi's order, as in nao_kin.naoqi.names. */
function jointsOf({ naoqi, chains, joints }: About, name: string): string[] {
  if (joints.some((joint) => joint.name === name)) return [name];
  if (/^(Body|JointActuators)$/.test(name)) return naoqi;
  if (name === "Joints") return naoqi.filter((joint) => !isHand(joint));
  if (name === "Actuators") return naoqi.filter(isHand);
  const titles = /^(Arm|Leg)s$/.test(name) ? ["L", "R"].map((side) => side + name.slice(0, -1)) : [name];
  const found = titles.flatMap((title) => chains.find((chain) => chain.title === title)?.joints ?? []);
  return found.length > 0 ? found.map((joint) => joint.name) : [name];
}

function shown(value: Value) {
  if (typeof value === "string") return quoted(value);
  if (typeof value === "number") return Number.isNaN(value) ? "not a number" : "a number too large for floating point";
  if (Array.isArray(value)) return "a list";
  if (value instanceof Call) return isDictionary(value) ? "an object" : `a call of ${quoted(value.name)}`;
  return value.unknown.slice(0, 40);
}

/** Values without names: the robot's joint values in the order of q, or the values of NAOqi's Body. */
function numbered({ coordinates, naoqi }: About, values: number[]): Read {
  const own = coordinates.map(({ joint }) => joint);
  const names = values.length === own.length ? own : naoqi;
  if (values.length !== names.length) {
    const body = naoqi.length ? ` (q) or ${naoqi.length} (NAOqi's Body)` : "";
    throw new Refused(`a list of ${values.length} numbers, expected ${own.length}${body}`);
  }
  return { kind: "a list", written: names.map((name, i) => ({ name, value: values[i], line: 0 })) };
}

function recognised(about: About, text: string): Read[] {
  // A first line without these characters is the header of a CSV; a joint's name contains them only in quotes.
  const first = text.trimStart().split("\n", 1)[0];
  const isBare = /^[\d\s.,;e+-]+$/i.test(text);
  if (!isBare && !/[[{(=]|^(#|"""|(import|from)\b)/.test(first)) return [{ kind: "CSV", written: fromCsv(text) }];
  const { values, set, names } = readStatements(isBare ? `[${text}]` : text);
  const calls = values.filter((value) => value instanceof Call).filter(({ name }) => name !== "dict");
  const known = calls.filter(({ name }) => KNOWN.test(name));
  if (known.length > 0) return known.map((call) => fromCall(about, call));
  // Choregraphe's export, whose call may be missing.
  const parts = ["names", "keys", "times"].map((name) => names.get(name) ?? "");
  if (parts.every(Array.isArray)) {
    return [fromCall(about, Object.assign(new Call("angleInterpolation", 1), { given: parts }))];
  }
  const last = values.at(-1) ?? "";
  const whole = Array.isArray(last) && last.length === 1 ? last[0] : last;
  if (whole instanceof Call && isDictionary(whole)) return [{ kind: "JSON", written: whole.named }];
  const count = Array.isArray(whole) && whole.every(isDictionary) ? whole.length : 0;
  if (count > 1) throw new Refused(`a list of ${count} configurations, expected one`);
  const joints = set.filter((entry) => about.joints.some(({ name }) => name === entry.name));
  if (joints.length > 0) return [{ kind: "Python", written: joints }];
  const row = values
    .map((value) => (Array.isArray(value) && value.length === 1 ? value[0] : value))
    .findLast((value) => Array.isArray(value));
  if (isNumbers(row)) return [numbered(about, row)];
  const expected = "configuration, setAngles, angleInterpolation";
  const found = calls.at(-1);
  if (found) throw new Refused(`line ${found.line}: a call of ${quoted(found.name)}, expected one of ${expected}`);
  throw new Refused(`no joint values found; expected JSON, CSV, a list of numbers, or a call of ${expected}`);
}

/**
 * Read the configuration, or the motion, in a text: JSON, CSV, Python or calls of NAOqi. Several calls add up.
 *
 * Joints that the text does not name keep their values; with `configuration({…})` they are at zero, as in Python.
 *
 * @param q the configuration shown
 * @throws {Refused}
 */
export function readConfiguration(about: About, q: ArrayLike<number>, text: string) {
  if (text.length > LONGEST) {
    throw new Refused(`a text of ${text.length} characters; a configuration has at most ${LONGEST}`);
  }
  const trimmed = text
    .replace(/^\uFEFF/, "")
    .replaceAll("−", "-")
    .trimEnd();
  if (!trimmed.trim()) throw new Refused("an empty text; expected joint names and values");
  const found = recognised(about, trimmed);
  const values = found.reduce(
    (before, { written, others }) => withValues(about, others ? jointsAtZero(about, before) : before, written),
    Array.from(q),
  );
  const { kind } = found[found.length - 1];
  const count = new Set(found.flatMap(({ written }) => written.map(({ name }) => name))).size;
  return { q: values, kind, count, tracks: found.findLast(({ tracks }) => tracks)?.tracks };
}
