import type { Object3D } from "three";

/** Say of a node that it is drawn over the robot and no part of it: copies of the robot leave it out. */
export function asMark<Node extends Object3D>(node: Node): Node {
  node.userData.mark = true;
  return node;
}

/** Take a node out of the scene, and give back what it holds on the graphics card. */
export function dispose(node: Object3D) {
  disposeChildren(node);
  const { geometry, material } = node as any;
  geometry?.dispose();
  material?.map?.dispose();
  material?.alphaMap?.dispose();
  material?.dispose();
  node.removeFromParent();
}

export function disposeChildren(node: Object3D) {
  for (const child of [...node.children]) dispose(child);
}
