import "./timeline.css";
import type { App } from "../app.ts";
import { div, element, iconButton, type IconName, select, toolbar } from "../panel/element.ts";
import { PlotStrip } from "../plot/plot_strip.ts";
import { Editor } from "./editor.ts";
import type { Received } from "../received.ts";
import { Motion } from "./motion.ts";
import { MotionFiles } from "./motion_files.ts";
import { Figure, MotionPlayback } from "./playback.ts";
import { Recording } from "./recorder.ts";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

/**
 * The bar under the view: it plays the clip from Python, a recording or key frames, one at a time.
 *
 * Events: "motion" when another motion is played or the motion has changed; "time" when the time shown changes; "selected"
 * when a key frame is selected; "edited" when the key frames have changed.
 */
export class Player extends EventTarget {
  // These are made with the robot, in `start`.
  editor!: Editor;
  recording!: Recording;
  plots!: PlotStrip;
  files!: MotionFiles;

  looping = true;
  speed = 1;
  /** The clip from Python, and its figure. */
  program: MotionPlayback | null = null;
  figure: Figure | null = null;
  /** The clip from Python, a recording, or a file. */
  clip: MotionPlayback | null = null;
  keys: MotionPlayback | null = null;
  /** The one that is played: the clip or the key frames. */
  playback: MotionPlayback | null = null;
  /** The state that the bar shows. */
  shownState: string | undefined = undefined;
  button = element("button", { type: "button", className: "play", onclick: () => this.toggle() });
  scrubber = element("input", { type: "range", min: "0", step: "any", ariaLabel: "Time" });
  clock = element("output", { ariaLive: "off" });
  loop = element("button", { type: "button", className: "loop", title: "Repeat" }, "↻");
  speeds = select(
    "Speed",
    SPEEDS.map((speed) => [`${speed}`, `${speed}×`]),
    () => this.setSpeed(Number(this.speeds.value)),
  );
  sheets = div("sheets");
  tools = div("actions");

  constructor(
    public page: App,
    public bar: HTMLElement,
  ) {
    super();
    this.scrubber.oninput = () => this.seek(Number(this.scrubber.value));
    this.loop.ariaLabel = "Repeat";
    this.loop.onclick = () => this.setLoop(!this.looping);
    Object.assign(this.speeds, { title: "Speed", value: "1" });
    const own = div("own", this.button, this.scrubber, this.clock, this.loop, this.speeds);
    bar.append(this.sheets, div("transport", own, this.tools));
    bar.classList.add("empty");
    page.addEventListener("started", () => this.start());
  }

  // Called when the robot and the panel have been made.
  start() {
    this.editor = new Editor(this);
    this.recording = new Recording(this);
    this.plots = new PlotStrip(this);
    const files = (this.files = new MotionFiles(this));
    this.sheets.replaceChildren(this.plots.element, this.editor.element);
    toolbar(this.tools, "Motion", this.recording.button, this.editor.button, this.plots.button, files.button);
    this.tools.after(files.menu);
    this.bar.hidden = this.page.role !== "";
    this.change(null);
  }

  get loaded() {
    return this.playback !== null;
  }

  /** The motion that is played, as configurations over time. */
  get motion() {
    return this.playback?.motion ?? null;
  }

  get time() {
    return this.playback?.time ?? 0;
  }

  get duration() {
    return this.playback?.duration ?? 0;
  }

  /** Play a clip from Python instead of the one before. */
  load({ times, q, handles, fps, ups, figure, play, loop }: Received["clip"]) {
    this.unload();
    const { reports, stance, viewer } = this.page;
    const motion = new Motion(times, q, handles ? "bezier" : "linear", handles ?? []);
    const moments = Array.from({ length: (ups?.length ?? 0) / 3 }, (_, i) => i / fps);
    const directions = ups && new Motion(moments, ups);
    this.figure = figure && new Figure(figure, viewer.scene);
    this.looping = loop;
    this.program = new MotionPlayback(motion, (shown, time) => {
      const up = directions?.at(time) ?? [];
      stance.put(shown, Math.hypot(...up) > 1e-6 ? up : null, false);
      this.figure?.show(time);
      reports.playing("clip", shown);
    });
    this.setClip(this.program);
    if (play) this.program.play();
    else this.program.seek(0);
  }

  // Remove the clip from Python.
  unload() {
    const { program } = this;
    this.program = null;
    this.figure?.remove();
    this.figure = null;
    this.page.viewer.set_dirty();
    if (!program) return;
    if (this.clip === program) this.clip = null;
    if (this.playback === program) this.change(this.keys);
  }

  /** @param clip the clip to play from now on, instead of key frames */
  setClip(clip: MotionPlayback) {
    this.clip = clip;
    this.editor.open(false);
    this.change(clip);
  }

  /** Take over new or changed key frames; null if there are none any more. */
  setKeys(motion: Motion | null) {
    if (!motion) this.keys = null;
    else if (this.keys) this.keys.motion = motion;
    else this.keys = this.playing(motion);
    this.change(this.keys);
  }

  playing(motion: Motion) {
    return new MotionPlayback(motion, (q) => this.show(q));
  }

  change(playback: MotionPlayback | null) {
    if (playback !== this.playback) this.playback?.pause();
    this.playback = playback;
    this.bar.classList.toggle("empty", !playback);
    this.files.button.hidden = !playback;
    this.setLoop(this.looping);
    this.setSpeed(this.speed);
    this.shownState = undefined;
    this.refresh();
    this.dispatchEvent(new Event("motion"));
  }

  toggle() {
    if (this.playback?.playing) this.pause();
    else this.play();
  }

  play() {
    if (!this.playback) return;
    this.page.reports.begins = true;
    this.playback.play();
    this.refresh();
  }

  pause() {
    this.playback?.pause();
    this.refresh();
  }

  seek(time: number) {
    this.page.reports.begins = true;
    this.playback?.seek(time);
    this.refresh();
  }

  setLoop(on: boolean) {
    this.looping = on;
    this.playback?.setLoop(on);
    this.loop.setAttribute("aria-pressed", String(on));
  }

  setSpeed(speed: number) {
    this.speed = speed;
    this.playback?.setSpeed(speed);
  }

  /** Show a configuration of a motion of this page, and report it, so that other pages follow. */
  show(q: number[]) {
    this.page.stance.put(q, null, false);
    this.page.reports.playing("played", q);
  }

  /** Bring the bar up to date; called for every picture. */
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

  /** Make a button of the bar that is on or off, as an `iconButton`. */
  switch(name: IconName, label: string, onclick: () => void, word: string) {
    const button = iconButton(name, label, onclick, "", word);
    button.setAttribute("aria-pressed", "false");
    return button;
  }

  say(text: string, bad: boolean = false) {
    this.page.panel.messages.say(text, { bad });
  }
}
