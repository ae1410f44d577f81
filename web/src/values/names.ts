// The largest number of characters of a name that are compared, and that a message shows.
const COMPARED = 60;
const SHOWN = 40;

/** Quote a name from a file or the user for a message. */
export const quoted = (name: string) => `"${name.length > SHOWN ? `${name.slice(0, SHOWN - 1)}…` : name}"`;

/** Whether a joint is a hand, whose value is a share from closed to open. */
export const isHand = (name: string) => name === "LHand" || name === "RHand";

/** The valid names with the fewest changed letters, best first; names that differ in half the letters are left out. */
export function nearest(name: string, valid: readonly string[], count: number = 3) {
  const wanted = name.slice(0, COMPARED).toLowerCase();
  return valid
    .map((candidate) => ({ candidate, changes: distance(wanted, candidate.slice(0, COMPARED).toLowerCase()) }))
    .filter(({ candidate, changes }) => changes <= Math.max(wanted.length, Math.min(candidate.length, COMPARED)) / 2)
    .sort((a, b) => a.changes - b.changes)
    .slice(0, count)
    .map(({ candidate }) => candidate);
}

/** The message about an unknown joint name. */
export function unknown(name: string, valid: readonly string[]) {
  const near = nearest(name, valid);
  return `unknown joint ${quoted(name)} ${near.length ? `(nearest: ${near.join(", ")})` : "(no similar name)"}`;
}

/** Whether a name contains every word of a search, ignoring case. */
export function matches(name: string, sought: string) {
  const lower = name.toLowerCase();
  return sought
    .toLowerCase()
    .split(/\s+/)
    .every((word) => lower.includes(word));
}

/** Letters to insert, delete or replace (Levenshtein). */
function distance(a: string, b: string) {
  let row = Array.from({ length: b.length + 1 }, (_, j) => j);
  for (let i = 1; i <= a.length; i++) {
    const next = [i];
    for (let j = 1; j <= b.length; j++) {
      next[j] = Math.min(row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] === b[j - 1] ? 0 : 1));
    }
    row = next;
  }
  return row[b.length];
}
