import { THREE } from "../three.ts";
import type { Motion } from "../timeline/motion.ts";
import type { About } from "../types.ts";
import type { Robot } from "./robot.ts";

/** The child of a node with a given name; it is made if it does not exist. */
export function childNamed(node: THREE.Object3D, name: string): THREE.Object3D {
  const found = node.children.find((child) => child.name === name);
  if (found) return found;
  const made = new THREE.Group();
  made.name = name;
  node.add(made);
  return made;
}

/** Whether a node is the holder or one of its descendants. */
export const isInside = (node: THREE.Object3D, holder: THREE.Object3D): boolean =>
  node === holder || (node.parent !== null && isInside(node.parent, holder));

/** Pose of one node in another's frame. */
export function between(node: THREE.Object3D, other: THREE.Object3D) {
  node.updateWorldMatrix(true, false);
  other.updateWorldMatrix(true, false);
  return new THREE.Matrix4().copy(other.matrixWorld).invert().multiply(node.matrixWorld);
}

/** Mark a node as an overlay, not part of the robot: copies of the robot leave it out. */
export function asMark<Node extends THREE.Object3D>(node: Node): Node {
  node.userData.mark = true;
  return node;
}

/** Remove a node from the scene and free its resources on the graphics card. */
export function dispose(node: THREE.Object3D) {
  for (const child of [...node.children]) dispose(child);
  const { geometry, material } = node as any;
  geometry?.dispose();
  material?.map?.dispose();
  material?.alphaMap?.dispose();
  material?.dispose();
  node.removeFromParent();
}

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
