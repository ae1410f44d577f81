import { degrees, sentence } from "./sentence.ts";
import { ArmPlace } from "../ik/arm_place.ts";
import { Leg } from "../ik/leg.ts";
import { product, turned } from "../math/rotations.ts";
import type { Answer } from "../ik/answer.ts";
import type { Branch } from "../ik/types.ts";
import type { Pose, Rotation, Vector } from "../math/types.ts";
import type { Followed, Follower, Limb } from "./types.ts";
import type { Arm } from "../ik/arm.ts";
import type { Gaze } from "../ik/gaze.ts";

// How a limb follows what is dragged, by its closed form: from a target in the torso's frame to a configuration inside
// the limits, the other branches, and what there is to say.

// The most [rad] that a joint of the arm moves in a step, and the length of a step [m].
const [JUMP, STRIDE] = [0.3, 0.005];

const isExplained = ({ reason }: Answer) => reason !== "REACHED" && reason !== "NOT_ENOUGH_JOINTS";

/**
 * A hand keeps the direction of its forearm where that is possible, and else only its place counts. Either way the arm
 * goes on from where it is: what would take a joint farther than JUMP at once, to another posture that meets the place
 * too, is refused, and so the way to a place is gone in steps of STRIDE.
 */
export class HandFollower implements Follower {
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

  /** Whether a branch is so near that the arm can go on to it. An arm outside its limits may come back inside. */
  nearTo(reference: number[]) {
    const most = JUMP + Math.max(0, this.limb.excess(reference));
    return ({ values }: Branch) => values.every((value, i) => Math.abs(value - reference[i]) <= most);
  }

  branches(target: Vector, q: number[]): Branch[] {
    return this.limb.solveDirection(target, this.direction, this.limb.values(q), false).branches;
  }
}

/**
 * A foot keeps its orientation. The motor of its HipYawPitch moves the other leg too: that foot stays on its place and its
 * sole as it is, and only turns about the sole's normal.
 */
export class FootFollower implements Follower {
  pose;
  other: Leg | undefined;
  otherPose;

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

/** A camera looks at what is dragged, or as near past it as the limits allow. */
export class GazeFollower implements Follower {
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

/** By the kind of limb. */
export const FOLLOWERS: Record<string, new (limb: any, poseOf: (frame: string) => Pose, limbs: Limb[]) => Follower> = {
  arm: HandFollower,
  leg: FootFollower,
  gaze: GazeFollower,
};
