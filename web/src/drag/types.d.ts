// What the closed forms of src/ik give, as far as a drag uses it.

import type { Group, Ray, Sprite } from "three";

import type { Rotation } from "../math/types.js";
import type { LimbNumbers } from "../types.js";

export interface Limb extends Pick<LimbNumbers, "kind" | "side" | "frame" | "torso" | "joints" | "columns"> {
  values(q: ArrayLike<number>): number[];
  merged(q: ArrayLike<number>, values: number[]): number[];
  excess(values: number[]): number;
  isInside(values: number[]): boolean;
}

export interface Branch {
  values: number[];
  /** How far a foot that stands is turned about the normal of its sole. */
  yaw?: number;
}

export interface Answer {
  limb: Limb;
  reason: string;
  joint: number;
  needed: number;
  limit: number;
  branches: Branch[];
  nearest?: { values: number[]; error: number };
}

/** A configuration that takes a limb to a target, and what there is to say about it; no q where it is not reached. */
export interface Followed {
  q?: number[];
  says: string;
}

/** How a limb follows a target in the torso's frame. It changes nothing. */
export interface Follower {
  /** A target farther away is to be taken in steps of this length [m]. */
  stride?: number;
  follow(target: number[], q: number[]): Followed;
  /** All branches for the same target, whatever the limits. */
  branches(target: number[], q: number[]): Branch[];
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
