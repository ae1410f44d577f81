import type { App } from "../app.ts";
import { Chain, type Placed } from "../ik/chain.ts";
import type { Descended } from "../ik/least_squares.ts";
import { Follower, type Limb } from "../ik/limbs.ts";
import { clamp } from "../math/numbers.ts";
import {
  angleBetween,
  direction,
  distance,
  minus,
  plus,
  product,
  quaternionBetween,
  rotationAbout,
  times,
  type Rotation,
  type Vector,
} from "../math/rotations.ts";
import { unitText } from "../pick/facts.ts";
import type { Viewport } from "../pick/pick.ts";
import { isInside } from "../robot/nodes.ts";
import type { Robot } from "../robot/robot.ts";
import { THREE } from "../three.ts";
import type { Coordinate } from "../types.ts";
import type { Gesture, Handle, Hold } from "./gestures.ts";
import { degrees, millimetres } from "./stops.ts";
import { Swept } from "./swept_angle.ts";

/** What a drag reaches. */
type Followed = Pick<Descended, "q" | "held">;

// A way is followed in strides of this length [m], or in the largest number of them.
const [STRIDE, STRIDES] = [0.02, 15];
// What is farther from its place [m] or its direction [rad] is said.
const [AWAY, TURNED] = [1e-4, 1e-3];
// The joints of a limb turn by no more than this in one picture [rad, m], unless the pointer jumps.
const SWING = 0.6;
const UNTURNED: Rotation = [1, 0, 0, 0, 1, 0, 0, 0, 1];

/** The joints that a limit holds, with the limits; empty if none is held. */
function heldJoints({ panel, robot }: App, { q, held }: Followed) {
  const { coordinates } = robot.about;
  return held
    .map((column) => coordinates.find((one) => one.column === column) as Coordinate)
    .map(({ joint, column, unit }) => `${joint} stops at ${unitText(q[column], unit, panel.settings.units)}`)
    .join(", ");
}

/** How far limbs that are coupled to the dragged one have turned or moved since the start; empty if none has. */
function coupledMoves({ kept }: Follower, q: number[]) {
  return kept.map(({ limb, placed }) => {
    const { p, R } = limb.chain.forward(q);
    const way = distance(p, placed.p);
    if (way <= AWAY && limb.under.length > 0) return "";
    if (way > AWAY) return `${limb.frame} moves by ${millimetres(way)}`;
    const turn = degrees(angleAbout([0, 0, 1], placed.R, R), 1);
    const joint = limb.joints.find(({ follows }) => follows !== "");
    return Number.parseFloat(turn) === 0 ? "" : `${limb.frame} turns by ${turn} with ${joint?.name ?? "it"}`;
  });
}

/** The angle about an axis in the rotation from one orientation to another, in (−2π, 2π]. */
function angleAbout(axis: Vector, from: Rotation, to: Rotation) {
  const [r0, ...r] = quaternionBetween(from, to);
  return 2 * Math.atan2(r[0] * axis[0] + r[1] * axis[1] + r[2] * axis[2], r0);
}

/** The height of the lowest vertex that moves with the last joint of a limb, over the floor. */
function lowestOf(robot: Robot, limb: Limb) {
  const carrier = robot.nodes[limb.joints.at(-1)?.link ?? limb.link];
  return robot.lowest(robot.meshes.filter(({ link }) => isInside(robot.nodes[link], carrier)));
}

const said = (limb: Limb, ...parts: string[]) => {
  const text = parts.filter(Boolean).join("; ");
  return text && `${limb.frame}: ${text}`;
};

/** A drag by a handle or one of its rings. The robot's first link stays where it is, unless it is what is dragged. */
class LimbGesture {
  limb = this.handle.limb;
  /** The first link at the start, in the world, and the node that moves it. */
  home = this.page.robot.nodes[0].matrixWorld.clone();
  carrier = this.page.robot.about.floating ? this.page.robot.nodes[0] : this.page.robot.root;
  before = this.carrier.matrix.clone();
  /** The configuration that is reached; that of a base goes on with the movement of the base. */
  q = [...this.page.stance.q, ...this.limb.under.map(() => 0)];
  follower = new Follower(this.limb, this.q);
  /** The first link, which moves with a base. */
  first = new Chain(this.limb.about, 0, undefined, this.limb.under);

  constructor(
    readonly page: App,
    readonly handle: Handle,
  ) {}

  /** The configuration shown, with the movement of a base. */
  get current() {
    return this.page.stance.q.concat(this.q.slice(this.page.stance.q.length));
  }

  /** Show a configuration that is reached. */
  show(q: readonly number[]) {
    const { stance } = this.page;
    const own = q.slice(0, stance.q.length);
    stance.set(own, this.limb.kind === "base" ? this.carry(own, this.first.forward(q)) : stance.up);
    stance.settle();
  }

  /** Move the base; returns the vertical in the root's frame that keeps a robot without soles as it is. */
  carry(own: number[], { R, p }: Placed) {
    const { page, carrier } = this;
    const { about } = page.robot;
    const [w, x, y, z] = quaternionBetween(UNTURNED, R);
    const T = new THREE.Matrix4().makeRotationFromQuaternion(new THREE.Quaternion(x, y, z, w)).setPosition(...p);
    T.premultiply(this.before).decompose(carrier.position, carrier.quaternion, carrier.scale);
    if (about.floating) own.splice(0, 7, ...carrier.position.toArray(), ...carrier.quaternion.toArray());
    if (about.floating || (about.soles.length > 0 && !page.stance.up)) return page.stance.up;
    return new THREE.Vector3(0, 0, 1).applyQuaternion(carrier.quaternion.clone().invert()).toArray();
  }

  end() {}
}

/** Drag of a handle: the limb follows it in the plane that faces the camera, as near as its limits allow. */
export class LimbDrag extends LimbGesture implements Gesture {
  pulled: ReturnType<Viewport["pulled"]> | null;
  floor: number;
  /** Where the handle is, in the first link at the start. */
  place: Vector;
  says = "";
  frame = 0;

  constructor(page: App, handle: Handle, hold: Hold | null) {
    super(page, handle);
    const { pick, robot } = page;
    const at = handle.knob.getWorldPosition(new THREE.Vector3());
    this.pulled = hold && pick.viewport.pulled(at, hold.ray);
    // The limb must not go below the floor; one that is already below must not go lower.
    const isStopped = !["gaze", "base"].includes(this.limb.kind) && !robot.about.floating && page.shown.standing.stands;
    this.floor = isStopped ? at.y - Math.max(0, lowestOf(robot, this.limb)) : -Infinity;
    this.place = this.inBase(at);
  }

  /** @param options `level` is whether the handle moves only up and down on the screen */
  move(ray: THREE.Ray, options: { level: boolean }) {
    const to = this.pulled?.(ray, options);
    return to ? this.moveTo(to) : this.says;
  }

  /** Move the handle from its current place to the right and up on the screen [m]. */
  step(right: number, up: number) {
    return this.moveTo(this.page.pick.viewport.shift(this.inWorld(this.place), right, up));
  }

  /** @param to in the world */
  moveTo(to: THREE.Vector3) {
    const isBelow = to.y < this.floor;
    if (isBelow) to.setY(this.floor);
    this.says = this.follow(this.inBase(to), isBelow ? "stands on the floor" : "");
    return this.says;
  }

  end() {
    cancelAnimationFrame(this.frame);
    this.handle.knob.position.set(this.handle.ahead, 0, 0);
  }

  /** Move the limb to a place along a straight line, or as near as it can. */
  follow(place: Vector, notice: string) {
    const { page, follower, handle, limb } = this;
    const strides = clamp(Math.ceil(distance(this.place, place) / STRIDE), 1, STRIDES);
    const way = minus(place, this.place);
    // Unless it still swings there, the program may have moved the robot.
    let followed: Followed = { q: this.frame ? this.q : this.current, held: [] };
    for (let i = 1; i <= strides; i++) {
      followed = follower.toPlace(plus(this.place, times(i / strides, way)), followed.q);
    }
    if (limb.kind === "hand" || limb.kind === "foot") followed = follower.anew(place, followed.q) ?? followed;
    const reached = limb.chain.forward(followed.q);
    if (limb.kind !== "gaze" && this.inWorld(reached.p).y < this.floor - AWAY) return said(limb, "stands on the floor");
    this.place = limb.kind === "gaze" ? place : reached.p;
    this.q = followed.q;
    page.ghosts.clearAnswers();
    this.approach(strides === STRIDES ? Infinity : SWING);
    // The handle of the gaze stays under the pointer, even if the camera cannot look exactly at it.
    if (handle.ahead) handle.knob.position.copy(handle.mark.worldToLocal(this.inWorld(place)));
    return said(limb, notice, this.missed(reached, place, followed), ...coupledMoves(follower, followed.q));
  }

  /** Show what is reached, or come nearer by as much as the joints of a limb move in one picture. */
  approach(most: number) {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    const { current } = this;
    const moved = Math.max(...this.limb.columns.map((column) => Math.abs(this.q[column] - current[column])));
    if (moved <= most) return this.show(this.q);
    this.show(current.map((value, column) => value + (most / moved) * (this.q[column] - value)));
    this.frame = requestAnimationFrame(() => this.approach(most));
  }

  /** How far the limb is from a place or from looking at it, and which joints stop it; empty if it is there. */
  missed({ p, R }: Placed, place: Vector, followed: Followed) {
    let miss = "";
    if (this.limb.kind === "gaze") {
      const angle = 2 * Math.asin(Math.min(1, 0.5 * distance([R[0], R[3], R[6]], direction(minus(place, p)))));
      if (angle > TURNED) miss = `looks ${degrees(angle, 1)} past it`;
    } else if (distance(p, place) > AWAY) miss = `out of reach by ${millimetres(distance(p, place))}`;
    const held = miss && heldJoints(this.page, followed);
    return held ? `${miss}: ${held}` : miss;
  }

  // --- frames --------------------------------------------------------------------------------------------------

  /** @param point in the world */
  inBase(point: THREE.Vector3): Vector {
    return point.clone().applyMatrix4(this.home.clone().invert()).toArray();
  }

  /** @param place in the first link */
  inWorld(place: Vector) {
    return new THREE.Vector3().fromArray(place).applyMatrix4(this.home);
  }
}

// The turn to an angle is made in steps [rad]; a step that cannot be made is halved up to HALVINGS times.
const [STEP, HALVINGS] = [0.05, 8];
// The largest errors of a step that is made: of the place [m], and of the turn [rad].
const [OFF, ASTRAY] = [1e-5, 1e-4];

/**
 * Drag of a ring, by the pointer or by keys: the limb turns its frame about the axis of the ring, in place, as far as it
 * can.
 */
export class TurnDrag extends LimbGesture implements Gesture {
  wanted = 0;
  reached = 0;
  swept: Swept | null;

  constructor(
    page: App,
    handle: Handle,
    readonly axis: Vector,
    hold: Hold | null,
  ) {
    super(page, handle);
    const origin = handle.mark.getWorldPosition(new THREE.Vector3());
    const along = new THREE.Vector3(...axis).transformDirection(handle.mark.matrixWorld);
    this.swept = hold && new Swept(page.pick.viewport, origin, along, hold);
  }

  move(ray: THREE.Ray) {
    this.wanted += this.swept?.about(ray) ?? 0;
    return this.turn();
  }

  /** @param angle by which to turn from the current orientation [rad] */
  step(angle: number) {
    this.wanted = this.reached + angle;
    return this.turn();
  }

  /** Turn as far towards the wanted angle as the limb can; returns a message, which may be empty. */
  turn() {
    const { page, follower, limb, axis } = this;
    const { R, p } = follower.start;
    let q = this.current;
    let stops = "";
    let step = STEP;
    while (this.reached !== this.wanted && step > STEP / 2 ** HALVINGS) {
      const next = this.reached + clamp(this.wanted - this.reached, -step, step);
      const wanted = product(R, rotationAbout(axis, next));
      const followed = follower.toTurn(wanted, axis, q);
      const made = limb.chain.forward(followed.q);
      const off = limb.hasSole ? angleBetween(made.R, wanted) : Math.abs(angleAbout(axis, wanted, made.R));
      if (distance(made.p, p) <= OFF && off <= ASTRAY) [q, this.reached, stops] = [followed.q, next, ""];
      else [step, stops] = [0.5 * step, heldJoints(page, followed) || "cannot turn farther"];
    }
    this.q = q;
    this.show(q);
    return said(limb, stops, ...coupledMoves(follower, q));
  }
}
