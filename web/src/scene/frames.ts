import { makeTriad } from "./arrows.ts";
import { asMark, dispose } from "./marking.ts";
import type { Group } from "three";
import type { Robot } from "../robot/robot.ts";
import type { Labels } from "./labels.ts";

/** Triads of chosen frames, with their names. */
export class Frames {
  triads: Group[] = [];

  /**
   * @param names frames to draw when they are shown
   * @param size length of the arrows [m]
   */
  constructor(
    readonly robot: Robot,
    readonly labels: Labels,
    readonly names: string[],
    readonly size: number,
  ) {}

  show(on: boolean) {
    for (const triad of this.triads) dispose(triad);
    const names = on ? this.names : [];
    this.triads = names.map((name) => {
      const triad = asMark(makeTriad(this.size));
      this.robot.frameNode(name).add(triad);
      triad.updateWorldMatrix(false, true);
      return triad;
    });
    this.labels.set(
      this,
      names.map((text, i) => ({ text, node: this.triads[i] })),
    );
  }
}
