import { clamp } from "../math/numbers.js";
import { Limb } from "./limb.js";

/** @import { GazeNumbers, HeadNumbers, Nearest } from "./types.js" */

// Steps of the search for the nearest yaw, divisions after it, and the share of the range that one keeps.
const STEPS = 120;
const DIVISIONS = 60;
const GOLDEN = 0.5 * (Math.sqrt(5) - 1);

/**
 * HeadYaw and HeadPitch, R = Rz(yaw) Ry(pitch), and the search for the values of both that come nearest to a target.
 *
 * @template {HeadNumbers | GazeNumbers} Numbers
 * @extends {Limb<Numbers>}
 */
export class Neck extends Limb {
  /**
   * The joint values with the smallest error: by search along the yaw, with the best pitch of each.
   *
   * @param {(values: number[]) => number} errorOf [rad]
   * @param {(c: number, s: number) => number} bestPitch at the cosine and sine of a yaw, whatever the limits
   * @param {boolean} enforce
   * @returns {Nearest}
   */
  bestYaw(errorOf, bestPitch, enforce) {
    const [low, high] = this.yawRange(enforce);
    /** @param {number} yaw @returns {Nearest} */
    const at = (yaw) => {
      const free = bestPitch(Math.cos(yaw), Math.sin(yaw));
      const [least, most] = [-Infinity, Infinity].map((pitch) => this.allowedPitch(yaw, pitch, enforce));
      const pitches = free < least || free > most ? [least, most] : [free];
      const tried = pitches.map((pitch) => ({ values: [yaw, pitch], error: errorOf([yaw, pitch]) }));
      return tried.reduce((a, b) => (a.error < b.error ? a : b));
    };
    const step = (high - low) / STEPS;
    const grid = Array.from({ length: STEPS + 1 }, (_, i) => at(low + i * step));
    let best = grid.reduce((a, b) => (b.error < a.error ? b : a));
    let [left, right] = [Math.max(low, best.values[0] - step), Math.min(high, best.values[0] + step)];
    for (let i = 0; i < DIVISIONS; i++) {
      const width = GOLDEN * (right - left);
      const [one, two] = [at(right - width), at(left + width)];
      if (one.error < two.error) right = two.values[0];
      else left = one.values[0];
      const lesser = one.error < two.error ? one : two;
      if (lesser.error < best.error) best = lesser;
    }
    return best;
  }

  /**
   * @param {boolean} enforce
   * @returns {[number, number]}
   */
  yawRange(enforce) {
    return enforce ? [this.lower[0], this.upper[0]] : [-Math.PI, Math.PI];
  }

  /**
   * The pitch nearest to one that is allowed at a yaw.
   *
   * @param {number} yaw
   * @param {number} pitch
   * @param {boolean} enforce
   */
  allowedPitch(yaw, pitch, enforce) {
    if (!enforce) return pitch;
    const [low, high] = [this.lower[1], this.upper[1]];
    const [least, most] = this.tableRange(yaw).map((bound) => clamp(bound, low, high));
    return clamp(pitch, least, most);
  }
}
