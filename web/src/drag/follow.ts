import type { Group, Ray, Sprite, Vector3 } from "three";
import type { Arm } from "../ik/arm.ts";
import { ArmPlace } from "../ik/arm_place.ts";
import type { Gaze } from "../ik/head.ts";
import { Leg } from "../ik/leg.ts";
import type { Answer } from "../ik/limb.ts";
import type { AnyLimb, Branch } from "../ik/limbs.ts";
import { distance, plus, product, times, turned, type Pose, type Rotation, type Vector } from "../math/rotations.ts";
import { convexHull, overlap, type Point } from "../math/surfaces.ts";
import type { Robot } from "../robot/robot.ts";
import { THREE, boxOf } from "../three.ts";
import { degrees, sentence } from "./stops.ts";

// Types of a drag: limbs, handles, gestures, and how a limb follows a target.

export type Limb = AnyLimb;

/** The configuration with a limb at its target, without q if that is not reached, and a message for the user. */
interface Followed {
  q?: number[];
  says: string;
}

/** Computes how a limb follows a target in the torso's frame. It does not move the robot. */
export interface Follower {
  /** A target farther away than this is approached in steps of this length [m]. */
  stride?: number;
  follow(target: Vector, q: number[]): Followed;
  /** All branches for the same target, ignoring the limits. */
  branches(target: Vector, q: number[]): Branch[];
  /** Keep the place of the limb's frame at the start, and turn the frame by a rotation in the torso's axes, row by row. */
  turn?(rotation: Rotation, q: number[]): Followed;
}

/** Where a pointer grabs something, in the world. */
export interface Hold {
  point: Vector3;
  ray: Ray;
}

/** Something that can be grabbed: the knob of a handle or a target, an arrow, or a ring. */
export interface Grip {
  /** The limb that it moves, if it moves one. */
  limb?: Limb;
  isLine: boolean;
  /** Points in the world: the middle of a knob, or many points along a line. */
  points(): Vector3[];
  /** Highlight it or not. */
  light(on: boolean): void;
  /** Begin to drag it, with a pointer or, without a hold, with keys. */
  gesture(hold: Hold | null): Gesture;
}

export interface Handle extends Grip {
  limb: Limb;
  mark: Group;
  knob: Sprite;
  /** The distance of the knob from the frame's origin along x [m]. */
  ahead: number;
}

/** A drag in progress. */
export interface Gesture {
  /** Follow the pointer; returns a message, which may be empty. */
  move(ray: Ray, options: { level: boolean }): string;
  /** End the drag. */
  end(): void;
  /** Restore the state before the drag, if it is not the robot's configuration. */
  cancel?(): void;
}

// The search tries WAYS directions and ends when its steps are shorter than LAST_STEP [m], or after TRIES tries.
const WAYS = 16;
const TRIES = 100;
export const LAST_STEP = 1e-4;

/** Unit vectors in all directions of the plane of two orthogonal unit vectors. */
export function directionsAround(right: Vector, up: Vector) {
  return Array.from({ length: WAYS }, (_, i) => {
    const angle = (i * 2 * Math.PI) / WAYS;
    return plus(times(Math.cos(angle), right), times(Math.sin(angle), up));
  });
}

/**
 * The reachable place nearest to a target: a search in a plane, from a reachable place, in steps in several directions. It
 * ends when the steps are a tenth of a millimetre, or after as many tries as one move of the pointer allows.
 *
 * @param from a reachable place
 * @param directions unit vectors in the plane
 */
export function nearestPlace(
  target: Vector,
  from: Vector,
  directions: Vector[],
  isReached: (place: Vector) => boolean,
) {
  let best = from;
  let step = distance(best, target);
  let left = TRIES;
  while (step > LAST_STEP && left > 0) {
    const away = distance(best, target);
    const found = directions
      .map((direction) => plus(best, times(step, direction)))
      .map((place) => ({ place, away: distance(place, target) }))
      .filter((tried) => tried.away < away)
      .sort((a, b) => a.away - b.away)
      .find(({ place }) => left-- > 0 && isReached(place));
    if (found) best = found.place;
    else step *= 0.5;
  }
  return best;
}

interface Foot {
  low: number;
  high: number;
  outline: Point[];
}

/** The shapes of a leg's last link. */
function shapesOf(robot: Robot, limb: Limb) {
  const foot = robot.linkOf(limb.joints[limb.joints.length - 1]);
  return robot.meshes.filter(({ link }) => link === foot);
}

/** The outline of a leg's last link from above, and its lowest and highest vertex, in the world of three.js. */
export function footOf(robot: Robot, limb: Limb): Foot {
  const vertex = new THREE.Vector3();
  const points = [];
  let [low, high] = [Infinity, -Infinity];
  for (const { mesh } of shapesOf(robot, limb)) {
    const { position } = mesh.geometry.attributes;
    for (let i = 0; i < position.count; i++) {
      const { x, y, z } = vertex.fromBufferAttribute(position, i).applyMatrix4(mesh.matrixWorld);
      points.push({ x, y: -z });
      [low, high] = [Math.min(low, y), Math.max(high, y)];
    }
  }
  return { low: Number.isFinite(low) ? low : 0, high, outline: convexHull(points) };
}

/** A box around a foot in the world of three.js, made of the boxes of its shapes, so not the smallest possible. */
function boxAround(robot: Robot, limb: Limb) {
  const box = new THREE.Box3();
  for (const { mesh } of shapesOf(robot, limb)) {
    box.union(boxOf(mesh).clone().applyMatrix4(mesh.matrixWorld));
  }
  return box;
}

/** Whether a foot overlaps that of another leg, by their outlines from above and their heights. */
export function feetCross(robot: Robot, limb: Limb, limbs: Limb[]) {
  if (limb.kind !== "leg") return false;
  // The outlines take a millisecond to compute, and the boxes of most feet are already apart.
  const box = boxAround(robot, limb);
  const near = limbs.filter(
    (other) => other.kind === "leg" && other !== limb && box.intersectsBox(boxAround(robot, other)),
  );
  if (near.length === 0) return false;
  const own = footOf(robot, limb);
  return near
    .map((other) => footOf(robot, other))
    .some((other) => own.low < other.high && other.low < own.high && overlap(own.outline, other.outline));
}

// How a limb follows the pointer by its closed form: from a target in the torso's frame to a configuration inside the
// limits, the other branches, and a message for the user.

// The largest move of an arm joint in a step [rad], and the length of a step [m].
const [JUMP, STRIDE] = [0.3, 0.005];

const isExplained = ({ reason }: Answer) => reason !== "REACHED" && reason !== "NOT_ENOUGH_JOINTS";

/**
 * The arm keeps the direction of its forearm if possible; otherwise only the place of the hand follows. Either way the arm
 * moves continuously: a branch that would move a joint by more than JUMP in a step is refused, although it meets the place
 * too. Therefore the way to a place is divided into steps of STRIDE.
 */
class HandFollower implements Follower {
  stride = STRIDE;

  place: Vector;
  direction: Vector;

  constructor(
    readonly limb: Arm,
    poseOf: (frame: string) => Pose,
  ) {
    const pose = poseOf(limb.frame);
    this.place = [pose[3], pose[7], pose[11]];
    this.direction = [pose[0], pose[4], pose[8]];
  }

  follow(target: Vector, q: number[]): Followed {
    const { limb, direction } = this;
    const reference = limb.values(q);
    const isNear = this.nearTo(reference);
    const kept = limb.solveDirection(target, direction, reference);
    const next = kept.branches.find(isNear);
    if (next) return { q: limb.merged(q, next.values), says: "" };
    const answer = new ArmPlace(limb, target, reference).solve({ near: true });
    if (!answer.branches.some(isNear)) {
      return { says: isExplained(answer) ? sentence(answer) : "cannot be reached from here" };
    }
    const says = `the forearm turns: ${isExplained(kept) ? sentence(kept) : "its direction cannot be kept here"}`;
    return { q: limb.merged(q, answer.branches[0].values), says };
  }

  turn(rotation: Rotation, q: number[]): Followed {
    const { limb } = this;
    const reference = limb.values(q);
    const answer = limb.solveDirection(this.place, turned(rotation, this.direction), reference);
    const next = answer.branches.find(this.nearTo(reference));
    if (next) return { q: limb.merged(q, next.values), says: "" };
    return { says: isExplained(answer) ? sentence(answer) : "the forearm cannot turn farther from here" };
  }

  /** Return a test whether a branch is near enough to move to. An arm outside its limits may move farther, to return. */
  nearTo(reference: number[]) {
    const most = JUMP + Math.max(0, this.limb.excess(reference));
    return ({ values }: Branch) => values.every((value, i) => Math.abs(value - reference[i]) <= most);
  }

  branches(target: Vector, q: number[]): Branch[] {
    return this.limb.solveDirection(target, this.direction, this.limb.values(q), false).branches;
  }
}

/**
 * A foot keeps its orientation. The motor of its HipYawPitch moves the other leg too: the other foot keeps its place and
 * the normal of its sole, and turns only about that normal.
 */
class FootFollower implements Follower {
  pose: Pose;
  other: Leg | undefined;
  otherPose: Pose;

  constructor(
    readonly limb: Leg,
    poseOf: (frame: string) => Pose,
    limbs: Limb[],
  ) {
    this.pose = poseOf(limb.frame);
    /** The leg on the same motor, and the pose of its foot. */
    this.other = limbs
      .filter((other) => other instanceof Leg)
      .find((other) => other !== limb && other.columns[0] === limb.columns[0]);
    this.otherPose = poseOf((this.other ?? limb).frame);
  }

  follow(target: Vector, q: number[]): Followed {
    return this.followPose(this.poseAt(target), q);
  }

  turn(rotation: Rotation, q: number[]): Followed {
    const { pose } = this;
    const before = [0, 1, 2, 4, 5, 6, 8, 9, 10].map((i) => pose[i]) as Rotation;
    const R = product(rotation, before);
    const rows = [0, 1, 2].flatMap((row) => [...R.slice(3 * row, 3 * row + 3), pose[4 * row + 3]]);
    return this.followPose([...rows, 0, 0, 0, 1] as Pose, q);
  }

  followPose(pose: Pose, q: number[]): Followed {
    const { limb, other } = this;
    const answer = limb.solve(pose, limb.values(q));
    if (answer.reason !== "REACHED") return { says: sentence(answer) };
    let blocked: Answer | null = null;
    for (const { values } of answer.branches) {
      const moved = limb.merged(q, values);
      if (!other) return { q: moved, says: "" };
      const reference = other.values(moved);
      const stood = other.stand(this.otherPose, reference[0], reference);
      if (stood.reason === "REACHED") {
        const [{ values: others, yaw }] = stood.branches;
        const turn = degrees(yaw, 1);
        const isSeen = Number.parseFloat(turn) !== 0;
        const says = isSeen ? `${other.frame} turns by ${turn} with the hip motor that both legs share` : "";
        return { q: other.merged(moved, others), says };
      }
      blocked ??= stood;
    }
    return { says: `${other?.frame} cannot stay where it is: ${sentence(blocked ?? answer)}` };
  }

  poseAt([x, y, z]: Vector): Pose {
    const pose: Pose = [...this.pose];
    [pose[3], pose[7], pose[11]] = [x, y, z];
    return pose;
  }

  branches(target: Vector, q: number[]): Branch[] {
    return this.limb.solve(this.poseAt(target), this.limb.values(q), false).branches;
  }
}

/** A camera looks at the point that is dragged, or as near to it as the limits allow. */
class GazeFollower implements Follower {
  constructor(readonly limb: Gaze) {}

  follow(target: Vector, q: number[]): Followed {
    const { limb } = this;
    const answer = limb.solveGaze(target, limb.values(q));
    if (answer.reason === "REACHED") return { q: limb.merged(q, answer.branches[0].values), says: "" };
    if (!answer.nearest) return { says: sentence(answer) };
    const { values, error } = answer.nearest;
    return { q: limb.merged(q, values), says: `${sentence(answer)}; looks ${degrees(error, 1)} past it` };
  }

  branches(target: Vector, q: number[]): Branch[] {
    return this.limb.solveGaze(target, this.limb.values(q), false).branches;
  }
}

/** The follower of each kind of limb. */
const FOLLOWERS: Record<string, new (limb: any, poseOf: (frame: string) => Pose, limbs: Limb[]) => Follower> = {
  arm: HandFollower,
  leg: FootFollower,
  gaze: GazeFollower,
};

/** Make what computes how a limb follows, from the current poses of the limbs. */
export function followerOf(robot: Robot, limb: Limb, limbs: Limb[]) {
  const poseOf = (frame: string) => robot.poseIn(frame, limb.torso).transpose().toArray() as Pose;
  return new FOLLOWERS[limb.kind](limb, poseOf, limbs);
}
