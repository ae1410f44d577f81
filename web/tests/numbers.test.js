import assert from "node:assert/strict";
import test from "node:test";

import { clamp, interpolate, squaredDistance } from "../src/math/numbers.ts";

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

test("a squared distance is the sum of the squares of the differences", () => {
  assert.equal(squaredDistance([1, 2, 3], [1, 4, 0]), 13);
  assert.equal(squaredDistance([], []), 0);
});
