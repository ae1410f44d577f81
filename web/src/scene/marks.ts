import type { Group } from "three";
import { asMark, dispose } from "../robot/nodes.ts";
import type { Robot } from "../robot/robot.ts";
import { THREE } from "../three.ts";
import type { Labels } from "./labels.ts";
import { makeScrew, makeTriad } from "./shapes.ts";
import type { Studio } from "./studio.ts";

/** Triads of chosen frames, with their names. */
export class Frames {
  triads: Group[] = [];

  /**
   * @param names frames to draw when they are shown
   * @param usual default length of the arrows [m]; they are shorter if there are many frames
   * @param size length of the arrows that was asked for, instead of the default [m]
   */
  constructor(
    readonly robot: Robot,
    readonly labels: Labels,
    readonly names: string[],
    readonly usual: number,
    readonly size: number | null = null,
  ) {}

  show(on: boolean) {
    for (const triad of this.triads) dispose(triad);
    const names = on ? this.names : [];
    const size = this.size ?? this.usual * Math.min(1, 5 / Math.sqrt(names.length));
    this.triads = names.map((name) => {
      const triad = asMark(makeTriad(size));
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

/** Colours of the lower pairs. */
const PAIR_COLOURS: Record<string, string> = {
  revolute: "#e8590c",
  prismatic: "#1c7ed6",
  helical: "#c2255c",
  cylindrical: "#5f3dc4",
  universal: "#7c4ddb",
  condyloid: "#9c36b5",
  spherical: "#099268",
  planar: "#846358",
  other: "#5c6678",
};

const colourOf = (pair: string) => PAIR_COLOURS[pair] ?? PAIR_COLOURS.other;

const LENGTH = 0.07;

/** The axes of the joints, each in the colour of its lower pair and labelled with its name. */
export class JointAxes {
  screws: THREE.Group[] = [];
  /** The axis of the joint whose row in the panel is under the pointer. */
  lit: THREE.Group | null = null;

  constructor(
    readonly robot: Robot,
    readonly studio: Studio,
    readonly labels: Labels,
  ) {}

  /** @returns the kinds of lower pairs drawn, with their colours */
  show(on: boolean): Map<string, string> {
    for (const screw of this.screws) dispose(screw);
    this.screws = [];
    const pairs = new Map();
    /** The label of each pair: the axes of one pair share a label, whose colour the legend explains. */
    const labels: Map<number, { text: string; node: THREE.Object3D; colour: string }> = new Map();
    for (const { name, pair, group, slides, axis, node } of on ? this.robot.joints.filter((joint) => joint.pair) : []) {
      const colour = colourOf(pair);
      pairs.set(pair, colour);
      const screw = this.draw({ slides, axis, node }, colour, LENGTH);
      this.screws.push(screw);
      const known = labels.get(group);
      if (known) known.text += `, ${name}`;
      else labels.set(group, { text: name, node: screw, colour });
    }
    this.labels.set(this, [...labels.values()]);
    this.studio.seeThrough(on);
    return pairs;
  }

  /** @param name of the joint whose axis is drawn, besides the others; null for none */
  light(name: string | null) {
    if (this.lit) dispose(this.lit);
    const joint = this.robot.joints.find((candidate) => candidate.name === name);
    this.lit = joint ? this.draw(joint, colourOf(joint.pair), 1.5 * LENGTH) : null;
  }

  /** @param length [m] for a robot of 1 m */
  draw(
    { slides, axis, node }: Pick<Robot["joints"][number], "slides" | "axis" | "node">,
    colour: string,
    length: number,
  ) {
    const screw = asMark(makeScrew(slides, colour, length * this.studio.markScale));
    screw.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), axis);
    node.parent?.add(screw);
    screw.updateWorldMatrix(true, true);
    return screw;
  }
}
