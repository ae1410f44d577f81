/** @import { Vector } from "./types.js" */

/**
 * @param {Vector} a
 * @param {Vector} b
 * @returns {Vector}
 */
export function plus([ax, ay, az], [bx, by, bz]) {
  return [ax + bx, ay + by, az + bz];
}

/**
 * @param {Vector} a
 * @param {Vector} b
 * @returns {Vector}
 */
export function minus([ax, ay, az], [bx, by, bz]) {
  return [ax - bx, ay - by, az - bz];
}

/**
 * @param {number} factor
 * @param {Vector} v
 * @returns {Vector}
 */
export function times(factor, [x, y, z]) {
  return [factor * x, factor * y, factor * z];
}

/**
 * @param {Vector} a
 * @param {Vector} b
 */
export function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/**
 * @param {Vector} a
 * @param {Vector} b
 * @returns {Vector}
 */
export function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** @param {Vector} v */
export function norm(v) {
  return Math.hypot(...v);
}

/**
 * The vector of length one along one that is not zero.
 *
 * @param {Vector} v
 * @returns {Vector}
 */
export function direction(v) {
  const length = norm(v);
  return [v[0] / length, v[1] / length, v[2] / length];
}

/**
 * @param {Vector} a
 * @param {Vector} b
 */
export function distance(a, b) {
  return norm(minus(a, b));
}
