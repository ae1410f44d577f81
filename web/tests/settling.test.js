import assert from "node:assert/strict";
import test from "node:test";
import { depth, directions, extremes, settled, touching } from "../src/robot/settling.ts";

const box = (...half) =>
  Float64Array.from([0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) => half.map((h, k) => (i & (1 << k) ? h : -h))));

const near = (a, b, slack = 1e-9) =>
  a.forEach((value, i) => assert.ok(Math.abs(value - b[i]) < slack, `${a} is not ${b}`));

test("a box lies down on the side that it leans over most", () => {
  near(settled(box(1, 2, 3), [0, 0, 0], [1, 0.2, 0.1]), [1, 0, 0]);
  near(settled(box(1, 2, 3), [0, 0, 0], [-0.9, 0.1, 0.2]), [-1, 0, 0]);
  near(settled(box(1, 2, 3), [0, 0, 0], [0.05, 0.02, 1]), [0, 0, 1]);
});

test("a box that leans over its edge falls, one that does not stands again", () => {
  const edge = Math.atan2(1, 3); // half width over half height
  for (const [angle, up] of [
    [edge - 0.01, [0, 0, 1]],
    [edge + 0.01, [1, 0, 0]],
  ]) {
    near(settled(box(1, 1, 3), [0, 0, 0], [Math.sin(angle), 0.001, Math.cos(angle)]), up);
  }
});

test("a centre of mass beside what carries it rolls the box over", () => {
  near(settled(box(1, 1, 1), [0.9, 0, 1.5], [0, 0, 1]), [0, 0, 1]);
  near(settled(box(1, 1, 1), [1.1, 0, 0], [0, 0, 1]), [-1, 0, 0]);
});

test("every way that a body comes to rest has its centre of mass above what it touches the floor with", () => {
  const spread = directions(300);
  const ball = Float64Array.from(spread, (value, i) => value * [1, 0.7, 0.4][i % 3]);
  const centre = [0.1, -0.05, 0.08];
  for (let i = 0; i < spread.length; i += 30) {
    const begin = spread.slice(i, i + 3);
    const up = settled(ball, centre, begin);
    const height = (u) =>
      u[0] * centre[0] +
      u[1] * centre[1] +
      u[2] * centre[2] +
      depth(
        ball,
        u.map((x) => -x),
      );
    assert.ok(height(up) <= height([...begin]) + 1e-12);
    for (let k = 0; k < spread.length; k += 3) {
      const turned = [0, 1, 2].map((axis) => up[axis] + 1e-4 * spread[k + axis]);
      const length = Math.hypot(...turned);
      assert.ok(height(turned.map((x) => x / length)) > height(up) - 1e-9);
    }
    const down = up.map((x) => -x);
    assert.ok(touching(ball, depth(ball, down) - 1e-5, down, centre).length >= 3);
  }
});

test("the extremes of a grid are its corners, and none of what is inside", () => {
  const grid = Float64Array.from({ length: 3 * 343 }, (_, i) => Math.floor(i / 3 / 7 ** (i % 3)) % 7);
  const corners = extremes(grid, directions(500));
  assert.equal(corners.length, 3 * 8);
  assert.ok(corners.every((value) => value === 0 || value === 6));
});

test("no points have no extremes", () => {
  assert.equal(extremes(new Float64Array(0), directions(8)).length, 0);
});
