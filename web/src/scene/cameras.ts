import { clamp } from "../math/numbers.ts";
import { THREE } from "../three.ts";
import type { Camera, MeshcatViewer } from "../types.ts";

/**
 * Move the camera so that what a preset looks at just fills the view, under a bar that takes a share of its height.
 *
 * @param box around what it looks at, in the world of three.js
 * @param size of the robot [m]
 */
export function lookAt(
  { camera, controls }: MeshcatViewer,
  preset: Camera,
  box: THREE.Box3,
  size: number,
  bar: number,
) {
  const { Vector3, MathUtils } = THREE;
  camera.fov = 28;
  camera.near = 0.02 * size;
  camera.far = 60 * size;
  const centre = box.getCenter(new Vector3());
  // The world of three.js has y up: z of the robot is its y, and y its −z.
  const [x, y, z] = preset.direction;
  const back = new Vector3(x, z, -y).normalize();
  const right = new Vector3(0, 1, 0).cross(back).normalize();
  const up = back.clone().cross(right);
  const half = Math.tan(MathUtils.degToRad(camera.fov / 2));
  const hidden = clamp(2 * bar - 0.1, 0, 0.5);
  const tall = half * (0.9 - hidden / 2);
  const wide = 0.9 * half * camera.aspect;
  let distance = preset.links.length ? 0 : size;
  for (let i = 0; i < 8; i++) {
    const corner = new Vector3(
      i & 1 ? box.max.x : box.min.x,
      i & 2 ? box.max.y : box.min.y,
      i & 4 ? box.max.z : box.min.z,
    ).sub(centre);
    const reach = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / tall);
    distance = Math.max(distance, reach + corner.dot(back));
  }
  // The camera sits in meshcat's node that turns z up again; its coordinates are those of the world.
  camera.position.copy(centre).addScaledVector(back, distance);
  // The picture moves down by half of what the bar hides; the camera still turns about the middle of the robot.
  const { aspect } = camera;
  camera.setViewOffset(1, 1, 0, -hidden / 4, 1, 1);
  camera.aspect = aspect;
  camera.updateProjectionMatrix();
  controls.target.copy(centre);
  controls.update();
}
