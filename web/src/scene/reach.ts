import type { App } from "../app.ts";
import { firstWhere, fixed } from "../math/numbers.ts";
import { element, select } from "../panel/element.ts";
import type { Received } from "../received.ts";
import { THREE } from "../three.ts";
import type { Vector } from "../types.ts";
import { onScale, scale } from "./legend.ts";
import { asMark, dispose } from "../robot/nodes.ts";

interface Voxel {
  centre: Vector;
  colour: THREE.Color;
}

/**
 * A map of voxels in a frame: the position of the first voxel [m], the three integer coordinates of each voxel from there,
 * and the value of each voxel as a share of 65535.
 */
type ReachMap = Required<Received["reach"]> & { stops: Vector[] };

const AXES = ["x", "y", "z"];
// The brightness of a voxel's sides along x and y, of its top and of its bottom; the side on the cut has the full colour.
// BEHIND is the brightness of the layers behind the cut.
const [SHADES, UP, DOWN, BEHIND] = [[0.6, 0.5], 0.8, 0.35, 0.75];

/** The voxels that a hand reaches, coloured by a value, cut by a plane that a slider moves. */
export class Reach {
  // These are set with a map, in `show`.
  voxel = 0;
  voxels: Voxel[] = [];
  /** The least and the largest coordinate along each axis. */
  box: [number, number][] = [];
  mesh!: THREE.InstancedMesh;
  rim!: THREE.LineLoop;
  group: THREE.Group | null = null;
  flipped = false;

  axis = select("Axis of the cut", AXES, () => this.turn());
  slider = element("input", {
    type: "range",
    step: "any",
    ariaLabel: "Position of the cut",
    oninput: () => this.cut(),
  });
  place = element("output");
  flip = element("button", { type: "button", title: "Show the other side" }, "⇄");

  constructor(
    readonly page: App,
    public bar: HTMLElement,
  ) {
    this.flip.onclick = () => {
      this.flipped = !this.flipped;
      this.arrange();
    };
    bar.replaceChildren("Cut", this.axis, this.slider, this.place, this.flip);
  }

  /** Draw a map instead of the one before; a map without voxels only removes that one. */
  show(message: Received["reach"]) {
    const { frame, voxel, first, cells, values, stops, cut, ...texts } = message as ReachMap;
    this.clear();
    this.bar.hidden = !cells;
    this.page.legend.set("reach", cells ? scale(texts, stops) : []);
    if (!cells) return;
    this.voxel = voxel;
    this.flipped = false;
    this.voxels = Array.from(values, (value, i) => ({
      centre: [0, 1, 2].map((axis) => (first[axis] + cells[3 * i + axis] + 0.5) * voxel) as Vector,
      colour: new THREE.Color(...onScale(stops, value / 65535)).convertSRGBToLinear(),
    }));
    this.box = [0, 1, 2].map((axis) => {
      const places = this.voxels.map(({ centre }) => centre[axis]);
      const [least, most] = places.reduce(
        ([a, b], place) => [Math.min(a, place), Math.max(b, place)],
        [Infinity, -Infinity],
      );
      return [least - voxel / 2, most + voxel / 2];
    });
    const side = 0.94 * voxel;
    // Not lit, so that the colours in the cut equal those of the legend.
    const material = new THREE.MeshBasicMaterial({ vertexColors: true });
    this.mesh = new THREE.InstancedMesh(new THREE.BoxGeometry(side, side, side), material, this.voxels.length);
    this.mesh.frustumCulled = false; // three.js would test the bounds of a single voxel
    const ink = new THREE.LineBasicMaterial({ color: 0x20242c });
    this.rim = new THREE.LineLoop(new THREE.BufferGeometry().setFromPoints(Array(4).fill(new THREE.Vector3())), ink);
    this.rim.frustumCulled = false;
    this.group = asMark(new THREE.Group());
    this.group.add(this.mesh, this.rim);
    this.page.robot.frameNode(frame).add(this.group);
    this.axis.value = cut?.axis ?? "x";
    this.turn(cut?.place);
  }

  /** The box around the voxels, in the world of three.js. */
  get bounds() {
    const box = new THREE.Box3();
    if (!this.group) return box;
    const [low, high] = [0, 1].map((end) => new THREE.Vector3(...this.box.map((ends) => ends[end])));
    this.group.updateWorldMatrix(true, false);
    return box.set(low, high).applyMatrix4(this.group.matrixWorld);
  }

  clear() {
    if (!this.group) return;
    this.mesh.dispose();
    dispose(this.group);
    this.group = null;
  }

  /**
   * Cut along the chosen axis: the slider moves from one end of the voxels to the other.
   *
   * @param place the first position of the cut; the middle if none is given
   */
  turn(place?: number) {
    const [least, most] = this.box[this.along];
    Object.assign(this.slider, { min: String(least), max: String(most) });
    this.slider.value = String(place ?? (least + most) / 2);
    this.shade();
    this.arrange();
  }

  // Shade the sides of the voxels, so that they look like cubes.
  shade() {
    const { geometry } = this.mesh;
    const { normal } = geometry.attributes;
    const shades = Array.from({ length: normal.count }, (_, i) => {
      const sides = [normal.getX(i), normal.getY(i), normal.getZ(i)];
      const along = sides.findIndex((value) => Math.abs(value) > 0.5);
      return along === this.along ? 1 : (SHADES[along] ?? (sides[along] > 0 ? UP : DOWN));
    });
    const colours = shades.flatMap((shade) => [shade, shade, shade]);
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
  }

  get along() {
    return AXES.indexOf(this.axis.value);
  }

  // Sort the voxels in the order in which the plane meets them, so that drawing only the first ones makes the cut.
  arrange() {
    const sign = this.flipped ? -1 : 1;
    const { along } = this;
    this.voxels.sort((a, b) => sign * (a.centre[along] - b.centre[along]));
    const matrix = new THREE.Matrix4();
    for (const [i, { centre }] of this.voxels.entries()) this.mesh.setMatrixAt(i, matrix.setPosition(...centre));
    this.mesh.instanceMatrix.needsUpdate = true;
    this.cut();
  }

  // Colour the layer in the cut as in the legend, and all voxels behind it darker.
  colour() {
    const { along, mesh, voxel, voxels } = this;
    const layer = voxels[mesh.count - 1]?.centre[along] ?? 0;
    const darker = new THREE.Color();
    for (const [i, { centre, colour }] of voxels.entries()) {
      const behind = Math.abs(centre[along] - layer) > voxel / 2;
      mesh.setColorAt(i, behind ? darker.copy(colour).multiplyScalar(BEHIND) : colour);
    }
    if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
  }

  cut() {
    const { along, box, voxels } = this;
    const sign = this.flipped ? -1 : 1;
    const plane = Number(this.slider.value);
    this.mesh.count = firstWhere(voxels.length, (i) => sign * voxels[i].centre[along] >= sign * plane);
    this.colour();
    const [a, b] = [0, 1, 2].filter((axis) => axis !== along);
    const corners = [0, 1, 1, 0].map((i, k) => {
      const corner = new THREE.Vector3(plane, plane, plane);
      return corner.setComponent(a, box[a][i]).setComponent(b, box[b][k >> 1]);
    });
    this.rim.geometry.setFromPoints(corners);
    this.place.textContent = `${this.axis.value} ${this.flipped ? ">" : "<"} ${fixed(1000 * plane, 0)} mm`;
    const [least, most] = box[along];
    const share = `${(100 * (plane - least)) / (most - least)}%`;
    this.slider.style.setProperty("--from", this.flipped ? share : "0%");
    this.slider.style.setProperty("--to", this.flipped ? "100%" : share);
    this.page.viewer.set_dirty();
  }
}
