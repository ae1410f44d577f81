import { clamp } from "../math/numbers.ts";
import { element } from "../panel/element.ts";
import type { KeyFrames } from "./key_frames.ts";

const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600];
const MOST_TICKS = 9;
// The least span of the track [s], and the factor of its span over the time of the last key.
const [SHORTEST, ROOM] = [2, 1.15];

/**
 * What the track calls when the user acts on it: a pointer selects and moves keys, and elsewhere it moves to a time.
 */
interface TrackActions {
  select: (place: number) => void;
  /** A pointer grabs a key. */
  grab: (place: number) => void;
  /** The grabbed key is moved to a time. */
  drag: (time: number) => void;
  release: () => void;
  seek: (time: number) => void;
  /** A key of the keyboard is pressed on a key frame. */
  press: (event: KeyboardEvent, place: number) => void;
}

/** The track on which the key frames are drawn. */
export class Track {
  span = 0;
  diamonds: HTMLElement[] = [];
  ruler = element("div", { className: "ruler" });
  spans = element("div", { className: "spans" });
  playhead = element("div", { className: "playhead" });
  row = element("div", { className: "row", role: "group", ariaLabel: "Key frames" });
  lane: HTMLDivElement;
  element: HTMLDivElement;
  dragging: boolean | undefined;

  constructor(readonly actions: TrackActions) {
    this.ruler.setAttribute("aria-hidden", "true");
    this.lane = element("div", { className: "lane" }, this.ruler, this.spans, this.playhead, this.row);
    this.element = element("div", { className: "track" }, this.lane);
    this.element.onpointerdown = (event) => this.down(event);
  }

  timeAt({ clientX }: PointerEvent) {
    const { left, width } = this.lane.getBoundingClientRect();
    return clamp((clientX - left) / width, 0, 1) * this.span;
  }

  down(event: PointerEvent) {
    if (event.button !== 0) return;
    const key = event.target instanceof Element ? event.target.closest(".key") : null;
    const place = key ? this.diamonds.indexOf(key as HTMLElement) : -1;
    // The difference between the time of the grabbed key and that of the pointer.
    const offset = place < 0 ? 0 : Number(key?.getAttribute("aria-valuenow")) - this.timeAt(event);
    event.preventDefault();
    this.element.setPointerCapture(event.pointerId);
    if (place < 0) this.actions.seek(this.timeAt(event));
    else this.actions.grab(place);
    this.element.onpointermove = (moved) => {
      const time = this.timeAt(moved) + offset;
      if (place < 0) this.actions.seek(time);
      else if (Math.abs(moved.clientX - event.clientX) > 2 || this.dragging) {
        this.dragging = true;
        this.actions.drag(moved.shiftKey ? time : Math.round(time * 20) / 20);
      }
    };
    this.element.onpointerup = this.element.onpointercancel = () => {
      this.element.onpointermove = this.element.onpointerup = this.element.onpointercancel = null;
      this.dragging = false;
      if (place >= 0) this.actions.release();
    };
  }

  draw({ keys }: KeyFrames, selected: number, tooFast: { from: number; to: number; text: string }[]) {
    if (!this.dragging) this.setSpan(Math.max(SHORTEST, ROOM * (keys.at(-1)?.time ?? 0)));
    const focused = this.row.contains(document.activeElement);
    while (this.diamonds.length > keys.length) this.diamonds.pop()?.remove();
    while (this.diamonds.length < keys.length) this.row.append(this.diamond(this.diamonds.length));
    keys.forEach(({ time }, place) => {
      const diamond = this.diamonds[place];
      diamond.style.left = this.across(time);
      diamond.tabIndex = place === Math.max(selected, 0) ? 0 : -1;
      diamond.classList.toggle("selected", place === selected);
      diamond.ariaLabel = `Key ${place + 1} of ${keys.length}`;
      Object.assign(diamond, { ariaValueNow: time, ariaValueMax: Math.max(this.span, time) });
      diamond.ariaValueText = `${time.toFixed(2)} s${place === selected ? ", selected" : ""}`;
    });
    if (focused && selected >= 0) this.diamonds[selected].focus();
    this.spans.replaceChildren(
      ...tooFast.map(({ from, to, text }) => {
        const span = element("div", { className: "too-fast", title: text });
        span.style.left = this.across(from);
        span.style.width = this.across(to - from);
        return span;
      }),
    );
  }

  diamond(place: number) {
    const diamond = element("div", { className: "key", tabIndex: -1, role: "slider", ariaValueMin: "0" });
    diamond.onkeydown = (event) => this.actions.press(event, place);
    this.diamonds.push(diamond);
    return diamond;
  }

  across(time: number) {
    return `${(100 * time) / this.span}%`;
  }

  /** @param span [s] */
  setSpan(span: number) {
    if (span === this.span) return;
    this.span = span;
    const step = STEPS.find((candidate) => span / candidate <= MOST_TICKS) ?? 600 * Math.ceil(span / 600 / MOST_TICKS);
    const ticks = Array.from({ length: Math.floor(span / step + 1e-9) + 1 }, (_, i) => {
      const tick = element("span", {}, `${Number((i * step).toFixed(1))}${i === 0 ? " s" : ""}`);
      tick.style.left = this.across(i * step);
      return tick;
    });
    this.ruler.replaceChildren(...ticks);
  }

  setTime(time: number) {
    this.playhead.style.left = this.across(Math.min(time, this.span));
  }
}
