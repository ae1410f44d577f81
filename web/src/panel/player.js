// @ts-nocheck
import { element } from "./element.js";
import { THREE } from "../three.js";

// The bar under the view that plays a clip; meshcat's animator does the work.
export class Player {
  // `begin` is called before the clip, rather than anything else, says how the robot stands.
  constructor(viewer, bar, begin) {
    this.viewer = viewer;
    this.begin = begin;
    this.bar = bar;
    this.looping = true;
    this.button = element("button", { type: "button", onclick: () => this.toggle() });
    this.scrubber = element("input", { type: "range", min: 0, step: "any", ariaLabel: "Time" });
    this.scrubber.oninput = () => this.seek(Number(this.scrubber.value));
    this.clock = element("output");
    this.loop = element("button", { type: "button", className: "loop", title: "Play again and again" }, "↻");
    this.loop.onclick = () => this.setLoop(!this.looping);
    bar.append(this.button, this.scrubber, this.clock, this.loop);
  }

  get animator() {
    return this.viewer.animator;
  }

  get loaded() {
    return this.animator.actions.length > 0;
  }

  load(options) {
    this.bar.hidden = !this.loaded;
    if (!this.loaded) return;
    this.scrubber.max = this.animator.duration;
    // An action that is not under way takes no notice of seeking.
    for (const action of this.animator.actions) action.play();
    this.setLoop(!(options.repetitions <= 1));
    if (this.animator.playing) this.begin();
    else this.seek(0);
    this.refresh();
  }

  unload() {
    this.pause();
    this.animator.clear();
    this.bar.hidden = true;
  }

  toggle() {
    if (this.animator.playing) return this.pause();
    const { animator } = this;
    if (animator.time >= animator.duration) this.seek(0);
    this.begin();
    animator.play();
    this.viewer.set_dirty();
    this.refresh();
  }

  pause() {
    if (this.animator.playing) this.animator.pause();
    this.refresh();
  }

  seek(time) {
    this.pause();
    this.begin();
    for (const action of this.animator.actions) {
      action.paused = false;
      action.play();
    }
    this.animator.seek(time);
    this.animator.display_progress(time);
    this.refresh();
  }

  setLoop(on) {
    const { LoopRepeat } = THREE;
    this.looping = on;
    for (const action of this.animator.actions) action.setLoop(LoopRepeat, on ? Infinity : 1);
    this.loop.setAttribute("aria-pressed", String(on));
  }

  refresh() {
    if (this.bar.hidden) return;
    const { playing, time, duration } = this.animator;
    this.button.textContent = playing ? "❚❚" : "▶";
    this.button.ariaLabel = playing ? "Pause" : "Play";
    if (document.activeElement !== this.scrubber || playing) this.scrubber.value = time;
    this.clock.textContent = `${time.toFixed(2)} / ${duration.toFixed(2)} s`;
  }
}
