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
function turn(a: Point, b: Point, c: Point) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/** Whether a point is in a convex outline, which goes counterclockwise. */
export function inside(hull: Point[], p: Point) {
  return hull.every((corner, i) => turn(corner, hull[(i + 1) % hull.length], p) >= 0);
}

/** Whether two convex outlines have a point in common, that is, no edge of one has the whole other outline outside. */
export function overlap(a: Point[], b: Point[]) {
  const parts = (one: Point[], other: Point[]) =>
    one.some((corner, i) => other.every((p) => turn(corner, one[(i + 1) % one.length], p) <= 0));
  return a.length > 0 && b.length > 0 && !parts(a, b) && !parts(b, a);
}

/**
 * Whether triangles enclose a solid and all face outwards: each edge is used once in each direction, and the volume is
 * positive. The back faces of such a solid are never visible.
 *
 * @param positions three coordinates per vertex, one vertex after another
 * @param index three vertices per triangle; null if the vertices are in order
 */
export function isClosed(positions: ArrayLike<number>, index: ArrayLike<number> | null) {
  const places: Map<string, number> = new Map();
  const point = new Int32Array(positions.length / 3);
  for (let i = 0; i < point.length; i++) {
    const place = `${positions[3 * i]},${positions[3 * i + 1]},${positions[3 * i + 2]}`;
    const known = places.get(place) ?? places.size;
    places.set(place, known);
    point[i] = known;
  }
  const size = places.size;
  const at = (corner: number) => point[index ? index[corner] : corner];
  /** For each edge the number of uses forwards minus the uses backwards. */
  const edges: Map<number, number> = new Map();
  const pass = (a: number, b: number) => {
    if (a === b) return;
    const [edge, by] = a < b ? [a * size + b, 1] : [b * size + a, -1];
    edges.set(edge, (edges.get(edge) ?? 0) + by);
  };
  let volume = 0;
  const corners = index ? index.length : point.length;
  for (let corner = 0; corner + 2 < corners; corner += 3) {
    const [a, b, c] = [at(corner), at(corner + 1), at(corner + 2)];
    pass(a, b);
    pass(b, c);
    pass(c, a);
    volume += sixfoldVolume(positions, index, corner);
  }
  for (const surplus of edges.values()) if (surplus !== 0) return false;
  return volume > 0;
}

/** Six times the volume of the tetrahedron from the origin to a triangle. */
function sixfoldVolume(positions: ArrayLike<number>, index: ArrayLike<number> | null, corner: number) {
  const [a, b, c] = [0, 1, 2].map((i) => 3 * (index ? index[corner + i] : corner + i));
  const [ax, ay, az] = [positions[a], positions[a + 1], positions[a + 2]];
  const [bx, by, bz] = [positions[b], positions[b + 1], positions[b + 2]];
  const [cx, cy, cz] = [positions[c], positions[c + 1], positions[c + 2]];
  return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
}
