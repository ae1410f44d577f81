/**
 * Say of a node that it is drawn over the robot and no part of it: copies of the robot leave it out.
 *
 * @template {import("three").Object3D} Node
 * @param {Node} node
 * @returns {Node}
 */
export function asMark(node) {
  node.userData.mark = true;
  return node;
}

/**
 * Take a node out of the scene, and give back what it holds on the graphics card.
 *
 * @param {import("three").Object3D} node
 */
export function dispose(node) {
  disposeChildren(node);
  const { geometry, material } = /** @type {any} */ (node);
  geometry?.dispose();
  material?.map?.dispose();
  material?.alphaMap?.dispose();
  material?.dispose();
  node.removeFromParent();
}

/** @param {import("three").Object3D} node */
export function disposeChildren(node) {
  for (const child of [...node.children]) dispose(child);
}
