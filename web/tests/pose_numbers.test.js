import assert from "node:assert/strict";
import test from "node:test";
import { quaternionOf } from "../src/math/rotations.ts";
import { COPIES, poseNumbers } from "../src/pick/facts.ts";

/** By columns, as three.js has its matrices. */
const matrix = (rows, [x, y, z] = [0, 0, 0]) => ({
  elements: [0, 1, 2].flatMap((k) => [...rows.map((row) => row[k]), 0]).concat([x, y, z, 1]),
});

const ONE = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];

test("no turn is the quaternion (1, 0, 0, 0), with no axis", () => {
  const { quaternion, axis, angle } = poseNumbers(matrix(ONE));
  assert.deepEqual(quaternion, [1, 0, 0, 0]);
  assert.deepEqual(axis, [0, 0, 0]);
  assert.equal(angle, 0);
});

test("half turns about each axis have a quaternion with a positive first number", () => {
  for (const [k, flipped] of [
    [1, [1, -1, -1]],
    [2, [-1, 1, -1]],
    [3, [-1, -1, 1]],
  ]) {
    const quaternion = quaternionOf(matrix(ONE.map((row, i) => row.map((value) => value * flipped[i]))));
    assert.deepEqual(
      quaternion,
      [0, 1, 2, 3].map((i) => (i === k ? 1 : 0)),
    );
  }
});

test("a small turn keeps its digits", () => {
  const angle = 1e-9;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const pose = poseNumbers(
    matrix([
      [c, -s, 0],
      [s, c, 0],
      [0, 0, 1],
    ]),
  );
  assert.ok(Math.abs(pose.angle / angle - 1) < 1e-12);
  assert.deepEqual(pose.axis, [0, 0, 1]);
});

test("what is copied has every digit, and no minus zero", () => {
  const pose = poseNumbers(matrix(ONE, [0.1, -0, 1 / 3]));
  const [array, position6d, rpy, quaternion] = COPIES.map(({ text }) => text(pose));
  assert.equal(array, "np.array([[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0.3333333333333333], [0, 0, 0, 1]])");
  assert.equal(position6d, "[0.1, 0, 0.3333333333333333, 0, 0, 0]");
  assert.equal(rpy, "[0, 0, 0]");
  assert.equal(quaternion, "[1, 0, 0, 0]");
});

test("of the two quaternions of a rotation the one with a positive first number is given", () => {
  for (const [axis, angle] of [
    [[1, 0, 0], 3],
    [[-1, 0, 0], 3],
    [[0, -0.6, 0.8], 2.5],
    [[-0.48, 0.6, -0.64], 2],
  ]) {
    const [c, s] = [Math.cos(angle / 2), Math.sin(angle / 2)];
    const [x, y, z] = axis.map((value) => value * s);
    const quaternion = quaternionOf(
      matrix([
        [1 - 2 * (y * y + z * z), 2 * (x * y - c * z), 2 * (x * z + c * y)],
        [2 * (x * y + c * z), 1 - 2 * (x * x + z * z), 2 * (y * z - c * x)],
        [2 * (x * z - c * y), 2 * (y * z + c * x), 1 - 2 * (x * x + y * y)],
      ]),
    );
    quaternion.forEach((value, i) => assert.ok(Math.abs(value - [c, x, y, z][i]) < 1e-15, `${quaternion}`));
  }
});
