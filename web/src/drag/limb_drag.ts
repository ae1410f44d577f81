import type { PageWith } from "../app.ts";
import { clamp, squaredDistance } from "../math/numbers.ts";
import { distance, minus, plus, times, type Rotation, type Vector } from "../math/rotations.ts";
import type { Viewport } from "../pick/pick.ts";
import type { Ghosts } from "../scene/ghosts.ts";
import type { Axis } from "../scene/shapes.ts";
import { THREE } from "../three.ts";
import {
  LAST_STEP,
  directionsAround,
  feetCross,
  followerOf,
  footOf,
  nearestPlace,
  type Gesture,
  type Handle,
  type Hold,
  type Limb,
  type Follower,
} from "./follow.ts";
import { Swept } from "./swept_angle.ts";

type Page = PageWith<"ghosts" | "pick" | "robot" | "stance">;

// Two branches are different if their squared distance is above OTHER. Then the looks of their ghosts, inside the limits
// and outside.
const OTHER = 1e-6;
const INSIDE = { colour: "#2f6fe0", opacity: 0.3 };
const OUTSIDE = { colour: "#5c6678", opacity: 0.1 };

/**
 * Drag of a handle: the limb follows it by its closed form in the plane that faces the camera; the trunk stays.
 */
export class LimbDrag implements Gesture {
  follower: Follower;
  pulled: ReturnType<Viewport["pulled"]> | null;
  floor: number;
  place: Vector;
  says: string | undefined;

  constructor(
    readonly page: Page,
    readonly limbs: Limb[],
    readonly ghosts: Ghosts,
    readonly handle: Handle,
    hold: Hold | null,
  ) {
    const { limb } = handle;
    this.follower = followerOf(page.robot, limb, limbs);
    const at = handle.knob.getWorldPosition(new THREE.Vector3());
    this.pulled = hold && page.pick.viewport.pulled(at, hold.ray);
    // The sole must not go below the floor; a sole that is already below must not go lower.
    const isOnFloor = limb.kind === "leg" && !page.robot.about.floating;
    this.floor = isOnFloor ? at.y - Math.max(0, footOf(page.robot, limb).low) : -Infinity;
    this.place = this.inTorso(at);
  }

  /** @param options `level` is whether the handle moves only up and down on the screen */
  move(ray: THREE.Ray, options: { level: boolean }) {
    const to = this.pulled?.(ray, options);
    return to ? this.moveTo(to) : (this.says ?? "");
  }

  /** Move the handle from its current place to the right and up on the screen [m]. */
  step(right: number, up: number) {
    return this.moveTo(this.page.pick.viewport.shift(this.inWorld(this.place), right, up));
  }

  /** @param to in the world */
  moveTo(to: THREE.Vector3) {
    const isBelow = to.y < this.floor;
    if (isBelow) to.setY(this.floor);
    this.says = this.follow(this.inTorso(to), isBelow ? "the sole is on the floor" : "");
    return this.says;
  }

  end() {
    this.handle.knob.position.set(this.handle.ahead, 0, 0);
    this.ghosts.clear();
  }

  /** Move the limb to a target in the torso's frame, or to the nearest reachable point in the plane of the drag. */
  follow(target: Vector, notice: string) {
    const { page, follower, handle } = this;
    const near = this.approach(target);
    let followed = follower.follow(target, near.q);
    const { says } = followed;
    let place = target;
    if (!followed.q) {
      place = nearestPlace(target, near.place, this.directions(), (tried) => this.isReached(tried, near.q));
      followed = follower.follow(place, near.q);
    }
    if (followed.q) {
      this.place = place;
      page.ghosts.clearAnswers();
      const others = this.others(place, followed.q);
      page.stance.set(followed.q);
      page.stance.settle();
      this.ghosts.show(others, page.robot.linkOf(handle.limb.joints[0]));
      // The handle of the gaze stays under the pointer, even if the camera cannot look exactly at it.
      if (handle.ahead) handle.knob.position.copy(handle.mark.worldToLocal(this.inWorld(target)));
    }
    const crossing = feetCross(page.robot, handle.limb, this.limbs) ? "the feet cross" : "";
    const said = [notice, says, crossing].filter(Boolean).join("; ");
    return said && `${handle.limb.frame}: ${said}`;
  }

  /**
   * Move towards a target in strides along a straight line; return the place and the configuration that are less than a
   * stride from it, or at which the line leaves the reach.
   */
  approach(target: Vector) {
    const { follower, place } = this;
    const strides = Math.ceil(distance(place, target) / (follower.stride ?? Infinity));
    let near = { place, q: this.page.stance.q };
    for (let i = 1; i < strides; i++) {
      const next = plus(place, times(i / strides, minus(target, place)));
      const { q } = follower.follow(next, near.q);
      if (!q) break;
      near = { place: next, q };
    }
    return near;
  }

  isReached(place: Vector, q: number[]): boolean {
    const isAbove = this.inWorld(place).y > this.floor - LAST_STEP;
    return isAbove && Boolean(this.follower.follow(place, q).q);
  }

  /** Unit vectors in the plane of the drag, in the torso's frame. */
  directions() {
    const toTorso = new THREE.Matrix4().copy(this.torso.matrixWorld).invert();
    const [right, up] = this.page.pick.viewport.axes.map((axis) => axis.transformDirection(toTorso).toArray());
    return directionsAround(right, up);
  }

  /** The other branches for a target as ghosts, fainter if they are outside the limits. */
  others(target: Vector, q: number[]) {
    const { limb } = this.handle;
    const own = limb.values(q);
    return this.follower
      .branches(target, q)
      .filter(({ values }) => squaredDistance(values, own) > OTHER)
      .map(({ values }) => ({ q: limb.merged(q, values), ...(limb.isInside(values) ? INSIDE : OUTSIDE) }));
  }

  // --- frames --------------------------------------------------------------------------------------------------

  get torso() {
    return this.page.robot.frameNode(this.handle.limb.torso);
  }

  /** @param point in the world */
  inTorso(point: THREE.Vector3): Vector {
    return this.torso.worldToLocal(point.clone()).toArray();
  }

  /** @param place in the torso */
  inWorld(place: Vector) {
    return this.torso.localToWorld(new THREE.Vector3().fromArray(place));
  }
}

// The turn to an angle is made in steps [rad]; a step that cannot be made is halved up to HALVINGS times.
const [STEP, HALVINGS] = [0.05, 8];

/**
 * Drag of a ring, by the pointer or by keys: the limb turns its frame about the axis of the ring, in place, as far as it
 * can.
 */
export class TurnDrag implements Gesture {
  follower: Follower;
  axis: THREE.Vector3;
  wanted = 0;
  reached = 0;
  swept: Swept | null;

  constructor(
    readonly page: Page,
    limbs: Limb[],
    readonly limb: Limb,
    { axis }: Axis,
    hold: Hold | null,
  ) {
    const { robot, pick } = page;
    this.follower = followerOf(robot, limb, limbs);
    const own = new THREE.Vector3(...axis);
    this.axis = own.clone().transformDirection(robot.poseIn(limb.frame, limb.torso));
    const node = robot.frameNode(limb.frame);
    const origin = node.getWorldPosition(new THREE.Vector3());
    this.swept = hold && new Swept(pick.viewport, origin, own.transformDirection(node.matrixWorld), hold);
  }

  move(ray: THREE.Ray) {
    this.wanted += this.swept?.about(ray) ?? 0;
    return this.turn();
  }

  /** @param angle by which to turn from the current orientation [rad] */
  step(angle: number) {
    this.wanted = this.reached + angle;
    return this.turn();
  }

  /** Turn as far towards the wanted angle as the limb can; returns a message, which may be empty. */
  turn() {
    const { page } = this;
    let { q } = page.stance;
    let says = "";
    let step = STEP;
    while (this.reached !== this.wanted && step > STEP / 2 ** HALVINGS) {
      const next = this.reached + clamp(this.wanted - this.reached, -step, step);
      const followed = this.follower.turn?.(this.rotation(next), q);
      if (followed?.q) [q, this.reached] = [followed.q, next];
      else step *= 0.5;
      says = followed?.says ?? "";
    }
    page.stance.set(q);
    page.stance.settle();
    return says && `${this.limb.frame}: ${says}`;
  }

  end() {}

  /** The rotation by an angle about the ring's axis, in the torso's frame, row by row. */
  rotation(angle: number): Rotation {
    const { elements: m } = new THREE.Matrix4().makeRotationAxis(this.axis, angle);
    return [m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]];
  }
}
