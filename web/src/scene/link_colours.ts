import type { Robot } from "../robot/robot.ts";
import { THREE } from "../three.ts";
import type { About, Shape, Vector } from "../types.ts";

/** Colours of the lower pairs. */
export const PAIR_COLOURS: Record<string, string> = {
  revolute: "#e8590c",
  prismatic: "#1c7ed6",
  helical: "#c2255c",
  cylindrical: "#5f3dc4",
  universal: "#7c4ddb",
  condyloid: "#9c36b5",
  spherical: "#099268",
  planar: "#846358",
  other: "#5c6678",
};

/** Colours of chains, apart from each other for the colour-blind too (Okabe and Ito), without orange and red. */
const CHAIN_COLOURS = ["#56b4e9", "#009e73", "#f0e442", "#0072b2", "#cc79a7", "#8f9aa8", "#7c4ddb", "#b08900"];

/**
 * The colour of each chain of a robot, and of all links that the joints of the chain carry, up to those of another chain.
 */
export function chainColours(about: About): {
  chains: { title: string; colour: string }[];
  links: Map<number, string>;
} {
  const links = new Map();
  const chains = about.chains.map(({ title, joints }, i) => {
    const colour = CHAIN_COLOURS[i % CHAIN_COLOURS.length];
    const names = new Set(joints.map(({ name }) => name));
    for (const { name, link } of about.joints) if (names.has(name)) links.set(link, colour);
    return { title, colour };
  });
  // What is fixed to a link, or follows it as fingers do, has its colour: parents come first.
  const numbers = new Map(about.links.map(({ path }, link) => [path.join("/"), link]));
  about.links.forEach(({ path }, link) => {
    if (links.has(link)) return;
    for (let end = path.length - 1; end > 0; end--) {
      const holder = numbers.get(path.slice(0, end).join("/"));
      if (holder === undefined) continue;
      if (links.has(holder)) links.set(link, links.get(holder));
      break;
    }
  });
  return { chains, links };
}

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

  constructor(readonly robot: Robot) {}

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
  paint({ mesh, link, accent }: Shape) {
    const { color } = mesh.material;
    const rgb = this.scale.get(link);
    const chain = this.chains.get(link);
    if (mesh.userData.lit) color.copy(GLASS);
    else if (rgb) color.setRGB(...rgb).convertSRGBToLinear();
    else if (chain) color.set(chain).convertSRGBToLinear();
    else if (this.edition && accent) color.setHex(EDITIONS[this.edition]).convertSRGBToLinear();
    else color.copy(mesh.userData.own);
    if (this.outside.has(link) && !mesh.userData.lit) color.lerp(RED, 0.8);
  }
}
