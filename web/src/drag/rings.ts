import { flatMaterial } from "../scene/arrows.ts";
import { asMark, dispose } from "../scene/marking.ts";
import { THREE } from "../three.ts";
import type { Handle } from "./types.ts";
import type { App } from "../app.ts";
import type { Handles } from "./handles.ts";

/** of a frame */
export interface Axis {
  name: string;
  axis: [number, number, number];
  colour: string;
}

/** a turn of a handle's frame about its own axis */
export interface Ring {
  handle: Handle;
  axis: Axis;
  mesh: THREE.Mesh;
}

// Sizes in metres for a small robot; the points of a ring that are looked at; how near to it a pointer is on it [px].
const [RADIUS, THICKNESS, SAMPLES, POINT, FINGER] = [0.072, 0.0011, 64, 6, 16];

const AXES: Axis[] = [
  { name: "x", axis: [1, 0, 0], colour: "#e0433a" },
  { name: "y", axis: [0, 1, 0], colour: "#2f9e44" },
  { name: "z", axis: [0, 0, 1], colour: "#2f6fe0" },
];

const TURNS: Record<string, Axis[]> = { leg: AXES, arm: AXES.slice(1) };

/** The axes that a handle's frame may be turned about. */
export const turnsOf = ({ limb }: Handle) => TURNS[limb.kind] ?? [];

/**
 * Rings that turn the frame of a limb, around the handle of the one that is selected: about all three axes of a foot; of a
 * hand, whose arm has five joints, about the two that turn the direction of the forearm.
 */
export class Rings {
  list: Ring[] = [];

  constructor(
    readonly app: App,
    readonly handles: Handles,
  ) {
    app.addEventListener("selected", () => this.refresh());
  }

  /** Draw the rings of the selected limb, and no others. */
  refresh() {
    for (const { mesh } of this.list) dispose(mesh);
    const { frame } = this.app.pick.selection;
    const handle = this.handles.shown && this.handles.list.find(({ limb }) => limb.frame === frame);
    this.list = handle ? turnsOf(handle).map((axis) => this.make(handle, axis)) : [];
    this.app.viewer.set_dirty();
  }

  make(handle: Handle, axis: Axis): Ring {
    const scale = this.app.studio.markScale;
    const mesh = new THREE.Mesh(
      new THREE.TorusGeometry(RADIUS * scale, THICKNESS * scale, 8, 64),
      flatMaterial(axis.colour, 21),
    );
    mesh.renderOrder = 21;
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...axis.axis));
    this.app.robot.frameNode(handle.limb.frame).add(asMark(mesh));
    return { handle, axis, mesh };
  }

  /** The ring under the pointer, and the place on it, in the world. */
  at({ clientX, clientY, pointerType }: { clientX: number; clientY: number; pointerType: string }) {
    const { viewport } = this.app.pick;
    let found: { ring: Ring; point: THREE.Vector3 } | null = null;
    let least = pointerType === "touch" ? FINGER : POINT;
    const radius = RADIUS * this.app.studio.markScale;
    for (const ring of this.list) {
      ring.mesh.updateWorldMatrix(true, false);
      for (let i = 0; i < SAMPLES; i++) {
        const angle = (2 * Math.PI * i) / SAMPLES;
        const point = new THREE.Vector3(radius * Math.cos(angle), radius * Math.sin(angle), 0);
        const place = viewport.place(point.applyMatrix4(ring.mesh.matrixWorld));
        const away = place ? Math.hypot(place.clientX - clientX, place.clientY - clientY) : Infinity;
        if (away < least) [found, least] = [{ ring, point }, away];
      }
    }
    return found;
  }
}
