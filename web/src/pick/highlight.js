import { asMark } from "../scene/marking.js";
import { THREE } from "../three.js";

/** A tint over the shapes of a link. It is a second coat, so that it needs to know nothing of colours, limits and lights. */
export class Highlight {
  /** @param {import("../robot/robot.js").Robot} robot */
  constructor(robot) {
    this.robot = robot;
    /** @type {number | null} */
    this.link = null;
    /** @type {THREE.Mesh[]} */
    this.coats = [];
    this.material = new THREE.MeshBasicMaterial({
      color: new THREE.Color(0x2f7ff0).convertSRGBToLinear(),
      transparent: true,
      opacity: 0.32,
      depthWrite: false,
      polygonOffset: true,
      polygonOffsetFactor: -1,
      polygonOffsetUnits: -1,
      toneMapped: false,
    });
  }

  /**
   * @param {number | null} link
   * @returns {boolean} whether anything changed
   */
  show(link) {
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
