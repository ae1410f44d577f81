import type { Rotation, Vector } from "../math/rotations.ts";
import { Arm } from "./arm.ts";
import { Gaze, Head } from "./head.ts";
import { Leg } from "./leg.ts";

/** The closed form of a limb of the robot; its `kind` tells which one. */
export type AnyLimb = Leg | Arm | Head | Gaze;

/** The class of each kind of limb, whose constructor takes the limb's description. */
export const LIMB_CLASSES: Record<LimbNumbers["kind"], new (numbers: any) => AnyLimb> = {
  leg: Leg,
  arm: Arm,
  head: Head,
  gaze: Gaze,
};

// Inputs and results of the closed forms.

/** A limb as `nk.ik.limbs` describes it. Lengths are in metres, angles in radians; an open limit is null. */
interface Described<Kind extends string, Geometry> {
  kind: Kind;
  /** "L", "R" or "". */
  side: string;
  /** The frame whose pose is the target, and below the frame in which the target is given. */
  frame: string;
  torso: string;
  /** The joints' names from the torso outwards, and the values from which the closed form counts. */
  joints: string[];
  zeros: number[];
  /** Value in the closed form = multiplier · q[column] + offset; the limits are those of these values. */
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

/** The frame in the link that carries it: its rotation, and its position relative to the last centre of joints. */
interface FrameInLink {
  rotation: Rotation;
  place: Vector;
  /** 0 if the frame has the axes of its link. */
  turned: number;
}

/** The leg: the hip in the torso, and the frame relative to the ankle. */
interface LegGeometry extends FrameInLink {
  hip: Vector;
  /** Angle of HipYawPitch's axis (0, cos κ, sin κ). */
  kappa: number;
  cos_kappa: number;
  sin_kappa: number;
  thigh: number;
  tibia: number;
  /** How far a target may be out of reach of the straight leg. */
  stretched: number;
}

/** The arm: the shoulder in the torso, the elbow relative to it in the upper arm, the frame relative to the elbow. */
interface ArmGeometry extends FrameInLink {
  shoulder: Vector;
  elbow_x: number;
  elbow_y: number;
  /** The length that counts as much as a radian, for the nearest pose, which the page does not compute. */
  weight: number;
}

/** The head: the neck in the torso, and the frame relative to it. */
interface HeadGeometry extends FrameInLink {
  neck: Vector;
}

/** Why there is no branch, or that there is one: names of `nk.ik.Reason`. */
export type Reason =
  "REACHED" | "OUT_OF_REACH" | "JOINT_LIMIT" | "COUPLED_LIMIT" | "NOT_ENOUGH_JOINTS" | "NOT_CONVERGED" | "NOT_RIGID";

/** The kind of infinitely many solutions that a branch represents: names of `nk.ik.Family`. */
export type Family = "NONE" | "ANKLE_AXIS" | "HIP_LOCK" | "SHOULDER_AXIS" | "ELBOW_LOCK" | "YAW_AXIS" | "REDUNDANT";

/** Distance [m] and angle [rad] from a target. */
export type Errors = [number, number];

/** One solution. */
export interface Branch {
  /** Values of the joints [rad], from the torso outwards. */
  values: number[];
  errors: Errors;
  family: Family;
  /** The squared distance of the values from the reference. */
  distance: number;
  /** The angle by which the foot turns about the normal of its sole [rad], if that may change; else 0. */
  yaw: number;
}

/** A range of a joint, and how far the value is outside it; negative inside. */
export interface Violation {
  reason: "JOINT_LIMIT" | "COUPLED_LIMIT";
  joint: number;
  value: number;
  low: number;
  high: number;
  outside: number;
}

/** Joint values that come as near to a target as possible, and the remaining angle [rad]. */
export interface Nearest {
  values: number[];
  error: number;
}
