import type { App } from "../app.ts";
import { makeInk } from "../panel/element.ts";
import type { Viewport } from "../pick/pick.ts";
import { keepSize } from "../scene/camera.ts";
import { AXES, flatMaterial, turnAlong, type Axis } from "../scene/shapes.ts";
import { asMark, dispose } from "../robot/nodes.ts";
import { THREE } from "../three.ts";
import { FOR_A_PLACE, Limb, limbsOf } from "../ik/limbs.ts";
import type { Grip, Handle } from "./gestures.ts";
import { LimbDrag, TurnDrag } from "./limb_drag.ts";

/** Make the knob of a handle: a circle that keeps its size on the screen. */
export function makeKnob() {
  const ink = makeInk(96, 96);
  ink.beginPath();
  ink.arc(48, 48, 34, 0, 2 * Math.PI);
  ink.fillStyle = "rgba(255, 255, 255, 0.78)";
  ink.fill();
  ink.lineWidth = 11;
  ink.strokeStyle = "#1d2433";
  ink.stroke();
  const map = new THREE.CanvasTexture(ink.canvas);
  map.encoding = THREE.sRGBEncoding;
  const material = new THREE.SpriteMaterial({ map, depthTest: false, sizeAttenuation: false, toneMapped: false });
  const knob = new THREE.Sprite(material);
  knob.renderOrder = 25;
  knob.onBeforeRender = keepSize;
  highlight(knob, false);
  return knob;
}

/** Draw a knob larger and brighter, or as usual. */
export function highlight(knob: THREE.Sprite, on: boolean) {
  const [size, opacity] = on ? [0.018, 1] : [0.013, 0.75];
  knob.scale.set(size, size, 1);
  knob.material.opacity = opacity;
}

/** Make a faint line along x, from the camera to its handle. */
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

// The distance from the mouse and from a finger within which grips are grabbed [px]: knobs, knobs on a link that can be
// grabbed itself, and lines.
const WITHIN = { knob: [14, 28], tight: [8, 12], line: [6, 16] };

/** The position and the kind of a pointer. */
export interface Pointed {
  clientX: number;
  clientY: number;
  pointerType: string;
}

/** The grip under the pointer and its point there: the nearest one, measured in the grip's own grabbing distance. */
export function nearest(viewport: Viewport, { clientX, clientY, pointerType }: Pointed, grips: Grip[]) {
  const by = pointerType === "touch" ? 1 : 0;
  let found: { grip: Grip; point: THREE.Vector3 } | null = null;
  let least = 1;
  for (const grip of grips) {
    for (const point of grip.points()) {
      const place = viewport.place(point);
      const away = place ? Math.hypot(place.clientX - clientX, place.clientY - clientY) : Infinity;
      const share = away / WITHIN[grip.shape][by];
      if (share < least) [found, least] = [{ grip, point }, share];
    }
  }
  return found;
}

/** Transform points from a node's frame into the world. */
export function inWorld(points: THREE.Vector3[], node: THREE.Object3D) {
  node.updateWorldMatrix(true, false);
  return points.map((point) => point.clone().applyMatrix4(node.matrixWorld));
}

/** Points of a circle about the z axis. */
const circle = (radius: number) =>
  Array.from({ length: SAMPLES }, (_, i) => {
    const angle = (2 * Math.PI * i) / SAMPLES;
    return new THREE.Vector3(radius * Math.cos(angle), radius * Math.sin(angle), 0);
  });

/** Make a ring about an axis, and points on it in the frame of the axis. */
export function makeRing(axis: Axis, radius: number, scale: number) {
  const shape = new THREE.TorusGeometry(radius * scale, THICKNESS * scale, 8, 64);
  const mesh = new THREE.Mesh(shape, flatMaterial(axis.colour, 21));
  mesh.renderOrder = 21;
  turnAlong(mesh, axis);
  return { mesh, points: circle(radius * scale).map((point) => point.applyQuaternion(mesh.quaternion)) };
}

/** A ring that turns a limb's frame about one of its own axes. */
interface Ring extends Grip {
  axis: Axis;
  mesh: THREE.Mesh;
}

// Radius and thickness of a ring for a small robot [m], and the number of points tested along it.
const [RADIUS, THICKNESS, SAMPLES] = [0.072, 0.0011, 64];

// A place takes three coordinates, so a limb with more can turn in place.
const FOR_TURNS = 4;

/** The axes that a handle's frame can be turned about. Rings of a link in the middle of a limb would cover the link. */
export function turnsOf({ limb, shape }: Handle) {
  return shape === "knob" && limb.kind !== "gaze" && limb.columns.length >= FOR_TURNS ? AXES : [];
}

// The handle of the gaze is in front of the camera at this share of the robot's size, which counts up to SMALL [m].
const [SIGHT, SMALL] = [0.25, 1.5];

/**
 * The handles of the limbs, one for the selected frame if it is none of theirs, and the rings that turn the frame of the
 * selected handle.
 */
export class Handles {
  shown = false;
  list: Handle[] = limbsOf(this.page.robot.about).map((limb) => this.make(limb));
  /** The handle of a selected frame that is not the end of a limb; it stays until another such frame is selected. */
  own: Handle | null = null;
  rings: Ring[] = [];

  constructor(readonly page: App) {
    page.addEventListener("selected", () => this.refresh());
  }

  make(limb: Limb, shape: Grip["shape"] = "knob") {
    const { robot, studio } = this.page;
    const mark = asMark(new THREE.Group());
    mark.position.set(...limb.point);
    const knob = makeKnob();
    mark.add(knob);
    const ahead = limb.kind === "gaze" ? SIGHT * Math.min(studio.size, SMALL) : 0;
    knob.position.x = ahead;
    if (ahead) mark.add(makeSight(ahead));
    robot.frameNode(limb.frame).add(mark);
    const handle: Handle = {
      ...{ limb, mark, knob, ahead, shape },
      points: () => [knob.getWorldPosition(new THREE.Vector3())],
      light: (on) => highlight(knob, on),
      gesture: (hold) => new LimbDrag(this.page, handle, hold),
    };
    return handle;
  }

  show(on: boolean) {
    this.shown = on;
    for (const { mark } of this.list) mark.visible = on;
    this.refresh();
  }

  /** Give the selected frame a handle, and draw the rings of it, and no others. Event of the page: "handles". */
  refresh() {
    const { frame } = this.page.pick.selection;
    if (frame !== null && this.list.every(({ limb }) => limb.frame !== frame)) this.change(frame);
    for (const { mesh } of this.rings) dispose(mesh);
    const handle = this.shown && this.list.find(({ limb }) => limb.frame === frame);
    this.rings = handle ? turnsOf(handle).map((axis) => this.ring(handle, axis)) : [];
    this.page.viewer.set_dirty();
  }

  /** Make the handle of a selected frame, and remove the one before. A frame that fewer joints move than
   * a place needs has none. */
  change(frame: string) {
    const { robot } = this.page;
    const limb = new Limb(robot.about, frame, robot.linkOf(frame), "hand");
    if (this.own) dispose(this.own.mark);
    const others = this.list.filter((handle) => handle !== this.own);
    this.own = limb.columns.length >= FOR_A_PLACE ? this.make(limb, "tight") : null;
    this.list = this.own ? [...others, this.own] : others;
    if (this.own) this.own.mark.visible = this.shown;
    this.page.dispatchEvent(new Event("handles"));
  }

  ring(handle: Handle, axis: Axis): Ring {
    const { limb, mark } = handle;
    const { mesh, points } = makeRing(axis, RADIUS, this.page.studio.markScale);
    mark.add(asMark(mesh));
    return {
      ...{ limb, axis, mesh, shape: "line" },
      points: () => inWorld(points, mark),
      light() {},
      gesture: (hold) => new TurnDrag(this.page, handle, axis.axis, hold),
    };
  }
}
