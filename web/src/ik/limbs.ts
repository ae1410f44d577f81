import { distance, type Rotation, type Vector } from "../math/rotations.ts";
import type { About, JointAbout } from "../types.ts";
import { Chain, carrierOf, type Placed } from "./chain.ts";
import { descend, lookTask, placeTask, turnTask, type Task } from "./least_squares.ts";

// The weights of tasks [1, m/rad]: what weighs more is met before what weighs less.
const [FIRM, WEAK] = [30, 1e-3];
// Of the turns about the other axes of a ring, that about x, which is along a forearm, matters least.
const ASIDE = [3e-3, 0.03, 0.03];

// The weight of the way of the joints that a hand leaves free [m/rad], so that they do not spin where the arm is stretched.
const REST = 3e-3;

// Such a hand is NEAR a place that it reaches [m].
const NEAR = 0.001;

// Tasks are met if half the sum of the squared errors is at most MET, or MET_NEARLY for such a hand. Otherwise another search begins with joints bent by
// BEND more [rad, m]. Its result is taken if its errors are less than BETTER of the first ones, and no joint moves more than
// JUMP.
const [MET, MET_NEARLY] = [1e-10, 2e-6];
const [BEND, BETTER, JUMP] = [0.1, 0.5, 1.2];

// A limb goes on past a branching of the tree while it has fewer coordinates than a place or a direction needs.
export const FOR_A_PLACE = 3;
const FOR_A_DIRECTION = 2;

/**
 * A foot keeps its orientation rather than its place, a hand its place rather than its orientation, and a gaze turns its x
 * axis towards a place.
 */
type Kind = "foot" | "gaze" | "hand";

/** A part of the robot that a handle moves: a frame, and the joints between it and the next branching of the tree. */
export class Limb {
  chain = new Chain(this.about, this.link);
  joints: JointAbout[] = [];
  /** The columns of the coordinates of these joints. */
  columns: number[] = [];
  /** Limbs with joints that follow coordinates of this one, as a leg of NAO has on the motor of the other. */
  coupled: Limb[] = [];

  constructor(
    readonly about: About,
    readonly frame: string,
    readonly link: number,
    readonly kind: Kind,
  ) {
    const { joints } = this.chain;
    const enough = kind === "gaze" ? FOR_A_DIRECTION : FOR_A_PLACE;
    const carriers = about.joints.map((joint) => ({
      joint,
      carrier: carrierOf(about, about.links[joint.link].path.slice(0, -1)),
    }));
    for (let i = joints.length - 1; i >= 0; i--) {
      this.joints.unshift(joints[i]);
      if (!this.columns.includes(joints[i].column)) this.columns.unshift(joints[i].column);
      const isBranch = carriers.some(({ joint, carrier }) => joint !== joints[i] && carrier === joints[i - 1]);
      if (isBranch && this.columns.length >= enough) break;
    }
  }

  /** Whether a joint that is not of this limb moves with one of its coordinates, and carries another limb. */
  moves(other: Limb) {
    return other.joints.some((joint) => !this.joints.includes(joint) && this.columns.includes(joint.column));
  }
}

/**
 * The limbs that have handles: the gaze of the first camera, the end effectors, which are hands or feet, and the ends of
 * other chains. A foot carries a sole, or is called one.
 */
export function limbsOf(about: About) {
  const { chains, effectors, eyes, frames, joints, links, soles } = about;
  const cameras = eyes.map(({ name }) => name);
  const ends = chains.map((chain) => joints.find(({ name }) => name === chain.joints.at(-1)?.name)?.link);
  const others = ends.map((end) => frames.find(({ link }) => link === end)?.name ?? "");
  const carriers = soles.map(({ link }) => carrierOf(about, links[link].path));
  const found: Limb[] = [];
  for (const name of [...cameras.slice(0, 1), ...effectors, ...others]) {
    const link = frames.find((frame) => frame.name === name)?.link;
    const last = link === undefined ? undefined : carrierOf(about, links[link].path);
    // Of the frames that one joint moves the first has the handle: the head has that of its gaze.
    if (link === undefined || !last || found.some((limb) => limb.joints.at(-1) === last)) continue;
    const isFoot = carriers.includes(last) || /foot|sole/i.test(name);
    const made = new Limb(about, name, link, cameras.includes(name) ? "gaze" : isFoot ? "foot" : "hand");
    // A finger with fewer joints than a place needs would pull the whole arm, which has a handle of its own.
    if (!found.some((limb) => made.joints.includes(limb.joints.at(-1) as JointAbout))) found.push(made);
  }
  // Wheels and grippers have none, unless the robot has nothing else.
  const enough = Math.min(FOR_A_PLACE, Math.max(0, ...found.map(({ columns }) => columns.length)));
  const limbs = found.filter(({ kind, columns }) => kind === "gaze" || columns.length >= enough);
  for (const limb of limbs) limb.coupled = limbs.filter((other) => other !== limb && limb.moves(other));
  return limbs;
}

/** Moves a limb from a configuration, while the limbs that are coupled to it stay. Poses are in the robot's first link. */
export class Follower {
  /** Placements of the limb and of the coupled limbs at the start. */
  start: Placed;
  kept: { limb: Limb; placed: Placed }[];
  columns: number[] = [...new Set([this.limb, ...this.limb.coupled].flatMap(({ columns }) => columns))];

  constructor(
    readonly limb: Limb,
    q: readonly number[],
  ) {
    this.start = limb.chain.forward(q);
    this.kept = limb.coupled.map((other) => ({ limb: other, placed: other.chain.forward(q) }));
  }

  /** Bring the frame to a place, near to the orientation at the start; for a gaze, look at the place. */
  toPlace(place: Vector, q: readonly number[]) {
    const { chain, kind } = this.limb;
    if (kind === "gaze") return this.meet([lookTask(chain, place)], q);
    const there = placeTask(chain, place, 1);
    const turned = (weight: number) => turnTask(chain, this.start.R, [weight, weight, weight]);
    if (kind === "foot") return this.meet([there, turned(FIRM)], q);
    const near = this.meet([there, turned(WEAK)], q, REST);
    // What turns and rests weigh keeps the hand a little from a place that it can reach.
    const isNear = distance(chain.forward(near.q).p, place) < NEAR;
    return isNear ? descend(this.limb.about, [there, ...this.stay], this.columns, near.q, 0.1 * REST) : near;
  }

  /**
   * Turn the frame where it is; the turns about its other axes follow as far as they can.
   *
   * @param axis of the frame: one number is 1
   */
  toTurn(R: Rotation, axis: Vector, q: readonly number[]) {
    const { chain, kind } = this.limb;
    const weights = axis.map((share, i) => (share !== 0 || kind === "foot" ? 1 : ASIDE[i])) as Vector;
    return this.meet([placeTask(chain, this.start.p, FIRM), turnTask(chain, R, weights)], q);
  }

  /** Tasks of the coupled limbs: place and direction of the z axis, about which they turn as the coordinates require. */
  get stay() {
    return this.kept.flatMap(({ limb: { chain }, placed: { p, R } }) => [
      placeTask(chain, p, FIRM),
      turnTask(chain, R, [FIRM, FIRM, WEAK]),
    ]);
  }

  /** Meet tasks, while the coupled limbs stay. */
  meet(own: Task[], q: readonly number[], rest: number = 0) {
    const tasks = [...own, ...this.stay];
    const { about } = this.limb;
    const found = descend(about, tasks, this.columns, q, rest);
    if (found.cost <= (rest > 0 ? MET_NEARLY : MET)) return found;
    // A stretched limb cannot begin to bend, for no joint moves it inwards: begin again with all joints a little bent.
    const bent = [...q];
    for (const { column, lower, upper } of about.coordinates) {
      if (lower === null || upper === null || !this.columns.includes(column)) continue;
      bent[column] += BEND * Math.sign(0.5 * (lower + upper) - q[column]);
    }
    const other = descend(about, tasks, this.columns, bent, rest);
    const jump = Math.max(...this.columns.map((column) => Math.abs(other.q[column] - q[column])));
    return other.cost < BETTER * found.cost && jump <= JUMP ? other : found;
  }
}
