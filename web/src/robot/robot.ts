import type { Object3D } from "three";
import { carrierOf } from "../ik/chain.ts";
import { LinkColours } from "../scene/link_colours.ts";
import { makeMesh } from "../scene/materials.ts";
import type { Studio } from "../scene/studio.ts";
import { THREE, boxOf, sphereOf } from "../three.ts";
import type { About, Coordinate, Shape } from "../types.ts";
import { rangeOf } from "../values/configurations.ts";
import { between, Skeleton } from "./nodes.ts";
import { Standing } from "./standing.ts";
import type { Received } from "../received.ts";

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

// How far a joint may be outside its limits [rad, m]: the values of a clip are rounded to 32 bits.
const SLACK = 1e-6;

/** The robot: its tree, its shapes, its limits and its masses. */
export class Robot extends Skeleton {
  /** The index of the link of every frame. */
  frames = new Map(this.about.frames.map(({ name, link }) => [name, link]));
  meshes: Shape[] = [];
  /** For each sole the links that move with it. */
  feet: number[][];
  /** The configuration. There is only this one array, into which all other parts write. */
  q = [...this.about.neutral];

  /** @param share factor on the opacity of its shapes */
  constructor(root: THREE.Object3D, about: About, parts: Parts, share: number) {
    super(root, about);
    for (const { link, geometry, matrix, colour, opacity, light } of about.shapes) {
      const mesh = makeMesh(parts.geometries.get(geometry) as THREE.BufferGeometry, colour, share * opacity);
      mesh.applyMatrix4(new THREE.Matrix4().fromArray(matrix));
      this.nodes[link].add(mesh);
      this.meshes.push({ mesh, link, light });
    }
    const carriers = about.links.map(({ path }) => carrierOf(about, path));
    this.feet = about.soles.map(({ link }) =>
      [...carriers.keys()].filter((other) => carriers[other] === carriers[link]),
    );
  }

  frameNode(name: string) {
    return this.nodes[this.linkOf(name)];
  }

  /** Whether a link is fixed to the root. */
  isBase(link: number) {
    return carrierOf(this.about, this.about.links[link].path) === undefined;
  }

  /** Index of the link that a frame belongs to. */
  linkOf(name: string) {
    const link = this.frames.get(name);
    if (link === undefined) throw new Error(`no frame ${name}`);
    return link;
  }

  /** The range of a coordinate, coupled limits included, in a configuration. */
  range(coordinate: Coordinate, q: ArrayLike<number>): [number, number] {
    return rangeOf(this.about, coordinate, q);
  }

  /** Columns of the coordinates that are outside their ranges. */
  outside(q: ArrayLike<number>) {
    const outside = this.about.coordinates.filter((coordinate) => {
      const [low, high] = this.range(coordinate, q);
      return q[coordinate.column] < low - SLACK || q[coordinate.column] > high + SLACK;
    });
    return new Set(outside.map(({ column }) => column));
  }

  /** Centre of mass in the same frame as `pose`; null for a robot without mass. */
  com() {
    const [sum, place] = [new THREE.Vector3(), new THREE.Vector3()];
    let total = 0;
    for (const { link, mass, centre } of this.about.bodies) {
      sum.addScaledVector(place.fromArray(centre).applyMatrix4(this.nodes[link].matrixWorld), mass);
      total += mass;
    }
    return total > 0 ? sum.divideScalar(total).applyMatrix4(this.toRoot()) : null;
  }

  /** The transform from three.js's world into the scene, which has z up and the floor at 0. */
  fromWorld() {
    const scene = this.root.parent as THREE.Object3D;
    return new THREE.Matrix4().copy(scene.matrixWorld).invert();
  }

  /** Pose of the root in the scene, whose floor is at z = 0. */
  placement() {
    return this.fromWorld().multiply(this.root.matrixWorld);
  }

  /** The corners of each sole in the scene, whose floor is at z = 0. */
  corners() {
    return this.about.soles.map(({ link, corners }) => {
      const T = this.fromWorld().multiply(this.nodes[link].matrixWorld);
      const places = Array.from({ length: corners.length / 3 }, (_, i) => new THREE.Vector3(...corners.slice(3 * i)));
      return places.map((corner) => corner.applyMatrix4(T));
    });
  }

  /** Height of the lowest vertex over the floor, of all shapes or of some. */
  lowest(among: Shape[] = this.meshes) {
    const fromWorld = this.fromWorld();
    const shapes = among.map(({ mesh }) => {
      const T = new THREE.Matrix4().multiplyMatrices(fromWorld, mesh.matrixWorld).elements;
      const { min, max } = boxOf(mesh);
      // The lowest corner of the box around it.
      const least = (slope: number, a: number, b: number) => slope * (slope > 0 ? a : b);
      const under = least(T[2], min.x, max.x) + least(T[6], min.y, max.y) + least(T[10], min.z, max.z) + T[14];
      return { position: mesh.geometry.attributes.position, T, under };
    });
    let lowest = Infinity;
    // The shapes that may reach lowest come first, so most of the others need not be searched.
    for (const { position, T, under } of shapes.sort((a, b) => a.under - b.under)) {
      if (under > lowest) break;
      for (let i = 0; i < position.count; i++) {
        const height = T[2] * position.getX(i) + T[6] * position.getY(i) + T[10] * position.getZ(i) + T[14];
        if (height < lowest) lowest = height;
      }
    }
    return Number.isFinite(lowest) ? lowest : 0;
  }

  /** Visit the vertices, relative to the floor, and their links, of the meshes that may reach below a height. */
  eachVertex(visit: (vertex: THREE.Vector3, link: number) => void, height: number) {
    const fromWorld = this.fromWorld();
    const matrix = new THREE.Matrix4();
    const vertex = new THREE.Vector3();
    for (const { mesh, link } of this.meshes) {
      matrix.multiplyMatrices(fromWorld, mesh.matrixWorld);
      const { center, radius } = sphereOf(mesh);
      if (vertex.copy(center).applyMatrix4(matrix).z - radius > height) continue;
      const { position } = mesh.geometry.attributes;
      for (let i = 0; i < position.count; i++) {
        visit(vertex.fromBufferAttribute(position, i).applyMatrix4(matrix), link);
      }
    }
  }

  /**
   * A sphere around all shapes, in the world of three.js; made from the spheres of the shapes, fast enough for every frame.
   */
  sphere(sphere: THREE.Sphere) {
    const own = new THREE.Sphere();
    sphere.makeEmpty();
    for (const { mesh } of this.meshes) {
      own.copy(sphereOf(mesh)).applyMatrix4(mesh.matrixWorld);
      if (sphere.isEmpty()) sphere.copy(own);
      else sphere.union(own);
    }
    if (sphere.isEmpty()) sphere.set(this.root.getWorldPosition(new THREE.Vector3()), 1);
    return sphere;
  }

  /** The box around some shapes in the frame of a link. */
  boxIn(link: number, shapes: Shape[]) {
    const box = new THREE.Box3();
    for (const { mesh } of shapes) {
      box.union(boxOf(mesh).clone().applyMatrix4(between(mesh, this.nodes[link])));
    }
    return box.isEmpty() ? box.expandByPoint(new THREE.Vector3()) : box;
  }

  /** The box around all shapes, or around the shapes that the given links carry, in the world of three.js. */
  box(links: number[]) {
    const box = new THREE.Box3();
    const wanted = new Set(links.map((link) => this.nodes[link]));
    for (const { mesh } of this.meshes) {
      let node: THREE.Object3D | null = mesh;
      while (wanted.size && node && !wanted.has(node)) node = node.parent;
      if (node) box.expandByObject(mesh);
    }
    if (box.isEmpty()) this.nodes.forEach((node) => box.expandByPoint(node.getWorldPosition(new THREE.Vector3())));
    return box;
  }
}

/** A robot in the scene: its tree and shapes, its placement on the floor, and the colours of its links. */
export class ShownRobot {
  robot: Robot;
  standing: Standing;
  colours: LinkColours;
  /** Columns of the coordinates that are outside their ranges. */
  outside: Set<number> = new Set();

  constructor(root: Object3D, about: About, parts: Parts, studio: Studio, opacity: number = 1) {
    this.robot = new Robot(root, about, parts, opacity);
    studio.adopt(this.robot);
    this.standing = new Standing(this.robot);
    this.colours = new LinkColours(this.robot);
  }

  /**
   * Bring the robot up to date with its configuration.
   *
   * @param up the vertical in the root's frame; null if it is not given
   * @param isHeld whether the root keeps its pose, even if the robot then leaves the floor
   */
  settle(up: ArrayLike<number> | null, isHeld: boolean = false) {
    const { robot } = this;
    robot.apply(robot.q);
    if (!robot.about.floating && !isHeld) this.standing.place(robot.q, up);
    this.outside = robot.outside(robot.q);
    const joints = robot.joints.filter(({ column }) => this.outside.has(column));
    this.colours.mark("outside", new Set(joints.map(({ link }) => link)));
  }
}
