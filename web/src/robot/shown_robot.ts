import { LinkColours } from "../scene/link_colours.ts";
import { Robot } from "./robot.ts";
import { Standing } from "./standing.ts";
import type { Object3D } from "three";
import type { About } from "../types.ts";
import type { Studio } from "../scene/studio.ts";

/** A robot in the scene: its tree and shapes, how it stands, and the colours of its links. */
export class ShownRobot {
  robot: Robot;
  standing: Standing;
  colours: LinkColours;
  /** Columns of the coordinates that are outside their ranges. */
  outside: Set<number> = new Set();

  constructor(root: Object3D, about: About, studio: Studio) {
    this.robot = new Robot(root, about);
    studio.adopt(this.robot);
    this.standing = new Standing(this.robot);
    this.colours = new LinkColours(this.robot);
  }

  /**
   * Bring it up to date with its configuration.
   *
   * @param up the vertical in the root's frame, where it is given
   * @param isHeld whether it keeps its place, on the floor or not
   */
  settle(up: ArrayLike<number> | null, isHeld: boolean = false) {
    const { robot } = this;
    robot.apply(robot.q);
    if (!robot.about.floating && !isHeld) this.standing.place(robot.q, up);
    this.outside = robot.outside(robot.q);
    const joints = robot.joints.filter(({ column }) => this.outside.has(column));
    this.colours.setOutside(new Set(joints.map(({ link }) => link)));
  }
}
