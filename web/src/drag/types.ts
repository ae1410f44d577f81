// What a drag works with.

import type { Group, Ray, Sprite } from "three";

import type { Rotation, Vector } from "../math/types.ts";
import type { AnyLimb } from "../ik/limbs.ts";
import type { Branch } from "../ik/types.ts";

export type Limb = AnyLimb;

/** A configuration that takes a limb to a target, and what there is to say about it; no q where it is not reached. */
export interface Followed {
  q?: number[];
  says: string;
}

/** How a limb follows a target in the torso's frame. It changes nothing. */
export interface Follower {
  /** A target farther away is to be taken in steps of this length [m]. */
  stride?: number;
  follow(target: Vector, q: number[]): Followed;
  /** All branches for the same target, whatever the limits. */
  branches(target: Vector, q: number[]): Branch[];
  /** At the place where it was, with its frame turned by a rotation of the torso, row by row. */
  turn?(rotation: Rotation, q: number[]): Followed;
}

export interface Handle {
  limb: Limb;
  mark: Group;
  knob: Sprite;
  /** How far along x of its frame the knob is [m]. */
  ahead: number;
}

/** Something that is held and moved. */
export interface Gesture {
  /** Follow the pointer; gives what there is to say. */
  move(ray: Ray, options: { level: boolean }): string;
  /** It is let go. */
  end(): void;
}
