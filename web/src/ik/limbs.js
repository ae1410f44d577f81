import { Arm } from "./arm.js";
import { Gaze } from "./gaze.js";
import { Head } from "./head.js";
import { Leg } from "./leg.js";

/** The closed form of each kind of limb. */
export const LIMB_CLASSES = { leg: Leg, arm: Arm, head: Head, gaze: Gaze };
