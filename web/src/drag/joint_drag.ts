import type { App } from "../app.ts";
import { joints, unitText } from "../pick/facts.ts";
import type { Robot } from "../robot/robot.ts";
import { THREE } from "../three.ts";
import type { Gesture, Hold } from "./gestures.ts";
import { farthest, type Stop } from "./stops.ts";
import { Swept } from "./swept_angle.ts";

/**
 * How a link moves with the coordinate of the joint that carries it: about a line in the world or along a direction, with
 * the rate per unit of the coordinate. Null for a link that no coordinate moves.
 *
 * If several joints that carry the link follow the same coordinate, as in a finger, their motions add up. With the screw
 * ω = Σ mᵢ aᵢ, v = Σ mᵢ aᵢ × (p − oᵢ) at a point p, the axis passes through p + ω × v / ω².
 *
 * @param point on the link, in the world
 */
export function motionOf(robot: Robot, link: number, point: THREE.Vector3) {
  const carriers = joints(robot.about, link);
  const joint = carriers.at(-1);
  if (!joint) return null;
  const omega = new THREE.Vector3();
  const velocity = new THREE.Vector3();
  for (const { link: moved, column, multiplier, axis, slides } of carriers) {
    if (column !== joint.column) continue;
    const node = robot.nodes[moved];
    const direction = new THREE.Vector3()
      .fromArray(axis)
      .transformDirection(node.matrixWorld)
      .multiplyScalar(multiplier);
    if (slides) velocity.add(direction);
    else {
      omega.add(direction);
      velocity.add(direction.clone().cross(point.clone().sub(node.getWorldPosition(new THREE.Vector3()))));
    }
  }
  const rate = omega.length();
  if (rate > 1e-9) {
    const origin = omega
      .clone()
      .cross(velocity)
      .divideScalar(rate * rate)
      .add(point);
    return { joint, slides: false, rate, origin, direction: omega.divideScalar(rate) };
  }
  const speed = velocity.length();
  return speed > 1e-9
    ? { joint, slides: true, rate: speed, origin: point, direction: velocity.divideScalar(speed) }
    : null;
}

/** Drag of a link: the joint that carries it follows the pointer inside its limits; the rest of the robot stays. */
export class JointDrag implements Gesture {
  /** The value that the pointer asks for, which may be outside the limits. */
  wanted = this.page.stance.q[this.motion.joint.column];
  swept: Swept;

  constructor(
    readonly page: App,
    readonly motion: NonNullable<ReturnType<typeof motionOf>>,
    hold: Hold,
  ) {
    const { robot, stance, pick } = page;
    const { column } = motion.joint;
    this.swept = new Swept(pick.viewport, motion.origin, motion.direction, hold);
    const [most, fewest] = [Infinity, -Infinity].map((end) => farthest(robot.about, stance.q, column, end).value);
    this.swept.angle.prefer(most - this.wanted < this.wanted - fewest ? -1 : 1);
  }

  move(ray: THREE.Ray) {
    const { page, motion, swept } = this;
    const { column } = motion.joint;
    this.wanted += (motion.slides ? swept.along(ray) : swept.about(ray)) / motion.rate;
    const { value, stop } = farthest(page.robot.about, page.stance.q, column, this.wanted);
    page.stance.move(column, value);
    page.stance.settle();
    return stop ? this.sentence(stop) : "";
  }

  end() {}

  sentence({ column, bound, upper, coupled }: Stop) {
    const { coordinates } = this.page.robot.about;
    const nameOf = (wanted: number) => coordinates.find((candidate) => candidate.column === wanted);
    const [own, other] = [nameOf(this.motion.joint.column), nameOf(column)];
    const limit = `${upper ? "at most" : "at least"} ${unitText(bound, other?.unit ?? "rad", this.page.panel.settings.units)}`;
    if (own !== other) return `${own?.joint} stops: ${other?.joint} may be ${limit} there (coupled limit)`;
    return `${own?.joint} stops: ${limit}${coupled ? " here (coupled limit)" : ""}`;
  }
}
