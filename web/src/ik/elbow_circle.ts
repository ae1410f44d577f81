import { cross, direction, dot, minus, norm, plus, times } from "../math/vectors.ts";
import type { Rotation, Vector } from "../math/types.ts";

/** A pose of the hand: its orientation, and the place of the frame from the shoulder. */
export interface HandPose {
  R: Rotation;
  place: Vector;
}

/** Where the elbow can be, seen from the shoulder, when the frame stands at its place and the forearm lies along n. */
export class ElbowCircle {
  n: Vector;
  along: number;
  across: number;
  v: Vector;
  radius: number;
  beta: number;

  /**
   * @param place of the frame, from the shoulder
   * @param forearm its direction, not zero
   * @param hand the frame from the elbow in the axes of the hand
   * @param onAxis the distance [m] up to which the shoulder is on the line of the circle's middle
   */
  constructor(
    readonly place: Vector,
    forearm: Vector,
    hand: Vector,
    onAxis: number,
  ) {
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
   * @param angle [rad]
   */
  handAt(angle: number): HandPose {
    const { n, v, place } = this;
    const k = plus(times(Math.cos(angle), v), times(Math.sin(angle), cross(n, v)));
    const o = cross(n, k);
    const [c, s] = [Math.cos(this.beta), Math.sin(this.beta)];
    const [y, z] = [minus(times(c, k), times(s, o)), plus(times(s, k), times(c, o))];
    return { R: [n[0], y[0], z[0], n[1], y[1], z[1], n[2], y[2], z[2]], place };
  }
}

/** A vector across a unit vector. */
function acrossTo(n: Vector): Vector {
  const s: Vector = Math.abs(n[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0];
  return minus(s, times(dot(s, n), n));
}
