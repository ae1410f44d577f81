import { convexHull, inside } from "../math/surfaces.ts";
import { THREE } from "../three.ts";
import type { About } from "../types.ts";
import { depth, directions, extremes, nearestPosture, settled, touching } from "./settling.ts";
import { between } from "./nodes.ts";
import type { Robot } from "./robot.ts";

interface Pose {
  q: number[];
  posture: number;
  rests: boolean;
  up: number[];
}

// How far [m] the soles may be above the robot's lowest point if it stands on both, and on one.
const [BOTH, ONE] = [0.008, 0.003];
// How far above the floor something may be and still carry the robot [m].
const CARRYING = 0.005;
// Two configurations are steps of one movement if no joint differs by more than this [rad, m].
const STEP = 0.5;
// Enough directions to find the points of a rounded link that can touch the floor, to a small part of a millimetre.
const TOWARDS = directions(800);
const VERTICAL = new THREE.Vector3(0, 0, 1);
const TRUNK_UPRIGHT = [0, 0, 1];

/**
 * Places a robot with a fixed base on the floor.
 *
 * The robot stands on both soles or on one if they are below everything else and its centre of mass is above the area that
 * touches the floor. Otherwise the nearest posture decides. If that posture lies or sits, the robot is put down with the
 * posture's vertical and rolls until it is at rest. If it stands, the robot stands too, although it would fall: on the sole
 * that is below everything else, or with the trunk upright.
 *
 * During a movement in small steps, a robot that lies or sits continues from its present vertical, until another posture is
 * clearly nearer.
 */
export class Standing {
  /** The last placement. */
  last: Pose | null = null;
  constructor(readonly robot: Robot) {}

  /** Let the next placement ignore the ones before. */
  forget() {
    this.last = null;
  }

  /**
   * Place the robot on the floor in the configuration of its nodes.
   *
   * @param up the vertical in the root's frame; null to find it from the configuration
   */
  place(q: number[], up: ArrayLike<number> | null) {
    const { root } = this.robot;
    if (up) this.forget();
    const [x, y, z] = Array.from(up ?? this.direction(q));
    root.quaternion.setFromUnitVectors(new THREE.Vector3(x, y, z).normalize(), VERTICAL);
    root.position.set(0, 0, 0);
    root.updateWorldMatrix(true, true);
    root.position.z = -this.robot.lowest();
    root.updateWorldMatrix(true, true);
  }

  direction(q: number[]): ArrayLike<number> {
    const { postures } = this.robot.about;
    const centre = this.robot.com()?.toArray() ?? null;
    const points = this.points();
    const onSoles = this.onSoles(points)?.toArray() ?? null;
    if (!centre || points.length === 0 || postures.every(({ up }) => !up)) return onSoles ?? TRUNK_UPRIGHT;
    const before = this.last?.q.every((value, i) => Math.abs(value - q[i]) < STEP) ? this.last : null;
    const posture = nearestPosture(q, postures, before?.posture ?? null);
    const { up } = postures[posture];
    const rests = up !== null && (before?.rests || !onSoles || !isBalanced(points, centre, onSoles));
    const begin = before?.rests && before.posture === posture ? before.up : up;
    const found = rests && begin ? settled(points, centre, begin) : (onSoles ?? TRUNK_UPRIGHT);
    this.last = { q: [...q], posture, rests, up: found };
    return found;
  }

  /**
   * The vertical with which the robot stands on both soles, or on the one sole that tilts the trunk least; null if no sole
   * is below everything else.
   */
  onSoles(points: Float64Array) {
    const soles = this.robot.about.soles.map((link) => {
      const pose = this.robot.pose(link);
      return {
        at: new THREE.Vector3().setFromMatrixPosition(pose),
        up: new THREE.Vector3().setFromMatrixColumn(pose, 2),
      };
    });
    const standingOn: (feet: typeof soles, slack: number) => THREE.Vector3 | null = (feet, slack) => {
      const down = feet.reduce((sum, foot) => sum.sub(foot.up), new THREE.Vector3()).normalize();
      const lowest = depth(points, down.toArray()) - slack;
      return feet.every(({ at }) => at.dot(down) > lowest) ? down.negate() : null;
    };
    const both = soles.length > 1 ? standingOn(soles, BOTH) : null;
    if (both) return both;
    const ways = soles.flatMap((sole) => standingOn([sole], ONE) ?? []);
    return ways.sort((a, b) => b.z - a.z)[0] ?? null;
  }

  /** The points that can touch the floor, in the root's frame. */
  points() {
    const outlines = outlinesOf(this.robot);
    const points = new Float64Array(outlines.reduce((sum, { points: { length } }) => sum + length, 0));
    const fromWorld = this.robot.toRoot();
    const pose = new THREE.Matrix4();
    let k = 0;
    for (const { link, points: own } of outlines) {
      const m = pose.multiplyMatrices(fromWorld, this.robot.nodes[link].matrixWorld).elements;
      for (let i = 0; i < own.length; i += 3) {
        const [x, y, z] = [own[i], own[i + 1], own[i + 2]];
        points[k++] = m[0] * x + m[4] * y + m[8] * z + m[12];
        points[k++] = m[1] * x + m[5] * y + m[9] * z + m[13];
        points[k++] = m[2] * x + m[6] * y + m[10] * z + m[14];
      }
    }
    return points;
  }
}

/** Whether the centre of mass is above the area that the robot stands on. */
function isBalanced(points: Float64Array, centre: number[], up: number[]) {
  const down = up.map((value) => -value);
  const hull = convexHull(touching(points, depth(points, down) - CARRYING, down, centre));
  return hull.length > 2 && inside(hull, { x: 0, y: 0 });
}

type Outline = { link: number; points: Float64Array };
/** The outlines by description, which equal robots share. */
const OUTLINES: WeakMap<About, Outline[]> = new WeakMap();

/** The points of each link that can touch the floor, in the frame of the link. */
function outlinesOf(robot: Robot): Outline[] {
  const known = OUTLINES.get(robot.about);
  if (known) return known;
  const vertex = new THREE.Vector3();
  const outlines = robot.nodes.map((node, link) => {
    const vertices: number[] = [];
    for (const { mesh } of robot.meshes.filter((shape) => shape.link === link)) {
      const T_link_mesh = between(mesh, node);
      const { position } = mesh.geometry.attributes;
      for (let i = 0; i < position.count; i++) {
        const { x, y, z } = vertex.fromBufferAttribute(position, i).applyMatrix4(T_link_mesh);
        vertices.push(x, y, z);
      }
    }
    return { link, points: extremes(Float64Array.from(vertices), TOWARDS) };
  });
  OUTLINES.set(robot.about, outlines);
  return outlines;
}
