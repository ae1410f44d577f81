import { direction, times, type Vector } from "../math/rotations.ts";
import { convexHull, inside } from "../math/surfaces.ts";
import { THREE } from "../three.ts";
import type { About } from "../types.ts";
import { depth, directions, extremes, nearestPosture, rolled, settled, TOUCHING } from "./settling.ts";
import { between } from "./nodes.ts";
import type { Robot } from "./robot.ts";

interface Pose {
  q: number[];
  posture: number;
  rests: boolean;
  up: Vector;
}

// The largest angle by which the robot turns until it rests on its soles [rad]: from a sole that its centre of mass is
// above, because another foot is lower, and otherwise onto another foot.
const [FROM_OWN, ONTO_OTHER] = [5, 1.5].map((angle) => (angle * Math.PI) / 180);
// How far other links may be below the soles of a robot that stands on them [m].
const BELOW = 0.001;
// Two configurations are steps of one movement if no joint differs by more than this [rad, m].
const STEP = 0.5;
// Enough directions to find the points of a rounded link that can touch the floor, to a small part of a millimetre.
const TOWARDS = directions(800);
const VERTICAL = new THREE.Vector3(0, 0, 1);
const TRUNK_UPRIGHT: Vector = [0, 0, 1];

/**
 * Places a robot with a fixed base on the floor.
 *
 * The robot stands on its soles if they are below everything else and it comes to rest on them within a small angle.
 * Otherwise the nearest posture decides. If that posture lies or sits, the robot is put down with the posture's vertical
 * and rolls until it is at rest. If it stands, the robot stands too, although it would fall: on the soles from which it
 * falls, or with the trunk upright.
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

  direction(q: number[]): Vector {
    const { postures } = this.robot.about;
    const centre = this.robot.com()?.toArray() ?? null;
    const points = this.points();
    const onSoles = this.onSoles(points, centre);
    const standing = onSoles?.up ?? TRUNK_UPRIGHT;
    if (!centre || points.length === 0 || postures.every(({ up }) => !up)) return standing;
    const before = this.last?.q.every((value, i) => Math.abs(value - q[i]) < STEP) ? this.last : null;
    const posture = nearestPosture(q, postures, before?.posture ?? null);
    const { up } = postures[posture];
    const rests = up !== null && (before?.rests || !onSoles?.rests);
    const begin = before?.rests && before.posture === posture ? before.up : up;
    const found = rests && begin ? settled(points, centre, begin) : standing;
    this.last = { q: [...q], posture, rests, up: found };
    return found;
  }

  /**
   * The vertical with which the robot stands on its soles, and whether it rests on them; null if no sole is below everything
   * else. The robot is put down on all soles, or on one, and turns until its centre of mass is above the corners on the
   * floor. A robot that does not come to rest stands on the soles on the floor from which it falls.
   */
  onSoles(points: Float64Array, centre: Vector | null) {
    const soles = this.robot.about.soles.map(({ link, corners }) => {
      const pose = this.robot.pose(link);
      const up = new THREE.Vector3().setFromMatrixColumn(pose, 2).toArray();
      const own = Array.from({ length: corners.length / 3 }, (_, i) => new THREE.Vector3(...corners.slice(3 * i)));
      const hull = convexHull(own);
      const above = centre && new THREE.Vector3(...centre).applyMatrix4(pose.clone().invert());
      const most = above && hull.length > 2 && inside(hull, above) ? FROM_OWN : ONTO_OTHER;
      return { up, most, corners: own.flatMap((corner) => corner.clone().applyMatrix4(pose).toArray()) };
    });
    const corners = Float64Array.from(soles.flatMap((sole) => sole.corners));
    const middle = centre ?? meanOf(corners);
    const starts = soles.map(({ up, most }) => ({ up, most }));
    const mean = meanOf(starts.flatMap(({ up }) => up));
    if (starts.length > 1 && Math.hypot(...mean) > 1e-9) starts.unshift({ up: direction(mean), most: ONTO_OTHER });
    const ways = starts
      .map(({ up, most }) => rolled(corners, middle, up, most))
      .map((way, i) => ({ ...way, cost: way.away > 0 ? 10 + way.away : i === 0 ? -2 : -way.up[2] }))
      .sort((a, b) => a.cost - b.cost);
    for (const { up, away } of ways) {
      const down = times(-1, up);
      const lowest = depth(corners, down);
      if (depth(points, down) > lowest + BELOW) continue;
      if (away === 0) return { up, rests: true };
      const used = soles.filter((sole) => depth(Float64Array.from(sole.corners), down) >= lowest - 2 * TOUCHING);
      return { up: direction(meanOf(used.flatMap((sole) => sole.up))), rests: false };
    }
    return null;
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

/** The mean of points x, y, z of one after another. */
function meanOf(points: ArrayLike<number>): Vector {
  const sum: Vector = [0, 0, 0];
  for (let i = 0; i < points.length; i++) sum[i % 3] += points[i];
  return times(3 / points.length, sum);
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
