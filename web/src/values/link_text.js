import { NoConfiguration } from "./reading.js";
import { quoted } from "./names.js";

// The pieces that a link is made of.

// Links give joints to a millionth: of a radian, that moves no hand by a micrometre.
export const ROUNDING = 1e-6;

export const NUMBER = /^-?\d{1,9}(\.\d{1,17})?$/;

/**
 * @param {number} value
 * @param {number} [digits]
 */
export const rounded = (value, digits = 6) =>
  value
    .toFixed(digits)
    .replace(/\.?0+$/, "")
    .replace(/^-0$/, "0");

/**
 * @param {string} text
 * @param {string} sign
 * @returns {[string, string]} what is before the sign, and after it
 */
export function splitAt(text, sign) {
  const at = text.indexOf(sign);
  return at < 0 ? [text, ""] : [text.slice(0, at), text.slice(at + 1)];
}

/** @param {string} text */
export function decoded(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    throw new NoConfiguration(`${quoted(text)} is no text of a link`);
  }
}
