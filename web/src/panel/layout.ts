import { clamp } from "../math/numbers.ts";
import { element, iconButton, handleKey } from "./element.ts";
import { remember, type Settings } from "./settings.ts";

// The least and the largest share of the window that the panel may take, and the step of a key [%].
const [LEAST, MOST, STEP] = [15, 80, 2];

/**
 * The layout of the panel and the view: the panel is beside the view, or under it if the window is narrow and high. The
 * line between them resizes the panel, and the panel can be hidden.
 */
export class Layout {
  stacked = matchMedia("(max-width: 47.5em) and (max-aspect-ratio: 1/1)");
  toggle = iconButton("panel", "Panel", () => this.fold(!this.folded), "P");
  separator = element("div", {
    className: "separator",
    tabIndex: 0,
    role: "separator",
    ariaLabel: "Size of the panel",
  });

  constructor(
    public aside: HTMLElement,
    view: HTMLElement,
    readonly settings: Settings,
  ) {
    this.toggle.id = "fold";
    this.toggle.setAttribute("aria-controls", aside.id);
    view.append(this.toggle);
    this.separator.setAttribute("aria-controls", aside.id);
    this.separator.onkeydown = (event) => this.key(event);
    this.separator.onpointerdown = (event) => this.grab(event);
    this.separator.ondblclick = () => this.resize(null);
    this.stacked.addEventListener("change", () => this.restore());
    window.addEventListener("resize", () => this.announce());
    this.restore();
    this.fold(settings.kept("folded") === "yes");
  }

  get along(): "width" | "height" {
    return this.stacked.matches ? "height" : "width";
  }

  get folded() {
    return this.aside.hidden;
  }

  fold(folded: boolean) {
    const inside = this.aside.contains(document.activeElement);
    this.aside.hidden = folded;
    document.body.classList.toggle("folded", folded);
    this.toggle.setAttribute("aria-expanded", String(!folded));
    if (this.settings.own) remember("folded", folded ? "yes" : "no");
    if (folded && inside) this.toggle.focus();
    this.announce();
  }

  // Restore the size that was chosen for this layout, or the default size.
  restore() {
    const size = parseFloat(this.settings.kept(this.along) ?? "");
    this.show(Number.isFinite(size) ? clamp(size, LEAST, MOST) : null);
  }

  /** @param share of the window [%], null for the default size */
  resize(share: number | null) {
    const size = share === null ? null : clamp(share, LEAST, MOST);
    remember(this.along, size === null ? "" : size.toFixed(1));
    this.show(size);
  }

  show(size: number | null) {
    const { style } = document.body;
    for (const along of ["width", "height"]) style.removeProperty(`--panel-${along}`);
    if (size !== null) style.setProperty(`--panel-${this.along}`, `${size.toFixed(1)}%`);
    this.announce();
  }

  // The current size of the panel [%].
  get share() {
    const [size, all] =
      this.along === "width" ? [this.aside.offsetWidth, innerWidth] : [this.aside.offsetHeight, innerHeight];
    return (100 * size) / all;
  }

  announce() {
    Object.assign(this.separator, {
      ariaOrientation: this.along === "width" ? "vertical" : "horizontal",
      ...{ ariaValueMin: LEAST, ariaValueMax: MOST },
      ariaValueNow: Math.round(clamp(this.share, LEAST, MOST)),
    });
  }

  key(event: KeyboardEvent) {
    const step = event.shiftKey ? 5 * STEP : STEP;
    const to = (share: number) => () => this.resize(share);
    const [larger, smaller] = [to(this.share + step), to(this.share - step)];
    handleKey(event, {
      ...{ ArrowLeft: larger, ArrowUp: larger, ArrowRight: smaller, ArrowDown: smaller },
      ...{ Home: to(LEAST), End: to(MOST), Enter: () => this.fold(true) },
    });
  }

  grab(event: PointerEvent) {
    if (event.button !== 0) return;
    const { separator } = this;
    separator.setPointerCapture(event.pointerId);
    const start = { at: this.place(event), share: this.share };
    separator.onpointermove = (move) => this.resize(start.share + start.at - this.place(move));
    separator.onlostpointercapture = () => (separator.onpointermove = null);
  }

  place({ clientX, clientY }: PointerEvent) {
    return this.along === "width" ? (100 * clientX) / innerWidth : (100 * clientY) / innerHeight;
  }
}
