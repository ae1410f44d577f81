export interface Point {
  x: number;
  y: number;
}

/** The convex hull of points in the plane, counterclockwise; empty for fewer than three. */
export function convexHull<P extends Point>(points: P[]) {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  const half = (list: P[]) => {
    const chain: P[] = [];
    for (const p of list) {
      while (chain.length > 1 && turn(chain[chain.length - 2], chain[chain.length - 1], p) <= 1e-9) chain.pop();
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return sorted.length < 3 ? [] : [...half(sorted), ...half(sorted.reverse())];
}

/** Twice the area of a triangle, positive where it goes counterclockwise. */
export function turn(a: Point, b: Point, c: Point) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/** Whether a point is in a convex outline, which goes counterclockwise. */
export function inside(hull: Point[], p: Point) {
  return hull.every((corner, i) => turn(corner, hull[(i + 1) % hull.length], p) >= 0);
}

/** Whether two convex outlines have a point in common: no edge of one has all of the other outside. */
export function overlap(a: Point[], b: Point[]) {
  const parts = (one: Point[], other: Point[]) =>
    one.some((corner, i) => other.every((p) => turn(corner, one[(i + 1) % one.length], p) <= 0));
  return a.length > 0 && b.length > 0 && !parts(a, b) && !parts(b, a);
}
