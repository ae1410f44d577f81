import assert from "node:assert/strict";
import { test } from "node:test";

import { doOverlap } from "../src/math/hulls.ts";

const at = (x, y, z) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];
const hull = (points, pose, radius = 0) => ({ points: Float64Array.from(points.flat()), pose, radius });
const CUBE = [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => [x, y, z])));
const turned = (angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return (x, y, z) => [c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, x, y, z, 1];
};
const start = () => Float64Array.of(0.3, -0.2, 0.9);

test("cubes overlap up to the distance at which they touch", () => {
  for (const [gap, expected] of [
    [-1e-6, true],
    [1e-6, false],
  ]) {
    assert.equal(doOverlap(hull(CUBE, at(0, 0, 0)), hull(CUBE, at(2 + gap, 0.3, -0.4)), start()), expected);
    // An edge against a face.
    const edge = 1 + Math.SQRT2 + gap;
    assert.equal(doOverlap(hull(CUBE, at(0, 0, 0)), hull(CUBE, turned(Math.PI / 4)(edge, 0.1, 0)), start()), expected);
  }
});

test("balls and capsules have a radius", () => {
  const capsule = [
    [0, 0, -1],
    [0, 0, 1],
  ];
  for (const [gap, expected] of [
    [-1e-6, true],
    [1e-6, false],
  ]) {
    const ball = hull([[0, 0, 0]], at(0.5 + gap, 0, 0.7), 0.3);
    assert.equal(doOverlap(hull(capsule, at(0, 0, 0), 0.2), ball, start()), expected);
    assert.equal(doOverlap(hull(CUBE, at(0, 0, 0)), hull([[0, 0, 0]], at(0, 1.3 + gap, 0), 0.3), start()), expected);
  }
  assert.ok(doOverlap(hull(CUBE, at(0, 0, 0)), hull([[0, 0, 0]], at(0, 0.2, 0), 0.1), start()));
});

test("a search that begins with the last direction gives the same answer", () => {
  const away = start();
  for (let i = 0; i <= 400; i++) {
    const angle = i / 60;
    const place = turned(angle)(1 + 2.2 * Math.abs(Math.sin(i / 9)), 0.4 * Math.cos(i), 0.2);
    const [one, other] = [hull(CUBE, at(0, 0, 0)), hull(CUBE, place)];
    assert.equal(doOverlap(one, other, away), doOverlap(one, other, start()), `step ${i}`);
  }
});
