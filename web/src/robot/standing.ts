import { direction, dot, times, type Vector } from "../math/rotations.ts";
import { convexHull, inside } from "../math/surfaces.ts";
import { isStanding } from "../ik/limbs.ts";
import { THREE } from "../three.ts";
import type { About } from "../types.ts";
import { depth, directions, extremes, nearestPosture, rolled, settled, TOUCHING } from "./settling.ts";
import { between } from "./nodes.ts";
import type { Robot } from "./robot.ts";

interface Down {
  /** The vertical in the root's frame. */
  up: Vector;
  /** The links of the feet that are flat on the floor. */
  feet: Set<number>;
}

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
// The cosine of the largest angle of a sole that is flat on the floor.
const FLAT_FOOT = Math.cos(Math.PI / 180);
// Two configurations are steps of one movement if no joint differs by more than this [rad, m].
const STEP = 0.5;
// Enough directions to find the points of a rounded link that can touch the floor, to a small part of a millimetre.
const TOWARDS = directions(800);
const VERTICAL = new THREE.Vector3(0, 0, 1);
const TRUNK_UPRIGHT: Down = { up: [0, 0, 1], feet: new Set() };

/**
 * Places a robot with a fixed base on the floor.
 *
 * A robot without feet keeps its base: the floor is in the origin of its root, or under its base if that is lower.
 *
 * Another robot stands on its soles if they are below everything else and it comes to rest on them within a small angle.
 * Otherwise the nearest posture decides. If that posture lies or sits, the robot is put down with the posture's vertical
 * and rolls until it is at rest. If it stands, the robot stands too, although it would fall: level with the soles from
 * which it falls, or, if other links are then below them, with the trunk upright.
 *
 * During a movement in small steps, a robot that lies or sits continues from its present vertical, until another posture is
 * clearly nearer.
 */
export class Standing {
  /** The last placement. */
  last: Pose | null = null;
  /** Whether the robot stands on the floor, and is not fixed to it by its base. */
  stands = isStanding(this.robot.about);

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
    let found = TRUNK_UPRIGHT;
    if (up) found = { up: direction([up[0], up[1], up[2]]), feet: new Set() };
    else if (this.stands) found = this.direction(q);
    root.quaternion.setFromUnitVectors(new THREE.Vector3(...found.up), VERTICAL);
    root.position.set(0, 0, 0);
    root.updateWorldMatrix(true, true);
    // Of the feet that the robot stands on, the planes of the soles are on the floor, whatever the shapes.
    const others = this.robot.meshes.filter(({ link }) =>
      this.stands ? !found.feet.has(link) : this.robot.isBase(link),
    );
    const heights = this.stands ? this.robot.corners().flatMap((corners) => corners.map(({ z }) => z)) : [0];
    if (others.length > 0) heights.push(this.robot.lowest(others));
    root.position.z = heights.length > 0 ? -Math.min(...heights) : 0;
    root.updateWorldMatrix(true, true);
  }

  direction(q: number[]): Down {
    const { postures } = this.robot.about;
    const centre = this.robot.com()?.toArray() ?? null;
    const placed = this.placed();
    const onSoles = this.onSoles(placed, centre);
    const standing = onSoles ?? TRUNK_UPRIGHT;
    if (!centre || placed.length === 0 || postures.every(({ up }) => !up)) return standing;
    const before = this.last?.q.every((value, i) => Math.abs(value - q[i]) < STEP) ? this.last : null;
    const posture = nearestPosture(q, postures, before?.posture ?? null);
    const { up } = postures[posture];
    const rests = up !== null && (before?.rests || !onSoles?.rests);
    const begin = before?.rests && before.posture === posture ? before.up : up;
    const found = rests && begin ? { up: settled(joined(placed), centre, begin), feet: new Set<number>() } : standing;
    this.last = { q: [...q], posture, rests, up: found.up };
    return found;
  }

  /**
   * How the robot stands on its soles, and whether it rests on them; null if no sole is below everything else. The robot is
   * put down on all soles, or on one, and turns until its centre of mass is above the corners on the floor. A robot that does
   * not come to rest is level with the soles on the floor from which it falls.
   */
  onSoles(placed: Outline[], centre: Vector | null): (Down & { rests: boolean }) | null {
    const soles = this.robot.about.soles.map(({ link, corners }, i) => {
      const pose = this.robot.pose(link);
      const up = new THREE.Vector3().setFromMatrixColumn(pose, 2).toArray();
      const own = Array.from({ length: corners.length / 3 }, (_, k) => new THREE.Vector3(...corners.slice(3 * k)));
      const hull = convexHull(own);
      const above = centre && new THREE.Vector3(...centre).applyMatrix4(pose.clone().invert());
      const most = above && hull.length > 2 && inside(hull, above) ? FROM_OWN : ONTO_OTHER;
      const points = Float64Array.from(own.flatMap((corner) => corner.clone().applyMatrix4(pose).toArray()));
      return { up, most, points, feet: this.robot.feet[i] };
    });
    const corners = joined(soles);
    const middle = centre ?? meanOf(corners);
    const starts = soles.map(({ up, most }) => ({ up, most }));
    const mean = meanOf(starts.flatMap(({ up }) => up));
    if (starts.length > 1 && Math.hypot(...mean) > 1e-9) starts.unshift({ up: direction(mean), most: ONTO_OTHER });
    const ways = starts
      .map(({ up, most }) => rolled(corners, middle, up, most))
      .map((way, i) => ({ ...way, cost: way.away > 0 ? 10 + way.away : i === 0 ? -2 : -way.up[2] }))
      .sort((a, b) => a.cost - b.cost);
    /** The soles that are on the floor with a vertical; null if other links are below them. */
    const standing = (up: Vector) => {
      const down = times(-1, up);
      const lowest = depth(corners, down);
      const used = soles.filter(({ points }) => depth(points, down) >= lowest - 2 * TOUCHING);
      const feet = new Set(used.filter((sole) => dot(sole.up, up) > FLAT_FOOT).flatMap((sole) => sole.feet));
      const isBelow = ({ link, points }: Outline) => !feet.has(link) && depth(points, down) > lowest + BELOW;
      return placed.some(isBelow) ? null : { up, used, feet };
    };
    for (const { up, away } of ways) {
      const found = standing(up);
      if (!found) continue;
      if (away === 0) return { ...found, rests: true };
      const level = standing(direction(meanOf(found.used.flatMap((sole) => sole.up))));
      return level && { ...level, rests: false };
    }
    return null;
  }

  /** The points that can touch the floor, in the root's frame. */
  placed(): Outline[] {
    const fromWorld = this.robot.toRoot();
    const pose = new THREE.Matrix4();
    return outlinesOf(this.robot).map(({ link, points: own }) => {
      const m = pose.multiplyMatrices(fromWorld, this.robot.nodes[link].matrixWorld).elements;
      const points = new Float64Array(own.length);
      for (let i = 0; i < own.length; i += 3) {
        const [x, y, z] = [own[i], own[i + 1], own[i + 2]];
        points[i] = m[0] * x + m[4] * y + m[8] * z + m[12];
        points[i + 1] = m[1] * x + m[5] * y + m[9] * z + m[13];
        points[i + 2] = m[2] * x + m[6] * y + m[10] * z + m[14];
      }
      return { link, points };
    });
  }
}

/** The points of several lists in one. */
function joined(parts: { points: Float64Array }[]) {
  const all = new Float64Array(parts.reduce((sum, { points }) => sum + points.length, 0));
  let k = 0;
  for (const { points } of parts) {
    all.set(points, k);
    k += points.length;
  }
  return all;
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
  const links = [...new Set(robot.meshes.map(({ link }) => link))];
  const outlines = links.map((link) => {
    const node = robot.nodes[link];
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
