import { clamp } from "../math/numbers.ts";
import { distance, type Rotation, type Vector } from "../math/rotations.ts";
import type { About, Frame, JointAbout } from "../types.ts";
import { rangeOf } from "../values/configurations.ts";
import { Chain, carrierOf, type Placed } from "./chain.ts";
import { descend, lookTask, placeTask, turnTask, type Descended, type Task } from "./least_squares.ts";

// The weights of tasks [1, m/rad]: what weighs more is met before what weighs less. HOLD is for feet that carry the base.
const [HOLD, FIRM, WEAK] = [1000, 30, 1e-3];
// Of the turns about the other axes of a ring, that about x, which is along a forearm, matters least. A base turns rather
// about z than that it tilts: the legs of a NAO leave it five coordinates.
const [ASIDE, UPRIGHT]: Vector[] = [[3e-3, 0.03, 0.03], [FIRM, FIRM, 0.03]]; // prettier-ignore

// The weight of the way of the joints that a hand leaves free [m/rad], so that they do not spin where the arm is stretched.
const REST = 3e-3;

// Such a hand is NEAR a place that it reaches [m].
const NEAR = 0.001;

// Tasks are met if half the sum of the squared errors is at most MET, or MET_NEARLY for such a hand. Otherwise another search begins with joints bent by
// BEND more [rad, m]. Its result is taken if its errors are less than BETTER of the first ones, and no joint moves more than
// JUMP.
const [MET, MET_NEARLY] = [1e-10, 2e-6];
const [BEND, BETTER, JUMP] = [0.1, 0.5, 1.2];
// A limb that does not reach a place begins anew BEGINS times, at shares of the ranges that the golden ratio spreads evenly. Without
// reaching it a limb must come nearer by the factor CLEARLY.
const [BEGINS, GOLDEN, CLEARLY] = [5, 0.618034, 0.8];

// A limb goes on past a branching of the tree while it has fewer coordinates than a place or a direction needs.
export const FOR_A_PLACE = 3;
const FOR_A_DIRECTION = 2;
// A leg with fewer coordinates stands on a point.
const FOR_A_SOLE = 5;

/**
 * A foot keeps its orientation rather than its place, a hand its place rather than its orientation, and a gaze turns its x
 * axis towards a place. The base is the first link, which moves while all feet stay.
 */
type Kind = "base" | "foot" | "gaze" | "hand";

const FOOT = /foot|sole|ankle|(^|_)toe/i;
const ORIGIN: Vector = [0, 0, 0];

/** A part of the robot that a handle moves: a point, and the joints between it and the next branching of the tree. */
export class Limb {
  chain = new Chain(this.about, this.link, this.point, this.under);
  joints: JointAbout[] = [];
  /** The columns of the coordinates of these joints. */
  columns: number[] = [];
  /** Whether it has a sole, which keeps its orientation; other feet are points. */
  hasSole: boolean;
  /** Limbs with joints that follow coordinates of this one, as a leg of NAO has on the motor of the other; they stay. */
  coupled: Limb[] = [];

  /**
   * @param point in the frame
   * @param under joints that carry the base
   */
  constructor(
    readonly about: About,
    readonly frame: string,
    readonly link: number,
    readonly kind: Kind,
    readonly point: Vector = ORIGIN,
    readonly under: JointAbout[] = [],
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
    this.hasSole = kind === "foot" && this.columns.length >= FOR_A_SOLE;
  }

  /** Whether a joint that is not of this limb moves with one of its coordinates, and carries another limb. */
  moves(other: Limb) {
    return other.joints.some((joint) => !this.joints.includes(joint) && this.columns.includes(joint.column));
  }
}

/**
 * The limbs that have handles: the gaze of the first camera, the ends, which are hands or feet, and the base if it stands
 * on feet. A foot carries a sole, or is called one.
 */
export function limbsOf(about: About) {
  const { ends, eyes, frames, links, soles } = about;
  const cameras = eyes.map(({ name }) => name);
  const carriers = soles.map(({ link }) => carrierOf(about, links[link].path));
  const found: Limb[] = [];
  for (const { frame: name, point } of [...cameras.slice(0, 1).map((frame) => ({ frame, point: ORIGIN })), ...ends]) {
    const link = frames.find((frame) => frame.name === name)?.link;
    const last = link === undefined ? undefined : carrierOf(about, links[link].path);
    // Of the frames that one joint moves the first has the handle: the head has that of its gaze.
    if (link === undefined || !last || found.some((limb) => limb.joints.at(-1) === last)) continue;
    const isFoot = carriers.includes(last) || FOOT.test(name);
    const made = new Limb(about, name, link, cameras.includes(name) ? "gaze" : isFoot ? "foot" : "hand", point);
    // A finger with fewer joints than a place needs would pull the whole arm, which has a handle of its own.
    if (!found.some((limb) => made.joints.includes(limb.joints.at(-1) as JointAbout))) found.push(made);
  }
  // Wheels and grippers have none, unless the robot has nothing else.
  const enough = Math.min(FOR_A_PLACE, Math.max(0, ...found.map(({ columns }) => columns.length)));
  const limbs = found.filter(({ kind, columns }) => kind === "gaze" || columns.length >= enough);
  for (const limb of limbs) limb.coupled = limbs.filter((other) => other !== limb && limb.moves(other));
  const feet = limbs.filter(({ kind }) => kind === "foot");
  return feet.length > 1 ? [...limbs, baseOf(about, feet)] : limbs;
}

/** The base on its feet: six joints move it along x, y and z and about them; their columns are those after q. */
function baseOf(about: About, feet: Limb[]) {
  const joints = [0, 1, 2, 5, 4, 3].map((row, i) => ({
    ...{ name: "", link: 0, slides: i < 3, axis: [0, 1, 2].map((k) => Number(k === row % 3)) as Vector },
    ...{ column: about.neutral.length + i, multiplier: 1, offset: 0, follows: "", pair: "", group: -1 },
  }));
  const free = joints.map(({ column }) => ({ joint: "", column, lower: null, upper: null, velocity: null, unit: "" }));
  const wide = { ...about, coordinates: [...about.coordinates, ...free] };
  const root = about.floating ? about.links[0].name : about.root;
  const at = about.frames.find(({ name }) => name === root) as Frame;
  const base = new Limb(wide, root, at.link, "base", ORIGIN, joints);
  base.coupled = feet.map(({ frame, link, kind, point, chain, hasSole }) => {
    const columns = [...new Set(chain.joints.map(({ column }) => column))];
    return Object.assign(new Limb(wide, frame, link, kind, point, joints), { columns, hasSole });
  });
  return base;
}

/** Whether a robot stands on the floor, and is not fixed to it. */
export const isStanding = (about: About) =>
  about.floating || about.postures.some(({ up }) => up) || limbsOf(about).some(({ kind }) => kind === "foot");

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
    if (kind === "base") return this.onFeet([there, turnTask(chain, this.start.R, UPRIGHT)], q);
    if (this.limb.hasSole) return this.meet([there, turned(FIRM)], q);
    const near = this.meet([there, turned(WEAK)], q, REST);
    // What turns and rests weigh keeps the hand a little from a place that it can reach.
    const isNear = distance(chain.forward(near.q).p, place) < NEAR;
    return isNear ? descend(this.limb.about, [there, ...this.stay()], this.columns, near.q, 0.1 * REST) : near;
  }

  /**
   * Turn the frame where it is; the turns about its other axes follow as far as they can.
   *
   * @param axis of the frame: one number is 1
   */
  toTurn(R: Rotation, axis: Vector, q: readonly number[]) {
    const { chain, kind } = this.limb;
    const aside = kind === "base" ? UPRIGHT : ASIDE;
    const weights = axis.map((share, i) => (share !== 0 || this.limb.hasSole ? 1 : aside[i])) as Vector;
    const tasks = [placeTask(chain, this.start.p, FIRM), turnTask(chain, R, weights)];
    return kind === "base" ? this.onFeet(tasks, q) : this.meet(tasks, q);
  }

  /**
   * Tasks of the coupled limbs: place and direction of the z axis, about which they turn as the coordinates require. Feet
   * that carry the base do not turn, unless they are points.
   */
  stay(firm: number = FIRM) {
    const isBase = this.limb.kind === "base";
    const about = isBase ? firm : WEAK;
    return this.kept.flatMap(({ limb: { chain, hasSole }, placed: { p, R } }) => {
      const there = placeTask(chain, p, firm);
      return isBase && !hasSole ? [there] : [there, turnTask(chain, R, [firm, firm, about])];
    });
  }

  /**
   * The same from other configurations all over the ranges, the middle first, for a limb that has not reached the place from
   * q: the nearest one that reaches it, or one that is clearly nearer to it; null if there is none.
   */
  anew(place: Vector, q: readonly number[]) {
    const { about, chain, columns, joints } = this.limb;
    const { screws, p } = chain.forward(q);
    const corners = [...screws.slice(-joints.length).map(({ origin }) => origin), p];
    const reach = corners.slice(1).reduce((sum, corner, i) => sum + distance(corners[i], corner), 0);
    const isBeyond = distance(corners[0], place) > reach && joints.every(({ slides }) => !slides);
    if (isBeyond || distance(p, place) < NEAR) return null;
    const own = about.coordinates.filter(({ column }) => columns.includes(column));
    let [best, least, nearest] = [null as Descended | null, CLEARLY * distance(p, place), Infinity];
    for (let begin = 0; begin < BEGINS; begin++) {
      const from = [...q];
      own.forEach(({ column, lower, upper }, i) => {
        const share = (0.5 + begin * GOLDEN * (i + 1)) % 1;
        // Half a turn away at most: a joint of several turns is not turned back.
        const [low, high] = [
          Math.max(lower ?? -Infinity, q[column] - Math.PI),
          Math.min(upper ?? Infinity, q[column] + Math.PI),
        ];
        from[column] = low + share * (high - low);
      });
      this.intoRanges(from);
      const found = this.toPlace(place, from);
      const short = Math.max(distance(chain.forward(found.q).p, place), NEAR);
      const moved = Math.max(...columns.map((column) => Math.abs(found.q[column] - q[column])));
      if (short > least || (short === least && moved > nearest)) continue;
      [best, least, nearest] = [found, short, moved];
    }
    return best;
  }

  /** Put the coordinates of the limb into their ranges: twice, because some ranges depend on other coordinates. */
  intoRanges(q: number[]) {
    const { about } = this.limb;
    const own = about.coordinates.filter(({ column }) => this.columns.includes(column));
    for (const one of [...own, ...own]) q[one.column] = clamp(q[one.column], ...rangeOf(about, one, q));
  }

  /** Meet tasks of a base: first while its feet may give way a little, because a search that holds them makes small steps. */
  onFeet(tasks: Task[], q: readonly number[]) {
    const { q: near } = this.meet(tasks, q);
    return descend(this.limb.about, [...tasks, ...this.stay(HOLD)], this.columns, near);
  }

  /** Meet tasks, while the coupled limbs stay. */
  meet(own: Task[], q: readonly number[], rest: number = 0) {
    const tasks = [...own, ...this.stay()];
    const { about } = this.limb;
    const found = descend(about, tasks, this.columns, q, rest);
    if (found.cost <= (rest > 0 ? MET_NEARLY : MET)) return found;
    // A stretched limb cannot begin to bend, for no joint moves it inwards: begin again with all joints a little bent.
    const bent = [...q];
    for (const { column, lower, upper } of about.coordinates) {
      if (lower === null || upper === null || !this.columns.includes(column)) continue;
      bent[column] += BEND * Math.sign(0.5 * (lower + upper) - q[column]);
    }
    // What begins outside a coupled range would stay outside.
    this.intoRanges(bent);
    const other = descend(about, tasks, this.columns, bent, rest);
    const jump = Math.max(...this.columns.map((column) => Math.abs(other.q[column] - q[column])));
    return other.cost < BETTER * found.cost && jump <= JUMP ? other : found;
  }
}
