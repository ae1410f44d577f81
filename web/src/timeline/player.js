import "./timeline.css";
import { element, iconButton } from "../panel/element.js";
import { PlotStrip } from "../plot/plot_strip.js";
import { Trails } from "../scene/trails.js";
import { ClipPlayback } from "./clip_playback.js";
import { Editor } from "./editor.js";
import { MotionFiles } from "./motion_files.js";
import { MotionPlayback } from "./motion_playback.js";
import { Recording } from "./recording.js";
import { TrailsMenu } from "./trails_menu.js";

/** @typedef {ClipPlayback | MotionPlayback} Playback */

const SPEEDS = [0.1, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 4];

/**
 * The bar under the view: it plays the clip from Python, a recording or key frames, one at a time.
 *
 * Events: "motion" when another one is played, or it was changed; "time" when the time shown is another one.
 */
export class Player extends EventTarget {
  // What comes with the robot, in `start`.
  /** @type {Editor} */ editor;
  /** @type {Recording} */ recording;
  /** @type {PlotStrip} */ plots;
  /** @type {Trails} */ trails;

  /**
   * @param {import("../app.js").App} app
   * @param {HTMLElement} bar
   * @param {() => void} begin called before the clip, rather than anything else, says how the robot stands
   */
  constructor(app, bar, begin) {
    super();
    this.app = app;
    this.bar = bar;
    this.begin = begin;
    this.looping = true;
    this.speed = 1;
    /** The clip from Python, a recording, or a file. @type {Playback | null} */
    this.clip = null;
    /** @type {MotionPlayback | null} */
    this.keys = null;
    /** The one of the two that is played. @type {Playback | null} */
    this.playback = null;
    /** What the bar shows. @type {string | undefined} */
    this.shownState = undefined;
    this.button = element("button", { type: "button", className: "play", onclick: () => this.toggle() });
    this.scrubber = element("input", { type: "range", min: "0", step: "any", ariaLabel: "Time" });
    this.scrubber.oninput = () => this.seek(Number(this.scrubber.value));
    this.clock = element("output", { ariaLive: "off" });
    this.loop = element("button", { type: "button", className: "loop", title: "Play again and again" }, "↻");
    this.loop.ariaLabel = "Play again and again";
    this.loop.onclick = () => this.setLoop(!this.looping);
    this.speeds = element(
      "select",
      { ariaLabel: "Speed", title: "Speed" },
      ...SPEEDS.map((speed) => element("option", { value: `${speed}`, selected: speed === 1 }, `${speed}×`)),
    );
    this.speeds.onchange = () => this.setSpeed(Number(this.speeds.value));
    this.sheets = element("div", { className: "sheets" });
    this.tools = element("div", { className: "actions" });
    const own = element("div", { className: "own" }, this.button, this.scrubber, this.clock, this.loop, this.speeds);
    bar.append(this.sheets, element("div", { className: "transport" }, own, this.tools));
    bar.classList.add("empty");
    new ResizeObserver(() => {
      bar.closest("main")?.style.setProperty("--bar-height", `${bar.offsetHeight}px`);
    }).observe(bar);
    app.addEventListener("started", () => this.start());
  }

  // The robot is there, and the panel.
  start() {
    this.editor = new Editor(this);
    this.recording = new Recording(this);
    this.plots = new PlotStrip(this);
    this.trails = new Trails(this.app, this);
    const files = new MotionFiles(this);
    const trails = new TrailsMenu(this.trails);
    this.sheets.replaceChildren(this.plots.element, this.editor.element);
    this.tools.replaceChildren(
      this.recording.button,
      this.editor.button,
      this.plots.button,
      trails.button,
      trails.menu,
      files.button,
      files.menu,
      files.field,
    );
    this.bar.hidden = this.app.role !== "";
    this.change(null);
  }

  get loaded() {
    return this.playback !== null;
  }

  /** What is played, as configurations over time. */
  get motion() {
    return this.playback?.motion ?? null;
  }

  get time() {
    return this.playback?.time ?? 0;
  }

  /** @param {{ animations?: { clip: { fps?: number } }[], options: { repetitions: number } }} message of meshcat: a clip has come */
  load({ animations, options }) {
    if (this.app.viewer.animator.actions.length === 0) return this.unload();
    this.keys?.pause();
    // What pauses the clip before would pause this one: the animator plays it already.
    if (this.playback instanceof ClipPlayback) this.playback = null;
    this.looping = !(options.repetitions <= 1);
    this.setClip(new ClipPlayback(this.app.viewer, this.begin, animations?.[0]?.clip.fps ?? 30));
  }

  // The clip from Python is over.
  unload() {
    const { animator } = this.app.viewer;
    if (animator.playing) animator.pause();
    animator.clear();
    if (this.clip instanceof ClipPlayback) this.clip = null;
    if (this.playback instanceof ClipPlayback) this.change(this.keys);
  }

  /** @param {Playback} clip what is played from now on, rather than key frames */
  setClip(clip) {
    this.clip = clip;
    this.editor.open(false);
    this.change(clip);
  }

  /**
   * Key frames have come, were changed, or are gone.
   *
   * @param {import("./motion.js").Motion | null} motion
   */
  setKeys(motion) {
    if (!motion) this.keys = null;
    else if (this.keys) this.keys.motion = motion;
    else this.keys = this.playing(motion);
    this.change(this.keys);
  }

  /** @param {import("./motion.js").Motion} motion */
  playing(motion) {
    return new MotionPlayback(motion, (q) => this.show(q));
  }

  /** @param {Playback | null} playback */
  change(playback) {
    if (playback !== this.playback) this.playback?.pause();
    this.playback = playback;
    this.bar.classList.toggle("empty", !playback);
    this.setLoop(this.looping);
    this.setSpeed(this.speed);
    this.shownState = undefined;
    this.refresh();
    this.dispatchEvent(new Event("motion"));
  }

  toggle() {
    if (!this.playback) return;
    if (this.playback.playing) return this.pause();
    this.app.reports.begins = true;
    this.playback.play();
    this.refresh();
  }

  pause() {
    this.playback?.pause();
    this.refresh();
  }

  /** @param {number} time */
  seek(time) {
    this.app.reports.begins = true;
    this.playback?.seek(time);
    this.refresh();
  }

  /** @param {boolean} on */
  setLoop(on) {
    this.looping = on;
    this.playback?.setLoop(on);
    this.loop.setAttribute("aria-pressed", String(on));
  }

  /** @param {number} speed */
  setSpeed(speed) {
    this.speed = speed;
    this.playback?.setSpeed(speed);
  }

  /**
   * Show a configuration of a motion of this page; other pages follow.
   *
   * @param {number[]} q
   */
  show(q) {
    this.app.stance.put(q, null, false);
    this.app.reports.playing("played", q);
  }

  /** Bring the bar up to date; on every picture. */
  refresh() {
    if (!this.playback) return;
    const { playing, time, duration } = this.playback;
    const state = `${playing} ${time} ${duration}`;
    if (state === this.shownState) return;
    this.shownState = state;
    this.button.textContent = playing ? "❚❚" : "▶";
    this.button.ariaLabel = playing ? "Pause" : "Play";
    this.scrubber.max = String(duration);
    if (document.activeElement !== this.scrubber || playing) this.scrubber.value = String(time);
    const share = duration > 0 ? Math.min(time / duration, 1) : 0;
    this.scrubber.style.setProperty("--to", `${100 * share}%`);
    this.scrubber.setAttribute("aria-valuetext", `${time.toFixed(2)} s`);
    this.clock.textContent = `${time.toFixed(2)} / ${duration.toFixed(2)} s`;
    this.dispatchEvent(new Event("time"));
  }

  /**
   * A button of the bar that is on or off.
   *
   * @param {import("../panel/icons.js").IconName} name
   * @param {string} label
   * @param {() => void} onclick
   */
  switch(name, label, onclick) {
    const button = iconButton(name, label, onclick);
    button.setAttribute("aria-pressed", "false");
    return button;
  }

  /**
   * @param {string} text
   * @param {boolean} [bad]
   */
  say(text, bad = false) {
    this.app.panel.messages.say(text, { bad });
  }
}
