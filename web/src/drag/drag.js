// @ts-nocheck
import { FOLLOWERS } from "./follow.js";
import { makeKnob, highlight, makeSight } from "./handle.js";
import { LIMB_CLASSES } from "../ik/limbs.js";
import { squaredDistance } from "../math/numbers.js";
import { convexHull, overlap } from "../math/polygon.js";
import { Ghosts } from "../scene/ghosts.js";
import { asMark } from "../scene/marking.js";
import { THREE } from "../three.js";

// Handles on hands, feet and gaze, and a pointer that drags them; the limb follows by its closed form. The pointer moves a
// handle in the plane through it that the camera faces, with Shift only up and down. While it is held the trunk stays
// where it is; when it is let go the robot stands on the floor again.
export class Drag {
  constructor(app, pane, line) {
    Object.assign(this, { app, pane, line, held: null, hovered: null });
    const { robot } = app;
    this.limbs = robot.about.limbs.map((limb) => new LIMB_CLASSES[limb.kind](limb));
    const gaze = this.limbs.find(({ kind }) => kind === "gaze");
    this.handles = this.limbs
      .filter((limb) => limb.kind === "arm" || limb.kind === "leg" || limb === gaze)
      .map((limb) => this.handle(limb));
    this.ghosts = new Ghosts(robot);
    // Before the camera's own control, which listens on the canvas inside.
    pane.addEventListener("pointerdown", (event) => this.grab(event), true);
    pane.addEventListener("pointermove", (event) => this.move(event));
    pane.addEventListener("pointerup", (event) => this.release(event));
    pane.addEventListener("pointercancel", (event) => this.release(event));
    pane.addEventListener("pointerleave", () => this.hover(null));
  }

  handle(limb) {
    const { robot, studio } = this.app;
    const mark = asMark(new THREE.Group());
    const knob = makeKnob();
    mark.add(knob);
    const ahead = limb.kind === "gaze" ? Drag.SIGHT * Math.min(studio.size, 1.5) : 0;
    knob.position.x = ahead;
    if (ahead) mark.add(makeSight(ahead));
    robot.nodes[robot.frames.get(limb.frame)].add(mark);
    return { limb, mark, knob, ahead };
  }

  // Whether there is anything to drag.
  get possible() {
    return this.handles.length > 0;
  }

  show(on) {
    this.shown = on;
    for (const { mark } of this.handles) mark.visible = on;
    if (!on) this.hover(null);
  }

  // --- the pointer ---------------------------------------------------------------------------------------------

  grab(event) {
    if (this.held || event.button !== 0 || !event.isPrimary) return;
    const handle = this.handleAt(event);
    if (!handle) return;
    const { camera } = this;
    const { Plane, Vector3 } = THREE;
    this.app.settle();
    const at = handle.knob.getWorldPosition(new Vector3());
    const plane = new Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), at);
    const hit = this.ray(event).intersectPlane(plane, new Vector3());
    if (!hit) return;
    this.app.viewer.controls.enabled = false;
    this.pane.setPointerCapture(event.pointerId);
    this.pane.style.cursor = "grabbing";
    const { limb } = handle;
    const follower = new FOLLOWERS[limb.kind](limb, (frame) => this.poseOf(frame, limb), this.limbs);
    // The sole is not to go below the floor, nor lower where it is below it.
    const isOnFloor = limb.kind === "leg" && !this.app.robot.about.floating;
    const floor = isOnFloor ? at.y - Math.max(0, this.footOf(limb).low) : -Infinity;
    const place = this.inTorso(at, limb);
    this.held = { handle, follower, pointer: event.pointerId, at, plane, hit, floor, place };
  }

  move(event) {
    if (!this.held) {
      if (event.pointerType !== "touch" && event.buttons === 0) this.hover(this.handleAt(event));
      return;
    }
    if (event.pointerId !== this.held.pointer) return;
    const { Vector3 } = THREE;
    const { plane, hit, at, handle } = this.held;
    const now = this.ray(event).intersectPlane(plane, new Vector3());
    if (!now) return;
    const by = now.sub(hit);
    if (event.shiftKey) {
      const up = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
      by.copy(up.multiplyScalar(by.dot(up)));
    }
    const to = at.clone().add(by);
    const isBelow = to.y < this.held.floor;
    if (isBelow) to.y = this.held.floor;
    this.follow(this.inTorso(to, handle.limb), isBelow ? "the sole is on the floor" : "");
  }

  release(event) {
    if (!this.held || event.pointerId !== this.held.pointer) return;
    const { knob, ahead } = this.held.handle;
    knob.position.set(ahead, 0, 0);
    this.held = null;
    this.app.viewer.controls.enabled = true;
    this.say("");
    this.ghosts.clear();
    // The legend goes only now: on a narrow page the picture grows by it.
    if (this.app.ghosts.group.children.length === 0) this.app.clearGhosts();
    this.app.restand();
    this.hover(event.type === "pointerup" && event.pointerType !== "touch" ? this.handleAt(event) : null);
  }

  // --- what follows --------------------------------------------------------------------------------------------

  // Take the limb to a target in the torso's frame, or to the reachable one nearest to it in the plane of the drag.
  follow(target, notice = "") {
    const { follower, handle } = this.held;
    const { app } = this;
    const near = this.approach(target);
    let followed = follower.follow(target, near.q);
    const { says } = followed;
    let place = target;
    if (!followed.q) {
      place = this.nearest(target, near);
      followed = follower.follow(place, near.q);
    }
    if (followed.q) {
      this.held.place = place;
      app.ghosts.clear();
      const others = this.others(place, followed.q);
      app.set(followed.q);
      app.settle();
      this.ghosts.show(others, this.app.robot.frames.get(handle.limb.joints[0]));
      // What a camera looks at, or past, stays where it is dragged.
      if (handle.ahead) handle.knob.position.copy(handle.mark.worldToLocal(this.inWorld(target, handle.limb)));
    }
    const said = [notice, says, this.feetCross() ? "the feet cross" : ""].filter(Boolean).join("; ");
    this.say(said && `${handle.limb.frame}: ${said}`);
  }

  // The place and the configuration from which a target is less than a stride away, or at which the straight way to it ends.
  approach(target) {
    const { follower, place } = this.held;
    const strides = Math.ceil(Drag.between(place, target) / (follower.stride ?? Infinity));
    let near = { place, q: this.app.q };
    for (let i = 1; i < strides; i++) {
      const next = place.map((value, k) => value + (i / strides) * (target[k] - value));
      const { q } = follower.follow(next, near.q);
      if (!q) break;
      near = { place: next, q };
    }
    return near;
  }

  // The reachable place nearest to a target: from one that is reached in steps in the plane of the drag, each way,
  // until they are a tenth of a millimetre or too many were tried for one move of the pointer.
  nearest(target, { place, q }) {
    const {
      follower,
      floor,
      handle: { limb },
    } = this.held;
    const away = (tried) => Drag.between(tried, target);
    const directions = this.directions();
    let best = place;
    let step = away(best);
    let left = Drag.TRIES;
    const isAbove = (tried) => this.inWorld(tried, limb).y > floor - Drag.LAST_STEP;
    const isReached = (tried) => left-- > 0 && isAbove(tried) && follower.follow(tried, q).q;
    while (step > Drag.LAST_STEP && left > 0) {
      const found = directions
        .map((direction) => best.map((value, k) => value + step * direction[k]))
        .filter((tried) => away(tried) < away(best))
        .sort((a, b) => away(a) - away(b))
        .find(isReached);
      if (found) best = found;
      else step *= 0.5;
    }
    return best;
  }

  // Unit vectors in the plane of the drag, in the torso's frame.
  directions() {
    const { Vector3, Matrix4 } = THREE;
    const { WAYS } = Drag;
    const { camera } = this;
    const toTorso = new Matrix4().copy(this.torso(this.held.handle.limb).matrixWorld).invert();
    const [right, up] = [0, 1].map((column) =>
      new Vector3().setFromMatrixColumn(camera.matrixWorld, column).transformDirection(toTorso),
    );
    return Array.from({ length: WAYS }, (_, i) => {
      const angle = (i * 2 * Math.PI) / WAYS;
      return new Vector3().addScaledVector(right, Math.cos(angle)).addScaledVector(up, Math.sin(angle)).toArray();
    });
  }

  // The other branches for a target as ghosts, fainter where a limit stands against them.
  others(target, q) {
    const { limb } = this.held.handle;
    const own = limb.values(q);
    return this.held.follower
      .branches(target, q)
      .filter(({ values }) => squaredDistance(values, own) > Drag.OTHER)
      .map(({ values }) => {
        const { INSIDE, OUTSIDE } = Drag;
        return { q: limb.merged(q, values), ...(limb.isInside(values) ? INSIDE : OUTSIDE) };
      });
  }

  // Whether the foot that is dragged is where another one is: their outlines from above, and their heights.
  feetCross() {
    const { limb } = this.held.handle;
    if (limb.kind !== "leg") return false;
    const own = this.footOf(limb);
    return this.limbs
      .filter((other) => other.kind === "leg" && other !== limb)
      .map((other) => this.footOf(other))
      .some((other) => own.low < other.high && other.low < own.high && overlap(own.outline, other.outline));
  }

  // The outline of a leg's last link from above, and its lowest and highest vertex.
  footOf(limb) {
    const { robot } = this.app;
    const foot = robot.frames.get(limb.joints[limb.joints.length - 1]);
    const vertex = new THREE.Vector3();
    const points = [];
    let [low, high] = [Infinity, -Infinity];
    for (const { mesh } of robot.meshes.filter(({ link }) => link === foot)) {
      const { position } = mesh.geometry.attributes;
      for (let i = 0; i < position.count; i++) {
        const { x, y, z } = vertex.fromBufferAttribute(position, i).applyMatrix4(mesh.matrixWorld);
        points.push({ x, y: -z });
        [low, high] = [Math.min(low, y), Math.max(high, y)];
      }
    }
    return { low: Number.isFinite(low) ? low : 0, high, outline: convexHull(points) };
  }

  say(text) {
    this.line.textContent = text;
    this.line.hidden = text === "";
  }

  // --- where things are ----------------------------------------------------------------------------------------

  hover(handle) {
    this.pane.style.cursor = handle ? "grab" : "";
    if (handle === this.hovered) return;
    for (const [which, on] of [
      [this.hovered, false],
      [handle, true],
    ]) {
      if (which) highlight(which.knob, on);
    }
    this.hovered = handle;
    this.app.viewer.set_dirty();
  }

  // The handle under the pointer; a finger covers more than a mouse points at.
  handleAt(event) {
    if (!this.shown) return null;
    const { Vector3 } = THREE;
    const { left, top, width, height } = this.pane.getBoundingClientRect();
    const { camera } = this;
    let [found, least] = [null, event.pointerType === "touch" ? Drag.FINGER : Drag.POINT];
    for (const handle of this.handles) {
      const { x, y, z } = handle.knob.getWorldPosition(new Vector3()).project(camera);
      const [px, py] = [left + ((1 + x) / 2) * width, top + ((1 - y) / 2) * height];
      const away = Math.hypot(px - event.clientX, py - event.clientY);
      if (z < 1 && away < least) [found, least] = [handle, away];
    }
    return found;
  }

  // The camera where its control has put it since the last picture.
  get camera() {
    const { camera } = this.app.viewer;
    camera.updateWorldMatrix(true, false);
    return camera;
  }

  ray(event) {
    const { Raycaster, Vector2 } = THREE;
    const { left, top, width, height } = this.pane.getBoundingClientRect();
    const x = (2 * (event.clientX - left)) / width - 1;
    const y = 1 - (2 * (event.clientY - top)) / height;
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2(x, y), this.camera);
    return caster.ray;
  }

  torso(limb) {
    const { robot } = this.app;
    return robot.nodes[robot.frames.get(limb.torso)];
  }

  inTorso(point, limb) {
    return this.torso(limb).worldToLocal(point.clone()).toArray();
  }

  inWorld(place, limb) {
    return this.torso(limb).localToWorld(new THREE.Vector3(...place));
  }

  // Pose of a frame in the frame of the torso, row by row.
  poseOf(frame, limb) {
    const { robot } = this.app;
    const pose = robot
      .pose(robot.frames.get(limb.torso))
      .invert()
      .multiply(robot.pose(robot.frames.get(frame)));
    return pose.transpose().toArray();
  }
}

Drag.between = (a, b) => Math.hypot(...a.map((value, k) => value - b[k]));

// The search for the nearest place that is reached goes so many WAYS, and ends with steps of LAST_STEP [m], or after so
// many TRIES. A handle is held within POINT pixels of the mouse, or FINGER of a touch; that of the gaze is at a share of
// the robot's size before the camera. Branches whose squared distance is above OTHER are two; their ghosts' looks.
Object.assign(Drag, {
  WAYS: 16,
  LAST_STEP: 1e-4,
  TRIES: 100,
  POINT: 14,
  FINGER: 28,
  SIGHT: 0.25,
  OTHER: 1e-6,
  INSIDE: { colour: "#2f6fe0", opacity: 0.3 },
  OUTSIDE: { colour: "#5c6678", opacity: 0.1 },
});
