import { convexHull, inside } from "../math/surfaces.ts";
import { makeInk } from "../panel/element.ts";
import type { Robot } from "../robot/robot.ts";
import { nearestOnRim } from "../robot/settling.ts";
import { THREE } from "../three.ts";
import type { Studio } from "./studio.ts";

// A point up to this height above the floor counts as touching it [m].
const TOUCHING = 0.002;
const INK = 0x20242c;
const [STANDS, FALLS] = [0x2f9e64, 0xd6453d];
const OVER = { depthTest: false, transparent: true };

/**
 * Draws the centre of mass with its projection on the floor, and the hull of all points that touch the floor: green while
 * the projection is inside the hull, else red. A line to the nearest edge shows the margin.
 */
export class Balance {
  shown = { com: false, support: false };
  ball;
  down = new THREE.Line(
    new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]),
    new THREE.LineDashedMaterial({ color: INK, dashSize: 0.012, gapSize: 0.008, ...OVER }),
  );
  foot;
  area = new THREE.Mesh(
    new THREE.BufferGeometry(),
    new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.22, depthWrite: false }),
  );
  rim = new THREE.LineLoop(new THREE.BufferGeometry(), new THREE.LineBasicMaterial(OVER));
  corners = new THREE.Points(
    new THREE.BufferGeometry(),
    new THREE.PointsMaterial({ size: 6, sizeAttenuation: false, ...OVER }),
  );
  margin = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial(OVER));
  group = new THREE.Group();

  constructor(
    readonly robot: Robot,
    scene: THREE.Scene,
    studio: Studio,
  ) {
    // Made only once: the graphics card would have to compile new materials in each step of a movement.
    const size = studio.markScale;
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
    this.area.position.z = 0.0006;
    this.area.renderOrder = 15;
    for (const mark of [this.rim, this.corners, this.margin]) mark.renderOrder = 16;
    this.group.add(this.ball, this.down, this.foot, this.area, this.rim, this.corners, this.margin);
    scene.add(this.group);
    this.draw();
  }

  show(changes: { com?: boolean; support?: boolean }) {
    Object.assign(this.shown, changes);
    this.draw();
  }

  draw() {
    const { com, support } = this.shown;
    for (const mark of this.group.children) mark.visible = false;
    if (!com && !support) return;
    const centre = this.robot.com()?.applyMatrix4(this.robot.placement()) ?? null;
    if (support) this.drawSupport(centre);
    if (com && centre) this.drawCentre(centre);
  }

  drawSupport(centre: THREE.Vector3 | null) {
    const hull = this.hull();
    if (hull.length < 3) return;
    const { area, rim, corners, margin } = this;
    const color = centre && inside(hull, centre) ? STANDS : FALLS;
    for (const mark of centre ? [area, rim, corners, margin] : [area, rim, corners]) {
      mark.visible = true;
      mark.material.color.setHex(color);
      mark.geometry.dispose();
    }
    area.geometry = new THREE.ShapeGeometry(new THREE.Shape(hull));
    const outline = hull.map(({ x, y }) => new THREE.Vector3(x, y, 0.001));
    for (const mark of [rim, corners]) mark.geometry = new THREE.BufferGeometry().setFromPoints(outline);
    if (!centre) return;
    const nearest = nearestOnRim(hull.map(({ x, y }) => ({ x: x - centre.x, y: y - centre.y })));
    const ends = [new THREE.Vector3(), new THREE.Vector3(nearest.x, nearest.y, 0)];
    margin.geometry = new THREE.BufferGeometry().setFromPoints(ends);
    margin.position.set(centre.x, centre.y, 0.001);
  }

  drawCentre(centre: THREE.Vector3) {
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

  /** The convex hull, on the floor, of all vertices that touch it; counterclockwise. */
  hull() {
    const points: THREE.Vector2[] = [];
    this.robot.eachVertex(({ x, y, z }) => z < TOUCHING && points.push(new THREE.Vector2(x, y)), TOUCHING);
    return convexHull(points);
  }
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
