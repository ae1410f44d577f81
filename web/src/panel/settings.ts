import { USUAL, type Choice } from "../values/units.ts";
import { div, element } from "./element.ts";

const PREFIX = "nao-kin.";

/** The text that the browser stored under a name; null if there is none or storage is forbidden. */
function remembered(name: string) {
  try {
    return localStorage.getItem(PREFIX + name);
  } catch {
    return null;
  }
}

/** Store a text in the browser, if that is allowed. */
export function remember(name: string, text: string) {
  try {
    localStorage.setItem(PREFIX + name, text);
  } catch {
    // Storage is forbidden or full: the setting then holds for this page only.
  }
}

const THEMES = { auto: "System", light: "Light", dark: "Dark" };

/**
 * The user's preferences: units, colours and keys. The browser stores them if that is allowed.
 *
 * Events: "units" when another unit is chosen, "theme" when other colours are.
 */
export class Settings extends EventTarget {
  units = {
    angle: this.kept("angle") === "rad" ? "rad" : USUAL.angle,
    length: this.kept("length") === "m" ? "m" : USUAL.length,
  };
  keys = this.kept("keys") !== "off";
  /** Pixels of a saved picture per pixel of the screen. */
  scale = this.kept("scale") === "2" ? 2 : 1;
  theme: string | undefined;

  /** @param own whether the page is for a user, and not only for taking a picture */
  constructor(readonly own: boolean) {
    super();
    const theme = own ? (this.kept("theme") ?? "auto") : "light";
    this.setTheme(Object.hasOwn(THEMES, theme) ? theme : "auto");
  }

  kept(name: string) {
    return this.own ? remembered(name) : null;
  }

  setTheme(theme: string) {
    this.theme = theme;
    document.documentElement.dataset.theme = theme;
    this.dispatchEvent(new Event("theme"));
  }

  setUnits(change: Partial<Choice>) {
    this.units = { ...this.units, ...change };
    remember("angle", this.units.angle);
    remember("length", this.units.length);
    this.dispatchEvent(new Event("units"));
  }

  /** The fields of the settings menu, with the current choices. */
  fields() {
    const { units } = this;
    return [
      choice("Angles", units.angle, { deg: "Degrees", rad: "Radians" }, (angle) =>
        this.setUnits({ angle: angle === "rad" ? "rad" : "deg" }),
      ),
      choice("Lengths", units.length, { mm: "Millimetres", m: "Metres" }, (length) =>
        this.setUnits({ length: length === "m" ? "m" : "mm" }),
      ),
      choice("Colours", this.theme, THEMES, (theme) => {
        this.setTheme(theme);
        remember("theme", theme);
      }),
      choice("Pictures", String(this.scale), { 1: "1×", 2: "2×" }, (scale) => {
        this.scale = Number(scale);
        remember("scale", scale);
      }),
      choice("Single keys (P, /, ?)", this.keys ? "on" : "off", { on: "On", off: "Off" }, (keys) => {
        this.keys = keys === "on";
        remember("keys", keys);
      }),
    ];
  }
}

/**
 * Make a group of radio buttons.
 *
 * @param options a text for each value
 */
function choice(
  legend: string,
  chosen: string | undefined,
  options: Record<string, string>,
  choose: (value: string) => void,
) {
  const radios = Object.entries(options).map(([value, text]) => {
    const radio = element("input", { type: "radio", name: legend, value, checked: value === chosen });
    radio.onchange = () => choose(value);
    return element("label", {}, radio, element("span", {}, text));
  });
  return element("fieldset", {}, element("legend", {}, legend), div("choice", ...radios));
}
