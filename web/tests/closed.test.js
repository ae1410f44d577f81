import assert from "node:assert/strict";
import { test } from "node:test";
import { isClosed } from "../src/math/surfaces.ts";

const CORNERS = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1];
const OUTWARDS = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2];

test("a tetrahedron that faces outwards is closed", () => {
  assert.equal(isClosed(CORNERS, OUTWARDS), true);
});

test("corners that stand there once per face are the same corners", () => {
  const positions = OUTWARDS.flatMap((corner) => CORNERS.slice(3 * corner, 3 * corner + 3));
  assert.equal(isClosed(positions, null), true);
});

test("with a face missing, turned over, or all inside out it is not", () => {
  assert.equal(isClosed(CORNERS, OUTWARDS.slice(3)), false);
  assert.equal(isClosed(CORNERS, [0, 1, 2, ...OUTWARDS.slice(3)]), false);
  assert.equal(isClosed(CORNERS, [...OUTWARDS].reverse()), false);
});
