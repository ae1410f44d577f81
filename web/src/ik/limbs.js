import { Arm } from "./arm.js";
import { Gaze } from "./gaze.js";
import { Head } from "./head.js";
import { Leg } from "./leg.js";

/** @import { LimbNumbers } from "./types.js" */

/**
 * The closed form of a limb of the robot; its `kind` tells which.
 *
 * @typedef {Leg | Arm | Head | Gaze} AnyLimb
 */

/**
 * The closed form of each kind of limb, made of the numbers of a limb of that kind.
 *
 * @type {Record<LimbNumbers["kind"], new (numbers: any) => AnyLimb>}
 */
export const LIMB_CLASSES = { leg: Leg, arm: Arm, head: Head, gaze: Gaze };
