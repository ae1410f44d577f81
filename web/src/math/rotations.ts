import { squaredDistance } from "./numbers.ts";
import type { Matrix3, Rotation, Vector } from "./types.ts";

/** @returns A B */
export function product(A: Matrix3, B: Matrix3): Matrix3 {
  const entries = [0, 3, 6].flatMap((i) =>
    [0, 1, 2].map((j) => A[i] * B[j] + A[i + 1] * B[j + 3] + A[i + 2] * B[j + 6]),
  );
  return entries as Matrix3;
}

/** @returns Aᵀ */
export function transposed([a, b, c, d, e, f, g, h, i]: Matrix3): Matrix3 {
  return [a, d, g, b, e, h, c, f, i];
}

/** @returns A v */
export function turned([a, b, c, d, e, f, g, h, i]: Matrix3, [x, y, z]: Vector): Vector {
  return [a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z];
}

/** @param angle [rad] */
export function rotX(angle: number): Rotation {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [1, 0, 0, 0, c, -s, 0, s, c];
}

/** @param angle [rad] */
export function rotY(angle: number): Rotation {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, 0, s, 0, 1, 0, -s, 0, c];
}

/** @param angle [rad] */
export function rotZ(angle: number): Rotation {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, -s, 0, s, c, 0, 0, 0, 1];
}

/** The angle [rad] between two rotations, from the differences of their entries: ‖R − F‖ = 2 √2 sin(angle / 2). */
export function angleBetween(R: Rotation, F: Rotation) {
  const half = Math.sqrt(0.125 * squaredDistance(R, F));
  // Of a small angle the sine is the angle itself.
  return half < 1e-9 ? 2 * half : 2 * Math.asin(Math.min(1, half));
}
