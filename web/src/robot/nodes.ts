import { THREE } from "../three.ts";

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
