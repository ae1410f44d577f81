import { THREE } from "../three.js";
import { rangeOf } from "../values/configurations.js";
import { between, isInside } from "./nodes.js";
import { Skeleton } from "./skeleton.js";

/** @typedef {import("../types.js").RobotMesh} RobotMesh */
/** @typedef {import("../types.js").Shape} Shape */

// How far a joint may be outside its limits [rad, m].
const SLACK = 1e-9;

/** The robot on show: its skeleton, its shapes, its limits and its masses. */
export class Robot extends Skeleton {
  /**
   * @param {THREE.Object3D} root
   * @param {import("../types.js").About} about
   */
  constructor(root, about) {
    super(root, about);
    /** Name of every frame → number of its link. */
    this.frames = new Map(about.frames.map(({ name, link }) => [name, link]));
    /** @type {Shape[]} */
    this.meshes = [];
    this.nodes.forEach((node, link) => {
      for (const visual of node.children.filter(({ name }) => name.startsWith("visual:"))) {
        visual.traverse((mesh) => {
          if (mesh instanceof THREE.Mesh) this.meshes.push({ mesh: /** @type {RobotMesh} */ (mesh), link });
        });
      }
    });
    /** The configuration. meshcat's clips write into this array of the root; all else does too: there is one truth. */
    this.q = [...about.neutral];
    /** The vertical in the root's frame that a clip gives with them, of any length; zeros where it gives none. */
    this.clipUp = [0, 0, 0];
    Object.assign(root, { joint_values: this.q, up_values: this.clipUp });
  }

  /**
   * The shapes that one visual of a link is drawn with.
   *
   * @param {number} link
   * @param {number} number of the visual among those of the link
   */
  visual(link, number) {
    const node = this.nodes[link].children.find(({ name }) => name === `visual:${number}`);
    return node ? this.meshes.filter(({ mesh }) => isInside(mesh, node)) : [];
  }

  /** @param {string} name of a frame */
  frameNode(name) {
    return this.nodes[this.linkOf(name)];
  }

  /**
   * Number of the link that a frame belongs to.
   *
   * @param {string} name
   */
  linkOf(name) {
    const link = this.frames.get(name);
    if (link === undefined) throw new Error(`no frame ${name}`);
    return link;
  }

  /**
   * Pose of a frame in that of another one.
   *
   * @param {string} frame
   * @param {string} reference
   */
  poseIn(frame, reference) {
    return between(this.frameNode(frame), this.frameNode(reference));
  }

  /**
   * The range of a coordinate, coupled limits included, in a configuration.
   *
   * @param {import("../types.js").Coordinate} coordinate
   * @param {ArrayLike<number>} q
   * @returns {[number, number]}
   */
  range(coordinate, q) {
    return rangeOf(this.about, coordinate, q);
  }

  /**
   * Columns of the coordinates that are outside their ranges.
   *
   * @param {ArrayLike<number>} q
   */
  outside(q) {
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

  /** Where the scene has z up and its floor at 0: the inverse of three.js's world there. */
  fromWorld() {
    const scene = /** @type {THREE.Object3D} */ (this.root.parent);
    return new THREE.Matrix4().copy(scene.matrixWorld).invert();
  }

  /** Pose of the root over the floor. */
  placement() {
    return this.fromWorld().multiply(this.root.matrixWorld);
  }

  /** Height of the lowest vertex over the floor. */
  lowest() {
    const fromWorld = this.fromWorld();
    const shapes = this.meshes.map(({ mesh }) => {
      const T = new THREE.Matrix4().multiplyMatrices(fromWorld, mesh.matrixWorld).elements;
      if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
      const { min, max } = /** @type {THREE.Box3} */ (mesh.geometry.boundingBox);
      // The lowest corner of the box around it.
      const least = (/** @type {number} */ slope, /** @type {number} */ a, /** @type {number} */ b) =>
        slope * (slope > 0 ? a : b);
      const under = least(T[2], min.x, max.x) + least(T[6], min.y, max.y) + least(T[10], min.z, max.z) + T[14];
      return { position: mesh.geometry.attributes.position, T, under };
    });
    let lowest = Infinity;
    // Those first that may reach lowest: most of the others need no look then.
    for (const { position, T, under } of shapes.sort((a, b) => a.under - b.under)) {
      if (under > lowest) break;
      for (let i = 0; i < position.count; i++) {
        const height = T[2] * position.getX(i) + T[6] * position.getY(i) + T[10] * position.getZ(i) + T[14];
        if (height < lowest) lowest = height;
      }
    }
    return Number.isFinite(lowest) ? lowest : 0;
  }

  /**
   * Visit the vertices of the meshes that may reach under a height, over the floor.
   *
   * @param {(vertex: THREE.Vector3) => void} visit
   * @param {() => number} height
   */
  eachVertex(visit, height) {
    const fromWorld = this.fromWorld();
    const matrix = new THREE.Matrix4();
    const vertex = new THREE.Vector3();
    for (const { mesh } of this.meshes) {
      matrix.multiplyMatrices(fromWorld, mesh.matrixWorld);
      if (!mesh.geometry.boundingSphere) mesh.geometry.computeBoundingSphere();
      const { center, radius } = /** @type {THREE.Sphere} */ (mesh.geometry.boundingSphere);
      if (vertex.copy(center).applyMatrix4(matrix).z - radius > height()) continue;
      const { position } = mesh.geometry.attributes;
      for (let i = 0; i < position.count; i++) visit(vertex.fromBufferAttribute(position, i).applyMatrix4(matrix));
    }
  }

  /**
   * A sphere around all shapes, in the world of three.js; from their own spheres, so that it may be asked for in every frame.
   *
   * @param {THREE.Sphere} sphere is given it
   */
  sphere(sphere) {
    const own = new THREE.Sphere();
    sphere.makeEmpty();
    for (const { mesh } of this.meshes) {
      if (!mesh.geometry.boundingSphere) mesh.geometry.computeBoundingSphere();
      own.copy(/** @type {THREE.Sphere} */ (mesh.geometry.boundingSphere)).applyMatrix4(mesh.matrixWorld);
      if (sphere.isEmpty()) sphere.copy(own);
      else sphere.union(own);
    }
    if (sphere.isEmpty()) sphere.set(this.root.getWorldPosition(new THREE.Vector3()), 1);
    return sphere;
  }

  /**
   * The box around some shapes in the frame of a link.
   *
   * @param {number} link
   * @param {Shape[]} shapes
   */
  boxIn(link, shapes) {
    const box = new THREE.Box3();
    for (const { mesh } of shapes) {
      if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
      const own = /** @type {THREE.Box3} */ (mesh.geometry.boundingBox).clone();
      box.union(own.applyMatrix4(between(mesh, this.nodes[link])));
    }
    return box.isEmpty() ? box.expandByPoint(new THREE.Vector3()) : box;
  }

  /**
   * The box around all shapes, or around those that the given links carry, in the world of three.js.
   *
   * @param {number[]} links
   */
  box(links) {
    const box = new THREE.Box3();
    const wanted = new Set(links.map((link) => this.nodes[link]));
    for (const { mesh } of this.meshes) {
      /** @type {THREE.Object3D | null} */
      let node = mesh;
      while (wanted.size && node && !wanted.has(node)) node = node.parent;
      if (node) box.expandByObject(mesh);
    }
    if (box.isEmpty()) this.nodes.forEach((node) => box.expandByPoint(node.getWorldPosition(new THREE.Vector3())));
    return box;
  }
}
