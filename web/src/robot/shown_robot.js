import { LinkColours } from "../scene/link_colours.js";
import { Robot } from "./robot.js";
import { Standing } from "./standing.js";

/** A robot in the scene: its tree and shapes, how it stands, and the colours of its links. */
export class ShownRobot {
  /**
   * @param {import("three").Object3D} root
   * @param {import("../types.js").About} about
   * @param {import("../scene/studio.js").Studio} studio
   */
  constructor(root, about, studio) {
    this.robot = new Robot(root, about);
    studio.adopt(this.robot);
    this.standing = new Standing(this.robot);
    this.colours = new LinkColours(this.robot);
    /** Columns of the coordinates that are outside their ranges. @type {Set<number>} */
    this.outside = new Set();
  }

  /**
   * Bring it up to date with its configuration.
   *
   * @param {ArrayLike<number> | null} up the vertical in the root's frame, where it is given
   * @param {boolean} isHeld whether it keeps its place, on the floor or not
   */
  settle(up, isHeld = false) {
    const { robot } = this;
    robot.apply(robot.q);
    if (!robot.about.floating && !isHeld) this.standing.place(robot.q, up);
    this.outside = robot.outside(robot.q);
    const joints = robot.joints.filter(({ column }) => this.outside.has(column));
    this.colours.setOutside(new Set(joints.map(({ link }) => link)));
  }
}
