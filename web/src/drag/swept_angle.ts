import type * as Three from "three";
import type { Viewport } from "../pick/pick.ts";
import type { Hold } from "./gestures.ts";
import { cross, direction as unit, distance, dot, minus, plus, times, type Vector } from "../math/rotations.ts";

// How a pointer turns something about an axis. Points and directions are three numbers each, in one frame; a ray is the
// position of the camera and a unit direction. `SweptAngle` needs neither the page nor three.js.

interface Ray {
  origin: Vector;
  direction: Vector;
}

// An axis within 20° of the view plane counts as seen from the side: the sine of that angle.
const FROM_THE_SIDE = Math.sin((20 * Math.PI) / 180);

// A point counts as at the edge, above or below the axis, within 20° of it: the cosine of the complement.
const EDGE = FROM_THE_SIDE;

// A thin object is rolled as if its radius were at least this many times the least distance from the axis.
const THIN = 2.5;

const goneAlong: (a: Vector, s: number, b: Vector) => Vector = (a, s, b) => plus(a, times(s, b));

/** The point where a ray meets the plane through a point; null if it does not meet it. */
function meet(ray: Ray, point: Vector, normal: Vector) {
  const along = dot(minus(point, ray.origin), normal) / dot(ray.direction, normal);
  return along > 0 && Number.isFinite(along) ? goneAlong(ray.origin, along, ray.direction) : null;
}

/**
 * The angle about an axis from one position of the pointer to the next, for an object grabbed at a point.
 *
 * If the camera sees the axis from the front, both rays meet the plane normal to the axis through the point, and the angle
 * is that between these two places about the axis. If the camera sees the axis from the side, the pointer rolls the near
 * side, as a hand rolls a ball: the angle is the pointer's motion across the axis, in the plane through the point that faces
 * the camera, divided by the distance of the point from the axis. At the edge, above or below the axis, the point belongs to
 * the near and the far side alike; there `prefer` decides which way it turns when it is pulled towards the axis.
 */
export class SweptAngle {
  centre = goneAlong(
    this.axis.origin,
    dot(minus(this.point, this.axis.origin), this.axis.direction),
    this.axis.direction,
  );
  radius = distance(this.point, this.centre);
  view = unit(minus(this.point, this.eye));
  sign = 1;
  fromTheSide = Math.abs(dot(this.view, this.axis.direction)) < FROM_THE_SIDE;

  /** @param least distance from the axis [m] within which the pointer gives no angle */
  constructor(
    readonly axis: Ray,
    readonly point: Vector,
    readonly eye: Vector,
    readonly least: number,
  ) {}
  /**
   * The direction in which the near side moves on the screen for a positive angle, in the world. Its length is the sine of
   * the angle between view and axis.
   */
  get near() {
    return cross(this.view, this.axis.direction);
  }

  /** At the edge, turn this way when the point is pulled towards the axis. */
  prefer(way: 1 | -1) {
    const arm = minus(this.point, this.centre);
    if (!this.fromTheSide || Math.abs(dot(arm, this.view)) > EDGE * this.radius) return;
    this.sign = dot(arm, this.near) > 0 ? -way : way;
  }

  /** @returns the angle [rad]; 0 if the pointer gives none */
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
    // No ray meets the plane, or the axis points at the camera: no angle.
    if (!a || !b || size < 1e-6) return 0;
    return (this.sign * dot(minus(b, a), near)) / size / Math.max(this.radius, THIN * this.least);
  }
}

/**
 * The distance of a pointer's motion along an axis: between the points nearest to the two rays on the line along the axis
 * through the grabbed point. It is 0 if the axis points at the camera.
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

// Nearer to an axis than this [px], the pointer gives no angle about it.
const NEAR_AXIS = 10;

/** Follows a pointer that moves something along an axis in the world, or turns it about the axis. */
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

  /** The angle turned since the last call [rad]. */
  about(ray: Three.Ray) {
    return this.since(ray, (before, now) => this.angle.between(before, now));
  }

  /** The distance moved since the last call [m]. */
  along(ray: Three.Ray) {
    return this.since(ray, (before, now) => sweptDistance(this.direction, this.point, before, now));
  }

  since(ray: Three.Ray, swept: (before: Ray, now: Ray) => number) {
    const { before } = this;
    this.before = triples(ray);
    return swept(before, this.before);
  }
}
