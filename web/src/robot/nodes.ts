import { THREE } from "../three.ts";

/** The child of a node with a name, made where there is none. */
export function childNamed(node: THREE.Object3D, name: string): THREE.Object3D {
  const found = node.children.find((child) => child.name === name);
  if (found) return found;
  const made = new THREE.Group();
  made.name = name;
  node.add(made);
  return made;
}

/** Whether a node is another one, or carried by it. */
export const isInside = (node: THREE.Object3D, holder: THREE.Object3D): boolean =>
  node === holder || (node.parent !== null && isInside(node.parent, holder));

/** Pose of one node in another's frame. */
export function between(node: THREE.Object3D, other: THREE.Object3D) {
  node.updateWorldMatrix(true, false);
  other.updateWorldMatrix(true, false);
  return new THREE.Matrix4().copy(other.matrixWorld).invert().multiply(node.matrixWorld);
}
