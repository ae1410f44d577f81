import type { App } from "../app.ts";
import type { Received } from "../received.ts";
import { entry } from "./legend.ts";
import { OVERLAP } from "./link_colours.ts";
import { doOverlap, type Hull } from "../math/hulls.ts";

/** A hull, and a ball around it, of which only the radius stays while the link moves. */
interface Placed extends Hull {
  link: number;
  /** Centre of the ball in the frame of the link, and in that of the poses [m]. */
  middle: number[];
  centre: Float64Array;
  reach: number;
}

/** Finds the links of a robot that overlap, from the hulls and the pairs of Python. */
export class SelfCollision {
  hulls: Placed[];
  parts;
  pairs: [number, number][];
  /** For a pair of hulls the direction that separated them last. */
  away: Map<number, Float64Array> = new Map();

  constructor({ links, counts, radii, points, pairs, parts }: Received["hulls"]) {
    let first = 0;
    this.hulls = links.map((link, k) => {
      const own = Float64Array.from(points.subarray(first, (first += 3 * counts[k])));
      const middle = [0, 1, 2].map((axis) => {
        const along = own.filter((_, i) => i % 3 === axis);
        return (Math.min(...along) + Math.max(...along)) / 2;
      });
      let reach = 0;
      for (let i = 0; i < own.length; i += 3) {
        reach = Math.max(reach, Math.hypot(own[i] - middle[0], own[i + 1] - middle[1], own[i + 2] - middle[2]));
      }
      const radius = radii[k];
      return { link, points: own, radius, pose: [], middle, centre: new Float64Array(3), reach: reach + radius };
    });
    this.parts = parts;
    this.pairs = Array.from({ length: pairs.length / 2 }, (_, i) => [pairs[2 * i], pairs[2 * i + 1]]);
  }

  /**
   * The pairs of links that overlap.
   *
   * @param poses the pose of each link, column by column, in any common frame
   */
  overlapping(poses: (link: number) => ArrayLike<number>): [number, number][] {
    for (const hull of this.hulls) {
      const m = (hull.pose = poses(hull.link));
      const [x, y, z] = hull.middle;
      for (let row = 0; row < 3; row++) {
        hull.centre[row] = m[row] * x + m[row + 4] * y + m[row + 8] * z + m[row + 12];
      }
    }
    const found: Map<number, [number, number]> = new Map();
    for (const [a, b] of this.pairs) {
      const links: [number, number] = [this.hulls[a].link, this.hulls[b].link];
      const name = links[0] * 1e6 + links[1];
      if (!found.has(name) && this.touch(a, b)) found.set(name, links);
    }
    return [...found.values()];
  }

  /** Whether two hulls overlap, and, if they have parts, such as fingers, two of these. */
  touch(a: number, b: number): boolean {
    if (!this.overlap(a, b)) return false;
    const [one, other] = [this.parts[a], this.parts[b]];
    if (one[0] === a && other[0] === b) return true;
    for (let i = one[0]; i < one[1]; i++) {
      for (let k = other[0]; k < other[1]; k++) if (this.overlap(i, k)) return true;
    }
    return false;
  }

  overlap(a: number, b: number) {
    const [one, other] = [this.hulls[a], this.hulls[b]];
    const [p, q] = [one.centre, other.centre];
    const [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    const most = one.reach + other.reach;
    if (x * x + y * y + z * z > most * most) return false;
    const pair = a * this.hulls.length + b;
    let away = this.away.get(pair);
    if (!away) this.away.set(pair, (away = Float64Array.of(x, y, z + 1e-9)));
    return doOverlap(one, other, away);
  }
}

/** Finds the links that overlap whenever the robot moves, and can show them in a colour of their own. */
export class Collisions {
  on = false;
  /** The pairs of links that overlap; null while Python has sent no hulls. */
  pairs: [number, number][] | null = null;
  private search: SelfCollision | null = null;

  constructor(readonly page: App) {}

  receive(hulls: Received["hulls"]) {
    this.search = new SelfCollision(hulls);
    this.refresh();
    this.page.toggles.refresh();
    this.page.panel.readout.refresh();
  }

  show(on: boolean) {
    this.on = on;
    this.paint();
  }

  refresh() {
    const { nodes } = this.page.robot;
    this.pairs = this.search?.overlapping((link) => nodes[link].matrixWorld.elements) ?? null;
    this.paint();
  }

  private paint() {
    const { colours, legend } = this.page;
    const links = new Set(this.on ? this.pairs?.flat() : []);
    // The legend is built anew only when it changes: it may move the picture.
    if (colours.mark("overlapping", links)) {
      legend.set("overlap", links.size > 0 ? [entry("links that overlap", OVERLAP)] : []);
    }
  }
}
