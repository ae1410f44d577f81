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
export interface CoupledTable {
  joint: number;
  of: number;
  at: number[];
  lower: number[];
  upper: number[];
}

/** The rotation of the frame in the link that carries it, entry by entry. */
interface FrameRotation {
  a00: number;
  a01: number;
  a02: number;
  a10: number;
  a11: number;
  a12: number;
  a20: number;
  a21: number;
  a22: number;
}

/** The leg: where the hip is in the torso, and the frame at (x, y, z) from the ankle in its own axes. */
export interface LegGeometry extends FrameRotation {
  hip_x: number;
  hip_y: number;
  hip_z: number;
  /** Angle of HipYawPitch's axis (0, cos κ, sin κ). */
  kappa: number;
  cos_kappa: number;
  sin_kappa: number;
  thigh: number;
  tibia: number;
  x: number;
  y: number;
  z: number;
  /** 0 where the frame has the axes of its link. */
  turned: number;
}

/** The arm: the shoulder at (x, y, z) in the torso, the elbow from it in the upper arm, the frame from the elbow. */
export interface ArmGeometry extends FrameRotation {
  x: number;
  y: number;
  z: number;
  elbow_x: number;
  elbow_y: number;
  hand_x: number;
  hand_y: number;
  hand_z: number;
  /** Metres that count as much as a radian, for the nearest pose; the page does not ask for that. */
  weight: number;
  /** 0 where the frame has the axes of its link. */
  turned: number;
}

/** The head: the neck at (x, y, z) in the torso, the frame from it by `forward` and `up` in the head. */
export interface HeadGeometry extends FrameRotation {
  x: number;
  y: number;
  z: number;
  forward: number;
  up: number;
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
