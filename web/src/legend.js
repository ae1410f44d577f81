import { element } from "./panel/element.js";

/** The legend under the picture. Colours of links, kinds of joints, what is reached and ghosts each have a part of it. */
export class Legend {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
    /** @type {Map<string, (string | Node)[]>} */
    this.parts = new Map(["colours", "chains", "pairs", "reach", "ghosts", "trails"].map((part) => [part, []]));
  }

  /**
   * Write a part anew.
   *
   * @param {string} part
   * @param {(string | Node)[]} children none takes the part away
   */
  set(part, children) {
    this.parts.set(part, children);
    const shown = [...this.parts.values()].filter(({ length }) => length > 0);
    this.box.replaceChildren(...shown.map((entries) => element("span", { className: "part" }, ...entries)));
    this.box.hidden = shown.length === 0;
  }
}

/**
 * A dot in a colour, and what it stands for.
 *
 * @param {string} text
 * @param {string} colour
 */
export function entry(text, colour) {
  const dot = element("span", { className: "dot" });
  dot.style.background = colour;
  return element("span", { className: "entry" }, dot, text);
}
