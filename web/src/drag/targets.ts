import type { App } from "../app.ts";
import type { Vector } from "../math/rotations.ts";
import type { Viewport } from "../pick/pick.ts";
import type { Received } from "../received.ts";
import { Changes } from "../reports.ts";
import { AXES, makeArrow, makeTriad, turnAlong, type Axis } from "../scene/shapes.ts";
import { asMark, dispose } from "../robot/nodes.ts";
import type { Group, Mesh, MeshBasicMaterial, Sprite } from "three";
import { THREE } from "../three.ts";
import type { Gesture, Grip, Hold } from "./gestures.ts";
import { highlight, inWorld, makeKnob, makeRing } from "./handles.ts";
import { Swept } from "./swept_angle.ts";

type Row = Received["targets"]["targets"][number];

type Drawn = Mesh | Group | Sprite;

/** The knob (without an axis), an arrow along an axis of the target, or a ring about one. */
interface TargetGrip extends Grip {
  axis: Axis | null;
  turns: boolean;
  drawn: Drawn;
}

// Sizes for a small robot [m]: of a mark; of the ball of a target that can be dragged, the start and end of its arrows, and
// its rings.
const SIZE = 0.09;
const [BALL, FROM, TO, RING] = [0.022, 0.034, 0.07, 0.056];
const COLOUR = 0xc2255c;

/** A target: a point or a pose in the robot's root, with grips if it can be dragged. */
class Target {
  node = new THREE.Group();
  grips: TargetGrip[] = [];
  /** Number of moves in this page. */
  count = 0;

  constructor(
    readonly page: App,
    readonly row: Row,
  ) {
    const scale = page.studio.markScale;
    const isMark = row.source === undefined;
    const [radius, opacity] = isMark ? [0.16 * SIZE, 0.3] : [BALL, 0.5];
    const veil = new THREE.MeshBasicMaterial({ color: COLOUR, transparent: true, opacity, depthWrite: false });
    // A target that can be dragged is visible even inside the hand.
    veil.depthTest = isMark;
    const ball = new THREE.Mesh(new THREE.SphereGeometry(radius * scale, 28, 20), veil);
    ball.renderOrder = isMark ? 0 : 20;
    this.node.add(ball);
    this.node.matrixAutoUpdate = false;
    if (isMark) {
      if (!row.point) this.node.add(makeTriad(0.6 * SIZE * scale));
      return;
    }
    for (const axis of AXES) {
      const direction = new THREE.Vector3(...axis.axis);
      const arrow = makeArrow((TO - FROM) * scale, 0.0016 * scale, axis.colour, 22);
      arrow.position.copy(direction).multiplyScalar(FROM * scale);
      turnAlong(arrow, axis);
      const along = [0, 0.25, 0.5, 0.75, 1, 1.25].map((share) => scale * (FROM + share * (TO - FROM)));
      const points = along.map((x) => direction.clone().multiplyScalar(x));
      this.add(arrow, points, axis, (hold) => new TargetMove(page, this, axis, hold));
      if (row.point) continue;
      const ring = makeRing(axis, RING, scale);
      this.add(ring.mesh, ring.points, axis, (hold) => new TargetTurn(page, this, axis, hold), true);
    }
    this.add(makeKnob(), [new THREE.Vector3()], null, (hold) => new TargetMove(page, this, null, hold));
  }

  get knob() {
    return this.grips[this.grips.length - 1];
  }

  /** @param points of the grip, in the target's frame */
  add(drawn: Drawn, points: THREE.Vector3[], axis: Axis | null, gesture: Grip["gesture"], turns = false) {
    const grip = {
      ...{ axis, turns, drawn, gesture },
      shape: axis === null ? ("knob" as const) : ("line" as const),
      points: () => inWorld(points, this.node),
      light: (on: boolean) => light(drawn, on),
    };
    this.grips.push(grip);
    this.node.add(drawn);
    grip.light(false);
  }
}

/** Draw a grip brighter while it is under the pointer. */
function light(drawn: Drawn, on: boolean) {
  if (drawn instanceof THREE.Sprite) return highlight(drawn, on);
  drawn.traverse((part) => {
    const material = (part as Mesh).material as MeshBasicMaterial | undefined;
    if (material) material.opacity = on ? 1 : 0.7;
  });
}

/**
 * The targets of the program, in the robot's root: marks, and targets that can be dragged. Event of the page: "targets",
 * when the list of targets changes.
 */
export class Targets {
  group = asMark(new THREE.Group());
  list: Target[] = [];
  gripsShown = true;
  /** The poses of the targets that were moved in this page. */
  changes = new Changes<Target, number[]>(this.page, ({ row, node, count }) => {
    const source = `${this.page.reports.source} ${count}`;
    this.page.send({ kind: "target", name: row.name, matrix: node.matrix.toArray(), source });
  });

  constructor(readonly page: App) {
    page.robot.root.add(this.group);
  }

  get movable() {
    return this.list.filter(({ grips }) => grips.length > 0);
  }

  /**
   * Show these targets and no others.
   *
   * @param rows matrices column by column; a point has no axes; targets with a source can be dragged
   */
  show(rows: Row[]) {
    const keyOf = ({ name, point, source }: Row) => `${point} ${source !== undefined} ${name}`;
    const known = new Map(this.list.map((target) => [keyOf(target.row), target]));
    const list = rows.map((row) => {
      const old = known.get(keyOf(row));
      const target = old ?? new Target(this.page, row);
      known.delete(keyOf(row));
      const isNews = this.page.reports.isNews(`target ${keyOf(row)}`, row, target.count);
      if (!old || (isNews && !this.changes.waiting.has(target))) target.node.matrix.fromArray(row.matrix);
      return target;
    });
    const isSame = known.size === 0 && list.length === this.list.length && list.every((one, i) => one === this.list[i]);
    for (const target of known.values()) dispose(target.node);
    this.list = list;
    if (!isSame) {
      for (const { node } of list) this.group.add(node);
      this.showGrips(this.gripsShown);
      this.page.labels.set(
        this,
        list.map((target) => ({
          text: this.isAim(target) ? `${target.row.name}: target` : target.row.name,
          node: target.node,
        })),
      );
      const aim = list.find((target) => this.isAim(target));
      if (aim) this.page.pick.selection.follow(aim.row.name);
      this.page.dispatchEvent(new Event("targets"));
    }
    this.group.updateWorldMatrix(true, true);
    this.page.panel.readout.refresh();
  }

  /** Whether a target is a mark that has the name of a frame: the frame is to get there. */
  isAim({ row }: Target) {
    return row.source === undefined && this.page.robot.about.frames.some(({ name }) => name === row.name);
  }

  showGrips(on: boolean) {
    this.gripsShown = on;
    for (const { drawn } of this.list.flatMap(({ grips }) => grips)) drawn.visible = on;
  }

  get grips() {
    return this.gripsShown ? this.list.flatMap((target) => target.grips) : [];
  }

  /** Move a target on behalf of the user; the program is told within 1/30 s. */
  move(target: Target, matrix: THREE.Matrix4) {
    target.node.matrix.copy(matrix);
    target.node.updateWorldMatrix(true, true);
    this.page.viewer.set_dirty();
    target.count += 1;
    this.changes.later(target);
    this.note(target, true);
  }

  /** @param own whether the user has just moved it in this page */
  note({ row, node }: Target, own: boolean) {
    this.changes.note(row.name, node.matrix.toArray(), own);
  }

  /** Move the targets back to earlier poses. */
  restore(placed: Targets["changes"]["kept"]) {
    this.changes.restore(placed, (name, matrix) => {
      const target = this.movable.find(({ row }) => row.name === name);
      if (target) this.move(target, new THREE.Matrix4().fromArray(matrix));
    });
  }
}

/** Drag of a target. Without a program, a message says that nothing follows the target. */
class TargetGesture {
  before = this.target.node.matrix.clone();
  /** The target's place, and the direction of the axis that it is dragged by, in the world. */
  origin: THREE.Vector3;
  direction: THREE.Vector3 | null;
  swept: Swept | null;
  /** Gives the place in the plane that faces the camera to which a pointer drags the target. */
  pulled: ReturnType<Viewport["pulled"]> | null;

  constructor(
    readonly page: App,
    readonly target: Target,
    readonly axis: Axis | null,
    hold: Hold | null,
  ) {
    const { node } = target;
    page.robot.root.updateWorldMatrix(true, false);
    node.updateWorldMatrix(true, false);
    page.targets.note(target, false);
    page.send({ kind: "held", name: target.row.name, held: true });
    this.origin = new THREE.Vector3().setFromMatrixPosition(node.matrixWorld);
    this.direction = axis && new THREE.Vector3(...axis.axis).transformDirection(node.matrixWorld);
    this.swept = this.direction && hold && new Swept(page.pick.viewport, this.origin, this.direction, hold);
    this.pulled = hold && page.pick.viewport.pulled(this.origin, hold.ray);
  }

  put(matrix: THREE.Matrix4) {
    this.page.targets.move(this.target, matrix);
    return document.body.dataset.live === "live" ? "" : `${this.target.row.name}: no program follows it`;
  }

  end() {
    this.page.targets.changes.report();
    this.page.send({ kind: "held", name: this.target.row.name, held: false });
  }

  cancel() {
    this.put(this.before);
  }
}

/** Drag that moves a target in the plane that faces the camera, or along one of its axes. */
export class TargetMove extends TargetGesture implements Gesture {
  /** The distance moved along the axis [m]. */
  way = 0;

  /** The target's position in the robot's root. */
  get place(): Vector {
    return new THREE.Vector3().setFromMatrixPosition(this.target.node.matrix).toArray();
  }

  /** @param options `level` is whether the target moves only up and down on the screen */
  move(ray: THREE.Ray, options: { level: boolean }) {
    const { direction, origin, swept } = this;
    if (!swept || !direction) {
      const to = this.pulled?.(ray, options);
      return to ? this.moveTo(to) : "";
    }
    this.way += swept.along(ray);
    return this.moveTo(origin.clone().addScaledVector(direction, this.way));
  }

  /** Move the target from its current place to the right and up on the screen [m]. */
  step(right: number, up: number) {
    const now = new THREE.Vector3().setFromMatrixPosition(this.target.node.matrixWorld);
    return this.moveTo(this.page.pick.viewport.shift(now, right, up));
  }

  /** @param to in the world */
  moveTo(to: THREE.Vector3) {
    return this.put(this.target.node.matrix.clone().setPosition(this.page.robot.root.worldToLocal(to.clone())));
  }
}

/** Drag that turns a target about one of its axes. */
export class TargetTurn extends TargetGesture implements Gesture {
  /** The angle turned so far [rad]. */
  reached = 0;

  move(ray: THREE.Ray) {
    return this.step(this.swept?.about(ray) ?? 0);
  }

  /** @param angle by which to turn on [rad] */
  step(angle: number) {
    this.reached += angle;
    const turn = new THREE.Matrix4().makeRotationAxis(new THREE.Vector3(...(this.axis as Axis).axis), this.reached);
    const place = new THREE.Vector3().setFromMatrixPosition(this.target.node.matrix);
    return this.put(this.before.clone().multiply(turn).setPosition(place));
  }
}
