// @ts-nocheck
import { element } from "../panel/element.js";
import { onScale, scaleBar } from "./colour_scale.js";
import { dispose, asMark } from "./marking.js";
import { THREE } from "../three.js";

// Voxels that a hand reaches, coloured by a number each, behind a plane that a slider moves.
export class Reach {
  constructor(app, bar) {
    this.app = app;
    this.bar = bar;
    this.axis = element("select", { ariaLabel: "Axis of the cut" });
    this.axis.append(...["x", "y", "z"].map((name) => element("option", { value: name }, name)));
    this.axis.onchange = () => this.turn();
    this.slider = element("input", { type: "range", step: "any", ariaLabel: "Place of the cut" });
    this.slider.oninput = () => this.cut();
    this.place = element("output");
    this.flip = element("button", { type: "button", title: "Show the other side" }, "⇄");
    this.flip.onclick = () => {
      this.flipped = !this.flipped;
      this.arrange();
    };
    bar.replaceChildren("Cut", this.axis, this.slider, this.place, this.flip);
  }

  // A message without voxels takes the ones before away.
  show({ frame, voxel, first, cells, values, stops, label, low, high, cut }) {
    this.clear();
    this.bar.hidden = !cells;
    this.app.legend.set("reach", cells ? [`${label} ${low}`, scaleBar(stops), high] : []);
    if (!cells) return;
    this.voxel = voxel;
    this.flipped = false;
    this.voxels = Array.from(values, (value, i) => ({
      centre: [0, 1, 2].map((axis) => (first[axis] + cells[3 * i + axis] + 0.5) * voxel),
      colour: new THREE.Color(...onScale(stops, value / 65535)).convertSRGBToLinear(),
    }));
    this.box = [0, 1, 2].map((axis) => {
      const places = this.voxels.map(({ centre }) => centre[axis]);
      const [least, most] = places.reduce(
        ([a, b], place) => [Math.min(a, place), Math.max(b, place)],
        [Infinity, -Infinity],
      );
      return [least - voxel / 2, most + voxel / 2];
    });
    const side = 0.94 * voxel;
    const material = new THREE.MeshPhongMaterial({ specular: 0x101010, shininess: 12 });
    this.mesh = new THREE.InstancedMesh(new THREE.BoxGeometry(side, side, side), material, this.voxels.length);
    this.mesh.frustumCulled = false; // what is reckoned for one voxel does not hold for all
    const ink = new THREE.LineBasicMaterial({ color: 0x20242c });
    this.rim = new THREE.LineLoop(new THREE.BufferGeometry().setFromPoints(Array(4).fill(new THREE.Vector3())), ink);
    this.rim.frustumCulled = false;
    this.group = asMark(new THREE.Group());
    this.group.add(this.mesh, this.rim);
    const { robot } = this.app;
    robot.nodes[robot.frames.get(frame)].add(this.group);
    this.axis.value = cut?.axis ?? "x";
    this.turn(cut?.place);
  }

  clear() {
    if (!this.group) return;
    this.group.removeFromParent();
    this.mesh.dispose();
    dispose(this.group);
    this.group = null;
  }

  // Another axis: the slider goes from one end of the voxels to the other, and begins in the middle.
  turn(place = null) {
    const [least, most] = this.box[this.along];
    Object.assign(this.slider, { min: least, max: most });
    this.slider.value = place ?? (least + most) / 2;
    this.arrange();
  }

  get along() {
    return ["x", "y", "z"].indexOf(this.axis.value);
  }

  // Voxels in the order in which the plane meets them, so that drawing fewer of them is a cut.
  arrange() {
    const sign = this.flipped ? -1 : 1;
    const { along } = this;
    this.voxels.sort((a, b) => sign * (a.centre[along] - b.centre[along]));
    const matrix = new THREE.Matrix4();
    for (const [i, { centre, colour }] of this.voxels.entries()) {
      this.mesh.setMatrixAt(i, matrix.setPosition(...centre));
      this.mesh.setColorAt(i, colour);
    }
    this.mesh.instanceMatrix.needsUpdate = this.mesh.instanceColor.needsUpdate = true;
    this.cut();
  }

  cut() {
    const { Vector3 } = THREE;
    const { along, box, voxels } = this;
    const sign = this.flipped ? -1 : 1;
    const plane = Number(this.slider.value);
    let [low, high] = [0, voxels.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (sign * voxels[middle].centre[along] < sign * plane) low = middle + 1;
      else high = middle;
    }
    this.mesh.count = low;
    const [a, b] = [0, 1, 2].filter((axis) => axis !== along);
    const corners = [
      [0, 0],
      [1, 0],
      [1, 1],
      [0, 1],
    ].map(([i, j]) => {
      const corner = [plane, plane, plane];
      [corner[a], corner[b]] = [box[a][i], box[b][j]];
      return new Vector3(...corner);
    });
    this.rim.geometry.setFromPoints(corners);
    this.place.textContent = `${this.axis.value} ${this.flipped ? ">" : "<"} ${(1000 * plane).toFixed(0)} mm`;
    const [least, most] = box[along];
    const share = `${(100 * (plane - least)) / (most - least)}%`;
    this.slider.style.setProperty("--from", this.flipped ? share : "0%");
    this.slider.style.setProperty("--to", this.flipped ? "100%" : share);
    this.app.viewer.set_dirty();
  }
}
