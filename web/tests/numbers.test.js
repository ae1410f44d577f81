import assert from "node:assert/strict";
import test from "node:test";

import { allTurnedTowards, clamp, interpolate, squaredDistance, turnedTowards, wrapped } from "../src/math/numbers.ts";

const AT = [-1, 0, 2];
const VALUES = [5, 3, 7];

test("between two places the value is linear, at a bend it is the one given there", () => {
  AT.forEach((x, i) => assert.equal(interpolate(AT, VALUES, x), VALUES[i]));
  assert.equal(interpolate(AT, VALUES, -0.5), 4);
  assert.equal(interpolate(AT, VALUES, 1.5), 6);
});

test("outside of the places the value is constant", () => {
  for (const x of [-1.001, -1e300, -Infinity]) assert.equal(interpolate(AT, VALUES, x), 5);
  for (const x of [2.001, 1e300, Infinity]) assert.equal(interpolate(AT, VALUES, x), 7);
  for (const x of [0, 1, 2]) assert.equal(interpolate([1], [9], x), 9);
});

test("a value is clamped to the end that it is beyond", () => {
  assert.equal(clamp(2, -1, 1), 1);
  assert.equal(clamp(-2, -1, 1), -1);
  assert.equal(clamp(0.5, -1, 1), 0.5);
  assert.equal(clamp(0, 1, -1), -1);
});

test("of the two ends of a turn only π is kept", () => {
  assert.equal(wrapped(Math.PI), Math.PI);
  assert.equal(wrapped(-Math.PI), Math.PI);
  assert.equal(wrapped(0), 0);
  const beyond = wrapped(Math.PI + 1e-9);
  assert.ok(beyond > -Math.PI && beyond < -Math.PI + 1e-8);
  const below = wrapped(-Math.PI - 1e-9);
  assert.ok(below < Math.PI && below > Math.PI - 1e-8);
});

test("an angle is turned to within half a turn of another, either way round", () => {
  const turn = 2 * Math.PI;
  for (const [angle, near, expected] of [
    [0.5, 10, 0.5 + 2 * turn],
    [0.5, -10, 0.5 - 2 * turn],
    [10, 0.5, 10 - 2 * turn],
    [-10, 0.5, -10 + 2 * turn],
    [3, -3, 3 - turn],
    [-3, 3, -3 + turn],
    [1, 2, 1],
  ]) {
    assert.ok(Math.abs(turnedTowards(angle, near) - expected) < 1e-14);
  }
  // Half a turn away on either side, the one above is taken.
  assert.equal(turnedTowards(-Math.PI, 0), Math.PI);
  assert.equal(turnedTowards(Math.PI, 0), Math.PI);
  assert.deepEqual(allTurnedTowards([0, turn], [0.1, 0.1]), [0, 0]);
});

test("a squared distance is the sum of the squares of the differences", () => {
  assert.equal(squaredDistance([1, 2, 3], [1, 4, 0]), 13);
  assert.equal(squaredDistance([], []), 0);
});
