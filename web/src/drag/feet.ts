import { convexHull, overlap, type Point } from "../math/polygon.ts";
import { THREE } from "../three.ts";
import type { Limb } from "./types.ts";
import type { Robot } from "../robot/robot.ts";

interface Foot {
  low: number;
  high: number;
  outline: Point[];
}

/** The shapes of a leg's last link. */
function shapesOf(robot: Robot, limb: Limb) {
  const foot = robot.linkOf(limb.joints[limb.joints.length - 1]);
  return robot.meshes.filter(({ link }) => link === foot);
}

/** The outline of a leg's last link from above, and its lowest and highest vertex, in the world of three.js. */
export function footOf(robot: Robot, limb: Limb): Foot {
  const vertex = new THREE.Vector3();
  const points = [];
  let [low, high] = [Infinity, -Infinity];
  for (const { mesh } of shapesOf(robot, limb)) {
    const { position } = mesh.geometry.attributes;
    for (let i = 0; i < position.count; i++) {
      const { x, y, z } = vertex.fromBufferAttribute(position, i).applyMatrix4(mesh.matrixWorld);
      points.push({ x, y: -z });
      [low, high] = [Math.min(low, y), Math.max(high, y)];
    }
  }
  return { low: Number.isFinite(low) ? low : 0, high, outline: convexHull(points) };
}

/** A box around a foot in the world of three.js, not the least one: that of its shapes' own boxes. */
function boxAround(robot: Robot, limb: Limb) {
  const box = new THREE.Box3();
  for (const { mesh } of shapesOf(robot, limb)) {
    if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
    const own = (mesh.geometry.boundingBox as THREE.Box3).clone();
    box.union(own.applyMatrix4(mesh.matrixWorld));
  }
  return box;
}

/**
 * Whether a foot is where that of another leg is: their outlines from above, and their heights.
 *
 * @param limb the leg of the foot
 */
export function feetCross(robot: Robot, limb: Limb, limbs: Limb[]) {
  if (limb.kind !== "leg") return false;
  // The outlines take a millisecond, and most feet are apart by their boxes.
  const box = boxAround(robot, limb);
  const near = limbs.filter(
    (other) => other.kind === "leg" && other !== limb && box.intersectsBox(boxAround(robot, other)),
  );
  if (near.length === 0) return false;
  const own = footOf(robot, limb);
  return near
    .map((other) => footOf(robot, other))
    .some((other) => own.low < other.high && other.low < own.high && overlap(own.outline, other.outline));
}
