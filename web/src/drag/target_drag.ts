import type { PageWith } from "../app.ts";
import type { Vector } from "../math/rotations.ts";
import { THREE } from "../three.ts";
import type { Gesture } from "./follow.ts";
import type { Axis } from "./handles.ts";
import { SweptAngle, sweptDistance, triples } from "./swept_angle.ts";
import type { Target } from "./targets.ts";

type Page = PageWith<"pick" | "robot" | "targets">;

/** Where a pointer took hold of something, in the world. */
interface Pointer {
  point: THREE.Vector3;
  ray: THREE.Ray;
}

// A pointer so near to the axis [px] says no angle.
const NEAR_AXIS = 10;

/** A target that is held. A page without a program says that nothing follows. */
class TargetGesture {
  before: THREE.Matrix4;

  constructor(
    readonly page: Page,
    readonly target: Target,
  ) {
    page.robot.root.updateWorldMatrix(true, false);
    target.node.updateWorldMatrix(true, false);
    this.before = target.node.matrix.clone();
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
  from = new THREE.Vector3();
  plane: THREE.Plane;
  /** Of the axis, in the world. */
  direction: THREE.Vector3 | null;

  constructor(
    page: Page,
    target: Target,
    axis: Axis | null = null,
    readonly pointer: Pointer | null = null,
  ) {
    super(page, target);
    this.from.setFromMatrixPosition(target.node.matrixWorld);
    this.plane = page.pick.viewport.facingPlane(this.from);
    this.direction = axis && new THREE.Vector3(...axis.axis).transformDirection(target.node.matrixWorld);
  }

  /** Where it is, in the robot's root. */
  get place(): Vector {
    return new THREE.Vector3().setFromMatrixPosition(this.target.node.matrix).toArray();
  }

  /** @param options whether it goes up and down only */
  move(ray: THREE.Ray, { level }: { level: boolean }) {
    const { from, pointer, direction, plane } = this;
    if (!pointer) return "";
    if (direction) {
      const way = sweptDistance(direction.toArray(), pointer.point.toArray(), triples(pointer.ray), triples(ray));
      return this.moveTo(from.clone().addScaledVector(direction, way));
    }
    const [start, now] = [pointer.ray, ray].map((one) => one.intersectPlane(plane, new THREE.Vector3()));
    if (!start || !now) return "";
    const by = now.sub(start);
    if (level) by.projectOnVector(this.page.pick.viewport.axes[1]);
    return this.moveTo(from.clone().add(by));
  }

  /**
   * Go on from where it is.
   *
   * @param right on the screen [m]
   */
  step(right: number, up: number) {
    const [x, y] = this.page.pick.viewport.axes;
    const now = new THREE.Vector3().setFromMatrixPosition(this.target.node.matrixWorld);
    return this.moveTo(now.addScaledVector(x, right).addScaledVector(y, up));
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
  seen;
  angle: SweptAngle | null = null;

  constructor(
    page: Page,
    target: Target,
    readonly axis: Axis,
    pointer: Pointer | null = null,
  ) {
    super(page, target);
    this.seen = pointer && triples(pointer.ray);
    if (!pointer || !this.seen) return;
    const { matrixWorld } = target.node;
    const line = {
      origin: new THREE.Vector3().setFromMatrixPosition(matrixWorld).toArray(),
      direction: new THREE.Vector3(...axis.axis).transformDirection(matrixWorld).toArray(),
    };
    const least = NEAR_AXIS * page.pick.viewport.metresPerPixel(pointer.point);
    this.angle = new SweptAngle(line, pointer.point.toArray(), this.seen.origin, least);
  }

  move(ray: THREE.Ray) {
    const now = triples(ray);
    const by = this.angle && this.seen ? this.angle.between(this.seen, now) : 0;
    this.seen = now;
    return this.step(by);
  }

  /** @param angle to go on by [rad] */
  step(angle: number) {
    this.reached += angle;
    const turn = new THREE.Matrix4().makeRotationAxis(new THREE.Vector3(...this.axis.axis), this.reached);
    const { matrix } = this.target.node;
    const place = new THREE.Vector3().setFromMatrixPosition(matrix);
    return this.put(this.before.clone().multiply(turn).setPosition(place));
  }
}
