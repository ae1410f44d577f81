import { THREE } from "../three.ts";
import { makeTriad } from "./arrows.ts";
import { asMark, disposeChildren } from "./marking.ts";
import type { Robot } from "../robot/robot.ts";
import type { Studio } from "./studio.ts";
import type { Labels } from "./labels.ts";

const SIZE = 0.09;

/** Points and poses that somebody wants reached, in the robot's root. */
export class Targets {
  group = asMark(new THREE.Group());

  constructor(
    robot: Robot,
    readonly studio: Studio,
    readonly labels: Labels,
  ) {
    robot.root.add(this.group);
  }

  /**
   * Mark these, and no others.
   *
   * @param targets matrices by columns; a point has no axes
   */
  show(targets: { name: string; matrix: number[]; point: boolean }[]) {
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
