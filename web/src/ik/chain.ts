import { plus, product, rotationAbout, times, turned, type Rotation, type Vector } from "../math/rotations.ts";
import type { About, JointAbout } from "../types.ts";

/** Rotation and position of a frame in another. */
interface Placement {
  R: Rotation;
  p: Vector;
}

/** A joint of a chain in a configuration: its axis and a point on it, in the base. */
interface Screw {
  joint: JointAbout;
  axis: Vector;
  origin: Vector;
}

/** A chain in a configuration: the placement of its last link, and its joints from the base outwards. */
export interface Placed extends Placement {
  screws: Screw[];
}

const IDENTITY: Placement = { R: [1, 0, 0, 0, 1, 0, 0, 0, 1], p: [0, 0, 0] };

const composed = (a: Placement, b: Placement): Placement => ({ R: product(a.R, b.R), p: plus(a.p, turned(a.R, b.p)) });

type Tree = Pick<About, "joints" | "links" | "places">;

/** What is at each node of a tree: a constant placement, or a joint. */
const NODES: WeakMap<Tree, Map<string, { place?: number[]; joint?: JointAbout }>> = new WeakMap();

function nodesOf(about: Tree): Map<string, { place?: number[]; joint?: JointAbout }> {
  const known = NODES.get(about);
  if (known) return known;
  const nodes: ReturnType<typeof nodesOf> = new Map();
  for (const { path, matrix } of about.places) nodes.set(path.join("\n"), { place: matrix });
  for (const joint of about.joints) {
    const key = about.links[joint.link].path.join("\n");
    nodes.set(key, { ...nodes.get(key), joint });
  }
  NODES.set(about, nodes);
  return nodes;
}

/** The last joint that moves the node of a path; undefined if none does. */
export function carrierOf(about: Tree, path: string[]): JointAbout | undefined {
  const nodes = nodesOf(about);
  for (let length = path.length; length > 0; length--) {
    const { joint } = nodes.get(path.slice(0, length).join("\n")) ?? {};
    if (joint) return joint;
  }
  return undefined;
}

/** The joints between the base, which is the first link of the robot, and a point of another link. */
export class Chain {
  joints: JointAbout[];
  /** The constant placement before each joint, and at the end that of the point. */
  before: Placement[];

  /** @param under joints that carry the base */
  constructor(about: Tree, link: number, point: Vector = [0, 0, 0], under: JointAbout[] = []) {
    const { path } = about.links[link];
    const nodes = nodesOf(about);
    this.joints = [...under];
    this.before = under.map(() => IDENTITY);
    let fixed = IDENTITY;
    for (let length = about.links[0].path.length + 1; length <= path.length; length++) {
      const { place, joint } = nodes.get(path.slice(0, length).join("\n")) ?? {};
      if (place) fixed = composed(fixed, placementOf(place));
      if (!joint) continue;
      this.joints.push(joint);
      this.before.push(fixed);
      fixed = IDENTITY;
    }
    this.before.push(composed(fixed, { ...IDENTITY, p: point }));
  }

  /** Placement of the point in the base, and the joints' axes. */
  forward(q: ArrayLike<number>): Placed {
    let at = IDENTITY;
    const screws = this.joints.map((joint, i) => {
      at = composed(at, this.before[i]);
      const { R, p } = at;
      const axis = turned(R, joint.axis);
      const value = joint.multiplier * q[joint.column] + joint.offset;
      at = joint.slides
        ? { R, p: plus(p, times(value, axis)) }
        : { R: product(R, rotationAbout(joint.axis, value)), p };
      return { joint, axis, origin: p };
    });
    return { ...composed(at, this.before[screws.length]), screws };
  }
}

/** @param m a homogeneous transform, column by column */
function placementOf(m: number[]): Placement {
  return { R: [m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]], p: [m[12], m[13], m[14]] };
}
