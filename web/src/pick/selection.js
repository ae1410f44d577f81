import { makeTriad } from "../scene/arrows.js";
import { asMark, dispose } from "../scene/marking.js";
import { THREE } from "../three.js";
import { frameOf } from "./link_facts.js";

const SIZE = 0.062;

/** The frame that is looked at: drawn as a triad with its name. Event of the app: "selected". */
export class Selection {
  /** @param {import("../app.js").App} app */
  constructor(app) {
    this.app = app;
    /** @type {string | null} */
    this.frame = null;
    /** @type {THREE.Group | null} */
    this.triad = null;
  }

  /** Number of the link that the frame belongs to. */
  get link() {
    return this.frame === null ? null : this.app.robot.linkOf(this.frame);
  }

  /** @param {number} link */
  selectLink(link) {
    this.select(frameOf(this.app.robot.about, link));
  }

  /** @param {string | null} frame null for none */
  select(frame) {
    if (frame === this.frame) return;
    this.frame = frame;
    if (this.triad) dispose(this.triad);
    this.triad = null;
    if (frame !== null) {
      this.triad = asMark(makeTriad(SIZE * this.app.studio.markScale));
      this.app.robot.frameNode(frame).add(this.triad);
    }
    this.app.labels.set(this, this.triad && frame !== null ? [{ text: frame, node: this.triad }] : []);
    this.app.viewer.set_dirty();
    this.app.dispatchEvent(new Event("selected"));
  }
}

/**
 * Pose of what poses are given in, in the robot's root.
 *
 * @param {import("../robot/robot.js").Robot} robot
 * @param {{ kind: "root" } | { kind: "floor" } | { kind: "frame", name: string }} reference
 */
export function referencePose(robot, reference) {
  if (reference.kind === "root") return new THREE.Matrix4();
  if (reference.kind === "floor") return robot.placement().invert();
  return robot.pose(robot.linkOf(reference.name));
}
