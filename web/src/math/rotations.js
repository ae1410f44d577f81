// @ts-nocheck
import { squaredDistance } from "./numbers.js";

// A product of two rotations.
export const product = (A, B) =>
  [0, 3, 6].flatMap((i) => [0, 1, 2].map((j) => A[i] * B[j] + A[i + 1] * B[j + 3] + A[i + 2] * B[j + 6]));

export const transposed = ([a, b, c, d, e, f, g, h, i]) => [a, d, g, b, e, h, c, f, i];

export const turned = (R, [x, y, z]) => [0, 3, 6].map((i) => R[i] * x + R[i + 1] * y + R[i + 2] * z);

export function rotX(angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [1, 0, 0, 0, c, -s, 0, s, c];
}

export function rotY(angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, 0, s, 0, 1, 0, -s, 0, c];
}

export function rotZ(angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, -s, 0, s, c, 0, 0, 0, 1];
}

// The angle between two rotations from the differences of their entries, ‖R − F‖ = 2 √2 sin(angle / 2).
export function angleBetween(R, F) {
  const half = Math.sqrt(0.125 * squaredDistance(R, F));
  // Of a small angle the sine is the angle itself.
  return half < 1e-9 ? 2 * half : 2 * Math.asin(Math.min(1, half));
}
