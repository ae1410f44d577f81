import { makeLine, makeMesh, makePoints } from "./extra_shapes.ts";
import { asMark, dispose } from "./marking.ts";
import { THREE } from "../three.ts";
import type { App } from "../app.ts";

const MAKERS: Record<string, (message: any) => THREE.Object3D> = { points: makePoints, mesh: makeMesh, line: makeLine };

/** Shapes that are no part of a robot, by name: in the world, or carried by a frame of the page's own robot. */
export class Extras {
  shapes: Map<string, THREE.Object3D> = new Map();

  constructor(readonly app: App) {}

  /**
   * Draw a shape, instead of the one of the same name.
   *
   * @param message and what belongs to its shape
   */
  add(message: { name: string; shape: string; frame: string | null }) {
    const { name, shape, frame } = message;
    if (!Object.hasOwn(MAKERS, shape)) return;
    this.remove(name);
    const made = asMark(MAKERS[shape](message));
    (frame === null ? this.app.viewer.scene : this.app.robot.frameNode(frame)).add(made);
    this.shapes.set(name, made);
    this.app.studio.moved();
  }

  /** Forget all shapes but these. */
  keep(names: string[]) {
    const kept = new Set(names);
    for (const name of [...this.shapes.keys()]) if (!kept.has(name)) this.remove(name);
  }

  remove(name: string) {
    const shape = this.shapes.get(name);
    if (!shape) return;
    shape.traverse((node) => node instanceof THREE.InstancedMesh && node.dispose());
    dispose(shape);
    this.shapes.delete(name);
    this.app.studio.moved();
  }
}
