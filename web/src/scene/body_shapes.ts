import type { App } from "../app.ts";
import { fixed } from "../math/numbers.ts";
import type { Received } from "../received.ts";
import { makeGeometry } from "../robot/robot.ts";
import { asMark, dispose } from "../robot/nodes.ts";
import { THREE } from "../three.ts";
import type { Vector } from "../types.ts";
import { shiny } from "./extras.ts";

const [GREEN, VIOLET, OPACITY]: [Vector, Vector, number] = [[0.05, 0.7, 0.5], [0.45, 0.3, 0.8], 0.35];

/** The shapes by which links collide, and the box of each body with its mass and inertia; drawn over the robot's own shapes. */
export class BodyShapes {
  /** The collision shapes, once the program has sent them. */
  shapes: Received["shapes"]["shapes"] = [];
  collision: THREE.Mesh[] = [];
  inertia: THREE.Mesh[] = [];

  constructor(readonly page: App) {}

  receive({ shapes }: Received["shapes"]) {
    this.shapes = shapes;
    this.page.toggles.refresh();
    if (this.page.toggles.shown.shapes) this.showCollision(true);
  }

  showCollision(on: boolean) {
    for (const mesh of this.collision) dispose(mesh);
    this.collision = (on ? this.shapes : []).map(({ link, geometry, matrix }) =>
      this.add(link, makeGeometry(geometry), matrix, GREEN, true),
    );
    this.page.studio.moved();
  }

  /** The box of a body is solid and even, and has the body's mass, centre and inertia. */
  showInertia(on: boolean) {
    for (const mesh of this.inertia) dispose(mesh);
    const { bodies } = this.page.robot.about;
    const drawn = on ? bodies.filter(({ size }) => Math.max(...size) > 0) : [];
    this.inertia = drawn.map(({ link, size, matrix }) => {
      // Even a flat or a thin body has a thickness to see.
      const [x, y, z] = size.map((edge) => Math.max(edge, 1e-3));
      return this.add(link, new THREE.BoxGeometry(x, y, z), matrix, VIOLET, false);
    });
    this.page.labels.set(
      this,
      drawn.map(({ mass }, i) => ({ text: `${fixed(mass, 3)} kg`, node: this.inertia[i] })),
    );
    this.page.studio.moved();
  }

  /** @param depthTest whether the robot's shapes hide what is inside them */
  add(link: number, geometry: THREE.BufferGeometry, matrix: number[], colour: Vector, depthTest: boolean) {
    const material = shiny(colour, OPACITY);
    Object.assign(material, { depthWrite: false, depthTest });
    // A collision mesh lies almost on the shape that it stands for, and is drawn in front of it.
    Object.assign(material, { polygonOffset: true, polygonOffsetFactor: -4, polygonOffsetUnits: -40 });
    const mesh = asMark(new THREE.Mesh(geometry, material));
    mesh.renderOrder = 5;
    mesh.applyMatrix4(new THREE.Matrix4().fromArray(matrix));
    this.page.robot.nodes[link].add(mesh);
    mesh.updateWorldMatrix(true, false);
    return mesh;
  }
}
