import type { App } from "../app.ts";
import { element, write } from "../panel/element.ts";
import { unitText } from "../pick/facts.ts";
import { asMark, between, isInside, OffScreen } from "../robot/nodes.ts";
import type { Robot } from "../robot/robot.ts";
import { Standing } from "../robot/standing.ts";
import { boxOf, THREE } from "../three.ts";
import type { Received } from "../received.ts";
import type { RobotMesh } from "../types.ts";

// The colour of a ghost for comparison.
const COMPARED = "#3f7fd9";
// Colours that differ from the blue and the grey of the branches during a drag.
export const GHOST_COLOURS = ["#e8590c", "#2f9e44", "#c2255c", "#7c4ddb", "#0c8599", "#b08900", "#7a4a2b", "#e64fa0"];

// The colour of the entry of the robot's own configuration.
const OWN = "#5c6678";

// The distance of a robot beside itself, as a share of its size, and its colour.
const [BESIDE, PALE] = [0.8, "#a9c4ee"];

// Poses whose entries [1, m] differ by no more than this count as equal.
const SAME = 1e-6;

interface GhostLook {
  q: number[];
  colour: string;
  opacity: number;
}

type Copy = THREE.Mesh<THREE.BufferGeometry, THREE.Material>;

/**
 * Ghosts: pale copies of the links that other configurations put elsewhere. Branches share the root of the robot; ghosts for
 * comparison stand on the floor by themselves.
 */
export class Ghosts {
  /** The entries of the legend; none for ghosts for comparison. */
  entries: HTMLElement[] = [];
  /** The configuration of the only ghost for comparison, if there is one. */
  compared: number[] | null = null;
  /** The pose of its root in the scene. */
  place: THREE.Matrix4 | null = null;
  group = asMark(new THREE.Group());
  private areBranches = true;
  skeleton = new OffScreen(this.robot);
  /**
   * One material for each ghost, kept when the ghost is removed: otherwise the graphics card would compile a new one in each
   * step of a drag.
   */
  materials: THREE.MeshPhongMaterial[] = [];
  shapes = this.robot.meshes.map(({ mesh, link }) => ({
    mesh,
    link,
    T_link_mesh: between(mesh, this.robot.nodes[link]),
  }));

  constructor(readonly robot: Robot) {
    this.group.matrixAutoUpdate = false;
    (robot.root.parent as THREE.Object3D).add(this.group);
  }

  /**
   * Draw these ghosts instead of the ones before.
   *
   * @param carrier only the links that this link carries are drawn
   * @param places the pose of the root of each in the scene; null for the robot's own
   */
  show(ghosts: GhostLook[], carrier: number = 0, places: THREE.Matrix4[] | null = null) {
    this.clear();
    this.areBranches = places === null;
    const shapes = this.shapes.filter(({ link }) => isInside(this.robot.nodes[link], this.robot.nodes[carrier]));
    for (const [i, { q, colour, opacity }] of ghosts.entries()) {
      const material = (this.materials[i] ??= makeMaterial(i));
      material.color.set(colour).convertSRGBToLinear();
      material.opacity = opacity;
      this.skeleton.apply(q);
      const poses = this.robot.nodes.map((_, link) => this.skeleton.pose(link));
      if (places) for (const pose of poses) pose.premultiply(places[i]);
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

  /** The box around those that are visible, in the world of three.js. */
  get box() {
    const box = new THREE.Box3();
    for (const copy of this.group.visible ? this.copies : []) {
      copy.updateWorldMatrix(true, false);
      if (copy.visible) {
        box.union(
          boxOf(copy as unknown as RobotMesh)
            .clone()
            .applyMatrix4(copy.matrixWorld),
        );
      }
    }
    return box;
  }

  /** Show only the links whose pose differs from the robot's. */
  refresh() {
    if (this.group.children.length === 0) return;
    const { nodes, root } = this.robot;
    const toGroup = this.areBranches ? this.robot.toRoot() : this.robot.fromWorld();
    const poses = nodes.map(({ matrixWorld }) => new THREE.Matrix4().multiplyMatrices(toGroup, matrixWorld).elements);
    if (this.areBranches) this.group.matrix.copy(root.matrix);
    else this.group.matrix.identity();
    for (const copy of this.copies) {
      const { link, pose }: { link: number; pose: THREE.Matrix4 } = copy.userData as any;
      copy.visible = pose.elements.some((value, i) => Math.abs(value - poses[link][i]) > SAME);
    }
  }

  /** Remove the ghosts if they are branches of an earlier target. */
  clearAnswers() {
    if (this.entries.length > 0) this.clear();
  }

  /** Remove the ghosts. The geometries belong to the robot and are not disposed. */
  clear() {
    this.compared = null;
    this.group.remove(...this.copies);
  }
}

function makeMaterial(place: number) {
  return new THREE.MeshPhongMaterial({
    transparent: true,
    shininess: 12,
    // Where surfaces coincide, the robot's is visible, and after it the first ghost's.
    polygonOffset: true,
    polygonOffsetFactor: place + 1,
    polygonOffsetUnits: place + 1,
  });
}

/**
 * Show configurations as ghosts, each in its own colour and numbered in the legend. Without a first number they are ghosts
 * for comparison, which are set down on the floor.
 *
 * @param message with the configurations one after another, and the number of the first
 * @param place the pose of their root in the scene, if it is known
 */
export function showGhosts(
  page: App,
  { qs, count, opacity, first }: Received["ghosts"],
  place: THREE.Matrix4 | null = null,
) {
  const width = qs.length / count;
  const looks = Array.from({ length: count }, (_, i) => {
    const colour = first === null ? COMPARED : GHOST_COLOURS[i % GHOST_COLOURS.length];
    return { q: [...qs.subarray(i * width, (i + 1) * width)], colour, opacity };
  });
  page.stance.settle();
  // Other solutions: the robot itself shows the one before them.
  const own = first !== null && first > 1 && count > 0;
  if (own) looks.unshift({ q: [...page.stance.q], colour: OWN, opacity });
  const places = first === null ? looks.map(({ q }) => place ?? placeOf(page.robot, q)) : null;
  page.ghosts.show(looks, 0, places);
  if (places?.length === 1) Object.assign(page.ghosts, { compared: looks[0].q, place: places[0] });
  page.ghosts.entries = first === null ? [] : choices(page, looks, own ? first - 1 : first, own);
  page.toggles.refresh();
  page.panel?.readout.refresh();
  page.show({ ghosts: true });
}

/** A radio button for each configuration, which the robot takes: so arrow keys step through them. */
function choices(page: App, looks: GhostLook[], first: number, own: boolean) {
  const { robot, stance } = page;
  const said = element("output", {}, own ? beyondLimits(page) : "");
  const entries = looks.map(({ q, colour }, i) => {
    const radio = element("input", { type: "radio", name: "ghost", checked: own && i === 0 });
    radio.style.setProperty("--colour", colour);
    radio.onchange = () => {
      stance.set(robot.about.floating ? [...stance.q.slice(0, 7), ...q.slice(7)] : q);
      stance.settle();
      write(said, beyondLimits(page));
    };
    return element("label", { className: "entry" }, radio, `${first + i}`);
  });
  return looks.length > 0 ? [element("b", {}, own ? "solutions" : "ghosts"), ...entries, said] : [];
}

/** In words, the joint that is farthest outside its limits, and how many others are. */
function beyondLimits({ robot, panel }: App) {
  const { q, about } = robot;
  const beyond = about.coordinates.map((coordinate) => {
    const [low, high] = robot.range(coordinate, q);
    return { ...coordinate, by: Math.max(low - q[coordinate.column], q[coordinate.column] - high) };
  });
  const worst = beyond.reduce((one, other) => (other.by > one.by ? other : one));
  const { size } = robot.outside(q);
  const others = size > 1 ? `, and ${size - 1} more` : "";
  return size > 0
    ? `refused: ${worst.joint} by ${unitText(worst.by, worst.unit, panel.settings.units)}${others}`
    : "inside all limits";
}

/** The pose of the root in the scene of a robot that is set down in a configuration; its own nodes serve for it meanwhile. */
function placeOf(robot: Robot, q: number[]) {
  const [position, quaternion] = [robot.root.position.clone(), robot.root.quaternion.clone()];
  robot.apply(q);
  if (!robot.about.floating) new Standing(robot).place(q, null);
  const found = robot.placement();
  robot.root.position.copy(position);
  robot.root.quaternion.copy(quaternion);
  robot.apply(robot.q);
  return found;
}

export function clearGhosts(page: App) {
  showGhosts(page, { qs: new Float64Array(0), count: 0, opacity: 1, first: null });
}

/** Keep the robot, as it stands there now, as a ghost, or beside itself. */
export function keepGhost(page: App, isBeside: boolean) {
  const place = page.robot.placement();
  const aside = new THREE.Matrix4().makeTranslation(0, isBeside ? -BESIDE * page.studio.size : 0, 0);
  const ghost = { qs: Float64Array.from(page.stance.q), count: 1, opacity: isBeside ? 1 : 0.3, first: null };
  showGhosts(page, ghost, aside.multiply(place));
  // What differs is measured as if they stood at one place.
  page.ghosts.place = place;
  page.panel.readout.refresh();
  if (!isBeside) return;
  page.ghosts.materials[0].color.set(PALE);
  if (!page.isInSight) page.frame();
}
