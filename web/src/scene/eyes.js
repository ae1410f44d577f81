import { element } from "../panel/element.js";
import { asMark } from "./marking.js";
import { THREE } from "../three.js";

/** @typedef {import("../types.js").Eye} Eye */

// A field of view that nobody has told [rad], and how far the drawn frustum reaches, as a share of the robot's size.
const USUAL = { horizontal: 1.0, vertical: 0.8 };
const REACH = 0.3;
const [NEAR, FAR] = [0.025, 60];

/**
 * The frame in the page around what a camera sees.
 *
 * @typedef {{ box: HTMLElement, picture: HTMLElement, select: HTMLSelectElement, field: HTMLElement, pane: HTMLElement }} Sight
 */

/**
 * @param {import("../app.js").App} app
 * @returns {Sight}
 */
export function makeSight(app) {
  const select = document.createElement("select");
  select.ariaLabel = "Camera of the robot";
  select.append(...app.robot.about.eyes.map(({ name }) => new Option(name, name)));
  select.onchange = () => {
    app.eyes.show(select.value);
    app.viewer.set_dirty();
  };
  const picture = element("div", { className: "sight" });
  const field = element("span", { title: "Horizontal and vertical field of view" });
  const caption = element("div", { className: "caption" }, /** @type {Node} */ (select), field);
  const box = element("div", { id: "eye", hidden: true }, picture, caption);
  app.pane.after(box);
  return { box, picture, select, field, pane: app.pane };
}

/** What the robot's own cameras see, drawn into a corner of the picture, and their frustum in the scene. */
export class Eyes {
  /**
   * @param {import("../robot/robot.js").Robot} robot
   * @param {import("./studio.js").Studio} studio
   * @param {Sight} sight where in the page the picture goes
   */
  constructor(robot, studio, sight) {
    this.robot = robot;
    this.studio = studio;
    this.sight = sight;
    this.camera = new THREE.PerspectiveCamera();
    // It looks along −z with y up, the robot's camera along x with z up.
    this.camera.quaternion.setFromRotationMatrix(
      new THREE.Matrix4().makeBasis(
        new THREE.Vector3(0, -1, 0),
        new THREE.Vector3(0, 0, 1),
        new THREE.Vector3(-1, 0, 0),
      ),
    );
    this.shape = new THREE.PerspectiveCamera();
    this.camera.add(asMark(this.shape));
    asMark(this.camera);
    this.sky = new THREE.Color();
    this.cleared = new THREE.Color();
    /** @type {Eye | null} */
    this.eye = null;
  }

  get eyes() {
    return this.robot.about.eyes;
  }

  /**
   * Look through a camera of the robot.
   *
   * @param {string | null} name null for none
   */
  show(name) {
    this.eye = this.eyes.find((eye) => eye.name === name) ?? null;
    this.sight.box.hidden = !this.eye;
    this.camera.removeFromParent();
    if (this.helper) {
      this.helper.removeFromParent();
      this.helper.geometry.dispose();
      /** @type {THREE.Material} */ (this.helper.material).dispose();
      this.helper = undefined;
    }
    if (!this.eye) return;
    const { link, horizontal, vertical } = this.eye;
    const [h, v] = [horizontal ?? USUAL.horizontal, vertical ?? USUAL.vertical];
    const { size } = this.studio;
    for (const [camera, near, far] of /** @type {[THREE.PerspectiveCamera, number, number][]} */ ([
      [this.camera, NEAR * Math.min(size, 1), FAR * size],
      [this.shape, 0.03 * size, REACH * size],
    ])) {
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
    const degrees = (/** @type {number} */ angle) => `${THREE.MathUtils.radToDeg(angle).toFixed(1)}°`;
    return `${degrees(this.eye.horizontal)} × ${degrees(this.eye.vertical)}`;
  }

  /**
   * Draw what it sees over the picture.
   *
   * @param {(camera: THREE.Camera) => void} draw
   */
  draw(draw) {
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
    /** @type {THREE.Object3D[]} */
    const marks = [];
    this.studio.viewer.scene.traverseVisible((node) => {
      if (node.userData.mark && node !== this.camera) marks.push(node);
    });
    for (const mark of marks) mark.visible = false;
    return marks;
  }
}
