/** @typedef {{ x: number, y: number }} Point */

/**
 * The convex hull of points in the plane, counterclockwise; empty for fewer than three.
 *
 * @template {Point} P
 * @param {P[]} points
 */
export function convexHull(points) {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  /** @param {P[]} list */
  const half = (list) => {
    /** @type {P[]} */
    const chain = [];
    for (const p of list) {
      while (chain.length > 1 && turn(chain[chain.length - 2], chain[chain.length - 1], p) <= 1e-9) chain.pop();
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return sorted.length < 3 ? [] : [...half(sorted), ...half(sorted.reverse())];
}

/**
 * Twice the area of a triangle, positive where it goes counterclockwise.
 *
 * @param {Point} a
 * @param {Point} b
 * @param {Point} c
 */
export function turn(a, b, c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/**
 * Whether a point is in a convex outline, which goes counterclockwise.
 *
 * @param {Point[]} hull
 * @param {Point} p
 */
export function inside(hull, p) {
  return hull.every((corner, i) => turn(corner, hull[(i + 1) % hull.length], p) >= 0);
}

/**
 * Whether two convex outlines have a point in common: no edge of one has all of the other outside.
 *
 * @param {Point[]} a
 * @param {Point[]} b
 */
export function overlap(a, b) {
  /** @param {Point[]} one @param {Point[]} other */
  const parts = (one, other) =>
    one.some((corner, i) => other.every((p) => turn(corner, one[(i + 1) % one.length], p) <= 0));
  return a.length > 0 && b.length > 0 && !parts(a, b) && !parts(b, a);
}
