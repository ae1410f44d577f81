import { THREE } from "../three.ts";
import { childNamed } from "./nodes.ts";
import type { About } from "../types.ts";

/** The robot's tree of nodes: joint values in, poses out. */
export class Skeleton {
  nodes;
  joints;

  constructor(
    readonly root: THREE.Object3D,
    readonly about: About,
  ) {
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

  /** From the world of three.js into that frame. */
  toRoot() {
    return new THREE.Matrix4().copy(this.root.matrixWorld).invert();
  }
}
