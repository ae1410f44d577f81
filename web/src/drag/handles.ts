import { asMark } from "../scene/marking.ts";
import { THREE } from "../three.ts";
import { highlight, makeKnob, makeSight } from "./marks.ts";
import type { Handle, Limb } from "./types.ts";
import type { App } from "../app.ts";

// Within how many pixels of the mouse, or of a touch, a handle is held.
const [POINT, FINGER] = [14, 28];

// That of the gaze is at a share of the robot's size before the camera, of a small robot.
const [SIGHT, SMALL] = [0.25, 1.5];

/** The handles of the limbs: where they are on the screen, and which one is the one to be held. */
export class Handles {
  shown = false;
  lit: Handle | null = null;
  list;

  constructor(
    readonly app: App,
    limbs: Limb[],
  ) {
    const gaze = limbs.find(({ kind }) => kind === "gaze");
    this.list = limbs
      .filter((limb) => limb.kind === "arm" || limb.kind === "leg" || limb === gaze)
      .map((limb) => this.make(limb));
  }

  make(limb: Limb): Handle {
    const { robot, studio } = this.app;
    const mark = asMark(new THREE.Group());
    const knob = makeKnob();
    mark.add(knob);
    const ahead = limb.kind === "gaze" ? SIGHT * Math.min(studio.size, SMALL) : 0;
    knob.position.x = ahead;
    if (ahead) mark.add(makeSight(ahead));
    robot.frameNode(limb.frame).add(mark);
    return { limb, mark, knob, ahead };
  }

  show(on: boolean) {
    this.shown = on;
    for (const { mark } of this.list) mark.visible = on;
    if (!on) this.light(null);
  }

  /** The handle under the pointer; a finger covers more than a mouse points at. */
  at({ clientX, clientY, pointerType }: { clientX: number; clientY: number; pointerType: string }) {
    if (!this.shown) return null;
    let found: Handle | null = null;
    let least = pointerType === "touch" ? FINGER : POINT;
    for (const handle of this.list) {
      const place = this.app.pick.viewport.place(handle.knob.getWorldPosition(new THREE.Vector3()));
      const away = place ? Math.hypot(place.clientX - clientX, place.clientY - clientY) : Infinity;
      if (away < least) [found, least] = [handle, away];
    }
    return found;
  }

  /** @param handle the one that is drawn larger */
  light(handle: Handle | null) {
    if (handle === this.lit) return;
    if (this.lit) highlight(this.lit.knob, false);
    if (handle) highlight(handle.knob, true);
    this.lit = handle;
    this.app.viewer.set_dirty();
  }
}
