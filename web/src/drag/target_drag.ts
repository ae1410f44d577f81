import type { PageWith } from "../app.ts";
import type { Vector } from "../math/rotations.ts";
import type { Viewport } from "../pick/pick.ts";
import { THREE } from "../three.ts";
import type { Gesture, Hold } from "./follow.ts";
import type { Axis } from "./handles.ts";
import { Swept } from "./swept_angle.ts";
import type { Target } from "./targets.ts";

export type Page = PageWith<"pick" | "robot" | "targets">;

/** A target that is held. A page without a program says that nothing follows. */
class TargetGesture {
  before: THREE.Matrix4;
  /** Its place, and the axis that it is held by, in the world. */
  origin: THREE.Vector3;
  direction: THREE.Vector3 | null;
  swept: Swept | null;

  constructor(
    readonly page: Page,
    readonly target: Target,
    axis: Axis | null,
    hold: Hold | null,
  ) {
    const { node } = target;
    page.robot.root.updateWorldMatrix(true, false);
    node.updateWorldMatrix(true, false);
    page.targets.note(target, false);
    this.before = node.matrix.clone();
    this.origin = new THREE.Vector3().setFromMatrixPosition(node.matrixWorld);
    this.direction = axis && new THREE.Vector3(...axis.axis).transformDirection(node.matrixWorld);
    this.swept = this.direction && hold && new Swept(page.pick.viewport, this.origin, this.direction, hold);
  }

  put(matrix: THREE.Matrix4) {
    this.page.targets.move(this.target, matrix);
    return document.body.dataset.live === "live" ? "" : `${this.target.row.name}: no program follows it`;
  }

  end() {}

  cancel() {
    this.put(this.before);
  }
}

/** It follows the pointer in the plane that the camera faces, or along one of its axes. */
export class TargetMove extends TargetGesture implements Gesture {
  pulled: ReturnType<Viewport["pulled"]> | null;
  /** How far it has come along the axis [m]. */
  way = 0;

  constructor(page: Page, target: Target, axis: Axis | null, hold: Hold | null) {
    super(page, target, axis, hold);
    this.pulled = hold && page.pick.viewport.pulled(this.origin, hold.ray);
  }

  /** Where it is, in the robot's root. */
  get place(): Vector {
    return new THREE.Vector3().setFromMatrixPosition(this.target.node.matrix).toArray();
  }

  /** @param options whether it goes up and down only */
  move(ray: THREE.Ray, options: { level: boolean }) {
    const { direction, origin, swept } = this;
    if (!swept || !direction) {
      const to = this.pulled?.(ray, options);
      return to ? this.moveTo(to) : "";
    }
    this.way += swept.along(ray);
    return this.moveTo(origin.clone().addScaledVector(direction, this.way));
  }

  /** Go on from where it is, to the right and up on the screen [m]. */
  step(right: number, up: number) {
    const now = new THREE.Vector3().setFromMatrixPosition(this.target.node.matrixWorld);
    return this.moveTo(this.page.pick.viewport.shift(now, right, up));
  }

  /** @param to in the world */
  moveTo(to: THREE.Vector3) {
    return this.put(this.target.node.matrix.clone().setPosition(this.page.robot.root.worldToLocal(to.clone())));
  }
}

/** It turns about one of its axes. */
export class TargetTurn extends TargetGesture implements Gesture {
  /** How far it has turned [rad]. */
  reached = 0;

  constructor(
    page: Page,
    target: Target,
    readonly axis: Axis,
    hold: Hold | null,
  ) {
    super(page, target, axis, hold);
  }

  move(ray: THREE.Ray) {
    return this.step(this.swept?.about(ray) ?? 0);
  }

  /** @param angle to go on by [rad] */
  step(angle: number) {
    this.reached += angle;
    const turn = new THREE.Matrix4().makeRotationAxis(new THREE.Vector3(...this.axis.axis), this.reached);
    const place = new THREE.Vector3().setFromMatrixPosition(this.target.node.matrix);
    return this.put(this.before.clone().multiply(turn).setPosition(place));
  }
}
