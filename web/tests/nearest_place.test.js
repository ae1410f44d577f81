import assert from "node:assert/strict";
import test from "node:test";
import { LAST_STEP, directionsAround, nearestPlace } from "../src/drag/follow.ts";
import { distance } from "../src/math/rotations.ts";

const AROUND = directionsAround([1, 0, 0], [0, 1, 0]);

test("directions are unit vectors all around in the plane", () => {
  assert.equal(AROUND.length, 16);
  for (const direction of AROUND) {
    assert.ok(Math.abs(Math.hypot(...direction) - 1) < 1e-12);
    assert.equal(Math.abs(direction[2]), 0);
  }
});

test("the nearest place in a disc is on its edge, towards the target", () => {
  const isReached = (place) => Math.hypot(...place) <= 0.2;
  const place = nearestPlace([0.3, 0.4, 0], [0, 0, 0], AROUND, isReached);
  assert.ok(isReached(place));
  assert.ok(distance(place, [0.12, 0.16, 0]) < 100 * LAST_STEP);
});

test("where nothing is reached it stays, after a bounded number of tries", () => {
  let tries = 0;
  const place = nearestPlace([1, 0, 0], [0, 0, 0], AROUND, () => {
    tries += 1;
    return false;
  });
  assert.deepEqual(place, [0, 0, 0]);
  assert.ok(tries <= 100);
});
