import { THREE } from "../three.js";
import { makeTriad } from "./arrows.js";
import { makeLabel } from "./label.js";
import { asMark, disposeChildren } from "./marking.js";

const SIZE = 0.09;

/** Points and poses that somebody wants reached, in the robot's root. */
export class Targets {
  /**
   * @param {import("../robot/robot.js").Robot} robot
   * @param {import("./studio.js").Studio} studio
   */
  constructor(robot, studio) {
    this.studio = studio;
    this.group = asMark(new THREE.Group());
    robot.root.add(this.group);
  }

  /**
   * Mark these, and no others.
   *
   * @param {{ name: string, matrix: number[], point: boolean }[]} targets matrices by columns; a point has no axes
   */
  show(targets) {
    disposeChildren(this.group);
    const size = SIZE * this.studio.markScale;
    for (const { name, matrix, point } of targets) {
      const mark = new THREE.Group();
      const veil = new THREE.MeshBasicMaterial({ color: 0xc2255c, transparent: true, opacity: 0.3, depthWrite: false });
      mark.add(new THREE.Mesh(new THREE.SphereGeometry(0.16 * size, 28, 20), veil));
      if (!point) mark.add(makeTriad(0.6 * size));
      mark.matrixAutoUpdate = false;
      mark.matrix.fromArray(matrix);
      mark.add(makeLabel(name, size));
      this.group.add(mark);
    }
  }
}
