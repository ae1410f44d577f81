/** @typedef {{ name: string, times: number[], values: number[] }} Track the keys of one joint */

/** A file that is no motion: one line that says what was wrong, and where. */
export class NoMotion extends Error {}

/** Keys of a joint that are read at all. */
export const MOST_ROWS = 50_000;

export const DEGREE = Math.PI / 180;

/** @type {Record<string, number>} */
export const TIME_UNITS = { s: 1, ms: 1e-3 };

/**
 * Whether a joint is a hand, given as a share from closed to open.
 *
 * @param {string} name
 */
export const isHand = (name) => name === "LHand" || name === "RHand";
