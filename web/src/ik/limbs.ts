import { Arm } from "./arm.ts";
import { Gaze, Head } from "./head.ts";
import { Leg } from "./leg.ts";
import type { LimbNumbers } from "./types.ts";

/** The closed form of a limb of the robot; its `kind` tells which. */
export type AnyLimb = Leg | Arm | Head | Gaze;

/** The closed form of each kind of limb, made of the numbers of a limb of that kind. */
export const LIMB_CLASSES: Record<LimbNumbers["kind"], new (numbers: any) => AnyLimb> = {
  leg: Leg,
  arm: Arm,
  head: Head,
  gaze: Gaze,
};
