import assert from "node:assert/strict";
import { test } from "node:test";
import { csvText, jsonText, motionOf } from "../src/timeline/formats.ts";
import { Motion } from "../src/timeline/motion.ts";
import { Refused } from "../src/values/literals.ts";
import { ABOUT, GEARED } from "./small_robot.js";

const Q = ABOUT.neutral;
const MOTION = Motion.of(
  [0, 0.1 + 0.2, 1e-7 + 1],
  [
    [0.1, -1e-9, 0.3, 1 / 3, 2],
    [0, 0, 0, 0, -2],
    [1, 2, 3, 4, 5],
  ],
);

test("a file has the numbers to the last bit", () => {
  const [header, ...rows] = csvText(ABOUT, MOTION).trimEnd().split("\n");
  assert.equal(header.split(",").length, 1 + ABOUT.coordinates.length);
  rows.forEach((row, i) =>
    assert.deepEqual(row.split(",").map(Number), [MOTION.times[i], ...MOTION.at(MOTION.times[i])]),
  );
  const { times, keys, interpolation } = JSON.parse(jsonText(ABOUT, MOTION));
  assert.deepEqual([times, keys.flat(), interpolation], [MOTION.times, Array.from(MOTION.values), "linear"]);
  const smooth = new Motion(MOTION.times, MOTION.values, "smooth");
  assert.equal(JSON.parse(jsonText(ABOUT, smooth)).interpolation, "smooth");
});

test("a smooth motion is sampled in a file that knows straight lines only", () => {
  const smooth = new Motion(MOTION.times, MOTION.values, "smooth");
  const rows = csvText(ABOUT, smooth).trimEnd().split("\n").slice(1);
  assert.ok(rows.length > 45);
  for (const row of rows) {
    const [time, ...values] = row.split(",").map(Number);
    smooth.at(time).forEach((value, i) => assert.ok(Math.abs(values[i] - value) < 1e-12));
  }
});

test("a joint that follows a motor moves it by what it does itself", () => {
  const read = motionOf(GEARED, [{ name: "RHip", times: [0, 1], values: [0.375, 0.125] }], Q);
  assert.deepEqual([read.at(0)[2], read.at(1)[2]], [-0.5, 0]);
});

test("joints of one motor give it their mean, at all their times", () => {
  const track = (name, values, times = [0, 0.5, 1]) => ({ name, times, values });
  const tracks = [track("HeadYaw", [0, 2], [0, 1]), track("LHip", [0.1, 0.2, 0.3]), track("RHip", [0.3, 0.4, 0.5])];
  const read = motionOf(ABOUT, tracks, [9, 9, 9, 9, 9]);
  assert.deepEqual(Array.from(read.times), [0, 0.5, 1]);
  assert.equal(read.at(0.5)[0], 1);
  assert.ok(Math.abs(read.at(0)[2] - 0.2) < 1e-12);
  assert.equal(read.at(0)[4], 9);
});

test("joints that are unknown or given twice are refused", () => {
  const track = (name) => ({ name, times: [0], values: [1] });
  const cases = /** @type {[string[], RegExp][]} */ ([
    [["HaedYaw"], /nearest: HeadYaw/],
    [["__proto__"], /unknown joint/],
    [["HeadYaw", "HeadYaw"], /given twice/],
    [[], /^no joints/],
  ]);
  for (const [names, message] of cases) {
    assert.throws(
      () => motionOf(ABOUT, names.map(track), Q),
      (error) => error instanceof Refused && message.test(error.message),
    );
  }
});

test("a name that a header cannot hold is refused, and JSON takes it", () => {
  const odd = { ...ABOUT, coordinates: ABOUT.coordinates.map((one, i) => (i ? one : { ...one, joint: "a,b" })) };
  assert.throws(() => csvText(odd, MOTION), Refused);
  assert.ok(jsonText(odd, MOTION).includes('"a,b"'));
});
