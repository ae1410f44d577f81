import type { PageWith } from "../app.ts";
import { evenTimes } from "../timeline/motion.ts";
import { OffScreen, asMark } from "../robot/nodes.ts";
import { THREE } from "../three.ts";
import type { Player } from "../timeline/player.ts";
import { GHOST_COLOURS } from "./ghosts.ts";
import { entry } from "./legend.ts";

type Page = PageWith<"legend" | "robot" | "studio" | "viewer">;

/** No trails, the past path of each frame, or its path during the whole motion. */
export type Mode = "off" | "behind" | "whole";

// The largest number of points of a trail, the least distance between them, and the radius of its tube [m].
const MOST = 400;
const [APART, RADIUS] = [0.001, 0.0016];
// The time between two drawings of a growing trail, and the time that a change waits for further changes [ms].
const PATIENCE = 100;

/** Draws the paths of chosen frames, in the frame of the robot's root, or in the world if its base floats. */
export class Trails {
  mode: Mode = "off";
  frames: Set<string>;
  /** The past positions of each frame. */
  past: Map<string, THREE.Vector3[]> = new Map();
  /** A copy of the robot's tree that computes poses in other configurations. */
  skeleton: OffScreen | undefined = undefined;
  waiting: ReturnType<typeof setTimeout> | undefined = undefined;
  // Kept, because a growing trail is drawn again ten times per second.
  materials = GHOST_COLOURS.map(
    (colour) => new THREE.MeshBasicMaterial({ color: new THREE.Color(colour).convertSRGBToLinear() }),
  );
  group = asMark(new THREE.Group());

  constructor(
    readonly page: Page,
    readonly player: Player,
  ) {
    this.frames = new Set(page.robot.about.effectors.slice(0, GHOST_COLOURS.length));
    page.robot.root.add(this.group);
    page.addEventListener("settled", () => this.follow());
    player.addEventListener("motion", () => this.mode === "whole" && this.later());
  }

  setMode(mode: Mode) {
    this.mode = mode;
    this.past.clear();
    if (mode === "behind") this.follow();
    this.draw();
  }

  choose(frame: string, on: boolean) {
    if (on) this.frames.add(frame);
    else this.frames.delete(frame);
    this.past.delete(frame);
    this.draw();
  }

  // The robot has moved.
  follow() {
    if (this.mode !== "behind") return;
    const { robot } = this.page;
    for (const frame of this.frames) {
      const way = this.past.get(frame) ?? [];
      this.past.set(frame, way);
      const place = new THREE.Vector3().setFromMatrixPosition(robot.pose(robot.linkOf(frame)));
      if (way.length > 0 && place.distanceTo(way[way.length - 1]) < APART) continue;
      way.push(place);
      if (way.length > MOST) way.shift();
      this.later();
    }
  }

  get tubes() {
    return this.group.children as THREE.Mesh[];
  }

  later() {
    this.waiting ??= setTimeout(() => this.draw(), PATIENCE);
  }

  draw() {
    clearTimeout(this.waiting);
    this.waiting = undefined;
    for (const { geometry } of this.tubes) geometry.dispose();
    this.group.remove(...this.tubes);
    const frames = this.mode === "off" ? [] : [...this.frames];
    const ways = this.mode === "whole" ? this.ahead(frames) : frames.map((frame) => this.past.get(frame) ?? []);
    ways.forEach((way, i) => {
      const tube = makeTube(way, this.materials[i % this.materials.length], RADIUS * this.page.studio.markScale);
      if (tube) this.group.add(tube);
    });
    const entries = frames.map((frame, i) => entry(frame, GHOST_COLOURS[i % GHOST_COLOURS.length]));
    this.page.legend.set("trails", entries.length > 0 ? ["trails", ...entries] : []);
    this.page.viewer.set_dirty();
  }

  ahead(frames: string[]) {
    const { motion } = this.player;
    if (!motion) return [];
    this.skeleton ??= new OffScreen(this.page.robot);
    // A straight line in joint values is a curve in space, so the path is sampled between the motion's times too.
    const times = evenTimes(motion, MOST);
    return this.skeleton.ways(
      motion,
      times,
      frames.map((frame) => this.page.robot.linkOf(frame)),
    );
  }
}

/** A thin tube along some points; null if they are all in one place. */
function makeTube(way: THREE.Vector3[], material: THREE.Material, radius: number) {
  // Coincident points would give the curve no direction.
  const apart = way.filter((place, i) => i === 0 || place.distanceTo(way[i - 1]) > 1e-5);
  if (apart.length < 2) return null;
  const curve = new THREE.CatmullRomCurve3(apart, false, "centripetal");
  curve.arcLengthDivisions = 2 * apart.length;
  return new THREE.Mesh(new THREE.TubeGeometry(curve, 2 * apart.length, radius, 6), material);
}
