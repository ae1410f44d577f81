import { clamp } from "../math/numbers.ts";
import { div, element } from "../panel/element.ts";
import type { Editor } from "./editor.ts";
import type { KeyFrames } from "./key_frames.ts";

const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600];
const MOST_TICKS = 9;
// The least span of the track [s], and the factor of its span over the time of the last key.
const [SHORTEST, ROOM] = [2, 1.15];
// The least time that fills the track [s], and the largest zoom.
const [CLOSEST, MOST_ZOOM] = [0.5, 100];

/** The track on which the key frames are drawn: a pointer selects and moves keys, and elsewhere it moves to a time. */
export class Track {
  span = 0;
  /** The width of the lane over that of the track. */
  zoom = 1;
  /** The fingers on the track and where they are [px]. */
  fingers: Map<number, number> = new Map();
  diamonds: HTMLElement[] = [];
  ruler = element("div", { className: "ruler", ariaHidden: "true" });
  spans = div("spans");
  playhead = div("playhead");
  row = element("div", { className: "row", role: "group", ariaLabel: "Key frames" });
  lane = div("lane", this.ruler, this.spans, this.playhead, this.row);
  element = div("track", this.lane);
  dragging: boolean | undefined;

  constructor(readonly editor: Editor) {
    this.element.onpointerdown = (event) => this.down(event);
    this.element.onwheel = (event) => {
      // Along the track, or with Shift, the wheel scrolls.
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) return;
      event.preventDefault();
      this.setZoom(this.zoom * Math.exp(-0.002 * event.deltaY), event.clientX);
    };
  }

  /**
   * Show a part of the time.
   *
   * @param clientX the place whose time stays there; by default that of the playhead
   */
  setZoom(zoom: number, clientX: number = this.playhead.getBoundingClientRect().x) {
    const before = this.lane.getBoundingClientRect();
    const share = (clientX - before.left) / before.width;
    this.zoom = clamp(zoom, 1, clamp(this.span / CLOSEST, 1, MOST_ZOOM));
    this.lane.style.width = `${100 * this.zoom}%`;
    this.drawRuler();
    const { left, width } = this.lane.getBoundingClientRect();
    this.element.scrollLeft += left + share * width - clientX;
  }

  timeAt({ clientX }: PointerEvent) {
    const { left, width } = this.lane.getBoundingClientRect();
    return clamp((clientX - left) / width, 0, 1) * this.span;
  }

  down(event: PointerEvent) {
    if (event.button !== 0) return;
    this.fingers.set(event.pointerId, event.clientX);
    if (this.fingers.size > 1) return this.pinch(event);
    const key = event.target instanceof Element ? event.target.closest(".key") : null;
    const place = key ? this.diamonds.indexOf(key as HTMLElement) : -1;
    // The difference between the time of the grabbed key and that of the pointer.
    const offset = place < 0 ? 0 : Number(key?.getAttribute("aria-valuenow")) - this.timeAt(event);
    event.preventDefault();
    this.element.setPointerCapture(event.pointerId);
    if (place < 0) this.editor.seek(this.timeAt(event));
    else this.editor.grab(place);
    this.element.onpointermove = (moved) => {
      const time = this.timeAt(moved) + offset;
      if (place < 0) this.editor.seek(time);
      else if (Math.abs(moved.clientX - event.clientX) > 2 || this.dragging) {
        this.dragging = true;
        this.editor.drag(moved.shiftKey ? time : Math.round(time * 20) / 20);
      }
    };
    this.element.onpointerup = this.element.onpointercancel = ({ pointerId }) => {
      this.fingers.delete(pointerId);
      this.element.onpointermove = this.element.onpointerup = this.element.onpointercancel = null;
      this.dragging = false;
      if (place >= 0) this.editor.draw();
    };
  }

  /** Zoom by two fingers; what the first one held is let go. */
  pinch({ pointerId }: PointerEvent) {
    const { element: track } = this;
    if (this.dragging) this.editor.draw();
    this.dragging = false;
    track.setPointerCapture(pointerId);
    const places = () => [...this.fingers.values()];
    const apart = () => Math.max(20, Math.abs(places()[0] - places()[1]));
    const [zoom, start] = [this.zoom, apart()];
    track.onpointermove = (moved) => {
      if (!this.fingers.has(moved.pointerId)) return;
      this.fingers.set(moved.pointerId, moved.clientX);
      if (this.fingers.size > 1) this.setZoom((zoom * apart()) / start, (places()[0] + places()[1]) / 2);
    };
    track.onpointerup = track.onpointercancel = (lifted) => {
      this.fingers.delete(lifted.pointerId);
      if (this.fingers.size === 0) track.onpointermove = null;
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
    diamond.onkeydown = (event) => this.editor.press(event, place);
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
    this.setZoom(this.zoom);
  }

  drawRuler() {
    const { span } = this;
    const most = MOST_TICKS * this.zoom;
    const step = STEPS.find((candidate) => span / candidate <= most) ?? 600 * Math.ceil(span / 600 / most);
    const ticks = Array.from({ length: Math.floor(span / step + 1e-9) + 1 }, (_, i) => {
      const tick = element("span", {}, `${Number((i * step).toFixed(1))}${i === 0 ? " s" : ""}`);
      tick.style.left = this.across(i * step);
      return tick;
    });
    this.ruler.replaceChildren(...ticks);
  }

  setTime(time: number) {
    this.playhead.style.left = this.across(Math.min(time, this.span));
    if (this.zoom === 1) return;
    // A zoomed track turns its page when the playhead leaves it.
    const { offsetLeft: at } = this.playhead;
    const { clientWidth, scrollLeft } = this.element;
    if (at < scrollLeft || at > scrollLeft + clientWidth) this.element.scrollLeft = at - 0.1 * clientWidth;
  }
}
