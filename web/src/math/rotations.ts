import { squaredDistance } from "./numbers.ts";

// Vectors, rotations and poses. Angles are in radians. Matrices are flat arrays, row by row, as NumPy ravels them.

export type Vector = [number, number, number];

/** A 3×3 matrix that is orthogonal with determinant 1, row by row. */
export type Rotation = [number, number, number, number, number, number, number, number, number];

export function plus([ax, ay, az]: Vector, [bx, by, bz]: Vector): Vector {
  return [ax + bx, ay + by, az + bz];
}

export function minus([ax, ay, az]: Vector, [bx, by, bz]: Vector): Vector {
  return [ax - bx, ay - by, az - bz];
}

export function times(factor: number, [x, y, z]: Vector): Vector {
  return [factor * x, factor * y, factor * z];
}

export function dot(a: Vector, b: Vector) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function norm(v: Vector) {
  return Math.hypot(...v);
}

/** The unit vector along a nonzero vector. */
export function direction(v: Vector): Vector {
  const length = norm(v);
  return [v[0] / length, v[1] / length, v[2] / length];
}

export function distance(a: Vector, b: Vector) {
  return norm(minus(a, b));
}

/** @returns A B */
export function product(A: Rotation, B: Rotation): Rotation {
  const [a, b, c, d, e, f, g, h, i] = A;
  const [j, k, l, m, n, o, p, q, r] = B;
  return [
    ...[a * j + b * m + c * p, a * k + b * n + c * q, a * l + b * o + c * r],
    ...[d * j + e * m + f * p, d * k + e * n + f * q, d * l + e * o + f * r],
    ...[g * j + h * m + i * p, g * k + h * n + i * q, g * l + h * o + i * r],
  ] as Rotation;
}

/** @returns Aᵀ */
export function transposed([a, b, c, d, e, f, g, h, i]: Rotation): Rotation {
  return [a, d, g, b, e, h, c, f, i];
}

/** @returns A v */
export function turned([a, b, c, d, e, f, g, h, i]: Rotation, [x, y, z]: Vector): Vector {
  return [a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z];
}

/** The rotation by an angle about a unit vector: cos φ I + sin φ [a]× + (1 − cos φ) a aᵀ. */
export function rotationAbout([x, y, z]: Vector, angle: number): Rotation {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const [tx, ty, tz] = [(1 - c) * x, (1 - c) * y, (1 - c) * z];
  return [
    ...[c + tx * x, tx * y - s * z, tx * z + s * y],
    ...[ty * x + s * z, c + ty * y, ty * z - s * x],
    ...[tz * x - s * y, tz * y + s * x, c + tz * z],
  ] as Rotation;
}

/** The angle [rad] between two rotations, from the differences of their entries: ‖R − F‖ = 2 √2 sin(angle / 2). */
export function angleBetween(R: Rotation, F: Rotation) {
  const half = Math.sqrt(0.125 * squaredDistance(R, F));
  // For a small angle the sine equals the angle.
  return half < 1e-9 ? 2 * half : 2 * Math.asin(Math.min(1, half));
}

/**
 * Roll, pitch and yaw [rad] of R = Rz(yaw) Ry(pitch) Rx(roll). The yaw is computed first; the other two follow from
 * Rz(−yaw) R, which stays accurate if the pitch is a right angle. (three.js's Euler loses 4e-4 rad there.)
 *
 * @param matrix column by column
 */
export function rollPitchYaw({ elements: m }: { elements: ArrayLike<number> }): [number, number, number] {
  const yaw = Math.atan2(m[1], m[0]);
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  const pitch = Math.atan2(-m[2], c * m[0] + s * m[1]);
  const roll = Math.atan2(s * m[8] - c * m[9], c * m[5] - s * m[4]);
  return [roll, pitch, yaw];
}

/**
 * The unit quaternion of a rotation, from the longest row of the matrix 4 r rᵀ, which is accurate at half a turn too.
 *
 * @param matrix column by column
 * @returns scalar first, with the canonical sign
 */
export function quaternionOf({ elements: m }: { elements: ArrayLike<number> }): number[] {
  const [d01, d02, d03] = [m[6] - m[9], m[8] - m[2], m[1] - m[4]];
  const [d12, d13, d23] = [m[1] + m[4], m[8] + m[2], m[6] + m[9]];
  const rows = [
    [1 + m[0] + m[5] + m[10], d01, d02, d03],
    [d01, 1 + m[0] - m[5] - m[10], d12, d13],
    [d02, d12, 1 - m[0] + m[5] - m[10], d23],
    [d03, d13, d23, 1 - m[0] - m[5] + m[10]],
  ];
  const longest = rows.reduce((best, row, i) => (row[i] > rows[best][best] ? i : best), 0);
  const row = rows[longest];
  const first = row.find((value) => value !== 0) ?? 1;
  const scale = Math.sign(first) / Math.hypot(...row);
  return row.map((value) => value * scale + 0);
}

/** The unit quaternion of the rotation from one orientation to another, in the axes of the first; as `quaternionOf`. */
export function quaternionBetween(from: Rotation, to: Rotation) {
  const [a, b, c, d, e, f, g, h, i] = product(transposed(from), to);
  return quaternionOf({ elements: [a, d, g, 0, b, e, h, 0, c, f, i] });
}
