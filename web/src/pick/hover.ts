import "./tip.css";
import type { App } from "../app.ts";
import { element } from "../panel/element.ts";
import type { Robot } from "../robot/robot.ts";
import { asMark } from "../robot/nodes.ts";
import { THREE } from "../three.ts";
import { jointOf, pairOf, unitText } from "./facts.ts";
import type { Picker } from "./pick.ts";

// The distance between the pointer and the tip [px].
const BESIDE = 16;

/** A card near the pointer: the link, the joint that moves it, its lower pair, its value and its range. */
class Tip {
  name = element("b");
  joint = element("span");
  pair = element("span", { className: "pair" });
  value = element("span");
  // Hidden from screen readers: the selection and the list of joints tell them the same.
  card = element("div", { className: "tip", hidden: true, ariaHidden: "true" });
  link: number | null = null;

  /** @param view the element that the card stays inside */
  constructor(
    readonly page: App,
    readonly view: HTMLElement,
  ) {
    this.card.append(this.name, this.joint, this.pair, this.value);
    view.append(this.card);
  }

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

  /** Update the joint's value. */
  refresh() {
    if (this.link === null) return;
    const { robot, panel } = this.page;
    const { about, q } = robot;
    this.name.textContent = about.links[this.link].title;
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

/** A tint over the shapes of links, drawn as a second layer, so that it is independent of their colours. */
class Highlight {
  links: number[] = [];
  coats: THREE.Mesh[] = [];
  material = new THREE.MeshBasicMaterial({
    color: new THREE.Color(0x2f7ff0).convertSRGBToLinear(),
    transparent: true,
    opacity: 0.32,
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -1,
    toneMapped: false,
  });

  constructor(readonly robot: Robot) {}

  /** @returns whether anything changed */
  show(links: number[]): boolean {
    if (String(links) === String(this.links)) return false;
    this.links = links;
    // The geometry belongs to the shape and is not disposed.
    for (const coat of this.coats) coat.removeFromParent();
    this.coats = this.robot.meshes
      .filter(({ link }) => links.includes(link))
      .map(({ mesh }) => {
        const coat = asMark(new THREE.Mesh(mesh.geometry, this.material));
        coat.renderOrder = 5;
        mesh.add(coat);
        return coat;
      });
    return true;
  }
}

/** Shows the link under the pointer: a tint on it, and its tip. */
export class Hover {
  highlight = new Highlight(this.page.robot);
  tip: Tip;
  waiting: { clientX: number; clientY: number } | null = null;
  found: (link: number | null) => void = () => {};

  constructor(
    readonly page: App,
    readonly picker: Picker,
    view: HTMLElement,
  ) {
    this.tip = new Tip(page, view);
    page.addEventListener("settled", () => this.tip.refresh());
  }

  /**
   * Find what is under the pointer before the next picture; only the last position until then counts.
   *
   * @param found is called with the link, or null
   */
  follow({ clientX, clientY }: { clientX: number; clientY: number }, found: (link: number | null) => void) {
    const isWaiting = this.waiting !== null;
    this.waiting = { clientX, clientY };
    this.found = found;
    if (!isWaiting) requestAnimationFrame(() => this.look());
  }

  look() {
    if (!this.waiting) return;
    const place = this.waiting;
    const link = this.picker.at(place)?.link ?? null;
    this.show(link, place);
    this.found(link);
  }

  show(link: number | null, place: { clientX: number; clientY: number }) {
    this.waiting = null;
    this.tip.show(link, place);
    if (this.highlight.show(link === null ? [] : [link])) this.page.viewer.set_dirty();
  }

  /** Tint the links that follow a joint and no later one, and draw the axis of the joint; null for neither. */
  showJoint(name: string | null) {
    const { axes, robot, viewer } = this.page;
    const { about } = robot;
    axes.light(name);
    this.highlight.show([...about.links.keys()].filter((link) => name !== null && jointOf(about, link)?.name === name));
    viewer.set_dirty();
  }

  clear() {
    this.show(null, { clientX: 0, clientY: 0 });
  }
}
