import { poseNumbers } from "../pick/pose_numbers.ts";
import { THREE } from "../three.ts";
import { element } from "./element.ts";
import { Numbers } from "./numbers.ts";
import { choose, frameSelect, nameOf, type SelectionSection } from "./selection.ts";
import type { App } from "../app.ts";

/** What is measured between two frames, or points of the surface: in numbers, and chosen without a pointer. */
export class MeasureCard {
  picking = element("button", { type: "button", title: "Two clicks on the robot; Escape ends it" }, "Measure");
  clear = element("button", { type: "button" }, "Clear");
  ends: HTMLSelectElement[];
  lengths = new Numbers(["distance", "dx", "dy", "dz"]);
  angle = new Numbers(["angle"]);
  relative = new Numbers(["x", "y", "z", "roll", "pitch", "yaw"]);
  relativeTitle = element("p", { className: "title" });
  frames: HTMLDivElement;
  results: HTMLDivElement;
  box: HTMLDivElement;

  /** @param selection that knows the reference */
  constructor(
    readonly app: App,
    readonly selection: SelectionSection,
  ) {
    const { measure } = app.pick;
    this.picking.onclick = () => measure.setPicking(!measure.picking);
    this.clear.onclick = () => measure.clear();
    this.ends = ["Measure from", "Measure to"].map((label, i) => {
      const select = frameSelect(label, app.robot.about, [["", "a point or frame"]]);
      select.onchange = () => measure.set(i, select.value === "" ? null : { kind: "frame", name: nameOf(select) });
      return select;
    });
    this.frames = element("div", {}, this.angle.box, this.relativeTitle, this.relative.box);
    this.results = element("div", { className: "results" }, this.lengths.box, this.frames);
    const [from, to] = this.ends;
    const buttons = element("div", { className: "copies" }, this.picking, this.clear);
    const which = element("div", { className: "which" }, from, element("span", {}, "to"), to);
    this.box = element("div", { className: "measure" }, buttons, which, this.results);
    app.addEventListener("measured", () => {
      const details = this.box.closest("details");
      if (details && measure.active) details.open = true;
      this.refresh();
    });
  }

  refresh() {
    const { measure } = this.app.pick;
    const { about } = this.app.robot;
    this.picking.setAttribute("aria-pressed", String(measure.picking));
    this.clear.hidden = !measure.active;
    measure.ends.forEach((end, i) => {
      const select = this.ends[i];
      choose(select, end?.kind === "frame" ? end.name : null);
      const text = end?.kind === "point" ? `a point on ${about.links[end.link].name}` : "a point or frame";
      if (select.options[0].text !== text) select.options[0].text = text;
    });
    const [a, b] = measure.ends;
    this.results.hidden = !a || !b;
    if (!a || !b) return;
    const [T_root_a, T_root_b] = [measure.pose(a), measure.pose(b)];
    const [from, to] = [T_root_a, T_root_b].map((pose) => new THREE.Vector3().setFromMatrixPosition(pose));
    const toReference = this.selection.referencePose().invert();
    const difference = to.applyMatrix4(toReference).sub(from.applyMatrix4(toReference));
    this.lengths.show(this.selection.poseShown([difference.length(), ...difference.toArray()], []));
    this.frames.hidden = a.kind !== "frame" || b.kind !== "frame";
    if (a.kind !== "frame" || b.kind !== "frame") return;
    const { position, rpy, angle } = poseNumbers(T_root_a.invert().multiply(T_root_b));
    this.angle.show(this.selection.poseShown([], [angle]));
    this.relativeTitle.textContent = `${b.name} in ${a.name}`;
    this.relative.show(this.selection.poseShown(position, rpy));
  }
}
