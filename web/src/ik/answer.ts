import { allTurnedTowards, squaredDistance } from "../math/numbers.ts";
import { VERIFIED } from "./tolerances.ts";
import type { Limb } from "./limb.ts";
import type { Branch, Errors, Family, LimbNumbers, Nearest, Reason } from "./types.ts";

/**
 * What a closed form answers for one target: the branches, nearest to the reference first, or the reason for none. The
 * joint named is that of the branch that is least outside the limits.
 */
export class Answer {
  branches: Branch[] = [];

  /** What comes nearest, where the head or a camera does not reach its target. */
  nearest: Nearest | undefined;

  /** Why there is none, or REACHED. */
  reason: Reason = "NOT_CONVERGED";
  joint = -1;
  needed = 0;
  limit = 0;

  /** How far the target was moved to be in reach [m], which the errors of branches include. */
  short = 0;

  /** How far the branch that is blamed is outside the limits [rad]. */
  #excess = Infinity;

  /**
   * @param reference values of its joints
   * @param enforce whether limits are enforced
   */
  constructor(
    readonly limb: Limb<LimbNumbers>,
    readonly reference: number[],
    public enforce: boolean,
  ) {}

  /**
   * @param joint its place in the limb, or -1
   * @param needed the value that the joint would need [rad]; without one, how far the target is out of reach [m]
   * @param limit the end of the joint's range that is in the way [rad]
   */
  blame(reason: Reason, joint: number = -1, needed: number = 0, limit: number = 0) {
    this.reason = reason;
    this.joint = joint;
    this.needed = needed;
    this.limit = limit;
    return this;
  }

  /** Whether a branch is inside the limits; if not, it is blamed where none before was less outside. */
  admits(values: number[]) {
    if (!this.enforce || this.limb.isInside(values)) return true;
    const outside = this.limb.excess(values);
    if (outside < this.#excess) {
      this.#excess = outside;
      this.blameLimit(values);
    }
    return false;
  }

  /** Blame the joint that is farthest outside. */
  blameLimit(values: number[]) {
    const worst = this.limb.violations(values).reduce((a, b) => (b.outside > a.outside ? b : a));
    const { reason, joint, value, low, high } = worst;
    this.blame(reason, joint, value, low - value > value - high ? low : high);
  }

  /**
   * Take a branch in, if it is verified; without limits with the whole turns that bring each joint within half a turn of
   * the reference.
   *
   * @param errors by forward kinematics
   */
  enter(values: number[], errors: Errors, family: Family = "NONE", yaw: number = 0) {
    if (!errors.every((error) => error <= VERIFIED)) return;
    const near = this.enforce ? [...values] : allTurnedTowards(values, this.reference);
    const withShort: Errors = [errors[0] + this.short, errors[1]];
    const distance = squaredDistance(this.reference, near);
    const branch = { values: near, errors: withShort, family, distance, yaw };
    let place = this.branches.length;
    while (place > 0 && this.branches[place - 1].distance > branch.distance) place--;
    this.branches.splice(place, 0, branch);
  }

  concluded() {
    return this.branches.length > 0 ? this.blame("REACHED") : this;
  }
}
