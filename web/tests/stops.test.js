import assert from "node:assert/strict";
import test from "node:test";
import { farthest } from "../src/drag/stops.ts";

// Coordinate 1 is coupled to 0: the range narrows from ±1 to ±0.5 as 0 goes from 0 to 2.
const about = {
  coordinates: [
    { joint: "yaw", column: 0, lower: -2, upper: 2, unit: "rad" },
    { joint: "pitch", column: 1, lower: -1, upper: 1, unit: "rad" },
    { joint: "wheel", column: 2, lower: null, upper: null, unit: "rad" },
  ],
  tables: [{ joint: 1, of: 0, at: [-2, 0, 2], lower: [-0.5, -1, -0.5], upper: [0.5, 1, 0.5] }],
};

test("inside its range a coordinate goes where it is wanted", () => {
  assert.deepEqual(farthest(about, [0, 0, 0], 0, 1.5), { value: 1.5, stop: null });
});

test("at the end of its range it stops", () => {
  const { value, stop } = farthest(about, [0, 0, 0], 0, -3);
  assert.equal(value, -2);
  assert.deepEqual(stop, { column: 0, bound: -2, upper: false, coupled: false });
});

test("at a coupled range it stops, and the table is named as the reason", () => {
  const { value, stop } = farthest(about, [1, 0, 0], 1, 2);
  assert.equal(value, 0.75);
  assert.deepEqual(stop, { column: 1, bound: 0.75, upper: true, coupled: true });
});

test("it stops where the range of a partner would leave the partner out", () => {
  for (const [pitch, sign] of [
    [0.75, 1],
    [-0.75, 1],
    [0.75, -1],
  ]) {
    const { value, stop } = farthest(about, [0, pitch, 0], 0, sign * 1.8);
    assert.equal(value, sign);
    assert.deepEqual(stop, { column: 1, bound: pitch, upper: pitch > 0, coupled: true });
  }
});

test("the bend of a table between here and there is not jumped over", () => {
  assert.equal(farthest(about, [-1, 0.75, 0], 0, 1.9).value, 1);
});

test("a partner that is outside already gets no farther out, and may come back", () => {
  assert.equal(farthest(about, [1, 0.9, 0], 0, 1.5).value, 1);
  assert.equal(farthest(about, [1, 0.9, 0], 0, 0.5).value, 0.5);
});

test("a coordinate that is outside comes back, and goes no farther out", () => {
  assert.equal(farthest(about, [2.5, 0, 0], 0, 2.7).value, 2.5);
  assert.equal(farthest(about, [2.5, 0, 0], 0, 2.2).value, 2.2);
  assert.equal(farthest(about, [2.5, 0, 0], 0, 1.2).value, 1.2);
});

test("without limits there is no stop", () => {
  assert.deepEqual(farthest(about, [0, 0, 0], 2, 50), { value: 50, stop: null });
});
