import { makeTriad } from "../scene/arrows.ts";
import { asMark, dispose } from "../scene/marking.ts";
import { THREE } from "../three.ts";
import { frameOf } from "./link_facts.ts";
import type { App } from "../app.ts";
import type { Robot } from "../robot/robot.ts";

const SIZE = 0.062;

/** The frame that is looked at: drawn as a triad with its name. Event of the app: "selected". */
export class Selection {
  frame: string | null = null;
  triad: THREE.Group | null = null;

  constructor(readonly app: App) {}

  /** Number of the link that the frame belongs to. */
  get link() {
    return this.frame === null ? null : this.app.robot.linkOf(this.frame);
  }

  selectLink(link: number) {
    this.select(frameOf(this.app.robot.about, link));
  }

  /** @param frame null for none */
  select(frame: string | null) {
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

/** Pose of what poses are given in, in the robot's root. */
export function referencePose(
  robot: Robot,
  reference: { kind: "root" } | { kind: "floor" } | { kind: "frame"; name: string },
) {
  if (reference.kind === "root") return new THREE.Matrix4();
  if (reference.kind === "floor") return robot.placement().invert();
  return robot.pose(robot.linkOf(reference.name));
}
