import { THREE } from "../three.ts";
import type { RobotMesh, Shape, Vector } from "../types.ts";
import type { Robot } from "../robot/robot.ts";

// What a light is made of: its colour comes from within.
const GLASS = new THREE.Color(0x2b3038).convertSRGBToLinear();
const RED = new THREE.Color(0xd92d20).convertSRGBToLinear();

/** The colours of the accents of NAO's editions. */
export const EDITIONS: Record<string, number> = { orange: 0xde541c, blue: 0x1f5fae, red: 0xb5161c, grey: 0x7d828a };

/** The colours of the links: red where a joint is outside its limits, by a number, by their chain, or their own. */
export class LinkColours {
  scale: Map<number, Vector> = new Map();
  chains: Map<number, string> = new Map();
  outside: Set<number> = new Set();
  edition = "";
  /** Shapes whose colour differs between editions. */
  accents: Set<RobotMesh>;

  constructor(readonly robot: Robot) {
    this.accents = new Set(
      robot.about.accents.flatMap(({ link, visual }) => robot.visual(link, visual).map(({ mesh }) => mesh)),
    );
  }

  /** @param scale link → red, green, blue */
  setScale(scale: Map<number, Vector>) {
    this.scale = scale;
    this.paintAll();
  }

  /** @param chains link → colour */
  setChains(chains: Map<number, string>) {
    this.chains = chains;
    this.paintAll();
  }

  /** @param edition one of EDITIONS; any other name for the robot's own colours */
  setEdition(edition: string) {
    this.edition = Object.hasOwn(EDITIONS, edition) ? edition : "";
    this.paintAll();
  }

  /** @param links those whose joint is outside its limits */
  setOutside(links: Set<number>) {
    if (links.size === this.outside.size && [...links].every((link) => this.outside.has(link))) return;
    this.outside = links;
    this.paintAll();
  }

  paintAll() {
    this.robot.meshes.forEach((shape) => this.paint(shape));
  }

  /** Give a shape the colour that it is to have. A light that is lit shines in its own, whatever its link's. */
  paint({ mesh, link }: Shape) {
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
