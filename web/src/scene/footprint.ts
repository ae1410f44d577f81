import { THREE } from "../three.ts";
import { asMark } from "../robot/nodes.ts";

/** The distance forwards at which ground that reaches the horizon is cut off [m]. */
const REACH = 10;
const COLOUR = 0x2f6fd0;

/**
 * The part of the floor that a camera sees: its corners, clockwise in the image from the upper left.
 *
 * @param pose of the camera over the floor: x forwards, y to the left, z upwards
 * @param horizontal angle of view [rad]
 * @param vertical angle of view [rad]
 */
export function groundInView(pose: THREE.Matrix4, horizontal: number, vertical: number): THREE.Vector2[] {
  const eye = new THREE.Vector3().setFromMatrixPosition(pose);
  const [forwards, up] = [0, 2].map((axis) => new THREE.Vector3().setFromMatrixColumn(pose, axis));
  // If a camera looks straight down, the top of its image counts as forwards.
  const level = Math.hypot(forwards.x, forwards.y) > 1e-9 ? forwards : up;
  level.setZ(0).normalize();
  const [y, z] = [Math.tan(horizontal / 2), Math.tan(vertical / 2)];
  const rays = [
    [y, z],
    [-y, z],
    [-y, -z],
    [y, -z],
  ].map(([left, above]) => new THREE.Vector3(1, left, above).transformDirection(pose));
  // Positive for rays that meet the floor within reach, and linear along an edge, which is cut where it is 0.
  const inside = rays.map((ray) => -REACH * ray.z - eye.z * ray.dot(level));
  const corners = rays.flatMap((ray, i) => {
    const k = (i + 1) % 4;
    const cut = rays[k].clone().lerp(ray, inside[k] / (inside[k] - inside[i]));
    return [...(inside[i] >= 0 ? [ray] : []), ...(inside[i] >= 0 !== inside[k] >= 0 ? [cut] : [])];
  });
  return eye.z > 0
    ? corners.map((ray) => new THREE.Vector2(eye.x, eye.y).addScaledVector(ray as any, -eye.z / ray.z))
    : [];
}

/** The ground that a camera of the robot sees, drawn on the floor. */
export class Footprint {
  area = new THREE.Mesh(
    new THREE.BufferGeometry(),
    new THREE.MeshBasicMaterial({ color: COLOUR, transparent: true, opacity: 0.12, depthWrite: false }),
  );
  rim = new THREE.LineLoop(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: COLOUR }));
  corners: THREE.Vector2[] = [];

  constructor(scene: THREE.Scene) {
    this.area.renderOrder = 14;
    for (const mark of [this.area, this.rim]) {
      mark.frustumCulled = false;
      scene.add(asMark(mark));
    }
  }

  draw(corners: THREE.Vector2[]) {
    this.corners = corners;
    for (const mark of [this.area, this.rim]) {
      mark.visible = corners.length > 2;
      mark.geometry.dispose();
    }
    if (corners.length < 3) return;
    this.area.geometry = new THREE.ShapeGeometry(new THREE.Shape(corners));
    const outline = corners.map(({ x, y }) => new THREE.Vector3(x, y, 0.0008));
    this.area.position.z = 0.0005;
    this.rim.geometry = new THREE.BufferGeometry().setFromPoints(outline);
  }
}
