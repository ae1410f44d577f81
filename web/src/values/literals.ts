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

// Reads the syntax in which configurations are written: JSON, and the part of Python that assigns names to values and calls
// a function with them. Nothing is executed.

export type Value = number | string | Value[] | Entries | Call | Name;
interface Name {
  kind: "name";
  name: string;
}

/** The entries of an object, in order and including repeated keys. */
export class Entries {
  list: { key: string; value: Value; line: number }[] = [];
}

/** A call: the last part of the function's name, and the arguments. */
export class Call {
  constructor(
    readonly name: string,
    readonly given: Value[],
    readonly named: Map<string, Value>,
    readonly line: number,
  ) {}
}

// The deepest nesting of lists and calls that is read.
const DEEPEST = 8;

const SPACE = /(?:[\s;]|#[^\n]*|\\\r?\n)*/y;
const NUMBER = /[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?(?![\w.])/iy;
const WORD = /[+-]?[\p{L}_][\p{L}\p{N}_]*(?:\s*\.\s*[\p{L}_][\p{L}\p{N}_]*)*/uy;
const STRING = /"((?:[^"\\\n]|\\[^\n])*)"|'((?:[^'\\\n]|\\[^\n])*)'/y;
const ESCAPES = /\\(?:u([0-9a-f]{4})|x([0-9a-f]{2})|(.))/gi;

const ESCAPED: Record<string, string> = { n: "\n", t: "\t", r: "\r", b: "\b", f: "\f" };

class Reader {
  at = 0;
  counted = { at: 0, line: 1 };
  names: Map<string, Value> = new Map();

  constructor(readonly text: string) {}

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

  take(sign: string) {
    this.match(SPACE);
    if (!this.text.startsWith(sign, this.at)) return false;
    this.at += sign.length;
    return true;
  }

  statements() {
    const values = [];
    this.match(SPACE);
    while (this.at < this.text.length) {
      const value = this.value(0);
      if (this.take("=")) {
        if (!isName(value)) throw this.fail("a name before =");
        const given = this.value(0);
        this.names.set(value.name, given);
        values.push(given);
      } else {
        values.push(value);
      }
      this.match(SPACE);
    }
    return values;
  }

  value(depth: number): Value {
    if (depth > DEEPEST) throw new Refused(`line ${this.line}: lists are nested too deeply`);
    this.match(SPACE);
    if (this.take("{")) return this.entries(depth + 1);
    if (this.take("[")) return this.list("]", depth + 1);
    if (this.take("(")) return this.list(")", depth + 1);
    const number = this.match(NUMBER);
    if (number) return Number(number[0]);
    const string = this.match(STRING);
    if (string) return unescaped(string[1] ?? string[2]);
    const word = this.match(WORD);
    if (!word) throw this.fail("a value");
    const name = word[0].replace(/\s/g, "");
    if (this.take("(")) return this.call(name, depth + 1);
    return this.names.get(name) ?? { kind: "name", name };
  }

  list(end: string, depth: number) {
    const values: Value[] = [];
    while (!this.take(end)) {
      values.push(this.value(depth));
      if (!this.take(",") && !this.ends(end) && !this.goesOn(values)) throw this.fail(`, or ${end}`);
    }
    return values;
  }

  /** Whether the next number follows these after blanks only, as NumPy prints arrays. */
  goesOn(values: Value[]) {
    NUMBER.lastIndex = this.at;
    return typeof values.at(-1) === "number" && /\s/.test(this.text[this.at - 1]) && NUMBER.test(this.text);
  }

  entries(depth: number) {
    const entries = new Entries();
    while (!this.take("}")) {
      this.match(SPACE);
      const { line } = this;
      const key = this.match(STRING);
      if (!key) throw this.fail("a joint's name in quotes");
      if (!this.take(":")) throw this.fail(":");
      entries.list.push({ key: unescaped(key[1] ?? key[2]), value: this.value(depth), line });
      if (!this.take(",") && !this.ends("}")) throw this.fail(", or }");
    }
    return entries;
  }

  call(name: string, depth: number) {
    const { line } = this;
    const given: Value[] = [];
    const named: Map<string, Value> = new Map();
    while (!this.take(")")) {
      const value = this.value(depth);
      if (isName(value) && this.take("=")) named.set(value.name, this.value(depth));
      else given.push(value);
      if (!this.take(",") && !this.ends(")")) throw this.fail(", or )");
    }
    // NumPy's number types as it prints them, such as np.float64(0.5).
    if (/\bfloat(32|64)$/.test(name) && given.length === 1 && typeof given[0] === "number") return given[0];
    return new Call(name.slice(name.lastIndexOf(".") + 1), given, named, line);
  }

  ends(sign: string) {
    this.match(SPACE);
    return this.text.startsWith(sign, this.at);
  }
}

export function isName(value: Value): value is Name {
  return typeof value === "object" && !Array.isArray(value) && "kind" in value && value.kind === "name";
}

function unescaped(text: string) {
  return text.replace(ESCAPES, (_, four, two, letter) =>
    letter === undefined ? String.fromCharCode(parseInt(four ?? two, 16)) : (ESCAPED[letter] ?? letter),
  );
}

/**
 * Read the values of the statements of a text; names that the text assigned are replaced by their values.
 *
 * @throws {Refused}
 */
export function readStatements(text: string): Value[] {
  return new Reader(text).statements();
}
