import { outermost } from "../math/hulls.ts";
import { clamp } from "../math/numbers.ts";
import { cross, direction, dot, plus, times, type Vector } from "../math/rotations.ts";
import { convexHull, inside, type Point } from "../math/surfaces.ts";

/**
 * Directions spread evenly over the sphere by the golden angle, x, y, z of one after another. None is in a plane of symmetry
 * of a shape, where two vertices would be equally far out.
 */
export function directions(count: number) {
  const spread = new Float64Array(3 * count);
  const golden = Math.PI * (3 - Math.sqrt(5));
  for (let i = 0; i < count; i++) {
    const z = 1 - (2 * i + 1) / count;
    const radius = Math.sqrt(1 - z * z);
    const turn = golden * (i + 0.5);
    spread.set([radius * Math.cos(turn), radius * Math.sin(turn), z], 3 * i);
  }
  return spread;
}

/**
 * The points that lie farthest in some direction: with enough directions, these are the points that can touch a floor.
 *
 * @param points x, y, z of one after another
 * @param towards the directions, in the same form
 */
export function extremes(points: Float64Array, towards: Float64Array) {
  const found: Set<number> = new Set();
  for (let k = 0; k < towards.length && points.length > 0; k += 3) {
    found.add(outermost(points, [towards[k], towards[k + 1], towards[k + 2]]));
  }
  return Float64Array.from([...found].flatMap((i) => [points[i], points[i + 1], points[i + 2]]));
}

// Points within this distance of the lowest one [m] touch the floor with it.
export const TOUCHING = 1e-5;
// A body rolls from one corner to the next; this number of rolls is more than any body was seen to need.
const MOST_ROLLS = 300;

/** The vertical in the frame of a rigid body at rest; the arguments are those of `rolled`. */
export function settled(points: Float64Array, centre: Vector, up: Vector): Vector {
  return rolled(points, centre, up, Math.PI).up;
}

/**
 * A rigid body that is put down with `up` upwards, and then rolls about the points that touch the floor until its centre of
 * mass is above their hull. This is a descent to a local minimum of the height of the centre of mass, u·c − min u·p over
 * the points p.
 *
 * @param points x, y, z of one after another
 * @param centre of mass
 * @param most a roll that would turn the body farther from the beginning does not take place [rad]
 * @returns the vertical, and the distance of the centre from the contacts seen from above, 0 at rest
 */
export function rolled(points: Float64Array, centre: Vector, up: Vector, most: number) {
  const begin = times(-1, direction(up));
  let [down, away] = [begin, 0];
  for (let roll = 0; roll < MOST_ROLLS; roll++) {
    const across = tangents(down);
    const floor = depth(points, down);
    const contacts = touching(points, floor - TOUCHING, down, centre, across);
    const nearest = nearestToOrigin(contacts);
    const distance = Math.hypot(nearest.x, nearest.y);
    away = distance < TOUCHING ? 0 : distance;
    if (away === 0) break;
    const side = plus(times(-nearest.x / distance, across[0]), times(-nearest.y / distance, across[1]));
    const angle = roomToRoll(points, floor, down, side, dot(centre, side) - distance);
    const next = direction(plus(times(Math.cos(angle), down), times(Math.sin(angle), side)));
    if (!(angle < Math.PI) || dot(next, begin) < Math.cos(most)) break;
    down = next;
  }
  return { up: times(-1, down), away };
}

/**
 * The points where a body touches the floor, seen from above, relative to its centre of mass.
 *
 * @param least the distance downwards from which on a point touches the floor
 */
export function touching(
  points: Float64Array,
  least: number,
  down: Vector,
  centre: Vector,
  [e1, e2] = tangents(down),
): Point[] {
  const [x0, y0] = [dot(centre, e1), dot(centre, e2)];
  const contacts: Point[] = [];
  for (let i = 0; i < points.length; i += 3) {
    const [x, y, z] = [points[i], points[i + 1], points[i + 2]];
    if (x * down[0] + y * down[1] + z * down[2] < least) continue;
    contacts.push({ x: x * e1[0] + y * e1[1] + z * e1[2] - x0, y: x * e2[0] + y * e2[1] + z * e2[2] - y0 });
  }
  return contacts;
}

/** The largest coordinate of the points along a direction. */
export function depth(points: Float64Array, down: ArrayLike<number>) {
  let most = -Infinity;
  for (let i = 0; i < points.length; i += 3) {
    most = Math.max(most, points[i] * down[0] + points[i + 1] * down[1] + points[i + 2] * down[2]);
  }
  return most;
}

/**
 * The angle by which `down` turns towards `side` until another point touches the floor.
 *
 * @param floor the coordinate of the floor along `down`
 * @param pivot the coordinate along `side` of the point about which the body rolls
 */
function roomToRoll(points: Float64Array, floor: number, down: number[], side: number[], pivot: number) {
  let cotangent = -Infinity;
  for (let i = 0; i < points.length; i += 3) {
    const [x, y, z] = [points[i], points[i + 1], points[i + 2]];
    const ahead = x * side[0] + y * side[1] + z * side[2] - pivot;
    const above = floor - (x * down[0] + y * down[1] + z * down[2]);
    const isNew = above > TOUCHING || ahead > TOUCHING;
    if (isNew && ahead > cotangent * above) cotangent = ahead / above;
  }
  return Math.atan2(1, cotangent);
}

/**
 * The point of the convex hull of some points that is nearest to the origin.
 *
 * @param points at least one
 */
function nearestToOrigin(points: Point[]): Point {
  const hull = convexHull(points);
  if (hull.length > 2 && inside(hull, { x: 0, y: 0 })) return { x: 0, y: 0 };
  return nearestOnRim(hull.length > 0 ? hull : points);
}

/** The point on the edges of an outline that is nearest to the origin, which may be inside or outside. */
export function nearestOnRim(corners: Point[]): Point {
  return corners
    .map((corner, i) => nearestOnEdge(corner, corners[(i + 1) % corners.length]))
    .reduce((best, point) => (Math.hypot(point.x, point.y) < Math.hypot(best.x, best.y) ? point : best));
}

function nearestOnEdge(a: Point, b: Point) {
  const [x, y] = [b.x - a.x, b.y - a.y];
  const square = x * x + y * y;
  const share = square > 0 ? clamp(-(a.x * x + a.y * y) / square, 0, 1) : 0;
  return { x: a.x + share * x, y: a.y + share * y };
}

/** Two unit vectors normal to a direction and to each other. */
function tangents(n: Vector): [Vector, Vector] {
  // The cross product with an axis that is far from n, so that it is not small.
  const flat: Vector = Math.abs(n[0]) < 0.6 ? [0, -n[2], n[1]] : [n[2], 0, -n[0]];
  const e1 = direction(flat);
  return [e1, cross(n, e1)];
}

// A joint's difference counts up to this [rad, m], so that moving one arm does not make another posture nearest.
const ELSEWHERE = 0.5;
// The factor by which another posture must be nearer to replace the one before.
const CLEARLY = 0.85;

/**
 * The index of the posture nearest to a configuration.
 *
 * @param postures at least one
 * @param before the nearest posture one step earlier
 */
export function nearestPosture(q: ArrayLike<number>, postures: { q: number[] }[], before: number | null = null) {
  const distances = postures.map((posture) =>
    posture.q.reduce((sum, value, i) => sum + Math.min(Math.abs(value - q[i]), ELSEWHERE), 0),
  );
  const nearest = distances.indexOf(Math.min(...distances));
  return before !== null && distances[nearest] > CLEARLY * distances[before] ? before : nearest;
}
