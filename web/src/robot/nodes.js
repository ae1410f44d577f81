import { THREE } from "../three.js";

/**
 * The child of a node with a name, made where there is none.
 *
 * @param {THREE.Object3D} node
 * @param {string} name
 * @returns {THREE.Object3D}
 */
export function childNamed(node, name) {
  const found = node.children.find((child) => child.name === name);
  if (found) return found;
  const made = new THREE.Group();
  made.name = name;
  node.add(made);
  return made;
}

/**
 * Whether a node is another one, or carried by it.
 *
 * @param {THREE.Object3D} node
 * @param {THREE.Object3D} holder
 * @returns {boolean}
 */
export const isInside = (node, holder) => node === holder || (node.parent !== null && isInside(node.parent, holder));

/**
 * Pose of one node in another's frame.
 *
 * @param {THREE.Object3D} node
 * @param {THREE.Object3D} other
 */
export function between(node, other) {
  node.updateWorldMatrix(true, false);
  other.updateWorldMatrix(true, false);
  return new THREE.Matrix4().copy(other.matrixWorld).invert().multiply(node.matrixWorld);
}
