import { degrees, sentence } from "./sentence.js";
import { ArmPlace } from "../ik/arm_place.js";
import { Leg } from "../ik/leg.js";
import { product, turned } from "../math/rotations.js";

/** @typedef {import("../ik/answer.js").Answer} Answer */
/** @typedef {import("../ik/types.js").Branch} Branch */
/** @typedef {import("../math/types.js").Pose} Pose */
/** @typedef {import("./types.js").Followed} Followed */
/** @typedef {import("./types.js").Follower} Follower */
/** @typedef {import("./types.js").Limb} Limb */
/** @typedef {import("../math/types.js").Rotation} Rotation */
/** @typedef {import("../math/types.js").Vector} Vector */

// How a limb follows what is dragged, by its closed form: from a target in the torso's frame to a configuration inside
// the limits, the other branches, and what there is to say.

// The most [rad] that a joint of the arm moves in a step, and the length of a step [m].
const [JUMP, STRIDE] = [0.3, 0.005];

/** @param {Answer} answer */
const isExplained = ({ reason }) => reason !== "REACHED" && reason !== "NOT_ENOUGH_JOINTS";

/**
 * A hand keeps the direction of its forearm where that is possible, and else only its place counts. Either way the arm
 * goes on from where it is: what would take a joint farther than JUMP at once, to another posture that meets the place
 * too, is refused, and so the way to a place is gone in steps of STRIDE.
 *
 * @implements {Follower}
 */
export class HandFollower {
  stride = STRIDE;

  /**
   * @param {import("../ik/arm.js").Arm} limb
   * @param {(frame: string) => Pose} poseOf
   */
  constructor(limb, poseOf) {
    this.limb = limb;
    const pose = poseOf(limb.frame);
    /** @type {Vector} */
    this.place = [pose[3], pose[7], pose[11]];
    /** @type {Vector} */
    this.direction = [pose[0], pose[4], pose[8]];
  }

  /** @type {(target: Vector, q: number[]) => Followed} */
  follow(target, q) {
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

  /** @type {(rotation: Rotation, q: number[]) => Followed} */
  turn(rotation, q) {
    const { limb } = this;
    const reference = limb.values(q);
    const answer = limb.solveDirection(this.place, turned(rotation, this.direction), reference);
    const next = answer.branches.find(this.nearTo(reference));
    if (next) return { q: limb.merged(q, next.values), says: "" };
    return { says: isExplained(answer) ? sentence(answer) : "the forearm cannot turn farther from here" };
  }

  /**
   * Whether a branch is so near that the arm can go on to it. An arm outside its limits may come back inside.
   *
   * @param {number[]} reference
   */
  nearTo(reference) {
    const most = JUMP + Math.max(0, this.limb.excess(reference));
    /** @param {Branch} branch */
    return ({ values }) => values.every((value, i) => Math.abs(value - reference[i]) <= most);
  }

  /** @type {(target: Vector, q: number[]) => Branch[]} */
  branches(target, q) {
    return this.limb.solveDirection(target, this.direction, this.limb.values(q), false).branches;
  }
}

/**
 * A foot keeps its orientation. The motor of its HipYawPitch moves the other leg too: that foot stays on its place and its
 * sole as it is, and only turns about the sole's normal.
 *
 * @implements {Follower}
 */
export class FootFollower {
  /**
   * @param {import("../ik/leg.js").Leg} limb
   * @param {(frame: string) => Pose} poseOf
   * @param {Limb[]} limbs
   */
  constructor(limb, poseOf, limbs) {
    this.limb = limb;
    this.pose = poseOf(limb.frame);
    /** The leg on the same motor, and the pose of its foot. */
    this.other = limbs
      .filter((other) => other instanceof Leg)
      .find((other) => other !== limb && other.columns[0] === limb.columns[0]);
    this.otherPose = poseOf((this.other ?? limb).frame);
  }

  /** @type {(target: Vector, q: number[]) => Followed} */
  follow(target, q) {
    return this.followPose(this.poseAt(target), q);
  }

  /** @type {(rotation: Rotation, q: number[]) => Followed} */
  turn(rotation, q) {
    const { pose } = this;
    const before = /** @type {Rotation} */ ([0, 1, 2, 4, 5, 6, 8, 9, 10].map((i) => pose[i]));
    const R = product(rotation, before);
    const rows = [0, 1, 2].flatMap((row) => [...R.slice(3 * row, 3 * row + 3), pose[4 * row + 3]]);
    return this.followPose(/** @type {Pose} */ ([...rows, 0, 0, 0, 1]), q);
  }

  /** @type {(pose: Pose, q: number[]) => Followed} */
  followPose(pose, q) {
    const { limb, other } = this;
    const answer = limb.solve(pose, limb.values(q));
    if (answer.reason !== "REACHED") return { says: sentence(answer) };
    /** @type {Answer | null} */
    let blocked = null;
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

  /** @type {(place: Vector) => Pose} */
  poseAt([x, y, z]) {
    /** @type {Pose} */
    const pose = [...this.pose];
    [pose[3], pose[7], pose[11]] = [x, y, z];
    return pose;
  }

  /** @type {(target: Vector, q: number[]) => Branch[]} */
  branches(target, q) {
    return this.limb.solve(this.poseAt(target), this.limb.values(q), false).branches;
  }
}

/**
 * A camera looks at what is dragged, or as near past it as the limits allow.
 *
 * @implements {Follower}
 */
export class GazeFollower {
  /** @param {import("../ik/gaze.js").Gaze} limb */
  constructor(limb) {
    this.limb = limb;
  }

  /** @type {(target: Vector, q: number[]) => Followed} */
  follow(target, q) {
    const { limb } = this;
    const answer = limb.solveGaze(target, limb.values(q));
    if (answer.reason === "REACHED") return { q: limb.merged(q, answer.branches[0].values), says: "" };
    if (!answer.nearest) return { says: sentence(answer) };
    const { values, error } = answer.nearest;
    return { q: limb.merged(q, values), says: `${sentence(answer)}; looks ${degrees(error, 1)} past it` };
  }

  /** @type {(target: Vector, q: number[]) => Branch[]} */
  branches(target, q) {
    return this.limb.solveGaze(target, this.limb.values(q), false).branches;
  }
}

/**
 * By the kind of limb.
 *
 * @type {Record<string, new (limb: any, poseOf: (frame: string) => Pose, limbs: Limb[]) => Follower>}
 */
export const FOLLOWERS = { arm: HandFollower, leg: FootFollower, gaze: GazeFollower };
