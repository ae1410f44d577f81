import { element } from "../panel/element.ts";
import { Motion } from "./motion.ts";
import type { Player } from "./player.ts";

/**
 * Reduce the samples of a motion, so that straight lines between the remaining ones stay within a tolerance of all others
 * (Ramer, Douglas and Peucker, for each number separately). Null if that takes more than `most` samples.
 */
export function thinned(motion: Motion, tolerance: number, most: number) {
  const { times, values, width, count } = motion;
  const kept = new Set([0, count - 1]);
  const open = [[0, count - 1]];
  for (let stretch = open.pop(); stretch; stretch = open.pop()) {
    const [first, last] = stretch;
    let [furthest, at] = [tolerance, -1];
    for (let i = first + 1; i < last; i++) {
      const share = (times[i] - times[first]) / (times[last] - times[first]);
      for (let column = 0; column < width; column++) {
        const [from, to] = [values[first * width + column], values[last * width + column]];
        const off = Math.abs(values[i * width + column] - from - share * (to - from));
        if (off > furthest) [furthest, at] = [off, i];
      }
    }
    if (at < 0) continue;
    kept.add(at);
    if (kept.size > most) return null;
    open.push([first, at], [at, last]);
  }
  const places = [...kept].sort((a, b) => a - b);
  return Motion.of(
    places.map((place) => times[place]),
    places.map((place) => motion.row(place)),
  );
}

/** The button that records the robot's motion, whatever moves it, and makes a clip of it. */
export class Recording {
  recorder: Recorder | null = null;
  began = 0;
  button = this.player.switch(
    "record",
    "Record the motion",
    () => (this.recorder ? this.stop() : this.start()),
    "Record",
  );
  clock = element("span", { className: "clock" });
  timer: number | undefined;

  constructor(readonly player: Player) {
    this.button.classList.add("record");
    this.button.append(this.clock);
  }

  get time() {
    return (performance.now() - this.began) / 1000;
  }

  start() {
    const { page } = this.player;
    this.recorder = new Recorder(page.stance.q.length);
    this.began = performance.now();
    this.recorder.add(0, page.stance.q);
    this.timer = setInterval(() => this.sample(), 1000 / RATE);
    this.button.setAttribute("aria-pressed", "true");
    this.button.ariaLabel = "Stop recording";
    this.button.title = "Stop recording";
    this.show();
  }

  sample() {
    const { recorder } = this;
    if (!recorder) return;
    const { rate } = recorder;
    recorder.add(this.time, this.player.page.stance.q);
    this.show();
    if (recorder.rate === rate) return;
    this.player.say(
      `The recording is long: from now on ${recorder.rate.toFixed(1)} configurations per second are kept.`,
    );
  }

  show() {
    const seconds = Math.floor(this.time);
    const text = `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
    if (this.clock.textContent !== text) this.clock.textContent = text;
  }

  stop() {
    const { player, recorder } = this;
    clearInterval(this.timer);
    recorder?.add(this.time, player.page.stance.q, true);
    this.recorder = null;
    this.clock.textContent = "";
    this.button.setAttribute("aria-pressed", "false");
    this.button.ariaLabel = this.button.title = "Record the motion";
    const motion = recorder?.motion;
    if (!motion) return;
    player.pause();
    const clip = player.playing(motion);
    // The robot is where the recording ends.
    clip.time = clip.duration;
    player.setClip(clip);
    player.say(`${motion.count} configurations recorded in ${motion.end.toFixed(1)} s`);
  }
}

/** Samples per second, while there is room. */
const RATE = 30;

// The largest count of numbers kept: 36 000 samples of a NAO, 20 minutes at 30 per second.
const MOST_NUMBERS = 36_000 * 25;

/**
 * Records configurations over time in memory of bounded size: when it is full, every second sample is dropped and the rate
 * is halved. So even a long recording is kept from its beginning.
 */
export class Recorder {
  rate = RATE;
  count = 0;
  times = new Float64Array(this.most);
  values = new Float64Array(this.most * this.width);

  /**
   * @param width numbers of a configuration
   * @param most samples, at least 2
   */
  constructor(
    readonly width: number,
    readonly most: number = Math.max(2, Math.floor(MOST_NUMBERS / width)),
  ) {}

  /** Time of the last sample [s]. */
  get end() {
    return this.count > 0 ? this.times[this.count - 1] : 0;
  }

  /**
   * Take a sample, unless the last one is too recent.
   *
   * @param whatever take it in any case, as the last sample of a recording
   */
  add(time: number, q: ArrayLike<number>, whatever: boolean = false) {
    const age = time - this.end;
    // Timers are not exact, so a sample may come a tenth of the interval early.
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

  /** The recorded motion; null if there are no samples. */
  get motion() {
    if (this.count === 0) return null;
    return new Motion(this.times.slice(0, this.count), this.values.slice(0, this.count * this.width));
  }
}
