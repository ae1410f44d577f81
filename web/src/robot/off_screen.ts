import { THREE } from "../three.ts";
import { Skeleton } from "./skeleton.ts";
import type { Robot } from "./robot.ts";
import type { Motion } from "../timeline/motion.ts";

/** The robot's tree once more, bare and out of the scene: for the poses of its links in any configuration. */
export class OffScreen extends Skeleton {
  constructor(robot: Robot) {
    const root = robot.root.clone(true);
    root.position.set(0, 0, 0);
    root.quaternion.identity();
    const dropped: THREE.Object3D[] = [];
    root.traverse((node) => (node.userData.mark || node.name.startsWith("visual:") ? dropped.push(node) : undefined));
    dropped.forEach((node) => node.removeFromParent());
    super(root, robot.about);
  }

  /**
   * The ways of some links through a motion, in the frame of the robot's root.
   *
   * @returns for each link a place at each time
   */
  ways(motion: Motion, times: ArrayLike<number>, links: readonly number[]): THREE.Vector3[][] {
    const ways: THREE.Vector3[][] = links.map(() => []);
    for (let i = 0; i < times.length; i++) {
      this.apply(motion.at(times[i]));
      links.forEach((link, k) => ways[k].push(new THREE.Vector3().setFromMatrixPosition(this.pose(link))));
    }
    return ways;
  }
}
