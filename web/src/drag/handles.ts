import type { PageWith } from "../app.ts";
import type { Pick } from "../pick/pick.ts";
import { flatMaterial } from "../scene/extras.ts";
import { asMark, dispose } from "../scene/marks.ts";
import { THREE } from "../three.ts";
import type { Handle, Limb } from "./follow.ts";

type Page = PageWith<"pick" | "robot" | "studio" | "viewer">;

/** A ring that keeps its size on the screen. */
export function makeKnob() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 96;
  const ink = canvas.getContext("2d") as CanvasRenderingContext2D;
  ink.beginPath();
  ink.arc(48, 48, 34, 0, 2 * Math.PI);
  ink.fillStyle = "rgba(255, 255, 255, 0.78)";
  ink.fill();
  ink.lineWidth = 11;
  ink.strokeStyle = "#1d2433";
  ink.stroke();
  const map = new THREE.CanvasTexture(canvas);
  map.encoding = THREE.sRGBEncoding;
  const material = new THREE.SpriteMaterial({ map, depthTest: false, sizeAttenuation: false, toneMapped: false });
  const knob = new THREE.Sprite(material);
  knob.renderOrder = 25;
  highlight(knob, false);
  return knob;
}

/** A handle under the pointer is larger and brighter. */
export function highlight(knob: THREE.Sprite, on: boolean) {
  const [size, opacity] = on ? [0.018, 1] : [0.013, 0.75];
  knob.scale.set(size, size, 1);
  knob.material.opacity = opacity;
}

/** A faint line along x, from the camera to its handle. */
function makeSight(length: number) {
  const ends = [new THREE.Vector3(), new THREE.Vector3(length, 0, 0)];
  const line = new THREE.Line(
    new THREE.BufferGeometry().setFromPoints(ends),
    new THREE.LineDashedMaterial({
      color: 0x1d2433,
      dashSize: 0.008,
      gapSize: 0.006,
      transparent: true,
      opacity: 0.45,
    }),
  );
  line.computeLineDistances();
  return line;
}

// Within how many pixels of the mouse, or of a touch, a handle and a line are held.
const [POINT, FINGER] = [14, 28];
const [LINE_POINT, LINE_FINGER] = [6, 16];

/** Where a pointer is. */
export interface Pointed {
  clientX: number;
  clientY: number;
  pointerType: string;
}

/**
 * What is under the pointer, and its point there: the nearest by what a mouse or a finger covers of it.
 *
 * @param places points in the world, of a knob or of a line
 */
export function nearest<Item>(
  viewport: Pick["viewport"],
  { clientX, clientY, pointerType }: Pointed,
  places: { item: Item; points: THREE.Vector3[]; isLine: boolean }[],
) {
  const [knob, line] = pointerType === "touch" ? [FINGER, LINE_FINGER] : [POINT, LINE_POINT];
  let found: { item: Item; point: THREE.Vector3 } | null = null;
  let least = 1;
  for (const { item, points, isLine } of places) {
    for (const point of points) {
      const place = viewport.place(point);
      const away = place ? Math.hypot(place.clientX - clientX, place.clientY - clientY) : Infinity;
      const share = away / (isLine ? line : knob);
      if (share < least) [found, least] = [{ item, point }, share];
    }
  }
  return found;
}

// That of the gaze is at a share of the robot's size before the camera, of a small robot.
const [SIGHT, SMALL] = [0.25, 1.5];

/** The handles of the limbs: where they are on the screen, and which one is the one to be held. */
export class Handles {
  shown = false;
  lit: Handle | null = null;
  list: Handle[];

  constructor(
    readonly page: Page,
    limbs: Limb[],
  ) {
    const gaze = limbs.find(({ kind }) => kind === "gaze");
    this.list = limbs
      .filter((limb) => limb.kind === "arm" || limb.kind === "leg" || limb === gaze)
      .map((limb) => this.make(limb));
  }

  make(limb: Limb): Handle {
    const { robot, studio } = this.page;
    const mark = asMark(new THREE.Group());
    const knob = makeKnob();
    mark.add(knob);
    const ahead = limb.kind === "gaze" ? SIGHT * Math.min(studio.size, SMALL) : 0;
    knob.position.x = ahead;
    if (ahead) mark.add(makeSight(ahead));
    robot.frameNode(limb.frame).add(mark);
    return { limb, mark, knob, ahead };
  }

  show(on: boolean) {
    this.shown = on;
    for (const { mark } of this.list) mark.visible = on;
    if (!on) this.light(null);
  }

  /** The handle under the pointer; a finger covers more than a mouse points at. */
  at(event: Pointed) {
    const places = (this.shown ? this.list : []).map((handle) => ({
      item: handle,
      points: [handle.knob.getWorldPosition(new THREE.Vector3())],
      isLine: false,
    }));
    return nearest(this.page.pick.viewport, event, places)?.item ?? null;
  }

  /** @param handle the one that is drawn larger */
  light(handle: Handle | null) {
    if (handle === this.lit) return;
    if (this.lit) highlight(this.lit.knob, false);
    if (handle) highlight(handle.knob, true);
    this.lit = handle;
    this.page.viewer.set_dirty();
  }
}

/** of a frame */
export interface Axis {
  name: string;
  axis: [number, number, number];
  colour: string;
}

/** Points of a circle about the z axis. */
const circle = (radius: number) =>
  Array.from({ length: SAMPLES }, (_, i) => {
    const angle = (2 * Math.PI * i) / SAMPLES;
    return new THREE.Vector3(radius * Math.cos(angle), radius * Math.sin(angle), 0);
  });

/** A ring about an axis, and points of it in the frame of the axis. */
export function makeRing({ axis, colour }: Axis, radius: number, scale: number) {
  const shape = new THREE.TorusGeometry(radius * scale, THICKNESS * scale, 8, 64);
  const mesh = new THREE.Mesh(shape, flatMaterial(colour, 21));
  mesh.renderOrder = 21;
  mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...axis));
  return { mesh, points: circle(radius * scale).map((point) => point.applyQuaternion(mesh.quaternion)) };
}

/** a turn of a handle's frame about its own axis */
export interface Ring {
  handle: Handle;
  axis: Axis;
  mesh: THREE.Mesh;
}

// Sizes in metres for a small robot; the points of a ring that are looked at.
const [RADIUS, THICKNESS, SAMPLES] = [0.072, 0.0011, 64];

export const AXES: Axis[] = [
  { name: "x", axis: [1, 0, 0], colour: "#e0433a" },
  { name: "y", axis: [0, 1, 0], colour: "#2f9e44" },
  { name: "z", axis: [0, 0, 1], colour: "#2f6fe0" },
];

const TURNS: Record<string, Axis[]> = { leg: AXES, arm: AXES.slice(1) };

/** The axes that a handle's frame may be turned about. */
export const turnsOf = ({ limb }: Handle) => TURNS[limb.kind] ?? [];

/**
 * Rings that turn the frame of a limb, around the handle of the one that is selected: about all three axes of a foot; of a
 * hand, whose arm has five joints, about the two that turn the direction of the forearm.
 */
export class Rings {
  list: Ring[] = [];

  constructor(
    readonly page: Page,
    readonly handles: Handles,
  ) {
    page.addEventListener("selected", () => this.refresh());
  }

  /** Draw the rings of the selected limb, and no others. */
  refresh() {
    for (const { mesh } of this.list) dispose(mesh);
    const { frame } = this.page.pick.selection;
    const handle = this.handles.shown && this.handles.list.find(({ limb }) => limb.frame === frame);
    this.list = handle ? turnsOf(handle).map((axis) => this.make(handle, axis)) : [];
    this.page.viewer.set_dirty();
  }

  make(handle: Handle, axis: Axis): Ring {
    const scale = this.page.studio.markScale;
    const { mesh } = makeRing(axis, RADIUS, scale);
    this.page.robot.frameNode(handle.limb.frame).add(asMark(mesh));
    return { handle, axis, mesh };
  }

  /** The ring under the pointer, and the place on it, in the world. */
  at(event: Pointed) {
    const places = this.list.map((ring) => {
      ring.mesh.updateWorldMatrix(true, false);
      const points = circle(RADIUS * this.page.studio.markScale).map((at) => at.applyMatrix4(ring.mesh.matrixWorld));
      return { item: ring, points, isLine: true };
    });
    const found = nearest(this.page.pick.viewport, event, places);
    return found && { ring: found.item, point: found.point };
  }
}
