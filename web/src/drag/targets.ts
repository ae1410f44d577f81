import type { PageWith } from "../app.ts";
import type { Group, Mesh, MeshBasicMaterial, Sprite } from "three";
import { isOutdated } from "../reports.ts";
import type { Received } from "../received.ts";
import { makeArrow, makeTriad } from "../scene/extras.ts";
import { asMark, dispose } from "../scene/marks.ts";
import { THREE } from "../three.ts";
import { AXES, highlight, makeKnob, makeRing, nearest, type Axis, type Pointed } from "./handles.ts";

type Page = PageWith<"labels" | "pick" | "reports" | "robot" | "send" | "studio" | "viewer">;

type Row = Received["targets"]["targets"][number];

/** What is taken hold of: the knob, without an axis, an arrow along an axis of the target, or a ring about one. */
export interface Grip {
  target: Target;
  axis: Axis | null;
  turns: boolean;
  drawn: Mesh | Group | Sprite;
  /** Points of it in the target's frame. */
  points: THREE.Vector3[];
}

// Sizes in metres for a small robot: of a mark; of a ball, its arrows, from and to, and its rings.
const SIZE = 0.09;
const [BALL, FROM, TO, RING] = [0.022, 0.034, 0.07, 0.056];
const COLOUR = 0xc2255c;
// The least time between two reports of a target [ms].
const BETWEEN = 1000 / 30;

/** A point or a pose in the robot's root; the grips of one that can be dragged. */
export class Target {
  node = new THREE.Group();
  grips: Grip[] = [];
  /** How often it was moved in this page. */
  count = 0;

  /** @param scale of what is drawn */
  constructor(
    readonly row: Row,
    scale: number,
  ) {
    const isMark = row.source === undefined;
    const [radius, opacity] = isMark ? [0.16 * SIZE, 0.3] : [BALL, 0.5];
    const veil = new THREE.MeshBasicMaterial({ color: COLOUR, transparent: true, opacity, depthWrite: false });
    // What is to be dragged is seen in the hand that holds it.
    veil.depthTest = isMark;
    const ball = new THREE.Mesh(new THREE.SphereGeometry(radius * scale, 28, 20), veil);
    ball.renderOrder = isMark ? 0 : 20;
    this.node.add(ball);
    this.node.matrixAutoUpdate = false;
    if (isMark) {
      if (!row.point) this.node.add(makeTriad(0.6 * SIZE * scale));
      return;
    }
    const turn = new THREE.Vector3(0, 0, 1);
    for (const axis of AXES) {
      const direction = new THREE.Vector3(...axis.axis);
      const arrow = makeArrow((TO - FROM) * scale, 0.0016 * scale, axis.colour, 22);
      arrow.position.copy(direction).multiplyScalar(FROM * scale);
      arrow.quaternion.setFromUnitVectors(turn, direction);
      const along = [0, 0.25, 0.5, 0.75, 1, 1.25].map((share) => scale * (FROM + share * (TO - FROM)));
      this.add({ axis, turns: false, drawn: arrow, points: along.map((x) => direction.clone().multiplyScalar(x)) });
      if (row.point) continue;
      const { mesh, points } = makeRing(axis, RING, scale);
      this.add({ axis, turns: true, drawn: mesh, points });
    }
    this.add({ axis: null, turns: false, drawn: makeKnob(), points: [new THREE.Vector3()] });
  }

  get knob() {
    return this.grips[this.grips.length - 1];
  }

  add(grip: Omit<Grip, "target">) {
    this.grips.push({ ...grip, target: this });
    this.node.add(grip.drawn);
    light(grip.drawn, false);
  }
}

/** What is under the pointer is brighter. */
function light(drawn: Grip["drawn"], on: boolean) {
  if (drawn instanceof THREE.Sprite) return highlight(drawn, on);
  drawn.traverse((part) => {
    const material = (part as Mesh).material as MeshBasicMaterial | undefined;
    if (material) material.opacity = on ? 1 : 0.7;
  });
}

/**
 * The targets of the program, in the robot's root: marks, and those that can be dragged. Event of the page: "targets" when
 * there are others.
 */
export class Targets {
  group = asMark(new THREE.Group());
  list: Target[] = [];
  gripsShown = true;
  lit: Grip | null = null;
  /** Those that were moved, and the program has not been told. */
  waiting = new Set<Target>();

  constructor(readonly page: Page) {
    page.robot.root.add(this.group);
  }

  get movable() {
    return this.list.filter(({ grips }) => grips.length > 0);
  }

  /**
   * Show these, and no others.
   *
   * @param rows matrices by columns; a point has no axes; those with a source can be dragged
   */
  show(rows: Row[]) {
    const keyOf = ({ name, point, source }: Row) => `${point} ${source !== undefined} ${name}`;
    const known = new Map(this.list.map((target) => [keyOf(target.row), target]));
    const { source: mine } = this.page.reports;
    const list = rows.map((row) => {
      const old = known.get(keyOf(row));
      const target = old ?? new Target(row, this.page.studio.markScale);
      known.delete(keyOf(row));
      if (!old || !isOutdated(row.source ?? "", mine, target.count)) target.node.matrix.fromArray(row.matrix);
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
        list.map(({ row, node }) => ({ text: row.name, node })),
      );
      this.page.dispatchEvent(new Event("targets"));
    }
    this.group.updateWorldMatrix(true, true);
  }

  /** @param on whether there is something to take hold of */
  showGrips(on: boolean) {
    this.gripsShown = on;
    for (const { drawn } of this.list.flatMap(({ grips }) => grips)) drawn.visible = on;
    if (!on) this.light(null);
  }

  /** What is under the pointer, and where in the world. */
  at(event: Pointed) {
    const grips = this.gripsShown ? this.list.flatMap((target) => target.grips) : [];
    const places = grips.map((grip) => {
      const { node } = grip.target;
      node.updateWorldMatrix(true, false);
      const points = grip.points.map((point) => point.clone().applyMatrix4(node.matrixWorld));
      return { item: grip, points, isLine: grip.axis !== null };
    });
    const found = nearest(this.page.pick.viewport, event, places);
    return found && { grip: found.item, point: found.point };
  }

  /** @param grip the one that is drawn brighter */
  light(grip: Grip | null) {
    if (grip === this.lit) return;
    if (this.lit) light(this.lit.drawn, false);
    if (grip) light(grip.drawn, true);
    this.lit = grip;
    this.page.viewer.set_dirty();
  }

  /** Move a target as somebody does in this page; the program is told soon. */
  move(target: Target, matrix: THREE.Matrix4) {
    target.node.matrix.copy(matrix);
    target.node.updateWorldMatrix(true, true);
    this.page.viewer.set_dirty();
    target.count += 1;
    if (this.waiting.size === 0) setTimeout(() => this.report(), BETWEEN);
    this.waiting.add(target);
  }

  report() {
    const { source } = this.page.reports;
    for (const { row, node, count } of this.waiting) {
      this.page.send({ kind: "target", name: row.name, matrix: node.matrix.toArray(), source: `${source} ${count}` });
    }
    this.waiting.clear();
  }
}
