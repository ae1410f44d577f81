import { THREE } from "../three.ts";
import type { Robot } from "../robot/robot.ts";
import type { Viewport } from "./viewport.ts";

/**
 * What is met on the surface of the robot: the link, the point in the world, and the same point in the frame of the link.
 */
export interface Hit {
  link: number;
  point: THREE.Vector3;
  local: THREE.Vector3;
}

/** Finds what is under the pointer. */
export class Picker {
  caster = new THREE.Raycaster();

  constructor(
    readonly robot: Robot,
    readonly viewport: Viewport,
  ) {}

  /**
   * The first surface under a place on the screen. Triangles are tried only of the shapes whose bounding sphere the ray
   * enters, from the nearest on, until what is left begins behind what was met.
   */
  at(place: { clientX: number; clientY: number }): Hit | null {
    const { caster, robot } = this;
    caster.ray.copy(this.viewport.ray(place));
    const sphere = new THREE.Sphere();
    const candidates = robot.meshes.flatMap(({ mesh, link }) => {
      const { geometry } = mesh;
      if (!geometry.boundingSphere) geometry.computeBoundingSphere();
      sphere.copy(geometry.boundingSphere as THREE.Sphere).applyMatrix4(mesh.matrixWorld);
      const along = sphere.center.clone().sub(caster.ray.origin).dot(caster.ray.direction);
      const beside = caster.ray.distanceSqToPoint(sphere.center);
      if (beside > sphere.radius ** 2) return [];
      return [{ mesh, link, entry: along - Math.sqrt(sphere.radius ** 2 - beside) }];
    });
    candidates.sort((a, b) => a.entry - b.entry);
    let [least, found, owner] = [Infinity, new THREE.Vector3(), -1];
    for (const { mesh, link, entry } of candidates) {
      if (entry > least) break;
      const [first] = caster.intersectObject(mesh, false);
      if (first && first.distance < least) [least, found, owner] = [first.distance, first.point, link];
    }
    if (owner < 0) return null;
    return { link: owner, point: found, local: robot.nodes[owner].worldToLocal(found.clone()) };
  }
}
