import { element } from "../panel/element.js";
import { jointOf, pairOf } from "./link_facts.js";
import { unitText } from "./unit_text.js";
import "./tip.css";

// Between the pointer and the tip [px].
const BESIDE = 16;

/** A card near the pointer: the link, the joint that moves it, its lower pair, its value and its range. */
export class Tip {
  /**
   * @param {import("../app.js").App} app
   * @param {HTMLElement} view what the card stays inside
   */
  constructor(app, view) {
    this.app = app;
    this.view = view;
    this.name = element("b");
    this.joint = element("span");
    this.pair = element("span", { className: "pair" });
    this.value = element("span");
    // The same is said by the selection and the joint list, to those who have no pointer.
    this.card = element("div", { className: "tip", hidden: true, ariaHidden: "true" });
    this.card.append(this.name, this.joint, this.pair, this.value);
    view.append(this.card);
    /** @type {number | null} */
    this.link = null;
  }

  /**
   * @param {number | null} link
   * @param {{ clientX: number, clientY: number }} place of the pointer
   */
  show(link, place) {
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
    const written = (/** @type {number} */ value) => unitText(value, coordinate.unit, panel.settings.units);
    const [low, high] = robot.range(coordinate, q).map(written);
    const leader = joint.follows ? `follows ${joint.follows}: ` : "";
    this.value.textContent = `${leader}${written(q[joint.column])}, range ${low} … ${high}`;
  }
}
