import type { Vector } from "./types.ts";

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

export function norm(v: Vector) {
  return Math.hypot(...v);
}

/** The vector of length one along one that is not zero. */
export function direction(v: Vector): Vector {
  const length = norm(v);
  return [v[0] / length, v[1] / length, v[2] / length];
}

export function distance(a: Vector, b: Vector) {
  return norm(minus(a, b));
}
