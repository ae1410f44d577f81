import { clamp } from "../math/numbers.ts";
import { Limb } from "./limb.ts";
import type { GazeNumbers, HeadNumbers, Nearest } from "./types.ts";

// Steps of the search for the nearest yaw, and halvings of the step after it.
const STEPS = 120;
const FINER = 48;

/**
 * HeadYaw and HeadPitch, R = Rz(yaw) Ry(pitch), and the search for the values of both that come nearest to a target.
 */
export class Neck<Numbers extends HeadNumbers | GazeNumbers> extends Limb<Numbers> {
  /**
   * The joint values with the smallest error: by search along the yaw, with the best pitch of each.
   *
   * @param errorOf [rad]
   * @param bestPitch at the cosine and sine of a yaw, whatever the limits
   * @param near a yaw to try beside the even steps
   */
  bestYaw(
    errorOf: (values: number[]) => number,
    bestPitch: (c: number, s: number) => number,
    near: number,
    enforce: boolean,
  ): Nearest {
    const [low, high] = this.yawRange(enforce);
    const at = (yaw: number): Nearest => {
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

  yawRange(enforce: boolean): [number, number] {
    return enforce ? [this.lower[0], this.upper[0]] : [-Math.PI, Math.PI];
  }

  /** The pitch nearest to one that is allowed at a yaw. */
  allowedPitch(yaw: number, pitch: number, enforce: boolean) {
    if (!enforce) return pitch;
    const [low, high] = [this.lower[1], this.upper[1]];
    const [least, most] = this.tableRange(yaw).map((bound) => clamp(bound, low, high));
    return clamp(pitch, least, most);
  }
}
