import type { Object3D, Scene } from "three";
import { dispose } from "../robot/nodes.ts";
import { THREE } from "../three.ts";
import { Motion } from "./motion.ts";

/** The figure of a clip, in the scene. */
export class Figure {
  object: Object3D;
  mixer: THREE.AnimationMixer;
  action: THREE.AnimationAction;
  /** The box around it at all times. */
  box = new THREE.Box3();

  constructor({ object, clip }: { object: object; clip: object }, scene: Scene) {
    this.object = new THREE.ObjectLoader().parse(object);
    this.mixer = new THREE.AnimationMixer(this.object);
    this.action = this.mixer.clipAction(THREE.AnimationClip.parse(clip)).play();
    scene.add(this.object);
    for (let i = 0; i <= 50; i++) {
      this.show((i / 50) * this.action.getClip().duration);
      this.box.expandByObject(this.object);
    }
  }

  show(time: number) {
    this.action.time = Math.min(time, this.action.getClip().duration);
    this.mixer.update(0);
  }

  remove() {
    dispose(this.object);
  }
}

/** Plays a motion: the clip of the program, key frames, a recording, a file. */
export class MotionPlayback {
  time = 0;
  playing = false;
  looping = true;
  speed = 1;
  request = 0;

  constructor(
    public motion: Motion,
    readonly show: (q: number[], time: number) => void,
  ) {}

  get duration() {
    return this.motion.end;
  }

  play() {
    this.seek(this.time >= this.duration ? 0 : this.time);
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
    this.show(this.motion.at(time), time);
  }

  /** @param time may be after the end, where the robot stands still */
  seek(time: number) {
    this.pause();
    this.time = Math.max(0, time);
    this.show(this.motion.at(this.time), this.time);
  }

  setLoop(on: boolean) {
    this.looping = on;
  }

  setSpeed(speed: number) {
    this.speed = speed;
  }
}
