import { Motion } from "./motion.ts";

/** Samples a second, while there is room. */
export const RATE = 30;

// Numbers that are kept at most: 36 000 samples of a NAO, 20 minutes at 30 a second.
const MOST_NUMBERS = 36_000 * 25;

/**
 * Configurations over time in memory of bounded size: when it is full, every second sample is dropped, and from then on
 * half as many are taken. So a recording of any length is there from its beginning.
 */
export class Recorder {
  rate = RATE;
  count = 0;
  times;
  values;

  /**
   * @param width numbers of a configuration
   * @param most samples, at least 2
   */
  constructor(
    readonly width: number,
    readonly most: number = Math.max(2, Math.floor(MOST_NUMBERS / width)),
  ) {
    this.times = new Float64Array(most);
    this.values = new Float64Array(most * width);
  }

  /** Time of the last sample [s]. */
  get end() {
    return this.count > 0 ? this.times[this.count - 1] : 0;
  }

  /**
   * Take a sample, unless the last one is too young.
   *
   * @param time [s]
   * @param whatever take it all the same: the last one of a recording
   */
  add(time: number, q: ArrayLike<number>, whatever: boolean = false) {
    const age = time - this.end;
    // Timers are not punctual: a tenth too early is early enough.
    if (this.count > 0 && (age <= 0 || (!whatever && age < 0.9 / this.rate))) return;
    if (this.count === this.most) this.halve();
    this.times[this.count] = time;
    this.values.set(Array.from(q), this.count * this.width);
    this.count += 1;
  }

  halve() {
    const { times, values, width } = this;
    const left = Math.ceil(this.count / 2);
    for (let i = 1; i < left; i++) {
      times[i] = times[2 * i];
      values.copyWithin(i * width, 2 * i * width, (2 * i + 1) * width);
    }
    this.count = left;
    this.rate /= 2;
  }

  /** What was recorded; null where that is nothing. */
  get motion() {
    if (this.count === 0) return null;
    return new Motion(this.times.slice(0, this.count), this.values.slice(0, this.count * this.width));
  }
}
