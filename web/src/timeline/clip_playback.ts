import { THREE } from "../three.ts";
import { Motion } from "./motion.ts";
import type { MeshcatViewer } from "../types.ts";

/** Plays the clip that came from Python; meshcat's animator does the work. */
export class ClipPlayback {
  known: Motion | null | undefined;

  /**
   * @param begin called before the clip, rather than anything else, says how the robot stands
   * @param fps configurations per second
   */
  constructor(
    readonly viewer: MeshcatViewer,
    readonly begin: () => void,
    readonly fps: number,
  ) {
    // An action that is not under way takes no notice of seeking.
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

  /** The same as configurations; null where the clip moves something else. */
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
    if (this.time >= this.duration) this.seek(0);
    this.begin();
    this.animator.play();
    this.viewer.set_dirty();
  }

  pause() {
    if (this.playing) this.animator.pause();
  }

  seek(time: number) {
    this.pause();
    this.begin();
    for (const action of this.animator.actions) {
      action.paused = false;
      action.play();
    }
    this.animator.seek(time);
    this.animator.display_progress(time);
  }

  /** @param on whether it begins again when it ends */
  setLoop(on: boolean) {
    for (const action of this.animator.actions) action.setLoop(THREE.LoopRepeat, on ? Infinity : 1);
  }

  /** @param speed 1 for its own */
  setSpeed(speed: number) {
    this.animator.mixer.timeScale = speed;
  }
}
