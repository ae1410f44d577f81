// @ts-nocheck
import { Arm } from "./arm.js";
import { Head } from "./head.js";
import { Leg } from "./leg.js";

export const LIMB_CLASSES = { leg: Leg, arm: Arm, head: Head, gaze: Head };
