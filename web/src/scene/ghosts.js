// @ts-nocheck
import { between, isInside } from "../robot/nodes.js";
import { Skeleton } from "../robot/skeleton.js";
import { asMark } from "./marking.js";
import { THREE } from "../three.js";

// Pale copies of the links that other configurations put elsewhere; they stay with the robot's root.
export class Ghosts {
  constructor(robot) {
    this.robot = robot;
    this.entries = []; // of the legend
    this.group = asMark(new THREE.Group());
    // The robot's tree once more, bare, for the poses of its links in any configuration.
    const bare = robot.root.clone(true);
    bare.position.set(0, 0, 0);
    bare.quaternion.identity();
    this.skeleton = new Skeleton(bare, robot.about);
    const dropped = [];
    bare.traverse((node) => (node.userData.mark || node.name.startsWith("visual:")) && dropped.push(node));
    dropped.forEach((node) => node.removeFromParent());
    this.shapes = robot.meshes.map(({ mesh, link }) => ({ mesh, link, T_link_mesh: between(mesh, robot.nodes[link]) }));
    robot.root.add(this.group);
  }

  // Draw these instead of those before: configurations with a colour and an opacity each; of all links, or of those that
  // the given one carries.
  show(ghosts, carrier = 0) {
    this.clear();
    const shapes = this.shapes.filter(({ link }) => isInside(this.robot.nodes[link], this.robot.nodes[carrier]));
    for (const [i, { q, colour, opacity }] of ghosts.entries()) {
      const material = new THREE.MeshPhongMaterial({
        color: new THREE.Color(colour).convertSRGBToLinear(),
        transparent: true,
        opacity,
        shininess: 12,
        // Of surfaces in one place the robot's is seen, and then the first ghost's.
        polygonOffset: true,
        polygonOffsetFactor: i + 1,
        polygonOffsetUnits: i + 1,
      });
      this.skeleton.apply(q);
      const poses = this.robot.nodes.map((_, link) => this.skeleton.pose(link));
      for (const { mesh, link, T_link_mesh } of shapes) {
        const copy = new THREE.Mesh(mesh.geometry, material);
        copy.matrixAutoUpdate = false;
        copy.matrix.multiplyMatrices(poses[link], T_link_mesh);
        Object.assign(copy.userData, { link, pose: poses[link] });
        this.group.add(copy);
      }
    }
    this.refresh();
  }

  // Show the links that are not where the robot has them.
  refresh() {
    if (this.group.children.length === 0) return;
    const poses = this.robot.nodes.map((_, link) => this.robot.pose(link).elements);
    for (const copy of this.group.children) {
      const { link, pose } = copy.userData;
      copy.visible = pose.elements.some((value, i) => Math.abs(value - poses[link][i]) > Ghosts.SAME);
    }
  }

  // The shapes' geometries are the robot's.
  clear() {
    for (const copy of [...this.group.children]) {
      copy.material.dispose();
      copy.removeFromParent();
    }
  }
}

// Poses whose entries [1, m] differ by no more are one.
Ghosts.SAME = 1e-6;

// Neither the blue nor the grey of the branches while a limb is dragged.
export const GHOST_COLOURS = ["#e8590c", "#2f9e44", "#c2255c", "#7c4ddb", "#0c8599", "#b08900", "#7a4a2b", "#e64fa0"];
