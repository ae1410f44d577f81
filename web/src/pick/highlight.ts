import { asMark } from "../scene/marking.ts";
import { THREE } from "../three.ts";
import type { Robot } from "../robot/robot.ts";

/** A tint over the shapes of a link. It is a second coat, so that it needs to know nothing of colours, limits and lights. */
export class Highlight {
  link: number | null = null;
  coats: THREE.Mesh[] = [];
  material = new THREE.MeshBasicMaterial({
    color: new THREE.Color(0x2f7ff0).convertSRGBToLinear(),
    transparent: true,
    opacity: 0.32,
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -1,
    toneMapped: false,
  });

  constructor(readonly robot: Robot) {}

  /** @returns whether anything changed */
  show(link: number | null): boolean {
    if (link === this.link) return false;
    this.link = link;
    // The geometry is the shape's.
    for (const coat of this.coats) coat.removeFromParent();
    this.coats = this.robot.meshes
      .filter((shape) => shape.link === link)
      .map(({ mesh }) => {
        const coat = asMark(new THREE.Mesh(mesh.geometry, this.material));
        coat.renderOrder = 5;
        mesh.add(coat);
        return coat;
      });
    return true;
  }
}
