import { cross, direction as unit, dot, minus, plus, times } from "../math/vectors.js";

// How a pointer turns something about an axis. Points and directions are three numbers each, in one frame; a ray is where
// the camera is and a unit direction. Nothing here needs the page or three.js.

/** @typedef {import("../math/types.js").Vector} Vector */
/** @typedef {{ origin: Vector, direction: Vector }} Ray */
/** @typedef {{ origin: Vector, direction: Vector }} Line a point on an axis and its unit direction */

// An axis within 20° of the view plane is seen from the side.
const FROM_THE_SIDE = Math.sin((20 * Math.PI) / 180);

// A point is above or below the axis where the angle from there is less than 20°, by the cosine of the other one.
const EDGE = FROM_THE_SIDE;

// Something thin is rolled as if it were so many times thicker than the least distance from the axis.
const THIN = 2.5;

/** @type {(a: Vector, s: number, b: Vector) => Vector} */
const goneAlong = (a, s, b) => plus(a, times(s, b));

/**
 * Where a ray meets the plane through a point; null where it does not.
 *
 * @param {Ray} ray
 * @param {Vector} point
 * @param {Vector} normal
 */
function meet(ray, point, normal) {
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
  /**
   * @param {Line} axis
   * @param {Vector} point where it is grabbed
   * @param {Vector} eye where the camera is
   * @param {number} least distance from the axis [m] within which a pointer says no angle
   */
  constructor(axis, point, eye, least) {
    this.axis = axis;
    this.least = least;
    const along = dot(minus(point, axis.origin), axis.direction);
    this.centre = goneAlong(axis.origin, along, axis.direction);
    this.point = point;
    this.radius = Math.hypot(...minus(point, this.centre));
    this.view = unit(minus(point, eye));
    this.sign = 1;
    this.fromTheSide = Math.abs(dot(this.view, axis.direction)) < FROM_THE_SIDE;
  }

  /** The direction on the screen, in the world, in which the near side goes with a positive angle; its length is a sine. */
  get near() {
    return cross(this.view, this.axis.direction);
  }

  /**
   * Turn this way, if both are as good, when the point is pulled towards the axis.
   *
   * @param {1 | -1} way
   */
  prefer(way) {
    const arm = minus(this.point, this.centre);
    if (!this.fromTheSide || Math.abs(dot(arm, this.view)) > EDGE * this.radius) return;
    this.sign = dot(arm, this.near) > 0 ? -way : way;
  }

  /**
   * @param {Ray} before
   * @param {Ray} now
   * @returns {number} [rad]; 0 where the pointer says nothing
   */
  between(before, now) {
    return this.fromTheSide ? this.rolled(before, now) : this.turned(before, now);
  }

  /** @type {(before: Ray, now: Ray) => number} */
  turned(before, now) {
    const { direction } = this.axis;
    const [a, b] = [before, now].map((ray) => {
      const met = meet(ray, this.centre, direction);
      return met && minus(met, this.centre);
    });
    if (!a || !b || Math.hypot(...a) < this.least || Math.hypot(...b) < this.least) return 0;
    return Math.atan2(dot(cross(a, b), direction), dot(a, b));
  }

  /** @type {(before: Ray, now: Ray) => number} */
  rolled(before, now) {
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
 * @param {Vector} direction of the axis, a unit vector
 * @param {Vector} point where it is grabbed
 * @param {Ray} before
 * @param {Ray} now
 * @returns {number} [m]
 */
export function sweptDistance(direction, point, before, now) {
  const [a, b] = [before, now].map((ray) => {
    const c = dot(direction, ray.direction);
    const w = minus(ray.origin, point);
    const squared = 1 - c * c;
    return squared > 1e-3 ? (dot(direction, w) - c * dot(ray.direction, w)) / squared : NaN;
  });
  return Number.isFinite(b - a) ? b - a : 0;
}
