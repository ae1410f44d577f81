import { THREE } from "../three.js";

// What a light is made of: its colour comes from within.
const GLASS = new THREE.Color(0x2b3038).convertSRGBToLinear();
const RED = new THREE.Color(0xd92d20).convertSRGBToLinear();

/** The colours of the links: red where a joint is outside its limits, by a number, or their own. */
export class LinkColours {
  /** @param {import("../robot/robot.js").Robot} robot */
  constructor(robot) {
    this.robot = robot;
    /** @type {Map<number, import("../types.js").Vector>} */
    this.scale = new Map();
    /** @type {Set<number>} */
    this.outside = new Set();
  }

  /** @param {Map<number, import("../types.js").Vector>} scale link → red, green, blue */
  setScale(scale) {
    this.scale = scale;
    this.robot.meshes.forEach((shape) => this.paint(shape));
  }

  /** @param {Set<number>} links those whose joint is outside its limits */
  setOutside(links) {
    if (links.size === 0 && this.outside.size === 0) return;
    this.outside = links;
    this.robot.meshes.forEach((shape) => this.paint(shape));
  }

  /**
   * Give a shape the colour that it is to have. A light that is lit shines in its own, whatever its link's.
   *
   * @param {import("../types.js").Shape} shape
   */
  paint({ mesh, link }) {
    const { color } = mesh.material;
    const rgb = this.scale.get(link);
    if (mesh.userData.lit) color.copy(GLASS);
    else if (rgb) color.setRGB(...rgb).convertSRGBToLinear();
    else color.copy(mesh.userData.own);
    if (this.outside.has(link) && !mesh.userData.lit) color.lerp(RED, 0.8);
  }
}
