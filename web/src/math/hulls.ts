// Whether two convex hulls, given by their vertices and grown by a radius, overlap: the algorithm of Gilbert, Johnson and
// Keerthi, as in nao_kin/_kernels/hulls.py. It looks for the point of the difference of both hulls that is nearest to the
// origin. Source: Ericson, Real-Time Collision Detection, 2005, 5.1 and 9.5.

import { cross, dot, minus, plus, times, type Vector } from "./rotations.ts";

/** A hull in the frame of its link: points first … last − 1, x, y, z of one after another [m]. */
export interface Hull {
  points: Float64Array;
  /** By which the hull is grown [m]. */
  radius: number;
  /** Pose of the link, column by column. */
  pose: ArrayLike<number>;
}

// Hulls that are nearer than this touch [m].
const EXACT = 1e-10;
// More steps than hulls of a few hundred vertices take.
const STEPS = 100;

/**
 * Whether two hulls overlap.
 *
 * @param away a direction from the second to the first, of any length but zero, to begin with; the search leaves in it
 *   the one that separates the hulls, with which the next search for the same hulls ends at once, if they moved little
 */
export function doOverlap(a: Hull, b: Hull, away: Float64Array): boolean {
  const grown = Math.max(EXACT, a.radius + b.radius);
  let [x, y, z] = away;
  /** The corners that span the point [x, y, z] of the difference, the nearest one to the origin so far. */
  let corners: Vector[] = [];
  let squared = Infinity;
  for (let step = 0; step < STEPS; step++) {
    const length = Math.hypot(x, y, z);
    if (corners.length > 0 && length <= grown) return true;
    const far = minus(farthest(a, -x, -y, -z), farthest(b, x, y, z));
    const along = x * far[0] + y * far[1] + z * far[2];
    if (along > grown * length) {
      away.set([x, y, z]);
      return false;
    }
    // No point of the difference is nearer than the nearest one so far.
    if (corners.length > 0 && squared - along <= EXACT * length) return false;
    const best = nearest([...corners, far]);
    if (!best) return true;
    const before = squared;
    ({ corners, squared } = best);
    [x, y, z] = best.point;
    if (squared >= before) return false; // not nearer, because of rounding
  }
  return false;
}

/** The vertex of a hull that is farthest along a direction, in the frame of the poses. */
function farthest({ points, pose: m }: Hull, x: number, y: number, z: number): Vector {
  const i = outermost(points, [
    m[0] * x + m[1] * y + m[2] * z,
    m[4] * x + m[5] * y + m[6] * z,
    m[8] * x + m[9] * y + m[10] * z,
  ]);
  const [p, q, r] = [points[i], points[i + 1], points[i + 2]];
  const along = (row: number) => m[row] * p + m[row + 4] * q + m[row + 8] * r + m[row + 12];
  return [along(0), along(1), along(2)];
}

/** The place in points, x, y, z of one after another, of the point that is farthest along a direction. */
export function outermost(points: Float64Array, [x, y, z]: Vector) {
  let [most, found] = [-Infinity, 0];
  for (let i = 0; i < points.length; i += 3) {
    const along = x * points[i] + y * points[i + 1] + z * points[i + 2];
    if (along > most) {
      most = along;
      found = i;
    }
  }
  return found;
}

/** A point of a simplex, and the corners that span the part of it with the point. */
type Best = { squared: number; corners: Vector[]; point: Vector };

/** The point of a simplex that is nearest to the origin; null if the origin is inside. */
function nearest(simplex: Vector[]): Best | null {
  const best: Best = { squared: Infinity, corners: [], point: [0, 0, 0] };
  const [a, b, c, d] = simplex;
  if (d) ofSolid(simplex, best);
  else if (c) ofFace(a, b, c, best);
  else if (b) ofEdge(a, b, best);
  else offer(best, a, a);
  best.corners = simplex.filter((corner) => best.corners.includes(corner));
  return best.squared < Infinity ? best : null;
}

/** Keep a point if it is nearer to the origin than the best one. */
function offer(best: Best, point: Vector, ...corners: Vector[]) {
  const squared = dot(point, point);
  if (squared < best.squared) Object.assign(best, { squared, corners, point });
}

/** Offer the point of an edge that is nearest to the origin. */
function ofEdge(a: Vector, b: Vector, best: Best) {
  const edge = minus(b, a);
  const [along, length] = [-dot(a, edge), dot(edge, edge)];
  if (along <= 0) offer(best, a, a);
  else if (along >= length) offer(best, b, b);
  else offer(best, plus(a, times(along / length, edge)), a, b);
}

/** Offer the point of a triangle that is nearest to the origin. */
function ofFace(a: Vector, b: Vector, c: Vector, best: Best) {
  const n = normal(a, b, c);
  const size = dot(n, n);
  // The origin is above the triangle if it is on the inner side of each edge.
  if (size > 0 && dot(cross(b, c), n) > 0 && dot(cross(c, a), n) > 0 && dot(cross(a, b), n) > 0) {
    return offer(best, times(dot(a, n) / size, n), a, b, c);
  }
  ofEdge(a, b, best);
  ofEdge(b, c, best);
  ofEdge(c, a, best);
}

/** Offer the points of the faces of a tetrahedron that the origin is outside of; none if it is inside. */
function ofSolid(simplex: Vector[], best: Best) {
  const flat = isFlat(simplex);
  for (const other of simplex) {
    const [a, b, c] = simplex.filter((corner) => corner !== other);
    const n = normal(a, b, c);
    const height = dot(a, n);
    if (flat || height * (height - dot(other, n)) <= 0) ofFace(a, b, c, best);
  }
}

/** Whether the four corners are in one plane, up to rounding. */
function isFlat([a, b, c, d]: Vector[]) {
  const size = Math.max(...[b, c, d].map((corner) => dot(minus(corner, a), minus(corner, a))));
  const volume = dot(normal(a, b, c), minus(d, a));
  return volume * volume <= 1e-24 * size * size * size;
}

/** Twice the area of a triangle, times its normal. */
const normal = (a: Vector, b: Vector, c: Vector) => cross(minus(b, a), minus(c, a));
