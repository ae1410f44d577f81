import type { Answer } from "../ik/answer.ts";

export const degrees: (angle: number, digits: number) => string = (angle, digits) =>
  `${((angle * 180) / Math.PI).toFixed(digits)}°`;

/** Why there is no branch, in degrees. */
export function sentence({ reason, joint, needed, limit, limb }: Answer) {
  if (reason === "OUT_OF_REACH") return `out of reach by ${millimetres(needed)}`;
  if (reason === "NOT_ENOUGH_JOINTS") return `${limb.joints.length} joints do not make this pose`;
  if (joint < 0) return "no solution found";
  const bound = needed < limit ? "at least" : "at most";
  const where = reason === "JOINT_LIMIT" ? "" : " there (coupled limit)";
  // As many digits as it takes to tell the two apart.
  const digits = [1, 2, 3, 4, 5].find((n) => degrees(needed, n) !== degrees(limit, n)) ?? 6;
  return `${limb.joints[joint]} needs ${degrees(needed, digits)}, ${bound} ${degrees(limit, digits)}${where}`;
}

export function millimetres(metres: number) {
  const digits = metres < 0.001 ? 3 : metres < 0.01 ? 1 : 0;
  return `${(1000 * metres).toFixed(digits)} mm`;
}
