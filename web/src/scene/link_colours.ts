import { makeInk } from "../panel/element.ts";
import { clamp } from "../math/numbers.ts";
import { asMark, between } from "../robot/nodes.ts";
import type { Robot } from "../robot/robot.ts";
import { THREE, sphereOf } from "../three.ts";
import type { About, RobotMesh, Shape, Vector } from "../types.ts";

/** Colours of chains, which colour-blind people can tell apart (Okabe and Ito), without orange and red. */
const CHAIN_COLOURS = ["#56b4e9", "#009e73", "#f0e442", "#0072b2", "#cc79a7", "#8f9aa8", "#7c4ddb", "#b08900"];

/**
 * The colour of each chain of a robot, and of the links that its joints carry, up to the links of the next chain.
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
  // A link that is fixed to its parent or mimics it, such as a finger, has the parent's colour; parents come first.
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

// The dark glass of a light, whose colour is emitted.
const GLASS = new THREE.Color(0x2b3038).convertSRGBToLinear();
const RED = new THREE.Color(0xd92d20).convertSRGBToLinear();
/** The colour of links that overlap. */
export const OVERLAP = "#f08c00";
const ORANGE = new THREE.Color(OVERLAP).convertSRGBToLinear();

/**
 * The colours of the links: red if a joint is outside its limits, orange if they overlap, else by a scale, by chain, or
 * their own colours.
 */
export class LinkColours {
  scale: Map<number, Vector> = new Map();
  chains: Map<number, string> = new Map();
  outside: Set<number> = new Set();
  overlapping: Set<number> = new Set();

  constructor(readonly robot: Robot) {}

  /** @param scale red, green and blue of each link */
  setScale(scale: Map<number, Vector>) {
    this.scale = scale;
    this.paintAll();
  }

  /** @param chains the colour of each link */
  setChains(chains: Map<number, string>) {
    this.chains = chains;
    this.paintAll();
  }

  /** @returns whether these are other links than before */
  mark(how: "outside" | "overlapping", links: Set<number>) {
    const before = this[how];
    if (links.size === before.size && [...links].every((link) => before.has(link))) return false;
    this[how] = links;
    this.paintAll();
    return true;
  }

  paintAll() {
    this.robot.meshes.forEach((shape) => this.paint(shape));
  }

  /** Set the colour of a shape. A light that is on keeps its own colour. */
  paint({ mesh, link }: Shape) {
    const { color } = mesh.material;
    const rgb = this.scale.get(link);
    const chain = this.chains.get(link);
    if (mesh.userData.lit) color.copy(GLASS);
    else if (rgb) color.setRGB(...rgb).convertSRGBToLinear();
    else if (chain) color.set(chain).convertSRGBToLinear();
    else color.copy(mesh.userData.own);
    const mark = this.outside.has(link) ? RED : this.overlapping.has(link) ? ORANGE : null;
    if (mark && !mesh.userData.lit) color.lerp(mark, 0.8);
  }
}

// The glow of a light: size and lift in radii of the light.
const GLOW = { size: 5.5, lift: 4, opacity: 0.3 };

type Light = Shape & { glow: THREE.Sprite };

/** The lights of the robot: dark glass that emits a colour, with a glow around it. */
export class Lights {
  shapes: Map<string, Light> = new Map();

  constructor(
    robot: Robot,
    readonly colours: LinkColours,
  ) {
    for (const shape of robot.meshes.filter(({ light }) => light)) {
      const { link, light } = shape;
      const box = robot.boxIn(
        link,
        robot.meshes.filter((other) => other.link === link),
      );
      // A light is set into a shell, so its own shadow is not needed.
      shape.mesh.castShadow = false;
      this.shapes.set(light, { ...shape, glow: makeGlow(shape.mesh, box, robot.nodes[link]) });
    }
  }

  /**
   * Switch on these lights and no others.
   *
   * @param lights red, green and blue from 0 to 1
   */
  show(lights: { name: string; rgb: Vector }[]) {
    const colours = new Map(lights.map(({ name, rgb }) => [name, rgb]));
    for (const [name, shape] of this.shapes) {
      const { mesh, glow } = shape;
      const rgb = colours.get(name);
      mesh.userData.lit = Boolean(rgb);
      const [red, green, blue] = rgb ?? [0, 0, 0];
      mesh.material.emissive.setRGB(red, green, blue).convertSRGBToLinear();
      this.colours.paint(shape);
      const brightest = Math.max(...(rgb ?? [0]));
      glow.visible = brightest > 0;
      glow.userData.strength = brightest;
      if (!rgb || !glow.visible) continue;
      const [r, g, b] = rgb;
      glow.material.color.setRGB(r / brightest, g / brightest, b / brightest).convertSRGBToLinear();
    }
  }
}

/**
 * A soft disc around a light, which faces the camera and fades if the light points away from the camera. The light points
 * away from the centre of its link.
 */
function makeGlow(mesh: RobotMesh, box: THREE.Box3, node: THREE.Object3D) {
  const { Sprite, SpriteMaterial, Vector3 } = THREE;
  const glow = new Sprite(new SpriteMaterial({ map: softDisc(), depthWrite: false, toneMapped: false }));
  const { center, radius } = sphereOf(mesh);
  const toNode = between(mesh, node);
  glow.position.copy(center).applyMatrix4(toNode);
  glow.scale.setScalar(GLOW.size * radius);
  glow.visible = false;
  const outwards = glow.position.clone().sub(box.getCenter(new Vector3())).normalize();
  const [towards, facing] = [new Vector3(), new Vector3()];
  glow.onBeforeRender = (_renderer, _scene, camera) => {
    const { elements } = glow.matrixWorld;
    const place = new Vector3().setFromMatrixPosition(glow.matrixWorld);
    towards.setFromMatrixPosition(camera.matrixWorld).sub(place).normalize();
    facing.copy(outwards).transformDirection(node.matrixWorld);
    glow.material.opacity = GLOW.opacity * glow.userData.strength * clamp(2 * facing.dot(towards), 0, 1);
    // In front of the shape that contains the light, and behind anything in front of that shape.
    place.addScaledVector(towards, GLOW.lift * radius);
    [elements[12], elements[13], elements[14]] = place.toArray();
  };
  node.add(asMark(glow));
  return glow;
}

let disc: THREE.Texture | null = null;

/** The texture that all glows share. */
function softDisc() {
  if (!disc) {
    const ink = makeInk(128, 128);
    const fade = ink.createRadialGradient(64, 64, 0, 64, 64, 64);
    [1, 0.62, 0.24, 0.06, 0].forEach((alpha, i) => fade.addColorStop(i / 4, `rgba(255,255,255,${alpha})`));
    ink.fillStyle = fade;
    ink.fillRect(0, 0, 128, 128);
    disc = new THREE.CanvasTexture(ink.canvas);
  }
  return disc;
}
