import { clamp } from "../math/numbers.ts";
import { Motion, type Interpolation } from "./motion.ts";

// Rounds in which a change of one segment may change the slopes, and so the speeds, of the next.
const MOST_ROUNDS = 30;

// A limit may be exceeded by this share without a message, because times are rounded.
const ROUNDING = 1e-9;

/**
 * The segments that exceed a speed limit, each with the column that needs most time, and the time [s] that it needs.
 *
 * @param limits the speed limit of each number of q [1/s]; null for none
 */
export function excesses(motion: Motion, limits: readonly (number | null)[]) {
  const found = [];
  for (let segment = 0; segment < motion.count - 1; segment++) {
    let [worst, column] = [1, -1];
    limits.forEach((limit, i) => {
      if (limit === null || !(limit > 0)) return;
      const share = motion.fastest(segment, i) / limit;
      if (share > worst * (1 + ROUNDING)) [worst, column] = [share, i];
    });
    const needs = worst * (motion.times[segment + 1] - motion.times[segment]);
    if (column >= 0) found.push({ segment, column, needs });
  }
  return found;
}

/**
 * New times of a motion's keys that keep every speed limit: segments that are too fast take as long as they need, in
 * whole milliseconds, and all later keys move later.
 */
export function slowedTimes(motion: Motion, limits: readonly (number | null)[]): number[] {
  let slowed = motion;
  for (let round = 0; round < MOST_ROUNDS; round++) {
    const needed = new Map(excesses(slowed, limits).map(({ segment, needs }) => [segment, needs]));
    if (needed.size === 0) break;
    const times = [slowed.start];
    for (let segment = 0; segment < slowed.count - 1; segment++) {
      const width = slowed.times[segment + 1] - slowed.times[segment];
      const needs = needed.get(segment);
      const longer =
        needs === undefined ? width : Math.max(Math.ceil(needs * 1000), Math.floor(width * 1000) + 1) / 1000;
      times.push(times[segment] + longer);
    }
    const rounded = times.map((time) => Math.round(time * 1e6) / 1e6);
    slowed = new Motion(rounded, motion.values, motion.interpolation);
  }
  return Array.from(slowed.times);
}

/** A time [s] and the configuration at that time. */
export interface Key {
  time: number;
  q: readonly number[];
}

/** The least time between two keys, and the latest time of a key [s]. */
export const GAP = 0.01;
export const LATEST = 3600;

/** The largest number of keys. */
export const MOST_KEYS = 500;

/** The time between the last key and one that is added after it [s]. */
const STEP = 1;

/**
 * Key frames in order of time. They are immutable: the methods that edit them return new ones. Methods that add or move a
 * key also return its place.
 */
export class KeyFrames {
  /** @param keys ascending in time */
  constructor(
    readonly keys: readonly Key[] = [],
    readonly interpolation: Interpolation = "linear",
  ) {}

  static from(motion: Motion) {
    const keys = Array.from(motion.times, (time, i) => ({ time, q: motion.row(i) }));
    return new KeyFrames(keys, motion.interpolation === "smooth" ? "smooth" : "linear");
  }

  get count() {
    return this.keys.length;
  }

  /** The motion through the keys; null without keys. */
  get motion() {
    if (this.count === 0) return null;
    return Motion.of(
      this.keys.map(({ time }) => time),
      this.keys.map(({ q }) => q),
      this.interpolation,
    );
  }

  /** The place of the key at a time; −1 if there is none. */
  at(time: number) {
    return this.keys.findIndex((key) => Math.abs(key.time - time) < GAP / 2);
  }

  /** The time for a new key: the given time, or after the last key if there is a key at that time already. */
  nextTime(time: number) {
    if (this.count === 0 || this.at(time) < 0) return time;
    return this.keys[this.count - 1].time + STEP;
  }

  adding(time: number, q: ArrayLike<number>) {
    return this.putting(this.keys, { time, q: Array.from(q) });
  }

  /** @param place of the key that is copied to after the last key */
  duplicating(place: number) {
    return this.adding(this.keys[this.count - 1].time + STEP, this.keys[place].q);
  }

  /** @param time wanted; the nearest free time is used */
  moving(place: number, time: number) {
    return this.putting(this.keys.toSpliced(place, 1), { ...this.keys[place], time });
  }

  replacing(place: number, q: ArrayLike<number>) {
    return new KeyFrames(this.keys.with(place, { ...this.keys[place], q: Array.from(q) }), this.interpolation);
  }

  without(place: number) {
    return new KeyFrames(this.keys.toSpliced(place, 1), this.interpolation);
  }

  interpolating(interpolation: Interpolation) {
    return new KeyFrames(this.keys, interpolation);
  }

  /** @param times new times of the keys, ascending */
  retimed(times: ArrayLike<number>) {
    return new KeyFrames(
      this.keys.map(({ q }, i) => ({ time: times[i], q })),
      this.interpolation,
    );
  }

  putting(others: readonly Key[], key: Key) {
    const time = freeTime(
      others.map((other) => other.time),
      key.time,
    );
    const place = others.findIndex((other) => other.time > time);
    const at = place < 0 ? others.length : place;
    return { frames: new KeyFrames(others.toSpliced(at, 0, { ...key, time }), this.interpolation), place: at };
  }
}

/** The time nearest to the wanted one, in whole milliseconds, that is at least GAP from every other key. */
function freeTime(others: readonly number[], wanted: number) {
  const rounded = (time: number) => Math.round(time * 1000) / 1000;
  const inside = clamp(rounded(wanted), 0, LATEST);
  const isFree = (time: number) => others.every((other) => Math.abs(other - time) > GAP - 1e-9);
  if (isFree(inside)) return inside;
  const beside = others.flatMap((other) => [Math.ceil((other + GAP - 1e-9) * 1000) / 1000, rounded(other - GAP)]);
  return beside
    .filter((time) => time >= 0 && time <= LATEST && isFree(time))
    .reduce((best, time) => (Math.abs(time - inside) < Math.abs(best - inside) ? time : best), Infinity);
}
