import { DEGREE } from "../math/numbers.ts";

/** The error of a text that cannot be read, or of values that cannot be written; the message says what is wrong, and where. */
export class Refused extends Error {}

const DECIMAL = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

/** The value of a decimal number; NaN if the text is not one. */
export const decimal = (text: string) => (DECIMAL.test(text) ? Number(text) : NaN);

const DELIMITERS = [",", ";", "\t"];

/**
 * Read the records of a CSV text and the lines in which they begin. The header line determines the delimiter; empty records
 * are left out.
 *
 * @throws {Refused}
 */
export function readRecords(text: string): { fields: string[]; line: number }[] {
  const header = text.replace(/^[\r\n]+/, "").split("\n", 1)[0];
  const count = (sign: string) => header.split(sign).length;
  const delimiter = DELIMITERS.reduce((best, sign) => (count(sign) > count(best) ? sign : best));
  const records = [];
  const unquoted = new RegExp(`[^${delimiter}\r\n]*`, "y");
  const quoted = /"((?:[^"]|"")*)"/y;
  let [at, line] = [0, 1];
  while (at < text.length) {
    const begin = line;
    const fields = [];
    for (;;) {
      const pattern = text[at] === '"' ? quoted : unquoted;
      pattern.lastIndex = at;
      const found = pattern.exec(text);
      if (!found) throw new Refused(`line ${line}: a quotation mark that is not closed`);
      at = pattern.lastIndex;
      line += found[0].split("\n").length - 1;
      fields.push((found[1]?.replaceAll('""', '"') ?? found[0]).trim());
      if (text[at] !== delimiter) break;
      at += 1;
    }
    if (at < text.length && !/[\r\n]/.test(text[at])) {
      throw new Refused(`line ${line}: text after a closing quotation mark`);
    }
    if (text[at] === "\r" && text[at + 1] === "\n") at += 1;
    at += 1;
    line += 1;
    if (fields.some(Boolean)) records.push({ fields, line: begin });
  }
  return records;
}

// Reads JSON, and the part of Python that sets names and calls functions: NAOqi's scripts, Choregraphe's exports, printed
// arrays. Degrees become radians; nothing is calculated or executed.

export type Value = number | string | Value[] | Call | Name;
interface Name {
  unknown: string;
}
/** A name and its value, and the line of the text, 0 if it is unknown. */
export interface Entry {
  name: string;
  value: Value;
  line: number;
}

/** A call: the last part of the function's name and the arguments. A dictionary is a call of `dict`. */
export class Call {
  given: Value[] = [];
  named: Entry[] = [];

  constructor(
    readonly name: string,
    readonly line: number,
  ) {}

  /** The argument at a position, or of one of these names. */
  argument(position: number, ...names: string[]): Value | undefined {
    return this.named.find(({ name }) => names.includes(name))?.value ?? this.given[position];
  }
}

// The deepest nesting of lists and calls, and the largest number of values of lists in degrees, that are read.
const DEEPEST = 8;
const MOST_SCALED = 100_000;

const SPACE = /(?:\s|#[^\n]*|\\\r?\n)*/y;
const STATEMENT_END = /[ \t]*(?:#[^\n]*)?(?:$|[;\r\n])/y;
const NUMBER = /(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?(?![\w.])/iy;
const WORD = /[\p{L}_][\p{L}\p{N}_]*/uy;
const STRING = /"((?:[^"\\\n]|\\[^\n])*)"|'((?:[^'\\\n]|\\[^\n])*)'/y;
// Behind a value, or before one, in degrees.
const IN_DEGREES = /[ \t]*\*[ \t]*(?:[\p{L}_][\p{L}\p{N}_]*\.)*TO_RAD(?![\p{L}\p{N}_.])/uy;
const DEGREES_OF = /(?:[\p{L}_][\p{L}\p{N}_]*\.)*TO_RAD[ \t]*\*/uy;
// Numbers between blanks, as NumPy prints an array.
const ROW = /\[\s*([-+]?[\d.]+(?:e[-+]?\d+)?(?:\s+[-+]?[\d.]+(?:e[-+]?\d+)?)+)\s*\]/iy;
const ENTRY = /(?:"((?:[^"\\\n]|\\[^\n])*)"|'((?:[^'\\\n]|\\[^\n])*)')\s*:/y;
// A name, or a key in brackets, that is set.
const TARGET = /(?:[\p{L}_][\p{L}\p{N}_]*\.)*([\p{L}_][\p{L}\p{N}_]*)(?:\[["']([^"'\n]*)["']\])? *=(?!=)/uy;

// What a script has beside values: texts in triple quotation marks, and lines that begin with these words.
const QUOTED = /("""|''')[^]*?\1/g;
const SKIPPED =
  /^[ \t]*(?:(?:import|from|class|def|try|except|finally|if|elif|else|while|with|return|print|pass|raise|global)\b|for\b.*:).*$/gm;

/** The statements of a text: the values of all, in order, and what they set. */
class Reader {
  at = 0;
  counted = { at: 0, line: 1 };
  scaledValues = 0;
  values: Value[] = [];
  set: Entry[] = [];
  names: Map<string, Value> = new Map();

  constructor(readonly text: string) {
    while (this.ends(";") || this.at < text.length) {
      if (this.take(";")) continue;
      const { line } = this;
      const target = this.match(TARGET);
      const value = this.value(0);
      this.values.push(value);
      if (target) {
        this.names.set(target[1], value);
        this.set.push({ name: target[2] ?? target[1], value, line });
      }
      if (!this.match(STATEMENT_END)) throw this.fail("the end of the line");
    }
  }

  // Counts on from the last call, because counting from the start for every entry would be slow in a long text.
  get line() {
    const { counted } = this;
    for (; counted.at < this.at; counted.at++) if (this.text[counted.at] === "\n") counted.line += 1;
    return counted.line;
  }

  fail(expected: string) {
    const found = this.text.slice(this.at, this.at + 20).split("\n")[0];
    return new Refused(`line ${this.line}: expected ${expected}, found ${found ? `"${found}"` : "the end"}`);
  }

  /** @param pattern sticky */
  match(pattern: RegExp) {
    pattern.lastIndex = this.at;
    const found = pattern.exec(this.text);
    if (found) this.at = pattern.lastIndex;
    return found;
  }

  ends(sign: string) {
    this.match(SPACE);
    return this.text.startsWith(sign, this.at);
  }

  take(sign: string) {
    const is = this.ends(sign);
    if (is) this.at += sign.length;
    return is;
  }

  value(depth: number): Value {
    this.match(SPACE);
    const isBehind = this.match(DEGREES_OF) !== null;
    const value = this.atom(depth);
    return isBehind || this.match(IN_DEGREES) ? this.scaled(value, DEGREE) : value;
  }

  atom(depth: number): Value {
    if (depth > DEEPEST) throw new Refused(`line ${this.line}: lists are nested too deeply`);
    if (this.take("-")) return this.scaled(this.atom(depth + 1), -1);
    if (this.take("+")) return this.atom(depth + 1);
    const row = this.match(ROW);
    if (row) return row[1].split(/\s+/).map(Number);
    if (this.take("{")) return this.arguments("dict", "}", depth + 1);
    if (this.take("[")) return this.arguments("", "]", depth + 1).given;
    if (this.take("(")) {
      const { given } = this.arguments("", ")", depth + 1);
      return given.length === 1 ? given[0] : given;
    }
    const found = this.match(NUMBER) ?? this.match(STRING);
    if (found) return found.length === 1 ? Number(found[0]) : unescaped(found);
    let name = this.word();
    let value: Value = this.names.get(name) ?? { unknown: name };
    while (/[.(]/.test(this.text[this.at])) {
      if (this.take("(")) value = this.called(this.arguments(name, ")", depth + 1), value);
      else {
        this.at += 1;
        name = this.word();
        if (!this.ends("(")) value = this.names.get(name) ?? { unknown: name };
      }
    }
    return value;
  }

  word() {
    const word = this.match(WORD);
    if (!word) throw this.fail("a value");
    return word[0];
  }

  /** Read the arguments of a call, the values of a list or the entries of a dictionary. */
  arguments(name: string, end: string, depth: number) {
    const call = new Call(name, this.line);
    while (!this.take(end)) {
      const { line } = this;
      const key = this.match(end === "}" ? ENTRY : TARGET);
      if (end === "}" && !key) throw this.fail("a joint's name in quotes");
      const value = this.value(depth);
      if (key) call.named.push({ name: unescaped(key), value, line });
      else call.given.push(value);
      if (!this.take(",") && !this.ends(end)) throw this.fail(`, or ${end}`);
    }
    return call;
  }

  /** @param object that a method is called of */
  called(call: Call, object: Value): Value {
    const [first = []] = call.given;
    if (/^(radians|deg2rad)$/.test(call.name)) return this.scaled(first, DEGREE);
    if (/^(array|asarray|tensor|list|tuple|float(32|64)?)$/.test(call.name)) return first;
    if (call.name === "tolist") return object;
    if (call.name === "append" && Array.isArray(object)) object.push(first);
    return call;
  }

  /** A number, or those of a list, times a factor; NaN where there is no number. */
  scaled(value: Value, factor: number): Value {
    const times = (entry: Value) => (typeof entry === "number" ? entry * factor : NaN);
    if (!Array.isArray(value)) return times(value);
    this.scaledValues += value.length;
    if (this.scaledValues > MOST_SCALED) throw new Refused(`line ${this.line}: lists are too long`);
    return value.map(times);
  }
}

/** The first group of a match that is there, without backslashes. */
const unescaped = ([, ...groups]: RegExpExecArray) =>
  (groups.find((group) => group !== undefined) ?? "").replace(/\\(.)/g, "$1");

/**
 * Read the statements of a text.
 *
 * @throws {Refused}
 */
export const readStatements = (text: string) =>
  new Reader(text.replace(QUOTED, (quoted) => quoted.replace(/[^\n]/g, "")).replace(SKIPPED, ""));
