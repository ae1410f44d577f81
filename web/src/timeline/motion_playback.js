/** Plays a motion of this page: key frames, a recording, a file. */
export class MotionPlayback {
  /**
   * @param {import("./motion.js").Motion} motion
   * @param {(q: number[]) => void} show
   */
  constructor(motion, show) {
    this.motion = motion;
    this.show = show;
    this.time = 0;
    this.playing = false;
    this.looping = true;
    this.speed = 1;
    this.request = 0;
  }

  get duration() {
    return this.motion.end;
  }

  play() {
    if (this.time >= this.duration) this.time = 0;
    this.pause();
    this.playing = true;
    let last = performance.now();
    const step = (/** @type {number} */ now) => {
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

  /** @param {number} seconds that have passed */
  step(seconds) {
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

  /** @param {number} time may be behind the end, where the robot stands still */
  seek(time) {
    this.pause();
    this.time = Math.max(0, time);
    this.show(this.motion.at(this.time));
  }

  /** @param {boolean} on */
  setLoop(on) {
    this.looping = on;
  }

  /** @param {number} speed */
  setSpeed(speed) {
    this.speed = speed;
  }
}
