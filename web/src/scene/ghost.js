import { Skeleton } from "../robot/skeleton.js";
import { THREE } from "../three.js";

/** A pale copy of the whole robot in another configuration. */
export class Ghost {
  /**
   * @param {import("../robot/robot.js").Robot} robot
   * @param {THREE.Scene} scene
   */
  constructor(robot, scene) {
    this.robot = robot;
    this.scene = scene;
    /** @type {Skeleton | null} */
    this.skeleton = null;
  }

  /** @param {number[] | null} q null takes it away */
  show(q) {
    this.skeleton?.root.removeFromParent();
    this.skeleton = null;
    if (!q) return;
    const root = this.robot.root.clone(true);
    /** @type {THREE.Object3D[]} */
    const marks = [];
    root.traverse((node) => node.userData.mark && marks.push(node));
    marks.forEach((mark) => mark.removeFromParent());
    const veil = new THREE.MeshPhongMaterial({ color: 0x3f7fd9, transparent: true, opacity: 0.22, depthWrite: false });
    root.traverse((node) => {
      if (node instanceof THREE.Mesh) Object.assign(node, { material: veil, castShadow: false, receiveShadow: false });
      node.layers.set(0);
    });
    this.scene.add(root);
    this.skeleton = new Skeleton(root, this.robot.about);
    this.skeleton.apply(q);
  }

  /** Put it where the robot stands. */
  follow() {
    if (!this.skeleton) return;
    this.skeleton.root.position.copy(this.robot.root.position);
    this.skeleton.root.quaternion.copy(this.robot.root.quaternion);
  }
}
