import assert from "node:assert/strict";
import test from "node:test";
import { Gaze, Head } from "../src/ik/head.ts";
import {
  areInside,
  assertBlamed,
  assertClose,
  assertLeastOutside,
  assertSorted,
  forwardIn,
  hasBranch,
  numbersOf,
  placeIn,
  poseOf,
  randomValues,
  unlimited,
} from "./chains.js";

const [YAW, PITCH] = [0, 1];
const numbers = numbersOf("Head");
const head = new Head(numbers);

// All pairs of a yaw and a pitch inside the limits, some hundredths of a radian apart.
const GRID = Array.from({ length: 80 }, (_, i) => numbers.lower[YAW] + (i / 79) * (2 * numbers.upper[YAW])).flatMap(
  (yaw) => Array.from({ length: 40 }, (_, j) => [yaw, -0.68 + (j / 39) * 1.2]),
);
const BESIDE = [-1e-2, -1e-3, -1e-4, 1e-4, 1e-3, 1e-2];

// Joint values inside the limits that are a little beside others.
const around = ([yaw, pitch]) =>
  [0, ...BESIDE]
    .flatMap((dy) => [0, ...BESIDE].map((dp) => [yaw + dy, pitch + dp]))
    .filter((q) => areInside(numbers, q, 0));

const INSIDE = GRID.filter((q) => areInside(numbers, q));

// The angle of the rotation from one pose to another, from the trace.
function angleBetween(T, other) {
  const trace = [0, 1, 2, 4, 5, 6, 8, 9, 10].reduce((sum, i) => sum + T[i] * other[i], 0);
  return Math.acos(Math.min(1, 0.5 * (trace - 1)));
}

// The angle by which a camera misses a point, and whether the point is before it.
function missed(limb, values, point) {
  const T = poseOf(limb, values);
  const to = point.map((value, i) => value - placeIn(T)[i]);
  const along = to.reduce((sum, value, i) => sum + value * forwardIn(T)[i], 0);
  const across = Math.sqrt(Math.max(0, to.reduce((sum, value) => sum + value * value, 0) - along * along));
  return Math.atan2(across, along);
}

test("an orientation of the head is made by one yaw and pitch", () => {
  for (const q of randomValues(numbers, 200, 1)) {
    const T = poseOf(numbers, q);
    assertClose(head.solve(T, [0, 0], false).branches[0].values, q);
    const answer = head.solve(T, [0, 0]);
    assert.equal(answer.branches.length, areInside(numbers, q, 0) ? 1 : 0);
    if (answer.branches.length > 0) assertClose(answer.branches[0].values, q);
    else assert.equal(answer.reason, "COUPLED_LIMIT");
  }
});

test("a frame that is turned in the head is turned back", () => {
  const turned = { ...numbersOf("CameraTop"), kind: "head" };
  const q = [0.4, -0.2];
  assertClose(new Head(turned).solve(poseOf(turned, q), [0, 0]).branches[0].values, q);
});

test("what leans to a side or is outside the limits gets the nearest orientation inside them", () => {
  const leaning = poseOf(numbers, [0.4, 0.1]);
  // Turned by 0.2 about its own x axis.
  const [c, s] = [Math.cos(0.2), Math.sin(0.2)];
  for (const row of [0, 4, 8]) {
    const [y, z] = [leaning[row + 1], leaning[row + 2]];
    [leaning[row + 1], leaning[row + 2]] = [c * y + s * z, c * z - s * y];
  }
  const answers = [head.solve(leaning, [0, 0])];
  assertBlamed(answers[0], "NOT_ENOUGH_JOINTS", -1, 0, 0);
  const turned = poseOf(numbers, [numbers.upper[YAW] + 0.1, -0.1]);
  answers.push(head.solve(turned, [0, 0]));
  assertBlamed(answers[1], "JOINT_LIMIT", YAW, numbers.upper[YAW] + 0.1, numbers.upper[YAW]);
  [leaning, turned].forEach((T, i) => {
    const { values, error } = answers[i].nearest;
    assert.ok(areInside(numbers, values));
    assert.ok(Math.abs(error - angleBetween(poseOf(numbers, values), T)) < 1e-7);
    assert.ok([...INSIDE, ...around(values)].every((q) => error <= angleBetween(poseOf(numbers, q), T) + 1e-9));
  });
});

test("a table that is wider than the range of HeadPitch widens nothing", () => {
  const table = { joint: PITCH, of: YAW, at: [-3, 3], lower: [-2, -2], upper: [2, 2] };
  const wide = new Head({ ...numbers, table });
  const { values } = wide.solve(poseOf(numbers, [0.2, 1]), [0, 0]).nearest;
  assertClose(values, [0.2, numbers.upper[PITCH]], 1e-7);
});

test("HeadYaw leaves HeadPitch less than its own range", () => {
  const { at, upper } = numbers.table;
  const bend = upper.indexOf(Math.min(...upper));
  const q = [at[bend], upper[bend] + 0.01];
  assertBlamed(head.solve(poseOf(numbers, q), q), "COUPLED_LIMIT", PITCH, q[PITCH], upper[bend]);
});

test("a matrix that is not a pose is refused", () => {
  assertBlamed(head.solve(new Array(16).fill(1), [0, 0]), "NOT_RIGID", -1, 0, 0);
});

for (const camera of ["CameraTop", "CameraBottom"]) {
  const cameraNumbers = numbersOf(camera);
  const gaze = new Gaze(cameraNumbers);

  test(`${camera} looks at points, and at the one on its axis as it was`, () => {
    for (const [i, q] of randomValues(cameraNumbers, 200, 2).entries()) {
      const T = poseOf(cameraNumbers, q);
      const point = placeIn(T).map((value, k) => value + (0.1 + 0.02 * i) * forwardIn(T)[k]);
      const all = gaze.solveGaze(point, q, false);
      assertSorted(all);
      assertClose(all.branches[0].values, q);
      for (const { values } of all.branches) assert.ok(missed(cameraNumbers, values, point) < 1e-7);
      const answer = gaze.solveGaze(point, [0, 0]);
      assert.equal(hasBranch(answer, q), areInside(cameraNumbers, q, 0));
      assert.ok(answer.branches.every(({ values }) => areInside(cameraNumbers, values)));
    }
  });

  test(`${camera} looks as near as it can past a point behind the robot`, () => {
    for (const point of [
      [-1, 0.3, 0.2],
      [-0.5, -0.4, 1],
      [0.02, 0.3, -0.5],
    ]) {
      const { branches, nearest } = gaze.solveGaze(point, [0, 0]);
      assert.equal(branches.length, 0);
      assert.ok(areInside(cameraNumbers, nearest.values));
      assertClose([nearest.error], [missed(cameraNumbers, nearest.values, point)], 1e-7);
      const others = [...INSIDE, ...around(nearest.values)];
      assert.ok(others.every((q) => nearest.error <= missed(cameraNumbers, q, point) + 1e-9));
    }
  });

  test(`${camera} names the joint of the look that is least outside`, () => {
    for (const q of randomValues(unlimited(cameraNumbers), 300, 5)) {
      const T = poseOf(cameraNumbers, q);
      const point = placeIn(T).map((value, k) => value + 0.5 * forwardIn(T)[k]);
      const answer = gaze.solveGaze(point, [0, 0]);
      if (answer.branches.length === 0) assertLeastOutside(gaze, answer, gaze.solveGaze(point, [0, 0], false));
    }
  });

  test(`${camera} cannot look at what is nearer to the neck than itself`, () => {
    const { neck, place } = cameraNumbers.geometry;
    const [x, y, z] = neck;
    const radius = Math.hypot(...place);
    const answer = gaze.solveGaze([x + 0.01, y, z], [0, 0]);
    assertBlamed(answer, "OUT_OF_REACH", -1, radius - 0.01, 0);
    assert.ok(answer.nearest);
    assert.equal(gaze.solveGaze([x, y, z], [0, 0]).nearest, undefined);
  });

  test(`above ${camera} any yaw will do: that of the reference, or the nearest that allows the pitch`, () => {
    const point = [0, 0, 2];
    const [{ values, family }] = gaze.solveGaze(point, [0.4, -1.5], false).branches;
    assert.equal(family, "YAW_AXIS");
    assert.equal(values[YAW], 0.4);
    const pitch = values[PITCH];
    // A table that lets the head look up from a yaw of 0.5 on, half way between two bends.
    const table = {
      joint: PITCH,
      of: YAW,
      at: [-1, 0, 1],
      lower: [pitch + 0.2, pitch + 0.2, pitch - 0.2],
      upper: [1, 1, 1],
    };
    const bent = new Gaze({ ...unlimited(cameraNumbers), table });
    assertClose(bent.solveGaze(point, [0.4, pitch]).branches[0].values, [0.5, pitch], 1e-9);
    assertClose(bent.solveGaze(point, [0.8, pitch]).branches[0].values, [0.8, pitch], 1e-9);
  });
}
