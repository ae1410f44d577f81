import type { App } from "../app.ts";
import { flatMaterial } from "../scene/shapes.ts";
import { asMark } from "../robot/nodes.ts";
import { THREE } from "../three.ts";
import { unitOf, withUnit } from "../values/units.ts";

/** One end of a measurement: a frame, or a point fixed to a link. */
type End = { kind: "frame"; name: string } | { kind: "point"; link: number; local: THREE.Vector3 };

const [SPOT, THREAD] = [0.006, 0.0014];
const COLOUR = "#c2255c";

/** Measures the distance between two frames or points of the surface, drawn as a line. Event of the page: "measured". */
export class Measure {
  /** Whether a click picks a point. */
  picking = false;
  ends: (End | null)[] = [null, null];
  group = asMark(new THREE.Group());
  spots;
  thread;
  label = new THREE.Group();

  constructor(readonly page: App) {
    page.robot.root.add(this.group);
    const scale = page.studio.markScale;
    const material = flatMaterial(COLOUR, 20);
    const sphere = new THREE.SphereGeometry(SPOT * scale, 20, 14);
    this.spots = [0, 1].map(() => new THREE.Mesh(sphere, material));
    this.thread = new THREE.Mesh(new THREE.CylinderGeometry(THREAD * scale, THREAD * scale, 1, 10), material);
    for (const mark of [...this.spots, this.thread]) mark.renderOrder = 20;
    this.group.add(...this.spots, this.thread, this.label);
    page.addEventListener("settled", () => this.draw());
    this.draw();
  }

  get active() {
    return this.picking || this.ends.some((end) => end !== null);
  }

  setPicking(on: boolean) {
    this.picking = on;
    this.changed();
  }

  /** Take a frame or a point as the second end if only the first is set, else as the first end of a new measurement. */
  pick(end: End) {
    this.ends = this.ends[0] && !this.ends[1] ? [this.ends[0], end] : [end, null];
    this.changed();
  }

  /** @param which 0 or 1 */
  set(which: number, end: End | null) {
    this.ends[which] = end;
    this.changed();
  }

  clear() {
    this.ends = [null, null];
    this.picking = false;
    this.changed();
  }

  changed() {
    this.draw();
    this.page.viewer.set_dirty();
    this.page.dispatchEvent(new Event("measured"));
  }

  /** The pose of an end in the robot's root; a point has the orientation of its link. */
  pose(end: End) {
    const { robot } = this.page;
    if (end.kind === "frame") return robot.pose(robot.linkOf(end.name));
    const pose = robot.pose(end.link);
    return pose.setPosition(end.local.clone().applyMatrix4(pose));
  }

  draw() {
    const places = this.ends.map((end) => end && new THREE.Vector3().setFromMatrixPosition(this.pose(end)));
    places.forEach((place, i) => {
      this.spots[i].visible = place !== null;
      if (place) this.spots[i].position.copy(place);
    });
    const [a, b] = places;
    this.thread.visible = Boolean(a && b);
    if (!a || !b) {
      this.page.labels.set(this, []);
      return;
    }
    const along = b.clone().sub(a);
    const length = along.length();
    this.thread.position.copy(a).lerp(b, 0.5);
    this.thread.scale.set(1, Math.max(length, 1e-9), 1);
    this.thread.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
    this.label.position.copy(this.thread.position);
    const text = withUnit(length, unitOf("m", this.page.panel.settings.units));
    this.page.labels.set(this, [{ text, node: this.label }]);
  }
}
