import { NoConfiguration } from "./reading.ts";
import { quoted } from "./names.ts";

// The pieces that a link is made of.

// Links give joints to a millionth: of a radian, that moves no hand by a micrometre.
export const ROUNDING = 1e-6;

export const NUMBER = /^-?\d{1,9}(\.\d{1,17})?$/;

export const rounded = (value: number, digits: number = 6) =>
  value
    .toFixed(digits)
    .replace(/\.?0+$/, "")
    .replace(/^-0$/, "0");

/** @returns what is before the sign, and after it */
export function splitAt(text: string, sign: string): [string, string] {
  const at = text.indexOf(sign);
  return at < 0 ? [text, ""] : [text.slice(0, at), text.slice(at + 1)];
}

export function decoded(text: string) {
  try {
    return decodeURIComponent(text);
  } catch {
    throw new NoConfiguration(`${quoted(text)} is no text of a link`);
  }
}
