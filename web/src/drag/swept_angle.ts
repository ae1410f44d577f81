import type * as Three from "three";
import type { Viewport } from "../pick/pick.ts";
import type { Hold } from "./follow.ts";
import { cross, direction as unit, dot, minus, plus, times, type Vector } from "../math/rotations.ts";

// How a pointer turns something about an axis. Points and directions are three numbers each, in one frame; a ray is where
// the camera is and a unit direction. Nothing here needs the page or three.js.

interface Ray {
  origin: Vector;
  direction: Vector;
}

/** a point on an axis and its unit direction */
interface Line {
  origin: Vector;
  direction: Vector;
}

// An axis within 20° of the view plane is seen from the side.
const FROM_THE_SIDE = Math.sin((20 * Math.PI) / 180);

// A point is above or below the axis where the angle from there is less than 20°, by the cosine of the other one.
const EDGE = FROM_THE_SIDE;

// Something thin is rolled as if it were so many times thicker than the least distance from the axis.
const THIN = 2.5;

const goneAlong: (a: Vector, s: number, b: Vector) => Vector = (a, s, b) => plus(a, times(s, b));

/** Where a ray meets the plane through a point; null where it does not. */
function meet(ray: Ray, point: Vector, normal: Vector) {
  const along = dot(minus(point, ray.origin), normal) / dot(ray.direction, normal);
  return along > 0 && Number.isFinite(along) ? goneAlong(ray.origin, along, ray.direction) : null;
}

/**
 * The angle from one pointer to the next about an axis, for something grabbed at a point.
 *
 * Where the camera sees the axis from the front, the angle is that between the places at which both rays meet the plane
 * across the axis at the point. Where it sees it from the side, the surface is taken along by its near side, as a ball is
 * under a hand: the way of the pointer across the axis, in the plane through the point that faces the camera, over the
 * distance of the point from the axis. Above or below the axis, where the point is as near to its far side as to its near
 * side, `prefer` says which way it turns when it is pulled towards the axis.
 */
export class SweptAngle {
  centre: Vector;
  radius: number;
  view: Vector;
  sign = 1;
  fromTheSide: boolean;

  /** @param least distance from the axis [m] within which a pointer says no angle */
  constructor(
    readonly axis: Line,
    readonly point: Vector,
    eye: Vector,
    readonly least: number,
  ) {
    const along = dot(minus(point, axis.origin), axis.direction);
    this.centre = goneAlong(axis.origin, along, axis.direction);
    this.radius = Math.hypot(...minus(point, this.centre));
    this.view = unit(minus(point, eye));
    this.fromTheSide = Math.abs(dot(this.view, axis.direction)) < FROM_THE_SIDE;
  }

  /** The direction on the screen, in the world, in which the near side goes with a positive angle; its length is a sine. */
  get near() {
    return cross(this.view, this.axis.direction);
  }

  /** Turn this way, if both are as good, when the point is pulled towards the axis. */
  prefer(way: 1 | -1) {
    const arm = minus(this.point, this.centre);
    if (!this.fromTheSide || Math.abs(dot(arm, this.view)) > EDGE * this.radius) return;
    this.sign = dot(arm, this.near) > 0 ? -way : way;
  }

  /** @returns [rad]; 0 where the pointer says nothing */
  between(before: Ray, now: Ray): number {
    return this.fromTheSide ? this.rolled(before, now) : this.turned(before, now);
  }

  turned(before: Ray, now: Ray): number {
    const { direction } = this.axis;
    const [a, b] = [before, now].map((ray) => {
      const met = meet(ray, this.centre, direction);
      return met && minus(met, this.centre);
    });
    if (!a || !b || Math.hypot(...a) < this.least || Math.hypot(...b) < this.least) return 0;
    return Math.atan2(dot(cross(a, b), direction), dot(a, b));
  }

  rolled(before: Ray, now: Ray): number {
    const [a, b] = [before, now].map((ray) => meet(ray, this.point, this.view));
    const { near } = this;
    const size = Math.hypot(...near);
    // Seen along the axis, at the axis: the pointer turns nothing.
    if (!a || !b || size < 1e-6) return 0;
    return (this.sign * dot(minus(b, a), near)) / size / Math.max(this.radius, THIN * this.least);
  }
}

/**
 * How far a pointer has come along an axis: between the places on the line through a grabbed point that are nearest to
 * the two rays. Seen end on, an axis says nothing.
 *
 * @param direction of the axis, a unit vector
 * @returns [m]
 */
export function sweptDistance(direction: Vector, point: Vector, before: Ray, now: Ray): number {
  const [a, b] = [before, now].map((ray) => {
    const c = dot(direction, ray.direction);
    const w = minus(ray.origin, point);
    const squared = 1 - c * c;
    return squared > 1e-3 ? (dot(direction, w) - c * dot(ray.direction, w)) / squared : NaN;
  });
  return Number.isFinite(b - a) ? b - a : 0;
}

/** A ray of three.js in plain numbers. */
const triples = ({ origin, direction }: Three.Ray) => ({ origin: origin.toArray(), direction: direction.toArray() });

// A pointer so near to an axis [px] says no angle about it.
const NEAR_AXIS = 10;

/** A pointer that takes something along an axis in the world, or about it. */
export class Swept {
  angle: SweptAngle;
  direction: Vector;
  point: Vector;
  before: Ray;

  constructor(viewport: Viewport, origin: Three.Vector3, direction: Three.Vector3, { point, ray }: Hold) {
    this.before = triples(ray);
    this.direction = direction.toArray();
    this.point = point.toArray();
    const line = { origin: origin.toArray(), direction: this.direction };
    this.angle = new SweptAngle(line, this.point, this.before.origin, NEAR_AXIS * viewport.metresPerPixel(point));
  }

  /** How far it has turned since it was asked last [rad]. */
  about(ray: Three.Ray) {
    return this.since(ray, (before, now) => this.angle.between(before, now));
  }

  /** How far it has come since it was asked last [m]. */
  along(ray: Three.Ray) {
    return this.since(ray, (before, now) => sweptDistance(this.direction, this.point, before, now));
  }

  since(ray: Three.Ray, swept: (before: Ray, now: Ray) => number) {
    const { before } = this;
    this.before = triples(ray);
    return swept(before, this.before);
  }
}
