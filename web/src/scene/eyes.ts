import { element } from "../panel/element.ts";
import type { Robot } from "../robot/robot.ts";
import { THREE } from "../three.ts";
import type { Eye, MeshcatViewer } from "../types.ts";
import { asMark } from "./marks.ts";
import type { Studio } from "./studio.ts";

/** The parts of the page that are used here. */
interface Page {
  readonly eyes: Eyes;
  readonly pane: HTMLElement;
  readonly robot: Robot;
  readonly viewer: MeshcatViewer;
}

// A field of view that nobody has told [rad], and how far the drawn frustum reaches, as a share of the robot's size.
const USUAL = { horizontal: 1.0, vertical: 0.8 };
const REACH = 0.3;
const [NEAR, FAR] = [0.025, 60];
// Where the football lies, as shares of the height of the camera: NAO's upper camera sees all of it, the lower one its lower
// half, and it has the size of a ball of the RoboCup Standard Platform League.
const [AHEAD, RADIUS] = [2.1, 0.1];

/** The frame in the page around what a camera sees. */
interface Sight {
  box: HTMLElement;
  picture: HTMLElement;
  select: HTMLSelectElement;
  field: HTMLElement;
  pane: HTMLElement;
}

export function makeSight(page: Page): Sight {
  const select = document.createElement("select");
  select.ariaLabel = "Camera of the robot";
  select.append(...page.robot.about.eyes.map(({ name }) => new Option(name, name)));
  select.onchange = () => {
    page.eyes.show(select.value);
    page.viewer.set_dirty();
  };
  const picture = element("div", { className: "sight" });
  const field = element("span", { title: "Horizontal and vertical field of view" });
  const caption = element("div", { className: "caption" }, select as Node, field);
  const box = element("div", { id: "eye", hidden: true }, picture, caption);
  page.pane.after(box);
  return { box, picture, select, field, pane: page.pane };
}

/** A football of radius 1: black where a regular icosahedron has its corners. */
function makeFootball() {
  const geometry = new THREE.SphereGeometry(1, 64, 48);
  const golden = (1 + Math.sqrt(5)) / 2;
  const corners = [-1, 1].flatMap((a) =>
    [-golden, golden].flatMap((b) => [
      [0, a, b],
      [a, b, 0],
      [b, 0, a],
    ]),
  );
  const { position } = geometry.attributes;
  const colours = Array.from({ length: position.count }, (_, i) => {
    const at = [position.getX(i), position.getY(i), position.getZ(i)];
    const near = Math.max(...corners.map((corner) => corner.reduce((sum, x, k) => sum + x * at[k], 0)));
    return Array(3).fill(near > 0.93 * Math.hypot(1, golden) ? 0.02 : 0.9);
  });
  geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours.flat(), 3));
  const ball = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ vertexColors: true, roughness: 0.5 }));
  const shade = new THREE.MeshBasicMaterial({ color: 0, transparent: true, opacity: 0.3, depthWrite: false });
  const shadow = new THREE.Mesh(new THREE.CircleGeometry(0.8, 32), shade);
  shadow.position.z = -0.98;
  ball.add(shadow);
  ball.visible = false;
  return ball;
}

/** What the robot's own cameras see, drawn into a corner of the picture, and their frustum in the scene. */
export class Eyes {
  camera = new THREE.PerspectiveCamera();
  shape = new THREE.PerspectiveCamera();
  sky = new THREE.Color();
  cleared = new THREE.Color();
  eye: Eye | null = null;
  ball = makeFootball();
  helper?: THREE.CameraHelper;

  /** @param sight where in the page the picture goes */
  constructor(
    readonly robot: Robot,
    readonly studio: Studio,
    public sight: Sight,
  ) {
    // It looks along −z with y up, the robot's camera along x with z up.
    this.camera.quaternion.setFromRotationMatrix(
      new THREE.Matrix4().makeBasis(
        new THREE.Vector3(0, -1, 0),
        new THREE.Vector3(0, 0, 1),
        new THREE.Vector3(-1, 0, 0),
      ),
    );
    this.camera.add(asMark(this.shape));
    asMark(this.camera);
    studio.viewer.scene.add(this.ball);
  }

  get eyes() {
    return this.robot.about.eyes;
  }

  /**
   * Look through a camera of the robot.
   *
   * @param name null for none
   */
  show(name: string | null) {
    this.eye = this.eyes.find((eye) => eye.name === name) ?? null;
    this.sight.box.hidden = !this.eye;
    this.camera.removeFromParent();
    if (this.helper) {
      this.helper.removeFromParent();
      this.helper.geometry.dispose();
      (this.helper.material as THREE.Material).dispose();
      this.helper = undefined;
    }
    const hadBall = this.ball.visible;
    this.ball.visible = this.eye !== null && this.studio.robots.length === 1;
    if (!this.eye) return;
    const { link, horizontal, vertical } = this.eye;
    const [h, v] = [horizontal ?? USUAL.horizontal, vertical ?? USUAL.vertical];
    const { size } = this.studio;
    for (const [camera, near, far] of [
      [this.camera, NEAR * Math.min(size, 1), FAR * size],
      [this.shape, 0.03 * size, REACH * size],
    ] as [THREE.PerspectiveCamera, number, number][]) {
      Object.assign(camera, { fov: THREE.MathUtils.radToDeg(v), aspect: Math.tan(h / 2) / Math.tan(v / 2), near, far });
      camera.updateProjectionMatrix();
    }
    this.sight.picture.style.setProperty("--aspect", String(this.camera.aspect));
    this.sight.select.value = this.eye.name;
    this.sight.field.textContent = this.field;
    this.robot.nodes[link].add(this.camera);
    this.helper = asMark(new THREE.CameraHelper(this.shape));
    // Under its camera its own matrix has nothing to add.
    this.helper.matrix = new THREE.Matrix4();
    this.shape.add(this.helper);
    this.camera.updateWorldMatrix(true, true);
    if (!hadBall) this.kickOff();
  }

  /** Put the football before the robot. */
  kickOff() {
    const height = Math.max(this.camera.getWorldPosition(new THREE.Vector3()).y, 0.2 * this.studio.size);
    const [x, y] = this.studio.place;
    this.ball.scale.setScalar(RADIUS * height);
    this.ball.position.set(x + AHEAD * height, y, RADIUS * height);
    this.ball.updateMatrixWorld();
  }

  /** The field of view as people write it, or "" where it is not known. */
  get field() {
    if (!this.eye?.horizontal || !this.eye.vertical) return "";
    const degrees = (angle: number) => `${THREE.MathUtils.radToDeg(angle).toFixed(1)}°`;
    return `${degrees(this.eye.horizontal)} × ${degrees(this.eye.vertical)}`;
  }

  /** Draw what it sees over the picture. */
  draw(draw: (camera: THREE.Camera) => void) {
    if (!this.eye || !this.helper) return;
    const { renderer } = this.studio.viewer;
    const pane = renderer.domElement.getBoundingClientRect();
    const frame = this.sight.picture.getBoundingClientRect();
    if (frame.width === 0 || pane.width === 0) return;
    // A picture for a file may be larger than the page.
    const size = renderer.getSize(new THREE.Vector2());
    const scale = size.x / this.sight.pane.clientWidth;
    const [x, y] = [scale * (frame.left - pane.left), size.y - scale * (frame.bottom - pane.top)];
    const [width, height] = [scale * frame.width, scale * frame.height];
    const alpha = renderer.getClearAlpha();
    const { floor } = this.studio;
    renderer.getClearColor(this.cleared);
    renderer.setClearColor(this.sky.copy(floor.uniforms.haze.value).convertLinearToSRGB(), 1);
    renderer.setViewport(x, y, width, height);
    renderer.setScissor(x, y, width, height);
    renderer.setScissorTest(true);
    const marks = this.hideMarks();
    floor.ground.visible = true;
    draw(this.camera);
    floor.ground.visible = false;
    for (const mark of marks) mark.visible = true;
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, size.x, size.y);
    renderer.setClearColor(this.cleared, alpha);
  }

  /** A camera does not see what is drawn over the robot. */
  hideMarks() {
    const marks: THREE.Object3D[] = [];
    this.studio.viewer.scene.traverseVisible((node) => {
      if (node.userData.mark && node !== this.camera) marks.push(node);
    });
    for (const mark of marks) mark.visible = false;
    return marks;
  }
}
