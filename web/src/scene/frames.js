import { makeTriad } from "./arrows.js";
import { makeLabel } from "./label.js";
import { asMark, dispose } from "./marking.js";

/** Triads of chosen frames, with their names. */
export class Frames {
  /**
   * @param {import("../robot/robot.js").Robot} robot
   * @param {string[]} names frames to draw when they are shown
   * @param {number} size length of the arrows [m]
   */
  constructor(robot, names, size) {
    this.robot = robot;
    this.names = names;
    this.size = size;
    /** @type {import("three").Group[]} */
    this.triads = [];
  }

  /** @param {boolean} on */
  show(on) {
    for (const triad of this.triads) dispose(triad);
    this.triads = (on ? this.names : []).map((name, index) => {
      const triad = asMark(makeTriad(this.size));
      triad.add(makeLabel(name, this.size, index));
      this.robot.frameNode(name).add(triad);
      return triad;
    });
  }
}
