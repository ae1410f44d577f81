import { clamp, squaredDistance, wrapped } from "../math/numbers.ts";
import { distance, dot, rotX, turned, type Vector } from "../math/rotations.ts";
import type { Arm } from "./arm.ts";
import { Answer, ROUNDING } from "./limb.ts";

// Number of values tried for ElbowYaw and for WristYaw, and the number of minima on this grid that the search refines.
const GRID = 15;
const BEST = 6;
// The last step of the whole search, and of the search around the reference only [rad].
const LAST_STEP = 1e-9;
const LAST_STEP_NEAR = 1e-4;
// After a step that fails: the factor on the step and the turn of its directions [rad]. Then the largest number of steps.
const SHORTER = 0.7;
const TURN = 0.3;
const MOST_STEPS = 400;
// The cost of values outside the limits, and of choices with which the position cannot be met.
const OUTSIDE = 1e3;
const IMPOSSIBLE = 1e6;

/** The best solution for one choice of ElbowYaw and WristYaw. */
interface Member {
  cost: number;
  yaw: number;
  wrist: number;
  values: number[];
}

/**
 * The arm for a position of its frame alone, which leaves two joints free: the solution nearest to the reference.
 *
 * The search chooses ElbowYaw and WristYaw; the other three joints follow in closed form, so the position is met to
 * rounding. It goes over a grid and then refines its best points. For a drag, which needs a fast answer, it looks only
 * around the reference, with a larger last step.
 */
export class ArmPlace {
  place: Vector;
  answer: Answer;
  yaws: number[];
  wrists: number[];
  stepYaw: number;
  stepWrist: number;

  /** @param target in the torso */
  constructor(
    readonly arm: Arm,
    target: Vector,
    reference: number[],
    enforce = true,
  ) {
    this.place = arm.fromShoulder(target);
    this.answer = new Answer(arm, reference, enforce);
    /** Lower and upper end of ElbowYaw and of WristYaw. */
    this.yaws = enforce ? [arm.lower[2], arm.upper[2]] : [-Math.PI, Math.PI];
    this.wrists = enforce ? [arm.lower[4], arm.upper[4]] : [-Math.PI, Math.PI];
    this.stepYaw = (this.yaws[1] - this.yaws[0]) / (GRID - 1);
    this.stepWrist = (this.wrists[1] - this.wrists[0]) / (GRID - 1);
  }

  /** The answer, with one branch or none. */
  solve({ near = false } = {}) {
    const { arm, answer, place } = this;
    if (arm.isTooFar(place, answer)) return answer;
    const starts = near ? [this.#atReference()] : [...this.#bestOfGrid(), this.#atReference()];
    const ends = starts.map((start) => this.#descend(start, near ? LAST_STEP_NEAR : LAST_STEP));
    const best = ends.reduce((a, b) => (b.cost < a.cost ? b : a));
    if (best.cost < OUTSIDE) {
      answer.addBranch(best.values, [distance(arm.forward(best.values).place, place), 0], "REDUNDANT");
      if (answer.branches.length > 0) return answer.finish();
    }
    answer.setReason("NOT_ENOUGH_JOINTS");
    if (best.cost < IMPOSSIBLE) answer.setLimitReason(best.values);
    return answer;
  }

  #atReference() {
    const { reference } = this.answer;
    return this.#memberInside(reference[2], reference[4]);
  }

  /** The best local minima of the grid. Its best points alone would all lie side by side around one minimum. */
  #bestOfGrid() {
    const numbers = [...Array(GRID).keys()];
    const grid = numbers.map((i) =>
      numbers.map((j) => this.#member(this.yaws[0] + i * this.stepYaw, this.wrists[0] + j * this.stepWrist)),
    );
    const around = (i: number, j: number) =>
      grid.slice(Math.max(0, i - 1), i + 2).flatMap((row) => row.slice(Math.max(0, j - 1), j + 2));
    const lowest = grid.flatMap((row, i) =>
      row.filter(({ cost }, j) => around(i, j).every((other) => cost <= other.cost)),
    );
    return lowest.sort((a, b) => a.cost - b.cost).slice(0, BEST);
  }

  /** Search from one solution in eight directions for better ones, until the steps are too small. */
  #descend(start: Member, lastStep: number) {
    let best = start;
    const longest = 0.5 * Math.max(this.stepYaw, this.stepWrist);
    let [step, turn] = [longest, 0];
    for (let count = 0; step > lastStep && count < MOST_STEPS; count++) {
      const better = this.#betterAround(best, step, turn);
      // In a narrow valley a step may fail in all eight directions, so these are turned; after a success steps grow again.
      [step, turn] = better ? [Math.min(2 * step, longest), turn] : [SHORTER * step, turn + TURN];
      best = better ?? best;
    }
    return best;
  }

  #betterAround({ cost, yaw, wrist }: Member, step: number, turn: number) {
    for (let i = 0; i < 8; i++) {
      const angle = 0.25 * Math.PI * i + turn;
      const tried = this.#memberInside(yaw + step * Math.cos(angle), wrist + step * Math.sin(angle));
      if (tried.cost < cost) return tried;
    }
    return null;
  }

  #memberInside(yaw: number, wrist: number) {
    const [low, high] = this.yaws;
    return this.#member(clamp(yaw, low, high), clamp(wrist, this.wrists[0], this.wrists[1]));
  }

  /** The best of the four solutions for the position with this ElbowYaw and WristYaw. */
  #member(yaw: number, wrist: number): Member {
    const { place } = this;
    const [ex, ey] = this.arm.elbow;
    const [c3, s3] = [Math.cos(yaw), Math.sin(yaw)];
    // The frame relative to the elbow, before ElbowRoll.
    const [gx, gy, gz] = turned(rotX(wrist), this.arm.hand);
    const squares = ex * ex + ey * ey + gx * gx + gy * gy + gz * gz;
    // a cos q₄ + b sin q₄ = k, from the distance between shoulder and frame
    const [a, b] = [ex * gx + ey * c3 * gy, ey * c3 * gx - ex * gy];
    const k = 0.5 * (dot(place, place) - squares) + ey * s3 * gz;
    const beyond = a * a + b * b - k * k;
    let best = { cost: Infinity, yaw, wrist, values: [0, 0, yaw, 0, wrist] };
    if (beyond < 0) return { ...best, cost: IMPOSSIBLE * (1 - beyond) };
    const [root, middle] = [Math.atan2(Math.sqrt(beyond), k), Math.atan2(b, a)];
    for (const bend of [1, -1]) {
      const roll = wrapped(middle + bend * root);
      const [c4, s4] = [Math.cos(roll), Math.sin(roll)];
      const [vx, vy] = [c4 * gx - s4 * gy, s4 * gx + c4 * gy];
      const [mx, my, mz] = [ex + vx, ey + c3 * vy - s3 * gz, s3 * vy + c3 * gz];
      const left = place[0] * place[0] + place[2] * place[2] - mz * mz;
      if (left < 0) {
        best.cost = Math.min(best.cost, IMPOSSIBLE * (1 - left));
        continue;
      }
      for (const side of [1, -1]) {
        const across = side * Math.sqrt(left);
        const pitch = Math.atan2(mz * place[0] - across * place[2], across * place[0] + mz * place[2]);
        const shoulder = wrapped(Math.atan2(place[1], across) - Math.atan2(my, mx));
        const values = [pitch, shoulder, yaw, roll, wrist];
        const cost = this.#cost(values);
        if (cost < best.cost) best = { cost, yaw, wrist, values };
      }
    }
    return best;
  }

  #cost(values: number[]) {
    const outside = this.answer.enforce ? this.arm.excess(values) : 0;
    if (outside > ROUNDING) return OUTSIDE * (1 + outside);
    return squaredDistance(this.answer.reference, values);
  }
}
