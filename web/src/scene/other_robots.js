import { ShownRobot } from "../robot/shown_robot.js";

/** @param {number} number */
const ground = (number) => `ground:${number}`;

/** @typedef {{ name: string, shown: ShownRobot, visible: boolean }} Other a robot, and whether it is to be seen */

/** The robots beside the page's own, each on a ground of its own, by the numbers that Python gives them. Event of the app: "robots", when they are others. */
export class OtherRobots {
  /** @param {import("../app.js").App} app */
  constructor(app) {
    this.app = app;
    /** @type {Map<number, Other>} */
    this.robots = new Map();
  }

  /**
   * The nodes of a robot are there: they become a robot.
   *
   * @param {{ robot: number, name: string, about: import("../types.js").About }} message
   */
  add({ robot: number, name, about }) {
    const { viewer, studio } = this.app;
    const root = viewer.scene_tree.find([ground(number), "robot"]).object;
    this.robots.set(number, { name, shown: new ShownRobot(root, about, studio), visible: true });
    this.app.dispatchEvent(new Event("robots"));
  }

  /**
   * @param {Other} other
   * @param {boolean} on whether it is to be seen
   */
  show(other, on) {
    other.visible = other.shown.robot.root.visible = on;
    this.app.studio.moved();
    this.app.viewer.set_dirty();
  }

  /**
   * @param {number} number
   * @param {ArrayLike<number>} q
   * @param {ArrayLike<number> | null} up
   */
  display(number, q, up) {
    const shown = this.robots.get(number)?.shown;
    if (!shown) return;
    shown.robot.q.splice(0, q.length, ...Array.from(q));
    shown.settle(up);
    this.app.studio.moved();
  }

  /** @param {number} number */
  remove(number) {
    const other = this.robots.get(number);
    if (other) this.app.studio.release(other.shown.robot);
    const isOther = this.robots.delete(number);
    // meshcat gives back what its nodes hold on the graphics card.
    this.app.viewer.scene_tree.delete([ground(number)]);
    if (isOther) this.app.dispatchEvent(new Event("robots"));
  }

  /**
   * Forget all robots but these.
   *
   * @param {number[]} numbers
   */
  keep(numbers) {
    for (const number of [...this.robots.keys()]) {
      if (!numbers.includes(number)) this.remove(number);
    }
  }

  /**
   * The box around all robots that are seen, in the world of three.js; around some links of the page's own where they are named.
   *
   * @param {number[]} links
   */
  box(links) {
    const box = this.app.robot.box(links);
    for (const { shown, visible } of links.length === 0 ? this.robots.values() : []) {
      if (!visible) continue;
      const { robot } = shown;
      robot.root.updateWorldMatrix(true, true); // its ground may have moved since
      box.union(robot.box([]));
    }
    return box;
  }
}
