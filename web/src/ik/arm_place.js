// @ts-nocheck
import { Answer } from "./answer.js";
import { TOLERANCES } from "./tolerances.js";
import { clamp, dot, squaredDistance, wrapped } from "../math/numbers.js";
import { rotX, turned } from "../math/rotations.js";

// The arm for the place of its frame alone, which leaves two joints free: the member of that family nearest to the
// reference. ElbowYaw and WristYaw are chosen, the other three follow in closed form, so that the place is met to
// rounding, and the choice is searched for: on a grid, then around the best of it; or only around the reference, with
// larger last steps, which is what a drag can wait for.
export class ArmPlace {
  constructor(arm, target, reference, enforce = true) {
    this.arm = arm;
    this.place = arm.fromShoulder(target);
    this.answer = new Answer(arm, reference, enforce);
    const [yaw, wrist] = enforce ? [2, 4].map((joint) => [arm.lower[joint], arm.upper[joint]]) : [[], []];
    [this.lowYaw, this.highYaw] = [yaw[0] ?? -Math.PI, yaw[1] ?? Math.PI];
    [this.lowWrist, this.highWrist] = [wrist[0] ?? -Math.PI, wrist[1] ?? Math.PI];
    const { GRID } = ArmPlace;
    this.stepYaw = (this.highYaw - this.lowYaw) / (GRID - 1);
    this.stepWrist = (this.highWrist - this.lowWrist) / (GRID - 1);
  }

  // The answer, with one branch or none.
  solve({ near = false } = {}) {
    const { arm, answer, place } = this;
    if (arm.isTooFar(place, answer)) return answer;
    const { OUTSIDE, IMPOSSIBLE, LAST_STEP, LAST_STEP_NEAR } = ArmPlace;
    const starts = near ? [this.atReference()] : [...this.bestOfGrid(), this.atReference()];
    let best = { cost: Infinity };
    for (const start of starts) {
      const end = this.descend(start, near ? LAST_STEP_NEAR : LAST_STEP);
      if (end.cost < best.cost) best = end;
    }
    if (best.cost < OUTSIDE) {
      const made = arm.forward(best.values);
      answer.enter(best.values, [Math.hypot(...made.place.map((value, k) => value - place[k])), 0], "REDUNDANT");
      if (answer.branches.length > 0) return answer.concluded();
    }
    answer.blame("NOT_ENOUGH_JOINTS");
    if (best.cost < IMPOSSIBLE) answer.blameLimit(best.values);
    return answer;
  }

  atReference() {
    const { reference } = this.answer;
    return this.member(
      clamp(reference[2], this.lowYaw, this.highYaw),
      clamp(reference[4], this.lowWrist, this.highWrist),
    );
  }

  bestOfGrid() {
    const { GRID, BEST } = ArmPlace;
    const members = [];
    for (let i = 0; i < GRID; i++) {
      for (let j = 0; j < GRID; j++) {
        members.push(this.member(this.lowYaw + i * this.stepYaw, this.lowWrist + j * this.stepWrist));
      }
    }
    return members.sort((a, b) => a.cost - b.cost).slice(0, BEST);
  }

  // From one choice in steps to better ones, in eight directions, until the steps are too small.
  descend(start, lastStep) {
    let best = start;
    let step = 0.5 * Math.max(this.stepYaw, this.stepWrist);
    while (step > lastStep) {
      const better = this.betterAround(best, step);
      if (better) best = better;
      else step *= 0.5;
    }
    return best;
  }

  betterAround({ cost, yaw, wrist }, step) {
    for (let i = 0; i < 8; i++) {
      const angle = 0.25 * Math.PI * i;
      const tried = this.member(
        clamp(yaw + step * Math.cos(angle), this.lowYaw, this.highYaw),
        clamp(wrist + step * Math.sin(angle), this.lowWrist, this.highWrist),
      );
      if (tried.cost < cost) return tried;
    }
    return null;
  }

  // Cost and joint values of the best of the four ways to meet the place with this ElbowYaw and WristYaw.
  member(yaw, wrist) {
    const { place } = this;
    const [ex, ey] = this.arm.elbow;
    const [c3, s3] = [Math.cos(yaw), Math.sin(yaw)];
    // The frame from the elbow, before ElbowRoll.
    const [gx, gy, gz] = turned(rotX(wrist), this.arm.hand);
    const squares = ex * ex + ey * ey + gx * gx + gy * gy + gz * gz;
    // a cos q₄ + b sin q₄ = k from the distance of shoulder and frame
    const [a, b] = [ex * gx + ey * c3 * gy, ey * c3 * gx - ex * gy];
    const k = 0.5 * (dot(place, place) - squares) + ey * s3 * gz;
    const beyond = a * a + b * b - k * k;
    let best = { cost: Infinity, yaw, wrist, values: [0, 0, yaw, 0, wrist] };
    if (beyond < 0) return { ...best, cost: ArmPlace.IMPOSSIBLE * (1 - beyond) };
    const [root, middle] = [Math.atan2(Math.sqrt(beyond), k), Math.atan2(b, a)];
    for (const bend of [1, -1]) {
      const roll = wrapped(middle + bend * root);
      const [c4, s4] = [Math.cos(roll), Math.sin(roll)];
      const [vx, vy] = [c4 * gx - s4 * gy, s4 * gx + c4 * gy];
      const [mx, my, mz] = [ex + vx, ey + c3 * vy - s3 * gz, s3 * vy + c3 * gz];
      const left = place[0] * place[0] + place[2] * place[2] - mz * mz;
      if (left < 0) {
        best.cost = Math.min(best.cost, ArmPlace.IMPOSSIBLE * (1 - left));
        continue;
      }
      for (const side of [1, -1]) {
        const across = side * Math.sqrt(left);
        const pitch = Math.atan2(mz * place[0] - across * place[2], across * place[0] + mz * place[2]);
        const shoulder = wrapped(Math.atan2(place[1], across) - Math.atan2(my, mx));
        const values = [pitch, shoulder, yaw, roll, wrist];
        const cost = this.cost(values);
        if (cost < best.cost) best = { cost, yaw, wrist, values };
      }
    }
    return best;
  }

  cost(values) {
    const outside = this.answer.enforce ? this.arm.excess(values) : 0;
    if (outside > TOLERANCES.LIMIT) return ArmPlace.OUTSIDE * (1 + outside);
    return squaredDistance(this.answer.reference, values);
  }
}

// Choices of ElbowYaw and WristYaw that are tried each, how many of the best are searched around, and the last steps
// [rad]; costs of what is outside the limits, and of choices with which the place cannot be met.
Object.assign(ArmPlace, {
  GRID: 15,
  BEST: 4,
  LAST_STEP: 1e-9,
  LAST_STEP_NEAR: 1e-4,
  OUTSIDE: 1e3,
  IMPOSSIBLE: 1e6,
});
