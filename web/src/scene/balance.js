import { convexHull, inside } from "../math/polygon.js";
import { THREE } from "../three.js";
import { disposeChildren } from "./marking.js";

// How far above the floor something may be and still touch it [m].
const TOUCHING = 0.005;
const INK = 0x20242c;
const [STANDS, FALLS] = [0x2f9e64, 0xd6453d];
const OVER = { depthTest: false, transparent: true };

/** The centre of mass over its projection, and the hull of what touches the floor: green while the one is in the other. */
export class Balance {
  /**
   * @param {import("../robot/robot.js").Robot} robot
   * @param {THREE.Scene} scene
   * @param {import("./studio.js").Studio} studio
   */
  constructor(robot, scene, studio) {
    this.robot = robot;
    this.studio = studio;
    this.shown = { com: false, support: false };
    this.group = new THREE.Group();
    scene.add(this.group);
  }

  /** @param {{ com?: boolean, support?: boolean }} changes */
  show(changes) {
    Object.assign(this.shown, changes);
    this.draw();
  }

  draw() {
    disposeChildren(this.group);
    const { com, support } = this.shown;
    if (!com && !support) return;
    const centre = this.robot.com()?.applyMatrix4(this.robot.placement()) ?? null;
    if (support) this.drawSupport(centre);
    if (com && centre) this.drawCentre(centre);
  }

  /** @param {THREE.Vector3 | null} centre */
  drawSupport(centre) {
    const hull = this.hull();
    if (hull.length < 3) return;
    const color = centre && inside(hull, centre) ? STANDS : FALLS;
    const area = new THREE.Mesh(
      new THREE.ShapeGeometry(new THREE.Shape(hull)),
      new THREE.MeshBasicMaterial({ color, transparent: true, opacity: 0.22, depthWrite: false }),
    );
    area.position.z = 0.0006;
    area.renderOrder = 15;
    const rim = new THREE.LineLoop(
      new THREE.BufferGeometry().setFromPoints(hull.map(({ x, y }) => new THREE.Vector3(x, y, 0.001))),
      new THREE.LineBasicMaterial({ color, ...OVER }),
    );
    rim.renderOrder = 16;
    this.group.add(area, rim);
  }

  /** @param {THREE.Vector3} centre */
  drawCentre(centre) {
    const size = this.studio.markScale;
    const ball = new THREE.Mesh(new THREE.SphereGeometry(0.018 * size, 32, 24), quarteredMaterial());
    ball.position.copy(centre);
    ball.renderOrder = 20;
    const down = new THREE.Line(
      new THREE.BufferGeometry().setFromPoints([centre, new THREE.Vector3(centre.x, centre.y, 0)]),
      new THREE.LineDashedMaterial({ color: INK, dashSize: 0.012, gapSize: 0.008, ...OVER }),
    );
    down.computeLineDistances();
    down.renderOrder = 19;
    const foot = new THREE.Mesh(
      new THREE.RingGeometry(0.011 * size, 0.016 * size, 40),
      new THREE.MeshBasicMaterial({ color: INK, side: THREE.DoubleSide, ...OVER }),
    );
    foot.renderOrder = 18;
    foot.position.set(centre.x, centre.y, 0.0015);
    this.group.add(ball, down, foot);
  }

  /** The convex hull, on the floor, of all vertices that touch it; counterclockwise. */
  hull() {
    /** @type {THREE.Vector2[]} */
    const points = [];
    this.robot.eachVertex(
      ({ x, y, z }) => z < TOUCHING && points.push(new THREE.Vector2(x, y)),
      () => TOUCHING,
    );
    return convexHull(points);
  }
}

// The engineer's sign of a centre of mass: a ball in four black and white quarters.
function quarteredMaterial() {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [128, 64];
  const ink = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  ink.fillStyle = "#ffffff";
  ink.fillRect(0, 0, 128, 64);
  ink.fillStyle = "#14181f";
  for (const [x, y] of [
    [0, 0],
    [64, 0],
    [32, 32],
    [96, 32],
  ]) {
    ink.fillRect(x, y, 32, 32);
  }
  return new THREE.MeshBasicMaterial({ map: new THREE.CanvasTexture(canvas), ...OVER });
}
