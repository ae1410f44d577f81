import { clamp } from "../math/numbers.js";
import { Limb } from "./limb.js";

/** @import { GazeNumbers, HeadNumbers, Nearest } from "./types.js" */

// Steps of the search for the nearest yaw, and halvings of the step after it.
const STEPS = 120;
const FINER = 48;

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
   * @param {number} near a yaw to try beside the even steps
   * @param {boolean} enforce
   * @returns {Nearest}
   */
  bestYaw(errorOf, bestPitch, near, enforce) {
    const [low, high] = this.yawRange(enforce);
    /** @param {number} yaw @returns {Nearest} */
    const at = (yaw) => {
      const free = bestPitch(Math.cos(yaw), Math.sin(yaw));
      const [least, most] = [-Infinity, Infinity].map((pitch) => this.allowedPitch(yaw, pitch, enforce));
      const pitches = free < least || free > most ? [least, most] : [free];
      const tried = pitches.map((pitch) => ({ values: [yaw, pitch], error: errorOf([yaw, pitch]) }));
      return tried.reduce((a, b) => (a.error < b.error ? a : b));
    };
    let step = (high - low) / STEPS;
    const yaws = [clamp(near, low, high), ...Array.from({ length: STEPS + 1 }, (_, i) => low + i * step)];
    let best = yaws.map(at).reduce((a, b) => (b.error < a.error ? b : a));
    for (let i = 0; i < FINER; i++) {
      const middle = best.values[0];
      for (const yaw of [middle - step, middle + step]) {
        const other = at(clamp(yaw, low, high));
        if (other.error < best.error) best = other;
      }
      step *= 0.5;
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
