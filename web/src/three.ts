import type { RobotMesh } from "./types.ts";

// The three.js that meshcat brings: one copy of it, in the page before this bundle.

export import THREE = MeshCat.THREE;

/** The box around a shape in its own frame. */
export function boxOf({ geometry }: RobotMesh) {
  if (!geometry.boundingBox) geometry.computeBoundingBox();
  return geometry.boundingBox as THREE.Box3;
}

/** The sphere around a shape in its own frame. */
export function sphereOf({ geometry }: RobotMesh) {
  if (!geometry.boundingSphere) geometry.computeBoundingSphere();
  return geometry.boundingSphere as THREE.Sphere;
}
