import type { App } from "../app.ts";
import { div, element, select } from "../panel/element.ts";
import type { Robot } from "../robot/robot.ts";
import { THREE } from "../three.ts";
import type { Eye } from "../types.ts";
import type { Received } from "../received.ts";
import { asMark, dispose } from "../robot/nodes.ts";
import { BODY } from "./camera.ts";
import type { Studio } from "./studio.ts";

// The field of view if it is unknown [rad], and the length of the drawn frustum as a share of the robot's size.
const USUAL = { horizontal: 1.0, vertical: 0.8 };
const REACH = 0.3;
const [NEAR, FAR] = [0.025, 60];
/** Turn a camera of three.js, which looks along −z with y up, so that it looks along x with z up, as the robot's do. */
function lookAhead(camera: THREE.PerspectiveCamera) {
  camera.quaternion.setFromRotationMatrix(BODY.clone().transpose());
}

function setField(camera: THREE.PerspectiveCamera, { horizontal, vertical }: Eye, near: number, far: number) {
  const [h, v] = [horizontal ?? USUAL.horizontal, vertical ?? USUAL.vertical];
  Object.assign(camera, { fov: THREE.MathUtils.radToDeg(v), aspect: Math.tan(h / 2) / Math.tan(v / 2), near, far });
  camera.updateProjectionMatrix();
}

/** Make the frame in the page around the camera's picture. */
export function makeSight(page: App) {
  const onchange = () => {
    page.eyes.show(list.value);
    page.viewer.set_dirty();
  };
  const names = page.robot.about.eyes.map(({ name }) => name);
  const list = select("Camera of the robot", names, onchange);
  const picture = element("div", { className: "sight", role: "img" });
  const field = element("span", { title: "Horizontal and vertical field of view" });
  const caption = div("caption", list, field);
  const box = element("div", { id: "eye", hidden: true }, picture, caption);
  page.pane.after(box);
  return { box, picture, select: list, field, pane: page.pane };
}

/** An image of a camera from the program. */
interface Shown {
  texture: THREE.Texture | null;
  /** The newest image, while an older one is decoded. */
  waiting: Blob | null;
  decoding: boolean;
}

/** Decode an image file; null if it is not an image. */
async function decoded(file: Blob) {
  const picture = new Image();
  picture.src = URL.createObjectURL(file);
  try {
    await picture.decode();
    return picture;
  } catch {
    return null;
  } finally {
    URL.revokeObjectURL(picture.src);
  }
}

/**
 * Shows in a corner of the picture what one of the robot's cameras sees, or an image from the program; also draws the
 * frustums of the cameras and the ground in view.
 */
export class Eyes {
  camera = new THREE.PerspectiveCamera();
  sky = new THREE.Color();
  cleared = new THREE.Color();
  eye: Eye | null = null;
  /** The camera whose picture is the whole picture, as in a file. */
  filling: Eye | null = null;
  /** The drawn frustums, each on the link of its camera. */
  frustums: THREE.Object3D[] = [];
  images: Map<string, Shown> = new Map();
  /** The rectangle on which an image is drawn. */
  sheet = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), new THREE.MeshBasicMaterial({ toneMapped: false }));
  flat = new THREE.OrthographicCamera(-1, 1, 1, -1, -1, 1);
  footprint = new Footprint(this.studio.viewer.scene);

  constructor(
    readonly robot: Robot,
    readonly studio: Studio,
    public sight: ReturnType<typeof makeSight>,
  ) {
    lookAhead(this.camera);
    asMark(this.camera);
  }

  get eyes() {
    return this.robot.about.eyes;
  }

  find(name: string | null) {
    return this.eyes.find((eye) => eye.name === name) ?? null;
  }

  /** Look through a camera of the robot; null for none. */
  show(name: string | null) {
    this.eye = this.find(name);
    this.sight.box.hidden = !this.eye;
    this.aim(this.eye);
    this.drawFrustums();
    if (!this.eye) return;
    this.sight.picture.style.setProperty("--aspect", String(this.camera.aspect));
    this.sight.select.value = this.eye.name;
    this.sight.field.textContent = this.field;
  }

  /** Let a camera's picture be the whole picture, until this is called with null. */
  fill(name: string | null) {
    this.filling = this.find(name);
    this.aim(this.filling ?? this.eye);
  }

  /** Put the camera of the scene where a camera of the robot is. */
  aim(eye: Eye | null) {
    this.camera.removeFromParent();
    if (!eye) return;
    setField(this.camera, eye, NEAR * Math.min(this.studio.size, 1), FAR * this.studio.size);
    this.robot.nodes[eye.link].add(this.camera);
    this.camera.updateWorldMatrix(true, true);
  }

  /** Draw the frustums of the camera in use and of all cameras with an image, which is drawn at the frustum's far end. */
  drawFrustums() {
    for (const frustum of this.frustums) {
      for (const part of frustum.children) if (part instanceof THREE.Mesh) part.material.map = null;
      dispose(frustum);
    }
    const { size } = this.studio;
    const drawn = this.eyes.filter((eye) => this.eye && (eye === this.eye || this.images.get(eye.name)?.texture));
    this.frustums = drawn.map((eye) => {
      const shape = asMark(new THREE.PerspectiveCamera());
      lookAhead(shape);
      setField(shape, eye, 0.03 * size, REACH * size);
      const helper = asMark(new THREE.CameraHelper(shape));
      // The helper is a child of its camera, so its own matrix is the identity.
      helper.matrix = new THREE.Matrix4();
      shape.add(helper);
      const map = this.images.get(eye.name)?.texture;
      if (map) {
        const height = 2 * shape.far * Math.tan(THREE.MathUtils.degToRad(shape.fov / 2));
        const image = new THREE.Mesh(
          new THREE.PlaneGeometry(height * shape.aspect, height),
          new THREE.MeshBasicMaterial({ map, side: THREE.DoubleSide, toneMapped: false }),
        );
        image.position.z = -shape.far;
        shape.add(image);
      }
      this.robot.nodes[eye.link].add(shape);
      shape.updateWorldMatrix(true, true);
      return shape;
    });
    this.drawGround();
    const shown = this.eye && this.images.get(this.eye.name)?.texture;
    this.sight.picture.ariaLabel = shown ? "Image from the program" : "What the camera sees";
    this.studio.viewer.set_dirty();
  }

  /** Draw the ground that the camera in use sees. */
  drawGround() {
    if (!this.eye) {
      if (this.footprint.corners.length > 0) this.footprint.draw([]);
      return;
    }
    const pose = this.robot.fromWorld().multiply(this.robot.nodes[this.eye.link].matrixWorld);
    this.footprint.draw(
      groundInView(pose, this.eye.horizontal ?? USUAL.horizontal, this.eye.vertical ?? USUAL.vertical),
    );
  }

  /**
   * Decode an image of a camera and show it. The first image of a camera selects that camera, unless the selected one has an
   * image.
   */
  async setImage({ camera, format, data }: Received["image"]) {
    const known = this.images.get(camera);
    const shown: Shown = known ?? { texture: null, waiting: null, decoding: false };
    if (!known) {
      if (!(this.eye && this.images.has(this.eye.name))) {
        this.sight.select.value = camera;
        if (this.eye) this.show(camera);
      }
      this.images.set(camera, shown);
    }
    shown.waiting = new Blob([data as BlobPart], { type: format });
    if (shown.decoding) return;
    shown.decoding = true;
    while (shown.waiting) {
      const file: Blob = shown.waiting;
      shown.waiting = null;
      const picture = await decoded(file);
      if (!picture || this.images.get(camera) !== shown) continue;
      shown.texture?.dispose();
      shown.texture = new THREE.Texture(picture);
      shown.texture.encoding = THREE.sRGBEncoding;
      shown.texture.needsUpdate = true;
      this.drawFrustums();
    }
    shown.decoding = false;
    this.sight.box.dispatchEvent(new Event("decoded"));
  }

  /** Wait until all images are decoded. */
  async complete() {
    while ([...this.images.values()].some(({ decoding }) => decoding)) {
      await new Promise((done) => this.sight.box.addEventListener("decoded", done, { once: true }));
    }
  }

  /** Remove the images of all cameras but these. */
  keepImages(cameras: string[]) {
    for (const [name, { texture }] of this.images) {
      if (cameras.includes(name)) continue;
      this.images.delete(name);
      texture?.dispose();
    }
    this.drawFrustums();
  }

  /** The field of view as text, or "" if it is unknown. */
  get field() {
    if (!this.eye?.horizontal || !this.eye.vertical) return "";
    const degrees = (angle: number) => `${THREE.MathUtils.radToDeg(angle).toFixed(1)}°`;
    return `${degrees(this.eye.horizontal)} × ${degrees(this.eye.vertical)}`;
  }

  /** Draw the camera's picture over the picture of the scene. */
  draw(draw: (camera: THREE.Camera) => void) {
    const eye = this.filling ?? this.eye;
    if (!eye) return;
    const { renderer } = this.studio.viewer;
    // The renderer's size, not the pane's: a picture for a file may be larger than the page.
    const size = renderer.getSize(new THREE.Vector2());
    const [x, y, width, height] = this.filling ? [0, 0, size.x, size.y] : this.corner(size);
    if (!(width > 0 && width < Infinity)) return;
    if (this.filling) {
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
    }
    const alpha = renderer.getClearAlpha();
    const { floor } = this.studio;
    renderer.getClearColor(this.cleared);
    renderer.setClearColor(this.sky.copy(floor.uniforms.haze.value).convertLinearToSRGB(), 1);
    renderer.setViewport(x, y, width, height);
    renderer.setScissor(x, y, width, height);
    renderer.setScissorTest(true);
    const texture = this.images.get(eye.name)?.texture;
    if (texture) this.drawImage(texture, width / height);
    else {
      const marks = this.hideMarks();
      floor.ground.visible = true;
      draw(this.camera);
      floor.ground.visible = false;
      for (const mark of marks) mark.visible = true;
    }
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, size.x, size.y);
    renderer.setClearColor(this.cleared, alpha);
  }

  /** The rectangle of the camera's picture in a drawing of some size. */
  corner(size: THREE.Vector2) {
    const pane = this.studio.viewer.renderer.domElement.getBoundingClientRect();
    const frame = this.sight.picture.getBoundingClientRect();
    const scale = size.x / this.sight.pane.clientWidth;
    const from = [scale * (frame.left - pane.left), size.y - scale * (frame.bottom - pane.top)];
    return [...from, scale * frame.width, scale * frame.height];
  }

  /** Draw the whole image, with a margin if its aspect ratio differs. */
  drawImage(texture: THREE.Texture, aspect: number) {
    const share = texture.image.width / texture.image.height / aspect;
    this.sheet.scale.set(Math.min(1, share), Math.min(1, 1 / share), 1);
    const { material } = this.sheet;
    if (material.map === null) material.needsUpdate = true;
    material.map = texture;
    const { renderer } = this.studio.viewer;
    renderer.render(this.sheet as any, this.flat);
  }

  /** Hide the marks over the robot, which its camera does not see, as it does points, meshes and lines of a program. */
  hideMarks() {
    const marks: THREE.Object3D[] = [];
    this.studio.viewer.scene.traverseVisible((node) => {
      if (node.userData.mark && !node.userData.isThing && node !== this.camera) marks.push(node);
    });
    for (const mark of marks) mark.visible = false;
    return marks;
  }
}

/** The distance forwards at which ground that reaches the horizon is cut off [m]. */
const HORIZON = 10;
const COLOUR = 0x2f6fd0;

/**
 * The part of the floor that a camera sees: its corners, clockwise in the image from the upper left.
 *
 * @param pose of the camera over the floor: x forwards, y to the left, z upwards
 * @param horizontal angle of view [rad]
 * @param vertical angle of view [rad]
 */
export function groundInView(pose: THREE.Matrix4, horizontal: number, vertical: number): THREE.Vector2[] {
  const eye = new THREE.Vector3().setFromMatrixPosition(pose);
  const [forwards, up] = [0, 2].map((axis) => new THREE.Vector3().setFromMatrixColumn(pose, axis));
  // If a camera looks straight down, the top of its image counts as forwards.
  const level = Math.hypot(forwards.x, forwards.y) > 1e-9 ? forwards : up;
  level.setZ(0).normalize();
  const [y, z] = [Math.tan(horizontal / 2), Math.tan(vertical / 2)];
  const rays = [y, -y, -y, y].map((left, i) => new THREE.Vector3(1, left, i < 2 ? z : -z).transformDirection(pose));
  // Positive for rays that meet the floor within reach, and linear along an edge, which is cut where it is 0.
  const inside = rays.map((ray) => -HORIZON * ray.z - eye.z * ray.dot(level));
  const corners = rays.flatMap((ray, i) => {
    const k = (i + 1) % 4;
    const cut = rays[k].clone().lerp(ray, inside[k] / (inside[k] - inside[i]));
    return [...(inside[i] >= 0 ? [ray] : []), ...(inside[i] >= 0 !== inside[k] >= 0 ? [cut] : [])];
  });
  return eye.z > 0
    ? corners.map((ray) => new THREE.Vector2(eye.x, eye.y).addScaledVector(ray as any, -eye.z / ray.z))
    : [];
}

/** The ground that a camera of the robot sees, drawn on the floor. */
export class Footprint {
  area = new THREE.Mesh(
    new THREE.BufferGeometry(),
    new THREE.MeshBasicMaterial({ color: COLOUR, transparent: true, opacity: 0.12, depthWrite: false }),
  );
  rim = new THREE.LineLoop(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: COLOUR }));
  corners: THREE.Vector2[] = [];

  constructor(scene: THREE.Scene) {
    this.area.renderOrder = 14;
    for (const mark of [this.area, this.rim]) {
      mark.frustumCulled = false;
      scene.add(asMark(mark));
    }
  }

  draw(corners: THREE.Vector2[]) {
    this.corners = corners;
    for (const mark of [this.area, this.rim]) {
      mark.visible = corners.length > 2;
      mark.geometry.dispose();
    }
    if (corners.length < 3) return;
    this.area.geometry = new THREE.ShapeGeometry(new THREE.Shape(corners));
    const outline = corners.map(({ x, y }) => new THREE.Vector3(x, y, 0.0008));
    this.area.position.z = 0.0005;
    this.rim.geometry = new THREE.BufferGeometry().setFromPoints(outline);
  }
}
