import assert from "node:assert/strict";
import { test } from "node:test";
import { csvText, jsonText, readMotion } from "../src/timeline/formats.ts";
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

test("what is written is read again to the last bit", () => {
  for (const text of [csvText(ABOUT, MOTION), jsonText(ABOUT, MOTION)]) {
    const read = readMotion(ABOUT, text, Q);
    assert.deepEqual(Array.from(read.times), MOTION.times);
    assert.deepEqual(Array.from(read.values), Array.from(MOTION.values));
    assert.equal(read.interpolation, "linear");
  }
  const smooth = new Motion(MOTION.times, MOTION.values, "smooth");
  assert.equal(readMotion(ABOUT, jsonText(ABOUT, smooth), Q).interpolation, "smooth");
});

test("a smooth motion is sampled in a file that knows straight lines only", () => {
  const smooth = new Motion(MOTION.times, MOTION.values, "smooth");
  const read = readMotion(ABOUT, csvText(ABOUT, smooth), Q);
  assert.ok(read.count > 45);
  for (const time of [...MOTION.times, 0.111, 0.7]) {
    smooth.at(time).forEach((value, i) => assert.ok(Math.abs(read.at(time)[i] - value) < 0.01));
  }
});

test("degrees, milliseconds, empty cells and joints of one motor are understood", () => {
  const text = "time [ms];HeadYaw [deg];LHip;RHip\n0;90;0.1;0.3\n500;;0.2;0.4\n1000;180;0.3;0.5\n";
  const read = readMotion(ABOUT, text, [9, 9, 9, 9, 9]);
  assert.deepEqual(Array.from(read.times), [0, 0.5, 1]);
  assert.ok(Math.abs(read.at(0.5)[0] - 0.75 * Math.PI) < 1e-12);
  assert.ok(Math.abs(read.at(0)[2] - 0.2) < 1e-12);
  assert.equal(read.at(0)[4], 9);
  const own = '{"joint_names": ["HeadYaw", "LArm"], "times": [[0, 1], [0.5]], "keys": [[0, 2], [7]]}';
  assert.deepEqual(readMotion(ABOUT, own, Q).at(0.5).slice(0, 4), [1, 0, 0, 7]);
});

test("a joint that follows a motor moves it by what it does itself", () => {
  const read = readMotion(GEARED, "time,RHip\n0,0.375\n1,0.125\n", Q);
  assert.deepEqual([read.at(0)[2], read.at(1)[2]], [-0.5, 0]);
});

test("in a file of degrees a hand is a share all the same", () => {
  const joints = [...ABOUT.joints, { ...ABOUT.joints[0], name: "LHand", column: 3 }];
  const text = '{"units": {"angle": "deg"}, "joint_names": ["HeadYaw", "LHand"], "times": [0], "keys": [[180, 0.5]]}';
  const read = readMotion({ ...ABOUT, joints }, text, Q);
  assert.deepEqual(read.at(0), [Math.PI, 0, 0, 0.5, 0]);
});

test("a file that is no motion is refused in one line that says where", () => {
  const cases = /** @type {[string, RegExp][]} */ ([
    ["", /^empty/],
    ["time,HeadYaw\n0,0\n1,abc\n", /^line 3, column 2: HeadYaw is "abc", expected a finite number/],
    ["time,HeadYaw\n0,0\n0,1\n", /^line 3: time 0 s does not come after 0 s/],
    ["time,HeadYaw\n0,0,3\n", /^line 2: 3 values/],
    ["time,HeadYaw\n0,1e999\n", /^line 2, column 2/],
    ["time,HeadYaw\n,1\n", /^line 2: a row without a time/],
    ["time,HeadYaw [mile]\n0,1\n", /^line 1, column 2: unit "mile"/],
    ["HeadYaw\n1\n", /^line 1: 0 columns of times/],
    ["time,HaedYaw\n0,1\n", /nearest: HeadYaw/],
    ["time,__proto__\n0,1\n", /unknown joint/],
    ["time,HeadYaw,HeadYaw\n0,1,1\n", /given twice/],
    ['{"joint_names": ["HeadYaw"],\n "times": [0],\n "keys": [[0]', /^line 3: malformed JSON/],
    ['{"joint_names": ["HeadYaw"], "times": [0], "keys": [["x"]]}', /^keys\[0\]\[0\] is "x"/],
    ['{"joint_names": ["HeadYaw"], "times": [0, 0], "keys": [[1], [2]]}', /^times\[1\] is 0, which does not/],
    ['{"joint_names": ["HeadYaw"], "times": [0], "keys": [[1, 2]]}', /expected 1/],
    ['{"joint_names": ["HeadYaw"], "interpolation": "bezier", "times": [0], "keys": [[1]]}', /Bézier/],
    ['{"times": [0], "keys": [[1]]}', /^joint_names is missing/],
    ["[1, 2]", /^expected an object/],
    [`time,HeadYaw\n${"0,1\n".repeat(60_000)}`, /more than 50000/],
  ]);
  for (const [text, message] of cases) {
    assert.throws(
      () => readMotion(ABOUT, text, Q),
      (error) => error instanceof Refused && message.test(error.message) && !error.message.includes("\n"),
      text.slice(0, 80),
    );
  }
});

test("a name that a header cannot hold is refused, and JSON takes it", () => {
  const odd = { ...ABOUT, coordinates: ABOUT.coordinates.map((one, i) => (i ? one : { ...one, joint: "a,b" })) };
  assert.throws(() => csvText(odd, MOTION), Refused);
  assert.ok(jsonText(odd, MOTION).includes('"a,b"'));
});
