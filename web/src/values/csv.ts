import { Unreadable } from "./literals.ts";

const DELIMITERS = [",", ";", "\t"];

/**
 * The records of a CSV text and the lines that they begin in; the header line says what separates fields. Empty records
 * are left out.
 *
 * @throws {Unreadable}
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
      if (!found) throw new Unreadable(`line ${line}: a quotation mark that is not closed`);
      at = pattern.lastIndex;
      line += found[0].split("\n").length - 1;
      fields.push((found[1]?.replaceAll('""', '"') ?? found[0]).trim());
      if (text[at] !== delimiter) break;
      at += 1;
    }
    if (at < text.length && !/[\r\n]/.test(text[at])) {
      throw new Unreadable(`line ${line}: text after a closing quotation mark`);
    }
    if (text[at] === "\r" && text[at + 1] === "\n") at += 1;
    at += 1;
    line += 1;
    if (fields.some(Boolean)) records.push({ fields, line: begin });
  }
  return records;
}
