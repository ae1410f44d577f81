import { cross, direction, dot, minus, norm, plus, times } from "../math/vectors.js";

/** @import { Rotation, Vector } from "../math/types.js" */

/**
 * A pose of the hand: its orientation, and the place of the frame from the shoulder.
 *
 * @typedef {{ R: Rotation, place: Vector }} HandPose
 */

/** Where the elbow can be, seen from the shoulder, when the frame stands at its place and the forearm lies along n. */
export class ElbowCircle {
  /**
   * @param {Vector} place of the frame, from the shoulder
   * @param {Vector} forearm its direction, not zero
   * @param {Vector} hand the frame from the elbow in the axes of the hand
   * @param {number} onAxis the distance [m] up to which the shoulder is on the line of the circle's middle
   */
  constructor(place, forearm, hand, onAxis) {
    this.place = place;
    this.n = direction(forearm);
    const middle = minus(place, times(hand[0], this.n));
    /** Where the middle is: so far along n, and so far across it, in the direction v. */
    this.along = dot(middle, this.n);
    const v = minus(middle, times(this.along, this.n));
    this.across = norm(v);
    // With the shoulder on the line any direction across will do.
    this.v = direction(this.across <= onAxis ? acrossTo(this.n) : v);
    this.radius = Math.hypot(hand[1], hand[2]);
    this.beta = Math.atan2(hand[2], hand[1]);
  }

  /** The least and the largest distance of the circle from the shoulder. */
  get reach() {
    const { along, across, radius } = this;
    return [Math.hypot(along, across - radius), Math.hypot(along, across + radius)];
  }

  /**
   * The pose of the hand with which the elbow is at an angle on the circle, from the side of the shoulder.
   *
   * @param {number} angle [rad]
   * @returns {HandPose}
   */
  handAt(angle) {
    const { n, v, place } = this;
    const k = plus(times(Math.cos(angle), v), times(Math.sin(angle), cross(n, v)));
    const o = cross(n, k);
    const [c, s] = [Math.cos(this.beta), Math.sin(this.beta)];
    const [y, z] = [minus(times(c, k), times(s, o)), plus(times(s, k), times(c, o))];
    return { R: [n[0], y[0], z[0], n[1], y[1], z[1], n[2], y[2], z[2]], place };
  }
}

/**
 * A vector across a unit vector.
 *
 * @param {Vector} n
 * @returns {Vector}
 */
function acrossTo(n) {
  /** @type {Vector} */
  const s = Math.abs(n[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0];
  return minus(s, times(dot(s, n), n));
}
