import { THREE } from "../three.ts";
import type { MeshcatViewer } from "../types.ts";

// From a camera of three.js, which looks along −z with y up, to the body frame of a camera: x ahead, y to the left, z up.
export const BODY = new THREE.Matrix4().set(0, -1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0, 0, 0, 1);
// A camera that looks this close to straight down or up [rad] is turned about its axis by where it stands.
const POLE = 1e-5;
const UP = new THREE.Vector3(0, 1, 0);

/** The pose of the page's camera in the scene, which has z up, column by column: x along its axis, y left, z up. */
export function cameraPose({ camera, scene }: MeshcatViewer): number[] {
  camera.updateWorldMatrix(true, false);
  const pose = new THREE.Matrix4().copy(scene.matrixWorld).invert().multiply(camera.matrixWorld);
  return pose.multiply(BODY).toArray();
}

/**
 * Put the page's camera at a pose, as `cameraPose` returns it. It turns about the point of its axis that is nearest to the
 * middle of the robot.
 *
 * @param middle of the robot, in the world of three.js
 * @param size of the robot [m]
 */
export function placeCamera(
  { camera, controls, scene }: MeshcatViewer,
  pose: number[],
  middle: THREE.Vector3,
  size: number,
) {
  const world = new THREE.Matrix4().copy(scene.matrixWorld).multiply(new THREE.Matrix4().fromArray(pose));
  const [ahead, left, up] = [0, 1, 2].map((column) => new THREE.Vector3().setFromMatrixColumn(world, column));
  const place = new THREE.Vector3().setFromMatrixPosition(world);
  const distance = Math.max(middle.sub(place).dot(ahead), 0.1 * size);
  camera.clearViewOffset();
  Object.assign(camera, { near: 0.02 * size, far: Math.max(60 * size, 3 * distance) });
  controls.maxDistance = Math.max(30 * size, 2 * distance);
  controls.target.copy(place).addScaledVector(ahead, distance);
  // The controls turn the camera about the vertical. They lose the direction of a camera that looks along it, so it stands a
  // little behind.
  if (Math.hypot(ahead.x, ahead.z) < POLE) place.addScaledVector(up, -POLE * distance);
  camera.position.copy(place);
  camera.up.copy(Math.abs(left.y) < 1e-9 ? UP : up);
  controls.update();
}

/**
 * Let the page's camera also draw in parallel projection, in which the point that it turns about keeps its size. It remains
 * the same object, which meshcat's controls move as before.
 */
export class Projection {
  isParallel = false;

  constructor({ camera, controls }: MeshcatViewer) {
    const inPerspective = camera.updateProjectionMatrix.bind(camera);
    camera.updateProjectionMatrix = () => {
      inPerspective();
      // The materials of three.js ask this.
      Object.assign(camera, { isOrthographicCamera: this.isParallel });
      if (!this.isParallel) return;
      const half = camera.position.distanceTo(controls.target) * Math.tan(THREE.MathUtils.degToRad(camera.fov / 2));
      const { aspect, far, projectionMatrix, view } = camera;
      const shift = view?.enabled ? (2 * half * view.offsetY) / view.fullHeight : 0;
      projectionMatrix.makeOrthographic(-aspect * half, aspect * half, half - shift, -half - shift, -far, far);
      camera.projectionMatrixInverse.copy(projectionMatrix).invert();
    };
  }
}

/** Whether a camera draws in parallel projection. */
export const isParallel = (camera: THREE.Camera) => (camera as THREE.OrthographicCamera).isOrthographicCamera;

/** For `onBeforeRender` of a sprite whose size on the screen does not depend on its distance: the same in parallel projection. */
export function keepSize(this: THREE.Object3D, _renderer: unknown, _scene: unknown, camera: THREE.Camera) {
  if (!isParallel(camera)) return;
  const { fov } = camera as unknown as THREE.PerspectiveCamera;
  const share = 1 / (camera.projectionMatrix.elements[5] * Math.tan(THREE.MathUtils.degToRad(fov / 2)));
  this.matrixWorld.scale(new THREE.Vector3(share, share, share));
}
