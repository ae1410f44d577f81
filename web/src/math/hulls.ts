// Whether two convex hulls, given by their vertices and grown by a radius, overlap: the algorithm of Gilbert, Johnson and
// Keerthi, as in nao_kin/_kernels/hulls.py. It looks for the point of the difference of both hulls that is nearest to the
// origin. Source: Ericson, Real-Time Collision Detection, 2005, 5.1 and 9.5.

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

/** The corners of the simplex, three numbers of each. */
const W = new Float64Array(12);
/** Its point that is nearest to the origin. */
const V = new Float64Array(3);
/** The farthest point of the difference of two hulls. */
const FAR = new Float64Array(3);

/**
 * Whether two hulls overlap.
 *
 * @param away a direction from the second to the first, of any length but zero, to begin with; the search leaves in it
 *   the one that separates the hulls, with which the next search for the same hulls ends at once, if they moved little
 */
export function doOverlap(a: Hull, b: Hull, away: Float64Array): boolean {
  const grown = a.radius + b.radius;
  V.set(away);
  let count = 0;
  let squared = Infinity;
  for (let step = 0; step < STEPS; step++) {
    const length = Math.hypot(V[0], V[1], V[2]);
    if (count > 0 && length <= Math.max(EXACT, grown)) return true;
    farthest(a, b, -V[0], -V[1], -V[2]);
    const along = V[0] * FAR[0] + V[1] * FAR[1] + V[2] * FAR[2];
    if (along > Math.max(EXACT, grown) * length) {
      away.set(V);
      return false;
    }
    // No point of the difference is nearer than the nearest one so far.
    if (count > 0 && squared - along <= EXACT * length) return false;
    W.set(FAR, 3 * count);
    count = nearest(count + 1);
    if (count === 4) return true;
    const before = squared;
    squared = V[0] * V[0] + V[1] * V[1] + V[2] * V[2];
    if (squared >= before) return false; // not nearer, because of rounding
  }
  return false;
}

/** Write the point of the first hull minus the second that is farthest along a direction into `FAR`. */
function farthest(a: Hull, b: Hull, x: number, y: number, z: number) {
  const i = farthestOf(a, x, y, z);
  const k = farthestOf(b, -x, -y, -z);
  const [p, q, m, n] = [a.points, b.points, a.pose, b.pose];
  for (let row = 0; row < 3; row++) {
    FAR[row] =
      m[row] * p[i] +
      m[row + 4] * p[i + 1] +
      m[row + 8] * p[i + 2] +
      m[row + 12] -
      (n[row] * q[k] + n[row + 4] * q[k + 1] + n[row + 8] * q[k + 2] + n[row + 12]);
  }
}

/** The place in its points of the vertex of a hull that is farthest along a direction. */
function farthestOf({ points, pose: m }: Hull, x: number, y: number, z: number) {
  const u = m[0] * x + m[1] * y + m[2] * z;
  const v = m[4] * x + m[5] * y + m[6] * z;
  const w = m[8] * x + m[9] * y + m[10] * z;
  let [best, found] = [-Infinity, 0];
  for (let i = 0; i < points.length; i += 3) {
    const along = u * points[i] + v * points[i + 1] + w * points[i + 2];
    if (along > best) {
      best = along;
      found = i;
    }
  }
  return found;
}

/**
 * Write the point of a simplex that is nearest to the origin into `V`, and move the corners that span it to the front.
 *
 * @returns the number of these corners; 4 if the origin is inside
 */
function nearest(count: number): number {
  if (count === 1) {
    V.set(W.subarray(0, 3));
    return 1;
  }
  const best = { squared: Infinity, corners: [] as number[], point: [0, 0, 0] };
  if (count === 2) ofEdge(0, 1, best);
  else if (count === 3) ofFace(0, 1, 2, best);
  else if (!ofSolid(best)) return 4;
  V.set(best.point);
  const moved = best.corners.sort().map((corner) => W.slice(3 * corner, 3 * corner + 3));
  moved.forEach((corner, i) => W.set(corner, 3 * i));
  return moved.length;
}

type Best = { squared: number; corners: number[]; point: number[] };

/** Keep a point if it is nearer to the origin than the best one. */
function offer(best: Best, x: number, y: number, z: number, ...corners: number[]) {
  const squared = x * x + y * y + z * z;
  if (squared < best.squared) Object.assign(best, { squared, corners, point: [x, y, z] });
}

/** Offer the point of an edge that is nearest to the origin. */
function ofEdge(i: number, j: number, best: Best) {
  const [ax, ay, az] = [W[3 * i], W[3 * i + 1], W[3 * i + 2]];
  const [x, y, z] = [W[3 * j] - ax, W[3 * j + 1] - ay, W[3 * j + 2] - az];
  const [along, length] = [-(ax * x + ay * y + az * z), x * x + y * y + z * z];
  if (along <= 0) offer(best, ax, ay, az, i);
  else if (along >= length) offer(best, ax + x, ay + y, az + z, j);
  else offer(best, ax + (along / length) * x, ay + (along / length) * y, az + (along / length) * z, i, j);
}

/** Offer the point of a triangle that is nearest to the origin. */
function ofFace(i: number, j: number, k: number, best: Best) {
  const n = normal(i, j, k);
  const size = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  // The origin is above the triangle if it is on the inner side of each edge.
  if (size > 0 && triple(j, k, n) > 0 && triple(k, i, n) > 0 && triple(i, j, n) > 0) {
    const share = (W[3 * i] * n[0] + W[3 * i + 1] * n[1] + W[3 * i + 2] * n[2]) / size;
    return offer(best, share * n[0], share * n[1], share * n[2], i, j, k);
  }
  ofEdge(i, j, best);
  ofEdge(j, k, best);
  ofEdge(k, i, best);
}

const FACES = [
  [0, 1, 2, 3],
  [0, 1, 3, 2],
  [0, 2, 3, 1],
  [1, 2, 3, 0],
];

/** Offer the points of the faces of a tetrahedron that the origin is outside of; returns false if it is inside. */
function ofSolid(best: Best) {
  const flat = isFlat();
  for (const [i, j, k, other] of FACES) {
    const n = normal(i, j, k);
    const height = W[3 * i] * n[0] + W[3 * i + 1] * n[1] + W[3 * i + 2] * n[2];
    const across = height - (W[3 * other] * n[0] + W[3 * other + 1] * n[1] + W[3 * other + 2] * n[2]);
    if (flat || height * across <= 0) ofFace(i, j, k, best);
  }
  return best.squared < Infinity;
}

/** Whether the four corners are in one plane, up to rounding. */
function isFlat() {
  const edges = [1, 2, 3].map((i) => [0, 1, 2].map((axis) => W[3 * i + axis] - W[axis]));
  const size = Math.max(...edges.map(([x, y, z]) => x * x + y * y + z * z));
  const n = normal(0, 1, 2);
  const volume = n[0] * edges[2][0] + n[1] * edges[2][1] + n[2] * edges[2][2];
  return volume * volume <= 1e-24 * size * size * size;
}

/** Twice the area of a triangle of the simplex, times its normal. */
function normal(i: number, j: number, k: number) {
  const [ax, ay, az] = [W[3 * i], W[3 * i + 1], W[3 * i + 2]];
  const [bx, by, bz] = [W[3 * j] - ax, W[3 * j + 1] - ay, W[3 * j + 2] - az];
  const [cx, cy, cz] = [W[3 * k] - ax, W[3 * k + 1] - ay, W[3 * k + 2] - az];
  return [by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx];
}

/** The triple product of two corners and a vector. */
function triple(i: number, j: number, n: number[]) {
  const [ax, ay, az] = [W[3 * i], W[3 * i + 1], W[3 * i + 2]];
  const [bx, by, bz] = [W[3 * j], W[3 * j + 1], W[3 * j + 2]];
  return (ay * bz - az * by) * n[0] + (az * bx - ax * bz) * n[1] + (ax * by - ay * bx) * n[2];
}
