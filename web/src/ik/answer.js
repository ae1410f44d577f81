// @ts-nocheck
import { TOLERANCES } from "./tolerances.js";
import { allTurnedTowards, squaredDistance } from "../math/numbers.js";

// What a closed form answers for one target: the branches, nearest to the reference first, or the reason for none. The
// joint named is that of the branch that is least outside the limits; without one, `needed` is how far the target is out
// of reach [m].
export class Answer {
  constructor(limb, reference, enforce) {
    this.limb = limb;
    Object.assign(this, { reference, enforce, branches: [], excess: Infinity });
    this.blame("NOT_CONVERGED");
  }

  blame(reason, joint = -1, needed = 0, limit = 0) {
    Object.assign(this, { reason, joint, needed, limit });
    return this;
  }

  // Whether a branch is inside the limits; if not, it is reported where none before was less outside.
  admits(values) {
    if (!this.enforce || this.limb.isInside(values)) return true;
    const outside = this.limb.excess(values);
    if (outside < this.excess) {
      this.excess = outside;
      this.blameLimit(values);
    }
    return false;
  }

  // Report the joint that is farthest outside.
  blameLimit(values) {
    let worst = { outside: -Infinity };
    for (const entry of this.limb.violations(values)) if (entry.outside > worst.outside) worst = entry;
    const { reason, joint, value, low, high } = worst;
    this.blame(reason, joint, value, low - value > value - high ? low : high);
  }

  // Take a branch in, if forward kinematics, which gave these errors [m, rad], verifies it; without limits with the
  // whole turns that bring each joint within half a turn of the reference.
  enter(values, errors, family = "NONE") {
    if (!errors.every((error) => error <= TOLERANCES.VERIFIED)) return;
    const near = this.enforce ? [...values] : allTurnedTowards(values, this.reference);
    const branch = { values: near, errors, family, distance: squaredDistance(this.reference, near) };
    let place = this.branches.length;
    while (place > 0 && this.branches[place - 1].distance > branch.distance) place--;
    this.branches.splice(place, 0, branch);
  }

  concluded() {
    return this.branches.length > 0 ? this.blame("REACHED") : this;
  }
}
