import type { Rotation, Vector } from "../math/rotations.ts";
import { Arm } from "./arm.ts";
import { Gaze, Head } from "./head.ts";
import { Leg } from "./leg.ts";

/** The closed form of a limb of the robot; its `kind` tells which. */
export type AnyLimb = Leg | Arm | Head | Gaze;

/** The closed form of each kind of limb, made of the numbers of a limb of that kind. */
export const LIMB_CLASSES: Record<LimbNumbers["kind"], new (numbers: any) => AnyLimb> = {
  leg: Leg,
  arm: Arm,
  head: Head,
  gaze: Gaze,
};

// What goes into the closed forms and what comes out of them.

/** Numbers of a limb as `nk.ik.limbs` describes it. Lengths are in metres, angles in radians; an open limit is null. */
interface Described<Kind extends string, Geometry> {
  kind: Kind;
  /** "L", "R" or "". */
  side: string;
  /** The frame whose pose is asked for, and the frame in which it is given. */
  frame: string;
  torso: string;
  /** Their names from the torso outwards; value = multiplier · q[column] + offset. */
  joints: string[];
  columns: number[];
  multiplier: number[];
  offset: number[];
  lower: (number | null)[];
  upper: (number | null)[];
  table: CoupledTable | null;
  geometry: Geometry;
}

export type LegNumbers = Described<"leg", LegGeometry>;
export type ArmNumbers = Described<"arm", ArmGeometry>;
export type HeadNumbers = Described<"head", HeadGeometry>;
export type GazeNumbers = Described<"gaze", HeadGeometry>;
export type LimbNumbers = LegNumbers | ArmNumbers | HeadNumbers | GazeNumbers;

/** The range of a joint of the limb at values `at` of another; linear between them and constant outside. */
interface CoupledTable {
  joint: number;
  of: number;
  at: number[];
  lower: number[];
  upper: number[];
}

/** The frame in the link that carries it: its rotation there, and its place from the last centre of joints. */
interface FrameInLink {
  rotation: Rotation;
  place: Vector;
  /** 0 where the frame has the axes of its link. */
  turned: number;
}

/** The leg: the hip in the torso, and the frame from the ankle. */
interface LegGeometry extends FrameInLink {
  hip: Vector;
  /** Angle of HipYawPitch's axis (0, cos κ, sin κ). */
  kappa: number;
  cos_kappa: number;
  sin_kappa: number;
  thigh: number;
  tibia: number;
  /** By how much a target may be out of reach of the straight leg. */
  stretched: number;
}

/** The arm: the shoulder in the torso, the elbow from it in the upper arm, the frame from the elbow. */
interface ArmGeometry extends FrameInLink {
  shoulder: Vector;
  elbow_x: number;
  elbow_y: number;
  /** Metres that count as much as a radian, for the nearest pose; the page does not ask for that. */
  weight: number;
}

/** The head: the neck in the torso, the frame from it. */
interface HeadGeometry extends FrameInLink {
  neck: Vector;
}

/** Why there is no branch, or that there is one: names of `nk.ik.Reason`. */
export type Reason =
  "REACHED" | "OUT_OF_REACH" | "JOINT_LIMIT" | "COUPLED_LIMIT" | "NOT_ENOUGH_JOINTS" | "NOT_CONVERGED" | "NOT_RIGID";

/** Infinitely many solutions that a branch stands for: names of `nk.ik.Family`. */
export type Family = "NONE" | "ANKLE_AXIS" | "HIP_LOCK" | "SHOULDER_AXIS" | "ELBOW_LOCK" | "YAW_AXIS" | "REDUNDANT";

/** Distance [m] and angle [rad] from a target. */
export type Errors = [number, number];

/** One solution. */
export interface Branch {
  /** Of the joints [rad], from the torso outwards. */
  values: number[];
  errors: Errors;
  family: Family;
  /** Squared, of the values from the reference. */
  distance: number;
  /** How far the foot is turned about the normal of its sole [rad], where that is given up; else 0. */
  yaw: number;
}

/** A range of a joint, and how far its value is outside; less than 0 inside. */
export interface Violation {
  reason: "JOINT_LIMIT" | "COUPLED_LIMIT";
  joint: number;
  value: number;
  low: number;
  high: number;
  outside: number;
}

/** Joint values that come as near to a target as they can, and the angle [rad] that is left. */
export interface Nearest {
  values: number[];
  error: number;
}
