import { THREE } from "../three.js";
import { Skeleton } from "./skeleton.js";

/** The robot's tree once more, bare and out of the scene: for the poses of its links in any configuration. */
export class OffScreen extends Skeleton {
  /** @param {import("./robot.js").Robot} robot */
  constructor(robot) {
    const root = robot.root.clone(true);
    root.position.set(0, 0, 0);
    root.quaternion.identity();
    /** @type {THREE.Object3D[]} */
    const dropped = [];
    root.traverse((node) => (node.userData.mark || node.name.startsWith("visual:") ? dropped.push(node) : undefined));
    dropped.forEach((node) => node.removeFromParent());
    super(root, robot.about);
  }

  /**
   * The ways of some links through a motion, in the frame of the robot's root.
   *
   * @param {import("../timeline/motion.js").Motion} motion
   * @param {ArrayLike<number>} times
   * @param {readonly number[]} links
   * @returns {THREE.Vector3[][]} for each link a place at each time
   */
  ways(motion, times, links) {
    /** @type {THREE.Vector3[][]} */
    const ways = links.map(() => []);
    for (let i = 0; i < times.length; i++) {
      this.apply(motion.at(times[i]));
      links.forEach((link, k) => ways[k].push(new THREE.Vector3().setFromMatrixPosition(this.pose(link))));
    }
    return ways;
  }
}
