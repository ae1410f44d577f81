import { makeTriad } from "./arrows.js";
import { asMark, dispose } from "./marking.js";

/** Triads of chosen frames, with their names. */
export class Frames {
  /**
   * @param {import("../robot/robot.js").Robot} robot
   * @param {import("./labels.js").Labels} labels
   * @param {string[]} names frames to draw when they are shown
   * @param {number} size length of the arrows [m]
   */
  constructor(robot, labels, names, size) {
    this.robot = robot;
    this.labels = labels;
    this.names = names;
    this.size = size;
    /** @type {import("three").Group[]} */
    this.triads = [];
  }

  /** @param {boolean} on */
  show(on) {
    for (const triad of this.triads) dispose(triad);
    const names = on ? this.names : [];
    this.triads = names.map((name) => {
      const triad = asMark(makeTriad(this.size));
      this.robot.frameNode(name).add(triad);
      triad.updateWorldMatrix(false, true);
      return triad;
    });
    this.labels.set(
      this,
      names.map((text, i) => ({ text, node: this.triads[i] })),
    );
  }
}
