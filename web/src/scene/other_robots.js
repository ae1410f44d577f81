import { ShownRobot } from "../robot/shown_robot.js";

/** @param {number} number */
const ground = (number) => `ground:${number}`;

/** The robots beside the page's own, each on a ground of its own, by the numbers that Python gives them. */
export class OtherRobots {
  /** @param {import("../app.js").App} app */
  constructor(app) {
    this.app = app;
    /** @type {Map<number, ShownRobot>} */
    this.robots = new Map();
  }

  /**
   * The nodes of a robot are there: they become a robot.
   *
   * @param {{ robot: number, about: import("../types.js").About }} message
   */
  add({ robot: number, about }) {
    const { viewer, studio } = this.app;
    const root = viewer.scene_tree.find([ground(number), "robot"]).object;
    this.robots.set(number, new ShownRobot(root, about, studio));
  }

  /**
   * @param {number} number
   * @param {ArrayLike<number>} q
   * @param {ArrayLike<number> | null} up
   */
  display(number, q, up) {
    const shown = this.robots.get(number);
    if (!shown) return;
    shown.robot.q.splice(0, q.length, ...Array.from(q));
    shown.settle(up);
    this.app.studio.moved();
  }

  /** @param {number} number */
  remove(number) {
    const shown = this.robots.get(number);
    if (shown) this.app.studio.release(shown.robot);
    this.robots.delete(number);
    // meshcat gives back what its nodes hold on the graphics card.
    this.app.viewer.scene_tree.delete([ground(number)]);
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
   * The box around all robots, in the world of three.js; around some links of the page's own where they are named.
   *
   * @param {number[]} links
   */
  box(links) {
    const box = this.app.robot.box(links);
    for (const { robot } of links.length === 0 ? this.robots.values() : []) {
      robot.root.updateWorldMatrix(true, true); // its ground may have moved since
      box.union(robot.box([]));
    }
    return box;
  }
}
