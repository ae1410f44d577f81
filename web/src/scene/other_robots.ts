import type { App } from "../app.ts";
import { ShownRobot } from "../robot/robot.ts";
import type { Received } from "../received.ts";

const ground = (number: number) => `ground:${number}`;

/** An added robot, and whether it is visible. */
export interface Other {
  name: string;
  shown: ShownRobot;
  visible: boolean;
}

/**
 * The robots besides the page's own, each on its own ground node, by the numbers that Python gives them. Event of the page:
 * "robots", when the list changes.
 */
export class OtherRobots {
  robots: Map<number, Other> = new Map();
  /** Whether they take, in this page, the values of the joints that the page's own robot has under the same names. */
  together = false;

  constructor(readonly page: App) {}

  /** Make a robot from its nodes, which have been received. */
  add({ robot: number, name, model, opacity }: Received["robot_added"]) {
    const { parts, viewer, studio } = this.page;
    const root = viewer.scene_tree.find([ground(number), "robot"]).object;
    const shown = new ShownRobot(root, parts.model(model), parts, studio, opacity);
    this.robots.set(number, { name, shown, visible: true });
    this.page.dispatchEvent(new Event("robots"));
  }

  show(other: Other, on: boolean) {
    other.visible = other.shown.robot.root.visible = on;
    this.page.studio.moved();
    this.page.viewer.set_dirty();
  }

  display(number: number, q: ArrayLike<number>, up: ArrayLike<number> | null) {
    const shown = this.robots.get(number)?.shown;
    if (!shown) return;
    shown.robot.q.splice(0, q.length, ...Array.from(q));
    shown.settle(up);
    this.page.studio.moved();
  }

  follow() {
    if (!this.together) return;
    const { robot, stance } = this.page;
    const values = new Map(robot.about.coordinates.map(({ joint, column }) => [joint, robot.q[column]]));
    for (const { shown } of this.robots.values()) {
      const { about, q } = shown.robot;
      for (const { joint, column } of about.coordinates) q[column] = values.get(joint) ?? q[column];
      shown.settle(stance.up);
    }
    this.page.studio.moved();
  }

  remove(number: number) {
    const other = this.robots.get(number);
    if (other) this.page.studio.release(other.shown.robot);
    const isOther = this.robots.delete(number);
    this.page.viewer.scene_tree.delete([ground(number)]);
    if (isOther) this.page.dispatchEvent(new Event("robots"));
  }

  /** Remove all robots but these, and the descriptions and geometries that only the removed ones used. */
  keep(numbers: number[]) {
    for (const number of [...this.robots.keys()]) {
      if (!numbers.includes(number)) this.remove(number);
    }
    this.page.parts.keep(this.page.studio.robots);
  }

  /**
   * The box around all visible robots, ghosts, a reach map and the figure of a clip, in the world of three.js; if links are given, the box around
   * these links of the page's own robot.
   */
  box(links: number[]) {
    const box = this.page.robot.box(links);
    if (links.length > 0) return box;
    const { ghosts, player, reach } = this.page;
    if (player.figure) box.union(player.figure.box);
    if (ghosts) box.union(ghosts.box).union(reach.bounds);
    for (const { shown, visible } of this.robots.values()) {
      if (!visible) continue;
      const { robot } = shown;
      robot.root.updateWorldMatrix(true, true); // its ground may have moved in the meantime
      box.union(robot.box([]));
    }
    return box;
  }
}
