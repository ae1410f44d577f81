import { THREE } from "../three.js";
import { makeScrew } from "./arrows.js";
import { asMark, dispose } from "./marking.js";
import { PAIR_COLOURS } from "./pair_colours.js";

const LENGTH = 0.07;

/** The axes of the joints as screws, in the colour of the lower pair that each belongs to. */
export class JointAxes {
  /**
   * @param {import("../robot/robot.js").Robot} robot
   * @param {import("./studio.js").Studio} studio
   */
  constructor(robot, studio) {
    this.robot = robot;
    this.studio = studio;
    /** @type {THREE.Group[]} */
    this.screws = [];
  }

  /**
   * @param {boolean} on
   * @returns {Map<string, string>} the pairs that are there, with their colours
   */
  show(on) {
    for (const screw of this.screws) dispose(screw);
    this.screws = [];
    const pairs = new Map();
    for (const { pair, slides, axis, node } of on ? this.robot.joints.filter((joint) => joint.pair) : []) {
      const colour = PAIR_COLOURS[pair] ?? PAIR_COLOURS.other;
      pairs.set(pair, colour);
      const screw = asMark(makeScrew(slides, colour, LENGTH * this.studio.markScale));
      screw.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), axis);
      node.parent?.add(screw);
      this.screws.push(screw);
    }
    this.studio.seeThrough(this.robot, on);
    return pairs;
  }
}
