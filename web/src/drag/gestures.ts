import type { Group, Ray, Sprite, Vector3 } from "three";
import type { Limb } from "../ik/limbs.ts";

// Types of a drag: what can be grabbed, where, and the movement that follows.

/** Where a pointer grabs something, in the world. */
export interface Hold {
  point: Vector3;
  ray: Ray;
}

/** Something that can be grabbed: the knob of a handle or a target, an arrow, or a ring. */
export interface Grip {
  /** The limb that it moves, if it moves one. */
  limb?: Limb;
  shape: "knob" | "line" | "tight";
  /** Points in the world: the middle of a knob, or many points along a line. */
  points(): Vector3[];
  /** Highlight it or not. */
  light(on: boolean): void;
  /** Begin to drag it, with a pointer or, without a hold, with keys. */
  gesture(hold: Hold | null): Gesture;
}

export interface Handle extends Grip {
  limb: Limb;
  mark: Group;
  knob: Sprite;
  /** The distance of the knob from the frame's origin along x [m]. */
  ahead: number;
}

/** A drag in progress. */
export interface Gesture {
  /** The limb that it moves, if it moves one. */
  limb?: Limb;
  /** Follow the pointer; returns a message, which may be empty. */
  move(ray: Ray, options: { level: boolean }): string;
  /** End the drag. */
  end(): void;
  /** Restore the state before the drag, if it is not the robot's configuration. */
  cancel?(): void;
}
