import { THREE } from "../three.ts";
import type { Motion } from "../timeline/motion.ts";
import type { About } from "../types.ts";
import { childNamed } from "./nodes.ts";
import type { Robot } from "./robot.ts";

/** The robot's tree of nodes, which turns joint values into poses. */
export class Skeleton {
  nodes;
  joints;

  constructor(
    readonly root: THREE.Object3D,
    readonly about: About,
  ) {
    for (const { path, matrix } of about.places) {
      const node = path.slice(1).reduce(childNamed, root);
      new THREE.Matrix4().fromArray(matrix).decompose(node.position, node.quaternion, node.scale);
    }
    /** Node of every link. */
    this.nodes = about.links.map(({ path }) => path.slice(1).reduce(childNamed, root));
    this.joints = about.joints.map((joint) => ({
      ...joint,
      node: this.nodes[joint.link],
      axis: new THREE.Vector3(...joint.axis),
    }));
  }

  apply(q: ArrayLike<number>) {
    if (this.about.floating) {
      this.nodes[0].position.set(q[0], q[1], q[2]);
      this.nodes[0].quaternion.set(q[3], q[4], q[5], q[6]).normalize();
    }
    for (const { node, axis, slides, column, multiplier, offset } of this.joints) {
      const value = multiplier * q[column] + offset;
      if (slides) node.position.copy(axis).multiplyScalar(value);
      else node.quaternion.setFromAxisAngle(axis, value);
    }
    this.root.updateWorldMatrix(true, true);
  }

  /** Pose of a link in the frame of the robot's root, or of the world when the base floats. */
  pose(link: number) {
    return this.toRoot().multiply(this.nodes[link].matrixWorld);
  }

  /** The transform from the world of three.js into that frame. */
  toRoot() {
    return new THREE.Matrix4().copy(this.root.matrixWorld).invert();
  }
}

/** A copy of the robot's tree without shapes and outside the scene, for poses in other configurations. */
export class OffScreen extends Skeleton {
  constructor(robot: Robot) {
    const root = robot.root.clone(true);
    root.position.set(0, 0, 0);
    root.quaternion.identity();
    const dropped: THREE.Object3D[] = [];
    root.traverse((node) => (node.userData.mark || node instanceof THREE.Mesh ? dropped.push(node) : undefined));
    dropped.forEach((node) => node.removeFromParent());
    super(root, robot.about);
  }

  /**
   * The paths of some links during a motion, in the frame of the robot's root.
   *
   * @returns for each link its position at each time
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
