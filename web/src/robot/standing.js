import { THREE } from "../three.js";

// How far [m] both soles, or one alone, may be above the lowest point of the robot that stands on them.
const [BOTH, ONE] = [0.008, 0.003];
const VERTICAL = new THREE.Vector3(0, 0, 1);

/**
 * Put a robot with a fixed base onto the floor: with the given direction up, or on both soles, or on the one under
 * everything else, or with the trunk upright.
 *
 * @param {import("./robot.js").Robot} robot
 * @param {ArrayLike<number> | null} up direction in the root's frame
 */
export function stand(robot, up) {
  const turn = up ? upright(up) : (onSoles(robot) ?? upright([0, 0, 1]));
  robot.root.position.z = -lowestTurned(robot, turn);
  robot.root.updateWorldMatrix(true, true);
}

/** @param {ArrayLike<number>} up */
function upright(up) {
  return new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(up[0], up[1], up[2]), VERTICAL);
}

/**
 * The turn with which the robot stands on both soles, or on the one that turns it least; null if no sole is under it.
 *
 * @param {import("./robot.js").Robot} robot
 */
function onSoles(robot) {
  const soles = robot.about.soles.map((link) => {
    const pose = robot.pose(link);
    return {
      at: new THREE.Vector3().setFromMatrixPosition(pose),
      up: new THREE.Vector3().setFromMatrixColumn(pose, 2),
    };
  });
  /** @type {(feet: typeof soles, slack: number) => THREE.Quaternion | null} */
  const standingOn = (feet, slack) => {
    const up = feet.reduce((sum, foot) => sum.add(foot.up), new THREE.Vector3()).normalize();
    const turn = new THREE.Quaternion().setFromUnitVectors(up, VERTICAL);
    const lowest = lowestTurned(robot, turn);
    return feet.every(({ at }) => at.clone().applyQuaternion(turn).z < lowest + slack) ? turn : null;
  };
  const both = soles.length > 1 ? standingOn(soles, BOTH) : null;
  if (both) return both;
  const turns = soles.flatMap((sole) => standingOn([sole], ONE) ?? []);
  return turns.sort((a, b) => Math.abs(b.w) - Math.abs(a.w))[0] ?? null;
}

/**
 * Height of the lowest vertex with the root turned so, at the origin.
 *
 * @param {import("./robot.js").Robot} robot
 * @param {THREE.Quaternion} turn
 */
function lowestTurned(robot, turn) {
  robot.root.quaternion.copy(turn);
  robot.root.position.set(0, 0, 0);
  robot.root.updateWorldMatrix(true, true);
  return robot.lowest();
}
