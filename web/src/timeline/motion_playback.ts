import type { Motion } from "./motion.ts";

/** Plays a motion of this page: key frames, a recording, a file. */
export class MotionPlayback {
  time = 0;
  playing = false;
  looping = true;
  speed = 1;
  request = 0;

  constructor(
    public motion: Motion,
    readonly show: (q: number[]) => void,
  ) {}

  get duration() {
    return this.motion.end;
  }

  play() {
    if (this.time >= this.duration) this.time = 0;
    this.pause();
    this.playing = true;
    let last = performance.now();
    const step = (now: number) => {
      this.step(Math.max(0, now - last) / 1000);
      last = Math.max(now, last);
      if (this.playing) this.request = requestAnimationFrame(step);
    };
    this.request = requestAnimationFrame(step);
  }

  pause() {
    this.playing = false;
    // Played again before the next picture, it would else go on twice as fast.
    cancelAnimationFrame(this.request);
  }

  /** @param seconds that have passed */
  step(seconds: number) {
    let time = this.time + seconds * this.speed;
    if (time >= this.duration) {
      if (this.looping && this.duration > 0) time %= this.duration;
      else {
        time = this.duration;
        this.playing = false;
      }
    }
    this.time = time;
    this.show(this.motion.at(time));
  }

  /** @param time may be behind the end, where the robot stands still */
  seek(time: number) {
    this.pause();
    this.time = Math.max(0, time);
    this.show(this.motion.at(this.time));
  }

  setLoop(on: boolean) {
    this.looping = on;
  }

  setSpeed(speed: number) {
    this.speed = speed;
  }
}
