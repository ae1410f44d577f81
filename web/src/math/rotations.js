import { squaredDistance } from "./numbers.js";

/** @import { Matrix3, Rotation, Vector } from "./types.js" */

/**
 * @param {Matrix3} A
 * @param {Matrix3} B
 * @returns {Matrix3} A B
 */
export function product(A, B) {
  const entries = [0, 3, 6].flatMap((i) =>
    [0, 1, 2].map((j) => A[i] * B[j] + A[i + 1] * B[j + 3] + A[i + 2] * B[j + 6]),
  );
  return /** @type {Matrix3} */ (entries);
}

/**
 * @param {Matrix3} A
 * @returns {Matrix3} Aᵀ
 */
export function transposed([a, b, c, d, e, f, g, h, i]) {
  return [a, d, g, b, e, h, c, f, i];
}

/**
 * @param {Matrix3} A
 * @param {Vector} v
 * @returns {Vector} A v
 */
export function turned([a, b, c, d, e, f, g, h, i], [x, y, z]) {
  return [a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z];
}

/**
 * @param {number} angle [rad]
 * @returns {Rotation}
 */
export function rotX(angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [1, 0, 0, 0, c, -s, 0, s, c];
}

/**
 * @param {number} angle [rad]
 * @returns {Rotation}
 */
export function rotY(angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, 0, s, 0, 1, 0, -s, 0, c];
}

/**
 * @param {number} angle [rad]
 * @returns {Rotation}
 */
export function rotZ(angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, -s, 0, s, c, 0, 0, 0, 1];
}

/**
 * The angle [rad] between two rotations, from the differences of their entries: ‖R − F‖ = 2 √2 sin(angle / 2).
 *
 * @param {Rotation} R
 * @param {Rotation} F
 */
export function angleBetween(R, F) {
  const half = Math.sqrt(0.125 * squaredDistance(R, F));
  // Of a small angle the sine is the angle itself.
  return half < 1e-9 ? 2 * half : 2 * Math.asin(Math.min(1, half));
}
