import { asMark } from "../scene/marking.js";
import { THREE } from "../three.js";
import { highlight, makeKnob, makeSight } from "./marks.js";

/** @typedef {import("./types.js").Handle} Handle */

// Within how many pixels of the mouse, or of a touch, a handle is held.
const [POINT, FINGER] = [14, 28];

// That of the gaze is at a share of the robot's size before the camera, of a small robot.
const [SIGHT, SMALL] = [0.25, 1.5];

/** The handles of the limbs: where they are on the screen, and which one is the one to be held. */
export class Handles {
  /**
   * @param {import("../app.js").App} app
   * @param {import("./types.js").Limb[]} limbs
   */
  constructor(app, limbs) {
    this.app = app;
    this.shown = false;
    /** @type {Handle | null} */
    this.lit = null;
    const gaze = limbs.find(({ kind }) => kind === "gaze");
    this.list = limbs
      .filter((limb) => limb.kind === "arm" || limb.kind === "leg" || limb === gaze)
      .map((limb) => this.make(limb));
  }

  /**
   * @param {import("./types.js").Limb} limb
   * @returns {Handle}
   */
  make(limb) {
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

  /** @param {boolean} on */
  show(on) {
    this.shown = on;
    for (const { mark } of this.list) mark.visible = on;
    if (!on) this.light(null);
  }

  /**
   * The handle under the pointer; a finger covers more than a mouse points at.
   *
   * @param {{ clientX: number, clientY: number, pointerType: string }} event
   */
  at({ clientX, clientY, pointerType }) {
    if (!this.shown) return null;
    /** @type {Handle | null} */
    let found = null;
    let least = pointerType === "touch" ? FINGER : POINT;
    for (const handle of this.list) {
      const place = this.app.pick.viewport.place(handle.knob.getWorldPosition(new THREE.Vector3()));
      const away = place ? Math.hypot(place.clientX - clientX, place.clientY - clientY) : Infinity;
      if (away < least) [found, least] = [handle, away];
    }
    return found;
  }

  /** @param {Handle | null} handle the one that is drawn larger */
  light(handle) {
    if (handle === this.lit) return;
    if (this.lit) highlight(this.lit.knob, false);
    if (handle) highlight(handle.knob, true);
    this.lit = handle;
    this.app.viewer.set_dirty();
  }
}
