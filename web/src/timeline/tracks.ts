/** the keys of one joint */
export interface Track {
  name: string;
  times: number[];
  values: number[];
}

/** A file that is no motion: one line that says what was wrong, and where. */
export class NoMotion extends Error {}

/** Keys of a joint that are read at all. */
export const MOST_ROWS = 50_000;

export const DEGREE = Math.PI / 180;

export const TIME_UNITS: Record<string, number> = { s: 1, ms: 1e-3 };

/** Whether a joint is a hand, given as a share from closed to open. */
export const isHand = (name: string) => name === "LHand" || name === "RHand";
