import type { RobotMesh } from "./types.ts";

// The copy of three.js that meshcat contains; the page loads it before this bundle.

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

export const cornersOf = ({ min, max }: THREE.Box3) =>
  [...Array(8).keys()].map(
    (i) => new THREE.Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z),
  );

/**
 * A rectangle over the whole picture, whose shader computes the picture from textures.
 *
 * @param fragmentShader gets the place in the picture as vUv, from 0 to 1
 */
export function makeScreen(fragmentShader: string, uniforms: Record<string, THREE.IUniform>) {
  const material = new THREE.ShaderMaterial({
    vertexShader: "varying vec2 vUv; void main() { vUv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }",
    ...{ fragmentShader, uniforms, blending: THREE.NoBlending, depthTest: false, depthWrite: false },
  });
  const screen = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
  screen.frustumCulled = false;
  return screen;
}
