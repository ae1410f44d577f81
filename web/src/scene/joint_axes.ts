import { THREE } from "../three.ts";
import { makeScrew } from "./arrows.ts";
import { asMark, dispose } from "./marking.ts";
import { PAIR_COLOURS } from "./pair_colours.ts";
import type { Robot } from "../robot/robot.ts";
import type { Studio } from "./studio.ts";
import type { Labels } from "./labels.ts";

const LENGTH = 0.07;

/** The axes of the joints as screws, in the colour of the lower pair that each belongs to, and with its name. */
export class JointAxes {
  screws: THREE.Group[] = [];

  constructor(
    readonly robot: Robot,
    readonly studio: Studio,
    readonly labels: Labels,
  ) {}

  /** @returns the pairs that are there, with their colours */
  show(on: boolean): Map<string, string> {
    for (const screw of this.screws) dispose(screw);
    this.screws = [];
    const pairs = new Map();
    /** Number of the pair → its label: axes that meet in one pair share it. */
    const labels: Map<number, { text: string; node: THREE.Object3D; colour: string }> = new Map();
    for (const { name, pair, group, slides, axis, node } of on ? this.robot.joints.filter((joint) => joint.pair) : []) {
      const colour = PAIR_COLOURS[pair] ?? PAIR_COLOURS.other;
      pairs.set(pair, colour);
      const screw = asMark(makeScrew(slides, colour, LENGTH * this.studio.markScale));
      screw.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), axis);
      node.parent?.add(screw);
      this.screws.push(screw);
      const known = labels.get(group);
      if (known) known.text = known.text.replace(" · ", `, ${name} · `);
      else labels.set(group, { text: `${name} · ${pair}`, node: screw, colour });
      screw.updateWorldMatrix(true, true);
    }
    this.labels.set(this, [...labels.values()]);
    this.studio.seeThrough(on);
    return pairs;
  }
}
