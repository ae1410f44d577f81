import assert from "node:assert/strict";
import test from "node:test";
import { busiest, evenTimes, Motion, sampleTimes } from "../src/timeline/motion.ts";

// The first number stays, the second goes by 3, the third by 0.5, the fourth by 1.
const ROWS = [
  [7, 0, 0.5, 0],
  [7, 3, 0, -1],
  [7, 1, 0.25, 0],
];
const MOTION = Motion.of([1, 2, 5], ROWS);

test("the numbers with the largest ranges are plotted, in the order given", () => {
  assert.deepEqual(busiest(MOTION, [0, 1, 2, 3], 2), [1, 3]);
  assert.deepEqual(busiest(MOTION, [3, 2, 1, 0], 3), [3, 2, 1]);
  assert.deepEqual(busiest(MOTION, [0, 2], 1), [2]);
});

test("a motion is sampled at its own times, or evenly from its start to its end", () => {
  assert.deepEqual(sampleTimes(MOTION, 3), [1, 2, 5]);
  assert.deepEqual(sampleTimes(MOTION, 2), [1, 5]);
  assert.deepEqual(sampleTimes(Motion.of([1, 2, 5], ROWS, "smooth"), 5), [1, 2, 3, 4, 5]);
  const times = evenTimes(Motion.of([0.1, 0.7], ROWS.slice(1)), 50);
  assert.deepEqual([times.length, times[0], times[49]], [50, 0.1, 0.7]);
});
