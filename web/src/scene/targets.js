import { THREE } from "../three.js";
import { makeTriad } from "./arrows.js";
import { asMark, disposeChildren } from "./marking.js";

const SIZE = 0.09;

/** Points and poses that somebody wants reached, in the robot's root. */
export class Targets {
  /**
   * @param {import("../robot/robot.js").Robot} robot
   * @param {import("./studio.js").Studio} studio
   * @param {import("./labels.js").Labels} labels
   */
  constructor(robot, studio, labels) {
    this.studio = studio;
    this.labels = labels;
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
    for (const { matrix, point } of targets) {
      const mark = new THREE.Group();
      const veil = new THREE.MeshBasicMaterial({ color: 0xc2255c, transparent: true, opacity: 0.3, depthWrite: false });
      mark.add(new THREE.Mesh(new THREE.SphereGeometry(0.16 * size, 28, 20), veil));
      if (!point) mark.add(makeTriad(0.6 * size));
      mark.matrixAutoUpdate = false;
      mark.matrix.fromArray(matrix);
      this.group.add(mark);
    }
    this.group.updateWorldMatrix(true, true);
    this.labels.set(
      this,
      targets.map(({ name }, i) => ({ text: name, node: this.group.children[i] })),
    );
  }
}
