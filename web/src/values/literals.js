// Reads the little that a configuration is written in: JSON, and the part of Python that names values and calls one
// function with them. Nothing is executed.

/**
 * @typedef {number | string | Value[] | Entries | Call | Name} Value
 * @typedef {{ kind: "name", name: string }} Name
 */

/** What cannot be read, and where. */
export class Unreadable extends Error {}

/** The entries of an object, in their order and with repeated keys. */
export class Entries {
  /** @type {{ key: string, value: Value, line: number }[]} */
  list = [];
}

/** A call of a function by its last name, and what it was given. */
export class Call {
  /**
   * @param {string} name
   * @param {Value[]} given
   * @param {Map<string, Value>} named
   * @param {number} line
   */
  constructor(name, given, named, line) {
    this.line = line;
    this.name = name;
    this.given = given;
    this.named = named;
  }
}

// Lists within lists, and calls within calls, that are read.
const DEEPEST = 8;

const SPACE = /(?:[\s;]|#[^\n]*|\\\r?\n)*/y;
const NUMBER = /[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?(?![\w.])/iy;
const WORD = /[+-]?[\p{L}_][\p{L}\p{N}_]*(?:\s*\.\s*[\p{L}_][\p{L}\p{N}_]*)*/uy;
const STRING = /"((?:[^"\\\n]|\\[^\n])*)"|'((?:[^'\\\n]|\\[^\n])*)'/y;
const ESCAPES = /\\(?:u([0-9a-f]{4})|x([0-9a-f]{2})|(.))/gi;

/** @type {Record<string, string>} */
const ESCAPED = { n: "\n", t: "\t", r: "\r", b: "\b", f: "\f" };

class Reader {
  /** @param {string} text */
  constructor(text) {
    this.text = text;
    this.at = 0;
    this.counted = { at: 0, line: 1 };
    /** @type {Map<string, Value>} */
    this.names = new Map();
  }

  // Counted on from where it was asked for last, or a long text would be gone through for every entry.
  get line() {
    const { counted } = this;
    for (; counted.at < this.at; counted.at++) if (this.text[counted.at] === "\n") counted.line += 1;
    return counted.line;
  }

  /** @param {string} expected */
  fail(expected) {
    const found = this.text.slice(this.at, this.at + 20).split("\n")[0];
    return new Unreadable(`line ${this.line}: expected ${expected}, found ${found ? `"${found}"` : "the end"}`);
  }

  /** @param {RegExp} pattern sticky */
  match(pattern) {
    pattern.lastIndex = this.at;
    const found = pattern.exec(this.text);
    if (found) this.at = pattern.lastIndex;
    return found;
  }

  /** @param {string} sign */
  take(sign) {
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

  /**
   * @param {number} depth
   * @returns {Value}
   */
  value(depth) {
    if (depth > DEEPEST) throw new Unreadable(`line ${this.line}: lists in lists in lists`);
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

  /**
   * @param {string} end
   * @param {number} depth
   */
  list(end, depth) {
    /** @type {Value[]} */
    const values = [];
    while (!this.take(end)) {
      values.push(this.value(depth));
      if (!this.take(",") && !this.ends(end)) throw this.fail(`, or ${end}`);
    }
    return values;
  }

  /** @param {number} depth */
  entries(depth) {
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

  /**
   * @param {string} name
   * @param {number} depth
   */
  call(name, depth) {
    const { line } = this;
    /** @type {Value[]} */
    const given = [];
    /** @type {Map<string, Value>} */
    const named = new Map();
    while (!this.take(")")) {
      const value = this.value(depth);
      if (isName(value) && this.take("=")) named.set(value.name, this.value(depth));
      else given.push(value);
      if (!this.take(",") && !this.ends(")")) throw this.fail(", or )");
    }
    return new Call(name.slice(name.lastIndexOf(".") + 1), given, named, line);
  }

  /** @param {string} sign */
  ends(sign) {
    this.match(SPACE);
    return this.text.startsWith(sign, this.at);
  }
}

/**
 * @param {Value} value
 * @returns {value is Name}
 */
export function isName(value) {
  return typeof value === "object" && !Array.isArray(value) && "kind" in value && value.kind === "name";
}

/** @param {string} text */
function unescaped(text) {
  return text.replace(ESCAPES, (_, four, two, letter) =>
    letter === undefined ? String.fromCharCode(parseInt(four ?? two, 16)) : (ESCAPED[letter] ?? letter),
  );
}

/**
 * The values of the statements of a text, the names that it gives to some of them put in.
 *
 * @param {string} text
 * @returns {Value[]}
 * @throws {Unreadable}
 */
export function readStatements(text) {
  return new Reader(text).statements();
}
