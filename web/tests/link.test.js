import assert from "node:assert/strict";
import test from "node:test";
import { readLink, writeLink } from "../src/values/link.ts";
import { Refused } from "../src/values/literals.ts";
import { ABOUT } from "./small_robot.js";

const TOGGLES = ["frames", "axes", "com"];
const STATE = {
  q: [0.25, 0, -0.123457, 0.05, 1.5],
  up: [0, -1, 0],
  camera: "three-quarter",
  shown: ["axes", "com"],
  units: { angle: "rad", length: "mm" },
  frame: "a, b & c=d",
};

test("a link says all of a state, shortly", () => {
  const text = writeLink(ABOUT, STATE);
  assert.equal(
    text,
    "v=1&q=HeadYaw:0.25,LHip:-0.123457,LArm:0.05,RArm:1.5&up=0,-1,0&camera=three-quarter&show=axes,com&units=rad,mm" +
      "&frame=a%2C%20b%20%26%20c%3Dd",
  );
  assert.deepEqual(readLink(ABOUT, TOGGLES, text), STATE);
});

test("a camera that no preset gives is six numbers", () => {
  const camera = [1, -2, 0.5, 0, 0.1, 0];
  assert.deepEqual(readLink(ABOUT, TOGGLES, writeLink(ABOUT, { ...STATE, camera })).camera, camera);
});

test("a floating base comes along", () => {
  const about = { ...ABOUT, floating: true, coordinates: [{ joint: "HeadYaw", column: 7, lower: -2, upper: 2 }] };
  const [base, joints] = [{ joints: [{ ...ABOUT.joints[0], column: 7 }] }, [1, 2, 3, 0, 0, 1, 0, 0.5]];
  const text = writeLink({ ...about, ...base }, { ...STATE, q: joints, up: null, frame: "LHand" });
  const read = readLink({ ...about, ...base, neutral: [0, 0, 0, 0, 0, 0, 1, 0] }, TOGGLES, text);
  assert.deepEqual(read.q, joints);
});

test("a base may stand before the joints, and needs an orientation", () => {
  const about = {
    ...ABOUT,
    floating: true,
    neutral: [0, 0, 0, 0, 0, 0, 1, 0],
    joints: [{ ...ABOUT.joints[0], column: 7 }],
    coordinates: [{ joint: "HeadYaw", column: 7, lower: -2, upper: 2 }],
  };
  const { q } = readLink(about, TOGGLES, "v=1&base=1,2,3,0,0,0,1&q=HeadYaw:0.5");
  assert.deepEqual(q, [1, 2, 3, 0, 0, 0, 1, 0.5]);
  assert.throws(() => readLink(about, TOGGLES, "v=1&base=1,2,3,0,0,0,0"), /a base with no orientation/);
});

test("a link of nothing but its version changes nothing", () => {
  assert.deepEqual(readLink(ABOUT, TOGGLES, "v=1"), {});
});

test("a text that is not a state is refused", () => {
  for (const [text, says] of [
    ["joints", /"joints" is not a state/],
    ["v=2&q=", /"v=2&q=" is not a state/],
    ["v=1&speed=3", /unknown field "speed"/],
    ["v=1&__proto__=3", /unknown field "__proto__"/],
    ["v=1&q=HeadYow:1", /unknown joint "HeadYow" \(nearest: HeadYaw/],
    ["v=1&q=HeadYaw:NaN", /HeadYaw is "NaN"/],
    ["v=1&q=HeadYaw:1e300", /HeadYaw is "1e300"/],
    ["v=1&q=HeadYaw:99999", /far outside/],
    ["v=1&q=HeadYaw:1,HeadYaw:2", /given twice/],
    ["v=1&q=%E0%A4%A:1", /not valid in a link/],
    ["v=1&up=0,0,0", /no direction/],
    ["v=1&up=0,0", /expected 3 numbers/],
    ["v=1&up=0,,1", /expected 3 numbers/],
    ["v=1&up=0,1e9,1", /expected 3 numbers/],
    ["v=1&up=0,Infinity,1", /expected 3 numbers/],
    ["v=1&base=0,0,0,0,0,0,1", /does not have/],
    ["v=1&camera=above", /unknown camera "above"/],
    ["v=1&camera=1,1,1,1,1,1", /looks at its own position/],
    ["v=1&show=axes,bones", /unknown overlay "bones"/],
    ["v=1&units=deg,inch", /expected deg or rad/],
    ["v=1&frame=x", /unknown frame "x"/],
  ]) {
    assert.throws(
      () => readLink(ABOUT, TOGGLES, text),
      (error) => error instanceof Refused && says.test(error.message),
      text,
    );
  }
});
