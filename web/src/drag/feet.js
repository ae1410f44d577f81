import { convexHull, overlap } from "../math/polygon.js";
import { THREE } from "../three.js";

/** @typedef {import("./types.js").Limb} Limb */
/** @typedef {{ low: number, high: number, outline: import("../math/polygon.js").Point[] }} Foot */

/**
 * The shapes of a leg's last link.
 *
 * @param {import("../robot/robot.js").Robot} robot
 * @param {Limb} limb
 */
function shapesOf(robot, limb) {
  const foot = robot.linkOf(limb.joints[limb.joints.length - 1]);
  return robot.meshes.filter(({ link }) => link === foot);
}

/**
 * The outline of a leg's last link from above, and its lowest and highest vertex, in the world of three.js.
 *
 * @param {import("../robot/robot.js").Robot} robot
 * @param {Limb} limb
 * @returns {Foot}
 */
export function footOf(robot, limb) {
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

/**
 * A box around a foot in the world of three.js, not the least one: that of its shapes' own boxes.
 *
 * @param {import("../robot/robot.js").Robot} robot
 * @param {Limb} limb
 */
function boxAround(robot, limb) {
  const box = new THREE.Box3();
  for (const { mesh } of shapesOf(robot, limb)) {
    if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
    const own = /** @type {THREE.Box3} */ (mesh.geometry.boundingBox).clone();
    box.union(own.applyMatrix4(mesh.matrixWorld));
  }
  return box;
}

/**
 * Whether a foot is where that of another leg is: their outlines from above, and their heights.
 *
 * @param {import("../robot/robot.js").Robot} robot
 * @param {Limb} limb the leg of the foot
 * @param {Limb[]} limbs
 */
export function feetCross(robot, limb, limbs) {
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
