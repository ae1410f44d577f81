import type { App } from "../app.ts";
import { limbsOf } from "../ik/limbs.ts";
import type { Robot } from "../robot/robot.ts";
import { makeTriad } from "../scene/shapes.ts";
import { asMark, dispose } from "../robot/nodes.ts";
import { isParallel } from "../scene/camera.ts";
import { THREE, sphereOf } from "../three.ts";
import type { MeshcatViewer } from "../types.ts";
import { frameOf } from "./facts.ts";
import { Hover } from "./hover.ts";
import { Measure } from "./measure.ts";

const SIZE = 0.062;

/** The selected frame, drawn as a triad with its name. Event of the page: "selected", at every click. */
class Selection {
  /** The frame whose pose the panel shows: the one selected last, at first a hand, whose pose changes most. */
  read =
    limbsOf(this.about).find(({ kind }) => kind === "hand")?.frame ??
    this.about.effectors[0] ??
    this.about.frames[0].name;
  frame: string | null = null;
  triad: THREE.Group | null = null;

  constructor(
    readonly page: App,
    readonly about = page.robot.about,
  ) {}

  /** Number of the link that the frame belongs to. */
  get link() {
    return this.frame === null ? null : this.page.robot.linkOf(this.frame);
  }

  selectLink(link: number) {
    this.select(frameOf(this.page.robot.about, link));
  }

  /** @param frame whose pose the panel shows from now on, drawn or not */
  follow(frame: string) {
    this.read = frame;
    this.page.dispatchEvent(new Event("selected"));
  }

  select(frame: string | null) {
    if (frame !== this.frame) this.draw(frame);
    this.follow(frame ?? this.read);
  }

  draw(frame: string | null) {
    this.frame = frame;
    if (this.triad) dispose(this.triad);
    this.triad = null;
    if (frame !== null) {
      this.triad = asMark(makeTriad(SIZE * this.page.studio.markScale));
      this.page.robot.frameNode(frame).add(this.triad);
    }
    this.page.labels.set(this, this.triad && frame !== null ? [{ text: frame, node: this.triad }] : []);
    this.page.viewer.set_dirty();
  }
}

/** The link under the pointer, the selection, and the measurement. */
export class Pick {
  viewport = new Viewport(this.page.viewer, this.pane);
  picker = new Picker(this.page.robot, this.viewport);
  hover = new Hover(this.page, this.picker, this.pane);
  selection = new Selection(this.page);
  measure = new Measure(this.page);

  constructor(
    readonly page: App,
    readonly pane: HTMLElement,
  ) {}
}

/** Converts between places on the screen and rays or points in the scene. */
export class Viewport {
  constructor(
    readonly viewer: MeshcatViewer,
    readonly pane: HTMLElement,
  ) {}

  /** The camera, with its world matrix up to date. */
  get camera() {
    const { camera } = this.viewer;
    camera.updateWorldMatrix(true, false);
    return camera;
  }

  /** The ray from the camera through a place on the screen. */
  ray({ clientX, clientY }: { clientX: number; clientY: number }) {
    const { left, top, width, height } = this.pane.getBoundingClientRect();
    const x = (2 * (clientX - left)) / width - 1;
    const y = 1 - (2 * (clientY - top)) / height;
    const { camera } = this;
    // In parallel projection the rays begin far in front of everything.
    const ends = [isParallel(camera) ? -1 : 0, 0.5].map((z) => new THREE.Vector3(x, y, z).unproject(camera));
    const from = isParallel(camera) ? ends[0] : new THREE.Vector3().setFromMatrixPosition(camera.matrixWorld);
    return new THREE.Ray(from, ends[1].sub(from).normalize());
  }

  /** The place on the screen of a point in the world [px]; null for a point behind the camera. */
  place(point: THREE.Vector3) {
    const { left, top, width, height } = this.pane.getBoundingClientRect();
    const { x, y, z } = point.clone().project(this.camera);
    if (z >= 1) return null;
    return { clientX: left + ((1 + x) / 2) * width, clientY: top + ((1 - y) / 2) * height };
  }

  /**
   * Return a function from a ray of the pointer to the new place of a point that it drags in the plane facing the camera.
   * The function returns null if the ray does not meet the plane; with `level` the point moves only up and down on the
   * screen.
   *
   * @param at the point, in the world
   * @param from the ray of the pointer when it grabs the point
   */
  pulled(at: THREE.Vector3, from: THREE.Ray) {
    const towards = this.camera.getWorldDirection(new THREE.Vector3());
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(towards, at);
    const start = from.intersectPlane(plane, new THREE.Vector3()) ?? at;
    return (ray: THREE.Ray, { level }: { level: boolean }) => {
      const by = ray.intersectPlane(plane, new THREE.Vector3())?.sub(start);
      if (by && level) by.projectOnVector(this.axes[1]);
      return by?.add(at) ?? null;
    };
  }

  /** Move a point to the right and up on the screen [m]. */
  shift(point: THREE.Vector3, right: number, up: number) {
    const [x, y] = this.axes;
    return point.addScaledVector(x, right).addScaledVector(y, up);
  }

  /** Unit vectors of the world to the right and up on the screen. */
  get axes() {
    const { matrixWorld } = this.camera;
    return [0, 1].map((column) => new THREE.Vector3().setFromMatrixColumn(matrixWorld, column));
  }

  /** Metres per pixel at the depth of a point. */
  metresPerPixel(point: THREE.Vector3) {
    const { camera } = this;
    if (isParallel(camera)) return 2 / camera.projectionMatrix.elements[5] / (this.pane.clientHeight || 1);
    const depth = point.clone().applyMatrix4(camera.matrixWorldInverse).z;
    const half = Math.tan(THREE.MathUtils.degToRad(camera.fov / 2)) / camera.zoom;
    return (2 * Math.abs(depth) * half) / (this.pane.clientHeight || 1);
  }
}

/**
 * A point on the surface of the robot: its link, the point in the world, and the same point in the frame of the link.
 */
export interface Hit {
  link: number;
  point: THREE.Vector3;
  local: THREE.Vector3;
}

/** Finds the surface under the pointer. */
export class Picker {
  caster = new THREE.Raycaster();

  constructor(
    readonly robot: Robot,
    readonly viewport: Viewport,
  ) {}

  /**
   * The first surface under a place on the screen. Only the triangles of shapes whose bounding sphere the ray enters are
   * tested, the nearest shape first, until the remaining spheres begin behind the surface found.
   */
  at(place: { clientX: number; clientY: number }): Hit | null {
    const { caster, robot } = this;
    caster.ray.copy(this.viewport.ray(place));
    const sphere = new THREE.Sphere();
    const candidates = robot.meshes.flatMap(({ mesh, link }) => {
      sphere.copy(sphereOf(mesh)).applyMatrix4(mesh.matrixWorld);
      const along = sphere.center.clone().sub(caster.ray.origin).dot(caster.ray.direction);
      const beside = caster.ray.distanceSqToPoint(sphere.center);
      if (beside > sphere.radius ** 2) return [];
      return [{ mesh, link, entry: along - Math.sqrt(sphere.radius ** 2 - beside) }];
    });
    candidates.sort((a, b) => a.entry - b.entry);
    let [least, found, owner] = [Infinity, new THREE.Vector3(), -1];
    for (const { mesh, link, entry } of candidates) {
      if (entry > least) break;
      const [first] = caster.intersectObject(mesh, false);
      if (first && first.distance < least) [least, found, owner] = [first.distance, first.point, link];
    }
    if (owner < 0) return null;
    return { link: owner, point: found, local: robot.nodes[owner].worldToLocal(found.clone()) };
  }
}
