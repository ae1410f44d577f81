import { element } from "../panel/element.ts";
import { RATE, Recorder } from "./recorder.ts";
import type { Player } from "./player.ts";

/** The button that records what moves, whoever moves it, and the clip that comes of it. */
export class Recording {
  recorder: Recorder | null = null;
  began = 0;
  button: HTMLButtonElement;
  clock = element("span", { className: "clock" });
  timer: number | undefined;

  constructor(readonly player: Player) {
    this.button = player.switch("record", "Record what moves", () => (this.recorder ? this.stop() : this.start()));
    this.button.classList.add("record");
    this.button.append(this.clock);
  }

  get time() {
    return (performance.now() - this.began) / 1000;
  }

  start() {
    const { app } = this.player;
    this.recorder = new Recorder(app.stance.q.length);
    this.began = performance.now();
    this.recorder.add(0, app.stance.q);
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
    recorder.add(this.time, this.player.app.stance.q);
    this.show();
    if (recorder.rate === rate) return;
    this.player.say(`The recording is long: from now on ${recorder.rate.toFixed(1)} configurations a second are kept.`);
  }

  show() {
    const seconds = Math.floor(this.time);
    const text = `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
    if (this.clock.textContent !== text) this.clock.textContent = text;
  }

  stop() {
    const { player, recorder } = this;
    clearInterval(this.timer);
    recorder?.add(this.time, player.app.stance.q, true);
    this.recorder = null;
    this.clock.textContent = "";
    this.button.setAttribute("aria-pressed", "false");
    this.button.ariaLabel = this.button.title = "Record what moves";
    const motion = recorder?.motion;
    if (!motion) return;
    player.pause();
    player.setClip(player.playing(motion));
    player.say(`${motion.count} configurations recorded in ${motion.end.toFixed(1)} s`);
  }
}
