import assert from "node:assert/strict";
import test from "node:test";

import { mirrored, rangeOf, unrounded } from "../src/values/configurations.ts";
import { History } from "../src/panel/past.ts";
import { matches, nearest } from "../src/values/names.ts";
import { USUAL, format, parse, spoken, stepped, stepsOfKey, unitOf } from "../src/values/units.ts";
import { ABOUT, Q } from "./small_robot.js";

const DEGREES = unitOf("rad", USUAL);
const RADIANS = unitOf("rad", { angle: "rad", length: "m" });
const key = (name, held = {}) => ({ key: name, shiftKey: false, ctrlKey: false, altKey: false, ...held });

test("a value is shown in the chosen unit, and zero without a sign", () => {
  assert.equal(format(Math.PI / 2, DEGREES), "90.0");
  assert.equal(format(-1e-9, DEGREES), "0.0");
  assert.equal(format(-1.23456, RADIANS), "−1.235");
  assert.equal(format(0.25, unitOf("m", USUAL)), "250.0");
  assert.equal(format(0.25, unitOf("m", { angle: "deg", length: "m" })), "0.2500");
  assert.equal(format(0.255, unitOf("1", USUAL)), "26");
  assert.equal(spoken(-0.5, RADIANS), "−0.500\u00a0rad");
  assert.equal(spoken(-Math.PI / 4, DEGREES), "−45.0°");
});

test("typed numbers take a comma, a unit and a minus sign of print, and nothing else", () => {
  assert.equal(parse(" 12,5 ", RADIANS), 12.5);
  assert.equal(parse("−3 RAD", RADIANS), -3);
  assert.equal(parse("90°", DEGREES), Math.PI / 2);
  assert.equal(parse("1e2", RADIANS), 100);
  for (const text of [
    "",
    "x",
    "0x10",
    "1,2,3",
    "1e999",
    "Infinity",
    "NaN",
    "--1",
    "1 2",
    "1".repeat(1000),
    "0".repeat(41),
    "1m",
  ]) {
    assert.ok(Number.isNaN(parse(text, RADIANS)), text);
  }
});

test("arrow keys mean one step, ten with Shift, a tenth with Ctrl or Alt", () => {
  assert.equal(stepsOfKey(key("ArrowUp")), 1);
  assert.equal(stepsOfKey(key("ArrowLeft", { shiftKey: true })), -10);
  assert.equal(stepsOfKey(key("ArrowRight", { ctrlKey: true })), 0.1);
  assert.equal(stepsOfKey(key("ArrowDown", { altKey: true })), -0.1);
  assert.equal(stepsOfKey(key("PageDown")), -10);
  assert.equal(stepsOfKey(key("End")), Infinity);
  assert.ok(Number.isNaN(stepsOfKey(key("a"))));
  assert.equal(format(stepped(stepped(0, 0.1, DEGREES), 0.2, DEGREES), DEGREES, 12), "0.300000000000");
});

test("a coupled range is that of its table where the other joint stands", () => {
  assert.deepEqual(rangeOf(ABOUT, ABOUT.coordinates[1], [1, 0]), [-0.5, 0.35]);
  assert.deepEqual(rangeOf(ABOUT, ABOUT.coordinates[4], Q), [-Infinity, Infinity]);
  assert.deepEqual(rangeOf(ABOUT, { ...ABOUT.coordinates[1], lower: -0.4, upper: 0.3 }, [1, 0]), [-0.4, 0.3]);
});

test("mirrored twice a configuration is itself", () => {
  const image = mirrored(ABOUT, Q);
  assert.deepEqual(image, [-0.25, -1e-7, -0.5, -1.5, -0.05]);
  assert.deepEqual(mirrored(ABOUT, image), Q);
  assert.ok(Object.is(mirrored(ABOUT, [0, 0, 0, 0, 0])[0], 0));
});

test("what rounding took over a limit is put back, what is further outside stays", () => {
  assert.deepEqual(unrounded(ABOUT, [2.0000005, 0.2000004, 0.8, 0, 0], 1e-6), [2, 0.2, 0.8, 0, 0]);
});

test("undo and redo go back and forth, and a new step ends what was taken back", () => {
  const history = new History(3);
  for (const before of [0, 1, 2, 3]) history.push(before);
  assert.equal(history.undo(4), 3);
  assert.equal(history.undo(3), 2);
  assert.equal(history.redo(2), 3);
  assert.equal(history.undo(3), 2);
  assert.equal(history.undo(2), 1);
  assert.equal(history.undo(1), undefined);
  history.push(1);
  assert.equal(history.redo(9), undefined);
});

test("names are found by their words, and mistyped ones by their letters", () => {
  assert.ok(matches("LShoulderPitch", "pitch sh"));
  assert.ok(!matches("LShoulderPitch", "pitch x"));
  assert.ok(matches("LShoulderPitch", ""));
  assert.deepEqual(nearest("headyow", ["HeadYaw", "HeadPitch", "LKneePitch"], 1), ["HeadYaw"]);
  assert.deepEqual(nearest("x".repeat(10_000), ["HeadYaw"]), []);
});
