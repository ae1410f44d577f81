import assert from "node:assert/strict";
import test from "node:test";
import { KeyFrames } from "../src/timeline/key_frames.ts";
import { MOST_LINKED, readKeys, readLink, writeKeys, writeLink } from "../src/values/link.ts";
import { Refused } from "../src/values/literals.ts";
import { ABOUT } from "./small_robot.js";

const KEYS = [
  { time: 0, q: [0.25, 0, -0.123457, 0.05, 1.5] },
  { time: 1.25, q: [0.25, 0, 0.1, 0, 1.5] },
  { time: 2, q: [-0.000001, 0, 0.1, 0, 0] },
];
const STATE = {
  q: KEYS[1].q,
  up: null,
  camera: "front",
  shown: [],
  units: { angle: "deg", length: "mm" },
  frame: "LHand",
};

test("key frames are written shortly and read as they were", () => {
  const shown = { frames: new KeyFrames(KEYS, "smooth"), time: 1.25 };
  const text = writeKeys(ABOUT, shown);
  assert.equal(text, "smooth:1.25:HeadYaw,LHip,LArm,RArm;0:5cwg,-2n9d,12kw,w5eo;1.25:,255s,0,;2:-1,,,0");
  assert.deepEqual(readKeys(ABOUT, text), shown);
  assert.deepEqual(readLink(ABOUT, [], writeLink(ABOUT, { ...STATE, keys: shown })).keys, shown);
});

test("a robot that stands at zero all along has keys too", () => {
  const shown = { frames: new KeyFrames([{ time: 0, q: [0, 0, 0, 0, 0] }]), time: 0 };
  assert.deepEqual(readKeys(ABOUT, writeKeys(ABOUT, shown)), shown);
});

test("a floating base comes along", () => {
  const about = { ...ABOUT, floating: true, coordinates: [{ joint: "HeadYaw", column: 7, lower: -2, upper: 2 }] };
  const robot = {
    ...about,
    joints: [{ ...ABOUT.joints[0], column: 7 }],
    neutral: [0, 0, 0, 0, 0, 0, 1, 0],
    tables: [],
  };
  const shown = { frames: new KeyFrames([{ time: 0, q: [1, 2, 3, 0, 0, 1, 0, 0.5] }]), time: 0 };
  assert.deepEqual(readKeys(robot, writeKeys(robot, shown)), shown);
  assert.throws(() => readKeys(robot, "linear:0:HeadYaw;0:1"), Refused);
});

test("sixty key frames of a robot of 25 joints have room, one more has not", () => {
  const coordinates = Array.from({ length: 25 }, (_, column) => ({ joint: `Joint${column}`, column, unit: "rad" }));
  const about = { ...ABOUT, coordinates, neutral: Array(25).fill(0) };
  const keys = Array.from({ length: MOST_LINKED + 1 }, (_, time) => ({
    time,
    q: coordinates.map(({ column }) => Math.sin(column + time)),
  }));
  assert.ok(writeKeys(about, { frames: new KeyFrames(keys.slice(1)), time: 0 })?.length < 9000);
  assert.equal(writeKeys(about, { frames: new KeyFrames(keys), time: 0 }), null);
  assert.ok(!writeLink(ABOUT, { ...STATE, keys: { frames: new KeyFrames(keys), time: 0 } }).includes("keys="));
});

test("a text that is not key frames is refused", () => {
  for (const [text, says] of [
    ["", /expected linear or smooth/],
    ["bezier:0:HeadYaw;0:1", /expected linear or smooth/],
    ["linear:0", /expected linear or smooth/],
    ["linear:0:HeadYaw:1;0:1", /expected linear or smooth/],
    ["linear:0:HeadYaw", /0 key frames, a link has 1 to 60/],
    [`linear:0:HeadYaw${";0:1".repeat(100)}`, /100 key frames/],
    ["linear:0:HeadYow;0:1", /unknown joint "HeadYow" \(nearest: HeadYaw/],
    ["linear:0:__proto__;0:1", /unknown joint "__proto__"/],
    ["linear:0:%E0%A4%A;0:1", /not valid in a link/],
    ["linear:0:HeadYaw,HeadYaw;0:1,1", /given twice/],
    ["linear:0:@,HeadYaw;0:1", /with a floating base/],
    ["linear:0:HeadYaw;0:1,2", /has 2 values, expected 1/],
    ["linear:0:HeadYaw;0:zzzzzzzz", /far outside/],
    ["linear:0:HeadYaw;0:zzzzzzzzz", /"zzzzzzzzz" is not a value/],
    ["linear:0:HeadYaw;0:NaN", /"NaN" is not a value/],
    ["linear:0:HeadYaw;0:</script>", /not a value/],
    ["linear:0:HeadYaw;1:1;1:2", /a key frame at 1 s follows one at 1 s/],
    ["linear:0:HeadYaw;-1:1", /the time of a key frame is "-1"/],
    ["linear:1e9:HeadYaw;0:1", /the time of a key frame is "1e9"/],
    ["linear:0:HeadYaw;3601:1", /expected 0 to 3600/],
  ]) {
    assert.throws(
      () => readKeys(ABOUT, text),
      (error) => error instanceof Refused && says.test(error.message),
      text,
    );
  }
});
