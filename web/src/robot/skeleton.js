import { THREE } from "../three.js";
import { childNamed } from "./nodes.js";

/** The robot's tree of nodes: joint values in, poses out. */
export class Skeleton {
  /**
   * @param {THREE.Object3D} root
   * @param {import("../types.js").About} about
   */
  constructor(root, about) {
    this.about = about;
    this.root = root;
    /** Node of every link. */
    this.nodes = about.links.map(({ path }) => path.slice(1).reduce(childNamed, root));
    this.joints = about.joints.map((joint) => ({
      ...joint,
      node: this.nodes[joint.link],
      axis: new THREE.Vector3(...joint.axis),
    }));
  }

  /** @param {ArrayLike<number>} q */
  apply(q) {
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

  /**
   * Pose of a link in the frame of the robot's root, or of the world when the base floats.
   *
   * @param {number} link
   */
  pose(link) {
    return this.toRoot().multiply(this.nodes[link].matrixWorld);
  }

  /** From the world of three.js into that frame. */
  toRoot() {
    return new THREE.Matrix4().copy(this.root.matrixWorld).invert();
  }
}
