import assert from "node:assert/strict";
import { test } from "node:test";
import { GAP, KeyFrames, LATEST, excesses, slowedTimes } from "../src/timeline/key_frames.ts";
import { Motion } from "../src/timeline/motion.ts";
import { Recorder, thinned } from "../src/timeline/recorder.ts";

const TIMES = [0, 1, 3, 3.5];
const ROWS = [
  [0, 1],
  [1, 3],
  [4, 2],
  [5, 2],
];

test("a motion goes through its keys and stands still outside of them", () => {
  for (const interpolation of /** @type {const} */ (["linear", "smooth"])) {
    const motion = Motion.of(TIMES, ROWS, interpolation);
    TIMES.forEach((time, i) => assert.deepEqual(motion.at(time), ROWS[i]));
    assert.deepEqual(motion.at(-1), ROWS[0]);
    assert.deepEqual(motion.at(9), ROWS[3]);
  }
});

test("straight lines lie between linear keys", () => {
  const motion = Motion.of(TIMES, ROWS);
  assert.deepEqual(motion.at(2), [2.5, 2.5]);
  assert.equal(motion.segment(1), 1);
  assert.ok(Math.abs(motion.fastest(1, 0) - 1.5) < 1e-12);
});

test("a smooth motion starts and ends at rest, and never leaves the range of two keys", () => {
  const motion = Motion.of(TIMES, ROWS, "smooth");
  const step = 1e-6;
  assert.ok(Math.abs(motion.at(step)[0]) < 1e-10);
  assert.ok(Math.abs(motion.at(3.5 - step)[0] - 5) < 1e-10);
  for (let time = 1; time <= 3; time += 0.01) {
    const [a, b] = motion.at(time);
    assert.ok(a >= 1 && a <= 4 && b >= 2 && b <= 3);
  }
});

test("a smooth motion passes a key at the slope that Fritsch and Butland give it", () => {
  // scipy's PchipInterpolator through the same keys has these slopes inside.
  const motion = Motion.of(TIMES, ROWS, "smooth");
  for (const [time, slope] of [
    [1, 1.173913043478261],
    [3, 1.7647058823529411],
  ]) {
    for (const step of [-1e-6, 1e-6]) {
      assert.ok(Math.abs((motion.at(time + step)[0] - motion.at(time)[0]) / step - slope) < 1e-5);
    }
  }
});

test("the fastest speed of a smooth segment is that of its samples", () => {
  const motion = Motion.of(TIMES, ROWS, "smooth");
  for (let segment = 0; segment < 3; segment++) {
    let most = 0;
    const width = TIMES[segment + 1] - TIMES[segment];
    for (let i = 0; i < 4000; i++) {
      const [from, to] = [i, i + 1].map((k) => motion.at(TIMES[segment] + (k / 4000) * width)[0]);
      most = Math.max(most, (Math.abs(to - from) * 4000) / width);
    }
    assert.ok(Math.abs(motion.fastest(segment, 0) - most) < 1e-3 * most, `${segment}`);
  }
});

test("a key is put where there is room, in order of time", () => {
  let frames = new KeyFrames();
  assert.equal(frames.motion, null);
  frames = frames.adding(1, [1]).frames;
  frames = frames.adding(0.5, [0.5]).frames;
  const beside = frames.adding(0.5001, [2]);
  assert.ok(Math.abs(Math.abs(beside.frames.keys[beside.place].time - 0.5) - GAP) < 1e-9);
  const moved = frames.moving(0, 2);
  assert.deepEqual([moved.place, moved.frames.keys.map(({ time }) => time)], [1, [1, 2]]);
  assert.deepEqual(frames.moving(1, -3).frames.keys[0].time, 0);
  assert.equal(frames.keys.length, 2);
});

test("no key comes after an hour, however many are put there", () => {
  let frames = new KeyFrames().adding(LATEST, [0]).frames;
  for (let i = 0; i < 4; i++) frames = frames.duplicating(0).frames;
  assert.equal(frames.count, 5);
  frames.keys.forEach(({ time }, i) => assert.ok(Math.abs(time - (LATEST - (4 - i) * GAP)) < 1e-9, `${time}`));
});

test("a key that is added on another one stands a second behind the last", () => {
  const frames = new KeyFrames().adding(0, [1]).frames.adding(2, [1]).frames;
  assert.equal(frames.nextTime(0), 3);
  assert.equal(frames.nextTime(2.001), 3);
  assert.equal(frames.nextTime(1), 1);
  assert.equal(frames.duplicating(0).frames.keys[2].time, 3);
});

test("what is too fast is found, and slowed down until it is not", () => {
  for (const interpolation of /** @type {const} */ (["linear", "smooth"])) {
    const motion = Motion.of(TIMES, ROWS, interpolation);
    assert.deepEqual(excesses(motion, [null, null]), []);
    const found = excesses(motion, [0.5, null]);
    assert.deepEqual(
      found.map(({ segment }) => segment),
      [0, 1, 2],
    );
    if (interpolation === "linear") assert.ok(Math.abs(found[1].needs - 6) < 1e-9);
    const times = slowedTimes(motion, [0.5, 0.3]);
    assert.deepEqual(excesses(Motion.of(times, ROWS, interpolation), [0.5, 0.3]), []);
    assert.equal(times[0], 0);
  }
});

test("samples on straight lines thin out to the corners", () => {
  const times = Array.from({ length: 201 }, (_, i) => i / 100);
  const motion = Motion.of(
    times,
    times.map((time) => [Math.min(time, 1), 0.5]),
  );
  assert.deepEqual(Array.from(thinned(motion, 1e-9, 500)?.times ?? []), [0, 1, 2]);
  assert.equal(thinned(motion, 1e-9, 3)?.count, 3);
  assert.equal(thinned(motion, 1e-9, 2), null);
  const noisy = Motion.of(
    times,
    times.map((_, i) => [i % 2, 0]),
  );
  assert.equal(thinned(noisy, 0.1, 100), null);
  const waving = Motion.of(
    times,
    times.map((time) => [Math.sin(5 * time), 0]),
  );
  const few = thinned(waving, 0.01, 500);
  assert.ok(few && few.count < 60);
  for (const time of times) assert.ok(Math.abs(few.at(time)[0] - Math.sin(5 * time)) < 0.01 + 1e-12);
});

test("an hour of recording keeps its beginning and its bound", () => {
  const recorder = new Recorder(2, 100);
  for (let i = 0; i <= 3600 * 30; i++) recorder.add(i / 30, [i / 30, 1]);
  recorder.add(3600.001, [3600.001, 1], true);
  const { motion } = recorder;
  assert.ok(motion && motion.count <= 100 && motion.count > 30);
  assert.equal(recorder.values.length, 200);
  assert.equal(motion.start, 0);
  assert.equal(motion.end, 3600.001);
  for (const time of [1, 999.5, 3000]) assert.ok(Math.abs(motion.at(time)[0] - time) < 1e-9);
  assert.ok(recorder.rate < 0.1);
});

test("samples nearer together than the rate are left out", () => {
  const recorder = new Recorder(1, 100);
  for (let i = 0; i < 30; i++) recorder.add(i / 300, [i]);
  assert.equal(recorder.motion?.count, 4);
  assert.equal(new Recorder(1).motion, null);
});

test("a recording of a NAO has room for 20 minutes, and of a larger robot for less", () => {
  assert.equal(new Recorder(25).most, 36_000);
  assert.equal(new Recorder(100).most, 9_000);
});
