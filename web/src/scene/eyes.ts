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

/** What the robot's own cameras see, drawn into a corner of the picture, and their frustum in the scene. */
export class Eyes {
  camera = new THREE.PerspectiveCamera();
  shape = new THREE.PerspectiveCamera();
  sky = new THREE.Color();
  cleared = new THREE.Color();
  eye: Eye | null = null;
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
    renderer.getClearColor(this.cleared);
    renderer.setClearColor(this.sky.set(0xe9edf3), 1);
    renderer.setViewport(x, y, width, height);
    renderer.setScissor(x, y, width, height);
    renderer.setScissorTest(true);
    const marks = this.hideMarks();
    draw(this.camera);
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
