import { THREE } from "../three.ts";
import type { MeshcatViewer } from "../types.ts";
import { Motion } from "./motion.ts";

/** The curves of a clip, as nao_kin.viewer.cubics describes them. */
export interface Curves {
  times: Float64Array;
  q: Float64Array;
  handles: Float64Array | null;
}

/**
 * Plays the clip that came from Python; meshcat's animator does the work. Of a clip with curves it counts the time, and the
 * configurations are those of the curves.
 */
export class ClipPlayback {
  known: Motion | null | undefined;
  readonly curves: Motion | null;

  /**
   * @param begin called before the clip takes over the robot's vertical
   * @param fps configurations per second
   */
  constructor(
    readonly viewer: MeshcatViewer,
    readonly begin: () => void,
    readonly fps: number,
    curves: Curves | null,
  ) {
    this.curves =
      curves && new Motion(curves.times, curves.q, curves.handles ? "bezier" : "linear", curves.handles ?? []);
    this.known = this.curves ?? undefined;
    // An action that is not playing ignores seeking.
    for (const action of this.animator.actions) action.play();
    if (this.playing) this.begin();
    else this.seek(0);
  }

  get animator() {
    return this.viewer.animator;
  }

  get duration() {
    return this.animator.duration;
  }

  get time() {
    return this.animator.time;
  }

  get playing() {
    return this.animator.playing;
  }

  /** The configuration of the curves now; null if the animator gives it. */
  get q() {
    // The animator's duration is a rounded one.
    return this.curves && this.curves.at(this.time >= this.duration ? Infinity : this.time);
  }

  /** The clip as a motion; null if the clip moves anything but the robot's configuration. */
  get motion(): Motion | null {
    if (this.known === undefined) {
      const tracks = this.animator.actions.flatMap((action) => action.getClip().tracks);
      const track = tracks.find(({ name }) => name === ".joint_values");
      const times = Array.from(track?.times ?? [], (_, i) => i / this.fps);
      this.known = track && times.length > 0 ? new Motion(times, track.values) : null;
    }
    return this.known;
  }

  play() {
    this.seek(this.time >= this.duration ? 0 : this.time);
    this.animator.play();
    this.viewer.set_dirty();
  }

  pause() {
    if (this.playing) this.animator.pause();
  }

  seek(time: number) {
    this.pause();
    this.begin();
    // The mixer writes only values that differ from those it wrote last, but the robot may have moved since. Stopping the
    // actions makes it forget these values.
    for (const action of this.animator.actions) action.stop().play();
    this.animator.seek(time);
    this.animator.display_progress(time);
  }

  /** @param on whether playback begins again at the end */
  setLoop(on: boolean) {
    for (const action of this.animator.actions) action.setLoop(THREE.LoopRepeat, on ? Infinity : 1);
  }

  setSpeed(speed: number) {
    this.animator.mixer.timeScale = speed;
  }
}

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
    // Otherwise, playing again before the next picture would make it run twice as fast.
    cancelAnimationFrame(this.request);
  }

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

  /** @param time may be after the end, where the robot stands still */
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
