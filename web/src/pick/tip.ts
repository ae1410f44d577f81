import { element } from "../panel/element.ts";
import { jointOf, pairOf } from "./link_facts.ts";
import { unitText } from "./unit_text.ts";
import "./tip.css";
import type { App } from "../app.ts";

// Between the pointer and the tip [px].
const BESIDE = 16;

/** A card near the pointer: the link, the joint that moves it, its lower pair, its value and its range. */
export class Tip {
  name = element("b");
  joint = element("span");
  pair = element("span", { className: "pair" });
  value = element("span");
  // The same is said by the selection and the joint list, to those who have no pointer.
  card = element("div", { className: "tip", hidden: true, ariaHidden: "true" });
  link: number | null = null;

  /** @param view what the card stays inside */
  constructor(
    readonly app: App,
    readonly view: HTMLElement,
  ) {
    this.card.append(this.name, this.joint, this.pair, this.value);
    view.append(this.card);
  }

  /** @param place of the pointer */
  show(link: number | null, place: { clientX: number; clientY: number }) {
    this.link = link;
    this.card.hidden = link === null;
    if (link === null) return;
    this.refresh();
    const { left, top, width, height } = this.view.getBoundingClientRect();
    const { offsetWidth, offsetHeight } = this.card;
    const [x, y] = [place.clientX - left, place.clientY - top];
    const aside = x + BESIDE + offsetWidth < width ? x + BESIDE : x - BESIDE - offsetWidth;
    const under = y + BESIDE + offsetHeight < height ? y + BESIDE : y - BESIDE - offsetHeight;
    this.card.style.transform = `translate(${Math.max(0, aside)}px, ${Math.max(0, under)}px)`;
  }

  /** Write the joint's value anew. */
  refresh() {
    if (this.link === null) return;
    const { robot, panel } = this.app;
    const { about, q } = robot;
    this.name.textContent = about.links[this.link].name;
    const joint = jointOf(about, this.link);
    const coordinate = about.coordinates.find(({ column }) => column === joint?.column);
    this.joint.textContent = joint ? joint.name : "fixed to the base";
    this.pair.textContent = joint ? pairOf(joint) : "";
    this.value.textContent = "";
    if (!joint || !coordinate) return;
    const written = (value: number) => unitText(value, coordinate.unit, panel.settings.units);
    const [low, high] = robot.range(coordinate, q).map(written);
    const leader = joint.follows ? `follows ${joint.follows}: ` : "";
    this.value.textContent = `${leader}${written(q[joint.column])}, range ${low} … ${high}`;
  }
}
