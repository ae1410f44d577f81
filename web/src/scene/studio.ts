import { clamp } from "../math/numbers.ts";
import type { Robot } from "../robot/robot.ts";
import { THREE, cornersOf } from "../three.ts";
import type { Camera, MeshcatViewer, Shape } from "../types.ts";
import type { Eyes } from "./eyes.ts";
import { FastLook, Smoothing } from "./fast_look.ts";
import { Contact, Floor, ROBOT_LAYER } from "./floor.ts";
import { makeEnvironment } from "./materials.ts";
import { LEVELS, Quality, REST } from "./quality.ts";

/**
 * Move the camera so that a box just fills the view, seen from the direction of a preset, below a bar that takes a share of
 * the view's height.
 *
 * @param box to look at, in the world of three.js
 * @param size of the robot [m]
 */
function lookAt({ camera, controls }: MeshcatViewer, preset: Camera, box: THREE.Box3, size: number, bar: number) {
  const { Vector3, MathUtils } = THREE;
  camera.fov = 28;
  camera.up.set(0, 1, 0);
  camera.near = 0.02 * size;
  const centre = box.getCenter(new Vector3());
  // The world of three.js has y up: the robot's z is its y, and the robot's y its −z.
  const [x, y, z] = preset.direction;
  const back = new Vector3(x, z, -y).normalize();
  const right = new Vector3(0, 1, 0).cross(back).normalize();
  const up = back.clone().cross(right);
  const half = Math.tan(MathUtils.degToRad(camera.fov / 2));
  const hidden = clamp(2 * bar - 0.1, 0, 0.5);
  const tall = half * (0.9 - hidden / 2);
  const wide = 0.9 * half * camera.aspect;
  let distance = preset.links.length ? 0 : size;
  for (const corner of cornersOf(box)) {
    corner.sub(centre);
    const reach = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / tall);
    distance = Math.max(distance, reach + corner.dot(back));
  }
  camera.far = Math.max(60 * size, 3 * distance);
  // The coordinates of the camera are those of the world, although it is in meshcat's node, which turns z up.
  camera.position.copy(centre).addScaledVector(back, distance);
  // The picture moves down by half the height of the bar; the camera still turns about the middle of the box.
  const { aspect } = camera;
  camera.setViewOffset(1, 1, 0, -hidden / 4, 1, 1);
  camera.aspect = aspect;
  camera.updateProjectionMatrix();
  controls.target.copy(centre);
  // Farther away the robots would be only dots.
  controls.maxDistance = Math.max(30 * size, 2 * distance);
  controls.update();
}

// How far a robot walks before the camera follows, as a share of its size. KEY is the direction of the key light.
const SLACK = 0.15;
const ROUNDING = 1e-12;
const SEEN_THROUGH = 0.28;
// Pictures drawn without environment map and shadows before the first one with them: with two, one is surely on the screen.
const PLAIN = 2;
const KEY = new THREE.Vector3(0.75, 0.85, 2.6).normalize();

/** Lights, floor, shadows and camera: the look of the scene, and the quality in which each frame is drawn. */
export class Studio {
  key = new THREE.DirectionalLight(0xfffaf2, 0.44);
  smoothing = new Smoothing(this.viewer.renderer);
  fastLook: FastLook;
  contact = new Contact(this.viewer.renderer);
  floor = new Floor(this.contact);
  place = [0, 0];
  size = 1;
  /** Robots that are drawn, the page's own first, and all of their shapes. */
  robots: Robot[] = [];
  shapes: Shape[] = [];
  quality = new Quality();
  // Whether every frame is drawn in the best quality, as for a picture.
  alwaysFine = false;
  robotMoved = true;
  // Number of frames with a moved robot since the shadows were drawn.
  shadowsOld = 0;
  seen = new Float64Array(32);
  sphere = new THREE.Sphere();
  part = new THREE.Sphere();
  ratio = devicePixelRatio;
  // The factor on the opacity of the shapes, and whether the joint axes inside must be visible.
  opacity = 1;
  axesShown = false;
  eyes: Eyes | null = null;
  /** When the drawing of a change began; null if no such drawing is unfinished. */
  began: number | null = null;
  isAwaiting = false;
  resting: number | undefined;
  /** Number of plain pictures drawn since the graphics card was new to this page. */
  plain = 0;
  isPrepared = false;

  constructor(readonly viewer: MeshcatViewer) {
    const { scene, renderer } = viewer;
    viewer.hide_background();
    for (const name of ["Grid", "Axes", "Lights"]) viewer.set_property([name], "visible", false);

    // Ghosts, extras and marks do not use the environment map; this light reaches them from all sides.
    const around = new THREE.HemisphereLight(0xffffff, 0xaab4c6, 0.16);
    this.key.castShadow = true;
    for (const light of [around, this.key]) light.layers.enable(ROBOT_LAYER);
    scene.add(around, this.key, this.key.target);

    this.fastLook = new FastLook(renderer, scene, this.key);
    scene.add(this.floor.node);
    this.followScreen();
    viewer.controls.addEventListener("start", () => (this.quality.expected = true));
    viewer.controls.addEventListener("end", () => (this.quality.expected = false));
  }

  // Take over the pixels per pixel of the page, which change with the browser's zoom and with the screen.
  followScreen() {
    this.ratio = devicePixelRatio;
    const change = () => {
      this.followScreen();
      this.viewer.set_dirty();
    };
    matchMedia(`(resolution: ${this.ratio}dppx)`).addEventListener("change", change, { once: true });
  }

  /** Make again what was on the graphics card: after its context was lost, it is empty. */
  restore() {
    this.isPrepared = false;
    this.plain = 0;
    this.viewer.set_dirty();
  }

  /** Make the environment map, and let balls and shadows be drawn again. */
  prepare() {
    this.isPrepared = true;
    this.viewer.scene.environment = makeEnvironment(this.viewer.renderer);
    this.fastLook.forget();
    this.shadowsOld = Infinity;
  }

  // Marks over a robot grow with its size, up to the size of a human.
  get markScale() {
    return Math.min(this.size, 1.5);
  }

  /** Fit floor and marks to the size of the page's own robot. */
  fit(robot: Robot) {
    this.size = robot.box([]).getSize(new THREE.Vector3()).length() || 1;
    this.floor.fit(this.size);
  }

  /** Add a robot to the drawn ones. */
  adopt(robot: Robot) {
    for (const { mesh } of robot.meshes) mesh.layers.enable(ROBOT_LAYER);
    this.robots.push(robot);
    this.shapes = this.robots.flatMap(({ meshes }) => meshes);
    this.moved();
  }

  release(robot: Robot) {
    this.robots = this.robots.filter((other) => other !== robot);
    this.fastLook.release(robot.meshes);
    for (const { mesh } of robot.meshes) mesh.material.dispose();
    this.shapes = this.robots.flatMap(({ meshes }) => meshes);
    this.moved();
  }

  /** Note that a robot has moved since the last picture. */
  moved() {
    this.robotMoved = true;
  }

  /**
   * Move the camera along with a walking robot, as if on a slack rope: a robot that only sways does not move the camera.
   */
  goAlong(x: number, y: number) {
    const way = [x - this.place[0], y - this.place[1]];
    const length = Math.hypot(...way);
    const share = 1 - (SLACK * this.size) / length;
    if (!(share > 0)) return;
    const [dx, dy] = way.map((step) => share * step);
    this.place = [this.place[0] + dx, this.place[1] + dy];
    const { camera, controls } = this.viewer;
    for (const node of [camera.position, controls.target]) {
      node.x += dx;
      node.z -= dy;
    }
    this.floor.goAlong(this.place);
  }

  /** Move camera and grid as far as a pose of the robot's root moves and turns on the floor, so that it seems to stay. */
  goWith(from: THREE.Matrix4, to: THREE.Matrix4) {
    const { Matrix4, Vector3 } = THREE;
    const { elements: m } = new Matrix4().copy(from).invert().premultiply(to);
    const turn = Math.atan2(m[8], m[0]);
    const way = new Matrix4().makeRotationY(turn);
    const [begin, end] = [from, to].map((pose) => new Vector3().setFromMatrixPosition(pose));
    const { x, z } = end.sub(begin.applyMatrix4(way));
    way.setPosition(x, 0, z);
    const { camera, controls } = this.viewer;
    for (const node of [camera.position, controls.target]) node.applyMatrix4(way);
    this.floor.goWith(way, turn);
  }

  /**
   * Draw a frame: as fast as necessary during a movement, and in the best quality at rest. The first ones are plain, because
   * the environment map takes longer than everything else.
   */
  draw() {
    const { viewer, quality } = this;
    const { camera, controls, scene } = viewer;
    controls.update();
    camera.updateProjectionMatrix();
    camera.updateWorldMatrix(true, false);
    if (!this.isPrepared && !this.alwaysFine && this.plain < PLAIN) return this.drawPlain();
    if (!this.isPrepared) this.prepare();
    const now = performance.now();
    this.done(now);
    const changed = this.cameraMoved() || this.robotMoved;
    if (this.robotMoved) this.shadowsOld += 1;
    this.robotMoved = false;
    const level = this.alwaysFine ? LEVELS[0] : quality.next(now, changed);
    // This is the picture at rest, for which `resting` waits.
    if (!quality.moving) clearTimeout(this.resting);
    const fine = level.fine || this.robots.length === 0;
    const texels = this.alwaysFine ? 4096 : fine ? 2048 : 1024;
    if (this.shadowsOld >= level.shadows || texels !== this.key.shadow.mapSize.x) this.castShadows(texels);
    this.setRatio(level.ratio * this.ratio);
    this.floor.plane.material = fine ? this.floor.fine : this.floor.fast;
    const { shapes } = this;
    if (this.eyes?.filling) viewer.renderer.clear();
    else if (fine) this.smoothing.draw(scene, camera);
    else this.fastLook.draw(shapes, camera);
    this.eyes?.draw((eye) => (fine ? viewer.renderer.render(scene, eye) : this.fastLook.draw(shapes, eye)));
    if (!changed || this.alwaysFine) return;
    this.began = now;
    this.awaitNext();
  }

  drawPlain() {
    this.plain += 1;
    this.setRatio(this.ratio);
    // The floor shows shadows.
    this.floor.node.visible = false;
    this.fastLook.drawPlain(this.shapes, this.viewer.camera);
    this.floor.node.visible = true;
    this.viewer.set_dirty();
  }

  awaitNext() {
    if (!this.isAwaiting) {
      requestAnimationFrame((now) => {
        this.isAwaiting = false;
        this.done(now);
        // If a frame has been drawn since this one was requested, the next request tells its time.
        if (this.began !== null) this.awaitNext();
      });
    }
    this.isAwaiting = true;
  }

  /** The browser is ready for the next frame, which gives the time that the last one took. */
  done(now: number) {
    if (this.began === null || now < this.began) return;
    this.quality.took(now, now - this.began);
    this.began = null;
    clearTimeout(this.resting);
    if (this.quality.moving) this.resting = window.setTimeout(() => this.viewer.set_dirty(), REST + 10);
  }

  cameraMoved() {
    const { camera } = this.viewer;
    let moved = false;
    for (const [offset, { elements }] of [
      [0, camera.matrixWorld],
      [16, camera.projectionMatrix],
    ] as [number, THREE.Matrix4][]) {
      for (let i = 0; i < 16; i++) {
        // Each update of the controls turns the camera by rounding errors.
        moved ||= Math.abs(this.seen[offset + i] - elements[i]) > ROUNDING;
        this.seen[offset + i] = elements[i];
      }
    }
    return moved;
  }

  /** @param ratio pixels of the picture per pixel of the page */
  setRatio(ratio: number) {
    const { renderer } = this.viewer;
    if (renderer.getPixelRatio() !== ratio) renderer.setPixelRatio(ratio);
  }

  // Draw the shadow of the key light, whose map is fitted to the robots, so that all of its pixels are used.
  castShadows(texels: number) {
    if (this.robots.length === 0) return;
    this.shadowsOld = 0;
    const { key, sphere, viewer } = this;
    this.robots[0].sphere(sphere);
    const { x: x0, z: z0 } = sphere.center;
    const places = new THREE.Box2(new THREE.Vector2(), new THREE.Vector2());
    for (const robot of this.robots.slice(1)) {
      sphere.union(robot.sphere(this.part));
      const { x, z } = this.part.center;
      places.expandByPoint(new THREE.Vector2(x - x0, z0 - z));
    }
    if (this.robots.length > 1 || this.floor.uniforms.spread.value > 0) this.floor.cover(places);
    const { center } = sphere;
    // The radius changes in steps, so that the shadow on a resting limb does not flicker while another limb moves.
    const radius = 1.1 ** Math.ceil(Math.log(sphere.radius) / Math.log(1.1));
    this.contact.draw(viewer.scene, center, radius);
    // The lights are in the scene, which has z up.
    const [x, y, z] = [center.x, -center.z, center.y];
    key.target.position.set(x, y, z);
    key.position
      .copy(KEY)
      .multiplyScalar(2 * radius)
      .add(key.target.position);
    const { camera, mapSize } = key.shadow;
    if (mapSize.x !== texels) {
      mapSize.set(texels, texels);
      (key.shadow.map as THREE.WebGLRenderTarget | null)?.dispose();
      key.shadow.map = null as any;
    }
    Object.assign(camera, { left: -radius, right: radius, top: radius, bottom: -radius });
    Object.assign(camera, { near: 0.9 * radius, far: 3.1 * radius + 3 * Math.max(0, z) });
    camera.updateProjectionMatrix();
    // The size of three texels [m], for surfaces at a slant to the light.
    key.shadow.normalBias = 3 * (radius / mapSize.x);
    key.shadow.bias = -0.0001;
    viewer.renderer.shadowMap.needsUpdate = true;
  }

  /** Make the robot transparent, so that the joint axes inside are visible. */
  seeThrough(on: boolean) {
    this.axesShown = on;
    this.setOpacity(this.opacity);
  }

  /** @param share factor on the shapes' own opacity */
  setOpacity(share: number) {
    this.opacity = share;
    const least = this.axesShown ? Math.min(share, SEEN_THROUGH) : share;
    for (const { mesh } of this.robots[0]?.meshes ?? []) {
      const opacity = least * mesh.userData.opacity;
      const side = opacity < mesh.userData.opacity ? THREE.FrontSide : mesh.userData.side;
      const transparent = opacity < 1;
      if (mesh.material.transparent !== transparent || mesh.material.side !== side) mesh.material.needsUpdate = true;
      Object.assign(mesh.material, { opacity, side, transparent });
    }
    this.viewer.set_dirty();
  }

  /**
   * Look from one of the presets.
   *
   * @param bar share of the picture's height that a bar covers
   */
  look(preset: Camera | undefined, robots: { box(links: number[]): THREE.Box3 }, bar: number = 0) {
    if (!preset) return;
    lookAt(this.viewer, preset, robots.box(preset.links), this.size, bar);
    this.viewer.set_dirty();
  }
}

export function resize(viewer: MeshcatViewer, width: number, height: number) {
  // In a hidden iframe the picture has no size yet, but the camera needs a valid aspect ratio.
  viewer.camera.aspect = width > 0 && height > 0 ? width / height : 1;
  viewer.camera.updateProjectionMatrix();
  viewer.renderer.setSize(width, height);
  viewer.set_dirty();
}
