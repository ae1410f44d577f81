import { THREE } from "../three.js";

/** @typedef {import("../types.js").Shape} Shape */

// What a light is made of: its colour comes from within.
const GLASS = new THREE.Color(0x2b3038).convertSRGBToLinear();
const RED = new THREE.Color(0xd92d20).convertSRGBToLinear();

/** The colours of the accents of NAO's editions. @type {Record<string, number>} */
export const EDITIONS = { orange: 0xde541c, blue: 0x1f5fae, red: 0xb5161c, grey: 0x7d828a };

/** The colours of the links: red where a joint is outside its limits, by a number, by their chain, or their own. */
export class LinkColours {
  /** @param {import("../robot/robot.js").Robot} robot */
  constructor(robot) {
    this.robot = robot;
    /** @type {Map<number, import("../types.js").Vector>} */
    this.scale = new Map();
    /** @type {Map<number, string>} */
    this.chains = new Map();
    /** @type {Set<number>} */
    this.outside = new Set();
    this.edition = "";
    /** Shapes whose colour differs between editions. @type {Set<import("../types.js").RobotMesh>} */
    this.accents = new Set(
      robot.about.accents.flatMap(({ link, visual }) => robot.visual(link, visual).map(({ mesh }) => mesh)),
    );
  }

  /** @param {Map<number, import("../types.js").Vector>} scale link → red, green, blue */
  setScale(scale) {
    this.scale = scale;
    this.paintAll();
  }

  /** @param {Map<number, string>} chains link → colour */
  setChains(chains) {
    this.chains = chains;
    this.paintAll();
  }

  /** @param {string} edition one of EDITIONS; any other name for the robot's own colours */
  setEdition(edition) {
    this.edition = Object.hasOwn(EDITIONS, edition) ? edition : "";
    this.paintAll();
  }

  /** @param {Set<number>} links those whose joint is outside its limits */
  setOutside(links) {
    if (links.size === this.outside.size && [...links].every((link) => this.outside.has(link))) return;
    this.outside = links;
    this.paintAll();
  }

  paintAll() {
    this.robot.meshes.forEach((shape) => this.paint(shape));
  }

  /**
   * Give a shape the colour that it is to have. A light that is lit shines in its own, whatever its link's.
   *
   * @param {Shape} shape
   */
  paint({ mesh, link }) {
    const { color } = mesh.material;
    const rgb = this.scale.get(link);
    const chain = this.chains.get(link);
    if (mesh.userData.lit) color.copy(GLASS);
    else if (rgb) color.setRGB(...rgb).convertSRGBToLinear();
    else if (chain) color.set(chain).convertSRGBToLinear();
    else if (this.edition && this.accents.has(mesh)) color.setHex(EDITIONS[this.edition]).convertSRGBToLinear();
    else color.copy(mesh.userData.own);
    if (this.outside.has(link) && !mesh.userData.lit) color.lerp(RED, 0.8);
  }
}
