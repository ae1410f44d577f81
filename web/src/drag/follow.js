// @ts-nocheck
import { degrees, sentence } from "./sentence.js";
import { ArmPlace } from "../ik/arm_place.js";

// How a limb follows what is dragged, by its closed form: from a target in the torso's frame to a configuration inside
// the limits, the other branches, and what there is to say. Each has `follow(target, q)`, whose `answer` tells whether
// the target is reached; it changes nothing. One with a `stride` [m] is to be taken to a target in steps of that length.

// A hand keeps the direction of its forearm where that is possible, and else only its place counts. Either way the arm goes
// on from where it is: what would take a joint farther than JUMP at once, to another posture that meets the place too, is
// refused, and so the way to a place is gone in steps of STRIDE.
export class HandFollower {
  constructor(limb, poseOf) {
    this.limb = limb;
    this.stride = HandFollower.STRIDE;
    const pose = poseOf(limb.frame);
    this.direction = [pose[0], pose[4], pose[8]];
  }

  follow(target, q) {
    const { limb, direction } = this;
    const reference = limb.values(q);
    // An arm outside its limits may come back inside.
    const most = HandFollower.JUMP + Math.max(0, limb.excess(reference));
    const isNear = ({ values }) => values.every((value, i) => Math.abs(value - reference[i]) <= most);
    const kept = limb.solveDirection(target, direction, reference);
    const next = kept.branches.find(isNear);
    if (next) return { answer: kept, q: limb.merged(q, next.values), says: "" };
    const answer = new ArmPlace(limb, target, reference).solve({ near: true });
    if (!answer.branches.some(isNear)) {
      const isKnown = answer.reason !== "REACHED" && answer.reason !== "NOT_ENOUGH_JOINTS";
      return { answer, says: isKnown ? sentence(answer) : "cannot be reached from here" };
    }
    const isKnown = kept.reason !== "REACHED" && kept.reason !== "NOT_ENOUGH_JOINTS";
    const says = `the forearm turns: ${isKnown ? sentence(kept) : "its direction cannot be kept here"}`;
    return { answer, q: limb.merged(q, answer.branches[0].values), says };
  }

  // All branches for the same target, whatever the limits.
  branches(target, q) {
    return this.limb.solveDirection(target, this.direction, this.limb.values(q), false).branches;
  }
}

// The most [rad] that a joint of the arm moves in a step, and the length of a step [m].
Object.assign(HandFollower, { JUMP: 0.3, STRIDE: 0.005 });

// A foot keeps its orientation. The motor of its HipYawPitch moves the other leg too: that foot stays on its place and its
// sole as it is, and only turns about the sole's normal.
export class FootFollower {
  constructor(limb, poseOf, limbs) {
    this.limb = limb;
    this.pose = poseOf(limb.frame);
    this.other = limbs.find((other) => other.kind === "leg" && other !== limb && other.columns[0] === limb.columns[0]);
    if (this.other) this.otherPose = poseOf(this.other.frame);
  }

  follow(target, q) {
    const { limb, other } = this;
    const answer = limb.solve(this.poseAt(target), limb.values(q));
    if (answer.reason !== "REACHED") return { answer, says: sentence(answer) };
    let blocked = null;
    for (const { values } of answer.branches) {
      const moved = limb.merged(q, values);
      if (!other) return { answer, q: moved, says: "" };
      const reference = other.values(moved);
      const stood = other.stand(this.otherPose, reference[0], reference);
      if (stood.reason === "REACHED") {
        const [{ values: others, yaw }] = stood.branches;
        const turn = degrees(yaw, 1);
        const isSeen = Number.parseFloat(turn) !== 0;
        const says = isSeen ? `${other.frame} turns by ${turn} with the hip motor that both legs share` : "";
        return { answer, q: other.merged(moved, others), says };
      }
      blocked ??= stood;
    }
    return { answer: blocked, says: `${other.frame} cannot stay where it is: ${sentence(blocked)}` };
  }

  poseAt([x, y, z]) {
    const pose = [...this.pose];
    [pose[3], pose[7], pose[11]] = [x, y, z];
    return pose;
  }

  branches(target, q) {
    return this.limb.solve(this.poseAt(target), this.limb.values(q), false).branches;
  }
}

// A camera looks at what is dragged, or as near past it as the limits allow.
export class GazeFollower {
  constructor(limb) {
    this.limb = limb;
  }

  follow(target, q) {
    const { limb } = this;
    const answer = limb.solveGaze(target, limb.values(q));
    if (answer.reason === "REACHED") return { answer, q: limb.merged(q, answer.branches[0].values), says: "" };
    if (!answer.nearest) return { answer, says: sentence(answer) };
    const { values, error } = answer.nearest;
    const says = `${sentence(answer)}; looks ${degrees(error, 1)} past it`;
    return { answer, q: limb.merged(q, values), says };
  }

  branches(target, q) {
    return this.limb.solveGaze(target, this.limb.values(q), false).branches;
  }
}

export const FOLLOWERS = { arm: HandFollower, leg: FootFollower, gaze: GazeFollower };
