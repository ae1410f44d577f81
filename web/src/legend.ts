import { element } from "./panel/element.ts";

/** The legend under the picture. Colours of links, kinds of joints, what is reached and ghosts each have a part of it. */
export class Legend {
  parts: Map<string, (string | Node)[]> = new Map(
    ["colours", "chains", "pairs", "reach", "ghosts", "trails"].map((part) => [part, []]),
  );

  constructor(public box: HTMLElement) {}

  /**
   * Write a part anew.
   *
   * @param children none takes the part away
   */
  set(part: string, children: (string | Node)[]) {
    this.parts.set(part, children);
    const shown = [...this.parts.values()].filter(({ length }) => length > 0);
    this.box.replaceChildren(...shown.map((entries) => element("span", { className: "part" }, ...entries)));
    this.box.hidden = shown.length === 0;
  }
}

/** A dot in a colour, and what it stands for. */
export function entry(text: string, colour: string) {
  const dot = element("span", { className: "dot" });
  dot.style.background = colour;
  return element("span", { className: "entry" }, dot, text);
}
