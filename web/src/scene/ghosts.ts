import type { PageWith } from "../app.ts";
import { between, isInside, type Robot } from "../robot/robot.ts";
import { OffScreen } from "../robot/skeleton.ts";
import { THREE } from "../three.ts";
import { entry } from "./legend.ts";
import { asMark } from "./marks.ts";
import type { Received } from "../received.ts";

type Page = PageWith<"ghosts" | "show" | "stance" | "toggles">;

// Of one that is to compare with.
const COMPARED = "#3f7fd9";
// Neither the blue nor the grey of the branches while a limb is dragged.
export const GHOST_COLOURS = ["#e8590c", "#2f9e44", "#c2255c", "#7c4ddb", "#0c8599", "#b08900", "#7a4a2b", "#e64fa0"];

// Poses whose entries [1, m] differ by no more are one.
const SAME = 1e-6;

interface GhostLook {
  q: number[];
  colour: string;
  opacity: number;
}

type Copy = THREE.Mesh<THREE.BufferGeometry, THREE.Material>;

/** Pale copies of the links that other configurations put elsewhere; they stay with the robot's root. */
export class Ghosts {
  /** Of the legend: none for what is only to compare with. */
  entries: HTMLElement[] = [];
  group = asMark(new THREE.Group());
  skeleton: OffScreen;
  /**
   * One for each ghost, kept when it goes: of another one the graphics card would build its program anew, in each step
   * of a drag.
   */
  materials: THREE.MeshPhongMaterial[] = [];
  shapes;

  constructor(readonly robot: Robot) {
    this.skeleton = new OffScreen(robot);
    this.shapes = robot.meshes.map(({ mesh, link }) => ({ mesh, link, T_link_mesh: between(mesh, robot.nodes[link]) }));
    robot.root.add(this.group);
  }

  /**
   * Draw these instead of those before.
   *
   * @param carrier only links that this one carries
   */
  show(ghosts: GhostLook[], carrier: number = 0) {
    this.clear();
    const shapes = this.shapes.filter(({ link }) => isInside(this.robot.nodes[link], this.robot.nodes[carrier]));
    for (const [i, { q, colour, opacity }] of ghosts.entries()) {
      const material = (this.materials[i] ??= makeMaterial(i));
      material.color.set(colour).convertSRGBToLinear();
      material.opacity = opacity;
      this.skeleton.apply(q);
      const poses = this.robot.nodes.map((_, link) => this.skeleton.pose(link));
      for (const { mesh, link, T_link_mesh } of shapes) {
        const copy = new THREE.Mesh(mesh.geometry, material);
        copy.matrixAutoUpdate = false;
        copy.matrix.multiplyMatrices(poses[link], T_link_mesh);
        Object.assign(copy.userData, { link, pose: poses[link] });
        this.group.add(copy);
      }
    }
    this.refresh();
  }

  get copies() {
    return this.group.children as Copy[];
  }

  /** Show the links that are not where the robot has them. */
  refresh() {
    if (this.group.children.length === 0) return;
    const toRoot = this.robot.toRoot();
    const poses = this.robot.nodes.map(
      ({ matrixWorld }) => new THREE.Matrix4().multiplyMatrices(toRoot, matrixWorld).elements,
    );
    for (const copy of this.copies) {
      const { link, pose }: { link: number; pose: THREE.Matrix4 } = copy.userData as any;
      copy.visible = pose.elements.some((value, i) => Math.abs(value - poses[link][i]) > SAME);
    }
  }

  /** Take them away if they are other answers to what is asked no more. */
  clearAnswers() {
    if (this.entries.length > 0) this.clear();
  }

  /** Take them away; the shapes' geometries are the robot's. */
  clear() {
    this.group.remove(...this.copies);
  }
}

function makeMaterial(place: number) {
  return new THREE.MeshPhongMaterial({
    transparent: true,
    shininess: 12,
    // Of surfaces in one place the robot's is seen, and then the first ghost's.
    polygonOffset: true,
    polygonOffsetFactor: place + 1,
    polygonOffsetUnits: place + 1,
  });
}

/**
 * Show configurations as ghosts, each in a colour of its own; the legend numbers them. Without numbers they are to compare
 * with.
 *
 * @param message one after another; number of the first
 */
export function showGhosts(page: Page, { qs, count, opacity, first }: Received["ghosts"]) {
  const width = qs.length / count;
  const looks = Array.from({ length: count }, (_, i) => {
    const colour = first === null ? COMPARED : GHOST_COLOURS[i % GHOST_COLOURS.length];
    return { q: [...qs.subarray(i * width, (i + 1) * width)], colour, opacity };
  });
  page.stance.settle();
  page.ghosts.show(looks);
  page.ghosts.entries = first === null ? [] : looks.map(({ colour }, i) => entry(`${first + i}`, colour));
  page.toggles.refresh();
  page.show({ ghosts: true });
}

export function clearGhosts(page: Page) {
  showGhosts(page, { qs: new Float64Array(0), count: 0, opacity: 1, first: null });
}

/** The configuration of now stays as a pale copy. */
export function keepGhost(page: Page) {
  showGhosts(page, { qs: Float64Array.from(page.stance.q), count: 1, opacity: 0.3, first: null });
}
