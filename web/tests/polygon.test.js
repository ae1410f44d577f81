import assert from "node:assert/strict";
import test from "node:test";
import { convexHull, inside, overlap } from "../src/math/surfaces.ts";

const square = (x, y, side = 1) => [
  { x, y },
  { x: x + side, y },
  { x: x + side, y: y + side },
  { x, y: y + side },
];

test("the hull of a square with points inside and on its edges is the square, counterclockwise", () => {
  const hull = convexHull([...square(0, 0), { x: 0.5, y: 0.5 }, { x: 0.5, y: 0 }, { x: 1, y: 0.2 }]);
  assert.deepEqual(hull, square(0, 0));
});

test("fewer than three points have no hull", () => {
  assert.deepEqual(
    convexHull([
      { x: 0, y: 0 },
      { x: 1, y: 1 },
    ]),
    [],
  );
});

test("a point on the edge is inside, one beside it is not", () => {
  assert.ok(inside(square(0, 0), { x: 1, y: 0.5 }));
  assert.ok(!inside(square(0, 0), { x: 1.001, y: 0.5 }));
});

test("outlines overlap where they share more than an edge", () => {
  assert.ok(overlap(square(0, 0), square(0.9, 0.9)));
  assert.ok(overlap(square(0, 0, 3), square(1, 1)));
  assert.ok(!overlap(square(0, 0), square(1.1, 0)));
  assert.ok(!overlap(square(0, 0), square(1, 0)));
  assert.ok(!overlap(square(0, 0), []));
});
