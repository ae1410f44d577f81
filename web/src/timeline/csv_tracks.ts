import { readRecords } from "../values/csv.ts";
import { Unreadable } from "../values/literals.ts";
import { quoted } from "../values/names.ts";
import { DEGREE, MOST_ROWS, NoMotion, TIME_UNITS, isHand, type Track } from "./tracks.ts";

const HEADING = /^([^[\]()]*?)\s*(?:[[(]\s*([^[\]()]*?)\s*[\])])?$/;
const HAND_UNITS: Record<string, number> = { 1: 1, "%": 0.01 };
const ANGLE_UNITS: Record<string, number> = { rad: 1, deg: DEGREE, "°": DEGREE, m: 1 };
const DECIMAL = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

/**
 * The joints of a CSV table: a header with units, a column of times, and one for each joint.
 *
 * @throws {NoMotion}
 */
export function fromCsv(text: string) {
  let rows = 0;
  for (let at = text.indexOf("\n"); at >= 0; at = text.indexOf("\n", at + 1)) rows += 1;
  if (rows > MOST_ROWS) throw new NoMotion(`${rows} rows, more than ${MOST_ROWS}`);
  const [header, ...records] = recordsOf(text);
  if (!header) throw new NoMotion("empty; expected a header with a column of times");
  const headings = header.fields.map((heading, column) =>
    headingOf(heading, `line ${header.line}, column ${column + 1}`),
  );
  const clocks = headings.filter(({ isTime }) => isTime);
  if (clocks.length !== 1) {
    throw new NoMotion(`line ${header.line}: ${clocks.length} columns of times, expected one, headed time [s]`);
  }
  if (records.length === 0) throw new NoMotion(`line ${header.line}: a header and no keys`);
  const clock = headings.indexOf(clocks[0]);
  const tracks: Track[] = headings.map(({ name }) => ({ name, times: [], values: [] }));
  let last = -Infinity;
  for (const { fields, line } of records) {
    if (fields.length !== headings.length) {
      throw new NoMotion(`line ${line}: ${fields.length} values, the header names ${headings.length} columns`);
    }
    const cells = fields.map((field, column) => {
      const value = field === "" ? NaN : DECIMAL.test(field) ? Number(field) * headings[column].scale : Infinity;
      if (Math.abs(value) < Infinity || field === "") return value;
      throw new NoMotion(
        `line ${line}, column ${column + 1}: ${headings[column].name} is ${quoted(field)}, expected a finite number`,
      );
    });
    const time = cells[clock];
    if (Number.isNaN(time)) throw new NoMotion(`line ${line}: a row without a time`);
    if (!(time > last)) throw new NoMotion(`line ${line}: time ${time} s does not come after ${last} s`);
    last = time;
    cells.forEach((value, column) => {
      if (Number.isNaN(value)) return;
      tracks[column].times.push(time);
      tracks[column].values.push(value);
    });
  }
  tracks.splice(clock, 1);
  const bare = tracks.find(({ times }) => times.length === 0);
  if (bare) throw new NoMotion(`${quoted(bare.name)} has no keys`);
  return tracks;
}

function recordsOf(text: string) {
  try {
    return readRecords(text);
  } catch (error) {
    if (error instanceof Unreadable) throw new NoMotion(error.message);
    throw error;
  }
}

function headingOf(heading: string, place: string) {
  const [, name, unit] = HEADING.exec(heading.slice(0, 1000)) ?? [];
  if (name === undefined) throw new NoMotion(`${place}: heading ${quoted(heading)}, expected a name and [unit]`);
  const isTime = /^(time|t)$/i.test(name);
  const units = isTime ? TIME_UNITS : isHand(name) ? HAND_UNITS : ANGLE_UNITS;
  if (unit !== undefined && !Object.hasOwn(units, unit)) {
    throw new NoMotion(
      `${place}: unit ${quoted(unit)} of ${quoted(name)}, expected one of ${Object.keys(units).join(", ")}`,
    );
  }
  return { name, isTime, scale: unit === undefined ? 1 : units[unit] };
}
