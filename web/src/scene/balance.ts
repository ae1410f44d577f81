import type { App } from "../app.ts";
import { convexHull, inside, type Point } from "../math/surfaces.ts";
import { makeInk } from "../panel/element.ts";
import { nearestOnRim } from "../robot/settling.ts";
import { THREE } from "../three.ts";
import { unitOf, withUnit } from "../values/units.ts";

// A point up to this height above the floor counts as touching it [m].
const TOUCHING = 0.002;
const INK = 0x20242c;
const [STANDS, FALLS] = [0x2f9e64, 0xd6453d];
const OVER = { depthTest: false, transparent: true };
// The marks lie so far above the floor [m]. They are drawn after it, and as if they were nearer to the camera than it.
const ABOVE = 0.001;
const FLAT = {
  transparent: true,
  side: THREE.DoubleSide,
  depthWrite: false,
  polygonOffset: true,
  polygonOffsetFactor: -2,
  polygonOffsetUnits: -2,
};
// Widths of the outline of the support, and of the line to its nearest edge [m].
const [RIM, THREAD] = [0.0045, 0.003];

/** How a robot stands, in the frame of the scene, whose floor is at z = 0. */
interface Stand {
  /** The centre of mass; null for a robot without mass. */
  centre: THREE.Vector3 | null;
  /** The support polygon, counterclockwise; empty if what touches the floor spans no area. */
  hull: THREE.Vector2[];
  /** The distance of the centre of mass, seen from above, from the nearest edge, negative outside [m]. */
  margin: number;
  /** The direction over that edge. */
  over: THREE.Vector2;
  /** The angle by which the robot can be tilted over that edge before it tips, negative for a robot that tips [rad]. */
  tilt: number;
}

/**
 * Draws the centre of mass with its projection on the floor, and the support polygon: green while the projection is inside,
 * else red. A line to the nearest edge shows the margin.
 */
export class Balance {
  shown = { com: false, support: false };
  ball;
  down = new THREE.Line(
    new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]),
    new THREE.LineDashedMaterial({ color: INK, dashSize: 0.012, gapSize: 0.008, ...OVER }),
  );
  foot;
  area = flatMark(15, 0.22);
  rim = flatMark(16);
  margin = flatMark(16);
  label = new THREE.Group();
  group = new THREE.Group();
  /** How the robot stands since its last movement, once somebody has asked. */
  private found: Stand | null = null;

  constructor(readonly page: App) {
    // Made only once: the graphics card would have to compile new materials in each step of a movement.
    const size = page.studio.markScale;
    this.ball = new THREE.Mesh(new THREE.SphereGeometry(0.018 * size, 32, 24), quarteredMaterial());
    this.ball.renderOrder = 20;
    this.down.computeLineDistances();
    this.down.frustumCulled = false;
    this.down.renderOrder = 19;
    this.foot = new THREE.Mesh(
      new THREE.RingGeometry(0.011 * size, 0.016 * size, 40),
      new THREE.MeshBasicMaterial({ color: INK, side: THREE.DoubleSide, ...OVER }),
    );
    this.foot.renderOrder = 18;
    this.group.add(this.ball, this.down, this.foot, this.area, this.rim, this.margin, this.label);
    page.viewer.scene.add(this.group);
    this.draw();
  }

  show(changes: { com?: boolean; support?: boolean }) {
    Object.assign(this.shown, changes);
    this.draw();
  }

  /** How the robot stands. */
  get stand() {
    return (this.found ??= this.find());
  }

  private find(): Stand {
    const { robot } = this.page;
    const centre = robot.com()?.applyMatrix4(robot.placement()) ?? null;
    const hull = this.hull();
    const over = new THREE.Vector2();
    if (!centre || hull.length < 3) return { centre, hull, margin: NaN, over, tilt: NaN };
    const nearest = nearestOnRim(hull.map(({ x, y }) => ({ x: x - centre.x, y: y - centre.y })));
    const sign = inside(hull, centre) ? 1 : -1;
    over.set(nearest.x, nearest.y).multiplyScalar(sign).normalize();
    const margin = sign * Math.hypot(nearest.x, nearest.y);
    return { centre, hull, margin, over, tilt: Math.atan2(margin, centre.z) };
  }

  /** Draw how the robot stands now. */
  draw() {
    this.found = null;
    const { com, support } = this.shown;
    for (const mark of this.group.children) mark.visible = false;
    const { labels } = this.page;
    if (!support) labels.set(this, []);
    if (!com && !support) return;
    const { centre } = this.stand;
    if (support) this.drawSupport(this.stand);
    if (com && centre) this.drawCentre(centre);
  }

  private drawSupport({ centre, hull, margin, over }: Stand) {
    const { labels, panel, studio } = this.page;
    if (hull.length < 3) return labels.set(this, []);
    const width = RIM * studio.markScale;
    this.fill(this.area, new THREE.ShapeGeometry(new THREE.Shape(hull)));
    this.fill(this.rim, ribbon(hull, width));
    if (!centre) return labels.set(this, []);
    const from = new THREE.Vector2(centre.x, centre.y);
    const to = from.clone().addScaledVector(over, margin);
    this.fill(this.margin, strip(from, to, THREAD * studio.markScale));
    this.label.position.set(to.x, to.y, ABOVE);
    labels.set(this, [{ text: withUnit(margin, unitOf("m", panel.settings.units)), node: this.label }]);
    for (const { material } of [this.area, this.rim, this.margin]) {
      material.color.setHex(margin >= 0 ? STANDS : FALLS).convertSRGBToLinear();
    }
  }

  /** Show a mark with another geometry. */
  private fill(mark: THREE.Mesh, geometry: THREE.BufferGeometry) {
    mark.geometry.dispose();
    mark.geometry = geometry;
    mark.visible = true;
  }

  private drawCentre(centre: THREE.Vector3) {
    const { ball, down, foot } = this;
    for (const mark of [ball, down, foot]) mark.visible = true;
    ball.position.copy(centre);
    foot.position.set(centre.x, centre.y, 0.0015);
    down.position.set(centre.x, centre.y, 0);
    const { position, lineDistance } = down.geometry.attributes;
    position.setZ(0, centre.z);
    lineDistance.setX(1, centre.z);
    position.needsUpdate = lineDistance.needsUpdate = true;
  }

  /**
   * The convex hull of what touches the floor, counterclockwise: the corners of the soles, and if other links than feet
   * touch it, all vertices, as in `nao_kin.world.balance`.
   */
  hull() {
    const { robot } = this.page;
    const hasOutline = robot.about.soles.map(({ corners }) => corners.length > 3);
    const corners = robot.corners().filter((_, i) => hasOutline[i]);
    const points = corners.flat().filter(({ z }) => z <= TOUCHING);
    const feet = new Set(robot.feet.filter((_, i) => hasOutline[i]).flat());
    const vertices: THREE.Vector3[] = [];
    let isOnFeet = true;
    robot.eachVertex((vertex, link) => {
      if (vertex.z > TOUCHING) return;
      vertices.push(vertex.clone());
      isOnFeet &&= feet.has(link);
    }, TOUCHING);
    const touching = isOnFeet ? points : [...points, ...vertices];
    return convexHull(touching.map(({ x, y }) => new THREE.Vector2(x, y)));
  }
}

/** A mark that lies on the floor, behind what is in front of it. */
function flatMark(order: number, opacity: number = 1) {
  const mark = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial({ ...FLAT, opacity }));
  mark.position.z = ABOVE;
  mark.renderOrder = order;
  mark.frustumCulled = false;
  return mark;
}

/** A band of a width around a convex outline, which goes counterclockwise. */
function ribbon(outline: readonly Point[], width: number) {
  const normals = outline.map(({ x, y }, i) => {
    const next = outline[(i + 1) % outline.length];
    const length = Math.hypot(next.x - x, next.y - y);
    return { x: (next.y - y) / length, y: (x - next.x) / length };
  });
  const corners: number[] = [];
  outline.forEach(({ x, y }, i) => {
    const [n, m] = [normals.at(i - 1) as Point, normals[i]];
    // The outer corner is in the middle between the directions out; at a sharp corner it is cut off.
    const scale = width / Math.max(1 + n.x * m.x + n.y * m.y, 0.5);
    corners.push(x, y, 0, x + scale * (n.x + m.x), y + scale * (n.y + m.y), 0);
  });
  const count = outline.length;
  const faces = outline.flatMap((_, i) => {
    const [a, b] = [2 * i, 2 * ((i + 1) % count)];
    return [a, a + 1, b, b, a + 1, b + 1];
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
  geometry.setIndex(faces);
  return geometry;
}

/** A strip of a width between two points. */
function strip(from: THREE.Vector2, to: THREE.Vector2, width: number) {
  const along = to.clone().sub(from).normalize();
  const side = new THREE.Vector2(-along.y, along.x).multiplyScalar(width / 2);
  const corners = [from.clone().sub(side), to.clone().sub(side), to.clone().add(side), from.clone().add(side)];
  return new THREE.ShapeGeometry(new THREE.Shape(corners));
}

// The usual symbol of a centre of mass: a ball with black and white quarters.
function quarteredMaterial() {
  const ink = makeInk(128, 64);
  ink.fillStyle = "#ffffff";
  ink.fillRect(0, 0, 128, 64);
  ink.fillStyle = "#14181f";
  for (const x of [0, 32, 64, 96]) ink.fillRect(x, x % 64, 32, 32);
  return new THREE.MeshBasicMaterial({ map: new THREE.CanvasTexture(ink.canvas), ...OVER });
}
