import { makeLine, makeMesh, makePoints } from "./extra_shapes.js";
import { asMark, dispose } from "./marking.js";
import { THREE } from "../three.js";

/** @type {Record<string, (message: any) => THREE.Object3D>} */
const MAKERS = { points: makePoints, mesh: makeMesh, line: makeLine };

/** Shapes that are no part of a robot, by name: in the world, or carried by a frame of the page's own robot. */
export class Extras {
  /** @param {import("../app.js").App} app */
  constructor(app) {
    this.app = app;
    /** @type {Map<string, THREE.Object3D>} */
    this.shapes = new Map();
  }

  /**
   * Draw a shape, instead of the one of the same name.
   *
   * @param {{ name: string, shape: string, frame: string | null }} message and what belongs to its shape
   */
  add(message) {
    const { name, shape, frame } = message;
    if (!Object.hasOwn(MAKERS, shape)) return;
    this.remove(name);
    const made = asMark(MAKERS[shape](message));
    (frame === null ? this.app.viewer.scene : this.app.robot.frameNode(frame)).add(made);
    this.shapes.set(name, made);
    this.app.studio.moved();
  }

  /**
   * Forget all shapes but these.
   *
   * @param {string[]} names
   */
  keep(names) {
    const kept = new Set(names);
    for (const name of [...this.shapes.keys()]) if (!kept.has(name)) this.remove(name);
  }

  /** @param {string} name */
  remove(name) {
    const shape = this.shapes.get(name);
    if (!shape) return;
    shape.traverse((node) => node instanceof THREE.InstancedMesh && node.dispose());
    dispose(shape);
    this.shapes.delete(name);
    this.app.studio.moved();
  }
}
