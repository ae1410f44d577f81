import type { Received } from "../received.ts";
import { THREE } from "../three.ts";
import type { About } from "../types.ts";
import type { Robot } from "./robot.ts";

/** Descriptions and geometries by the names of Python: equal robots share a description, and equal shapes a geometry. */
export class Parts {
  geometries: Map<string, THREE.BufferGeometry> = new Map();
  models: Map<string, About> = new Map();

  addGeometry({ name, geometry }: Received["geometry"]) {
    if (!this.geometries.has(name)) this.geometries.set(name, makeGeometry(geometry));
  }

  addModel({ name, about }: Received["model"]) {
    if (!this.models.has(name)) this.models.set(name, about);
  }

  /** @param name of a description that has been received */
  model(name: string): About {
    return this.models.get(name) as About;
  }

  /** Remove the descriptions and geometries that none of these robots uses. */
  keep(robots: readonly Robot[]) {
    const models = new Set(robots.map(({ about }) => about));
    const used = new Set(robots.flatMap(({ meshes }) => meshes.map(({ mesh }) => mesh.geometry)));
    for (const [name, about] of this.models) if (!models.has(about)) this.models.delete(name);
    for (const [name, geometry] of this.geometries) {
      if (used.has(geometry)) continue;
      geometry.dispose();
      this.geometries.delete(name);
    }
  }
}

/** @param geometry in the format of three.js's loader */
export function makeGeometry(geometry: object): THREE.BufferGeometry {
  const { made } = new THREE.ObjectLoader().parseGeometries([{ ...geometry, uuid: "made" }]);
  return made as THREE.BufferGeometry;
}
