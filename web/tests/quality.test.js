import assert from "node:assert/strict";
import { test } from "node:test";

import { LEVELS, Quality } from "../src/scene/quality.ts";

/** Draw frames with a change each, all of the given duration [ms]; returns the levels at which they were drawn. */
function move(quality, from, count, time) {
  const levels = [];
  for (let i = 0; i < count; i++) {
    const now = from + i * time;
    levels.push(LEVELS.indexOf(quality.next(now, true)));
    quality.took(now + time, time);
  }
  return levels;
}

test("one change alone is drawn at its best", () => {
  const quality = new Quality();
  assert.equal(quality.next(5000, true), LEVELS[0]);
  quality.took(5400, 400);
  assert.equal(quality.next(5560, false), LEVELS[0]);
});

test("a slow machine gets the fastest level within a few frames and the best one at rest", () => {
  const quality = new Quality();
  const levels = move(quality, 0, 12, 300);
  assert.equal(levels.at(-1), LEVELS.length - 1);
  const end = 12 * 300;
  assert.equal(quality.next(end + 100, false), LEVELS.at(-1));
  assert.equal(quality.next(end + 160, false), LEVELS[0]);
});

test("a quick machine gets the best level after a second, and keeps it", () => {
  const levels = move(new Quality(), 0, 600, 16.7);
  assert.ok(levels.slice(80).every((level) => level === 0));
});

test("a level that is too slow is tried less and less often", () => {
  const quality = new Quality();
  let now = 0;
  const levels = [];
  for (let i = 0; i < 4000; i++) {
    const level = LEVELS.indexOf(quality.next(now, true));
    levels.push(level);
    const time = level === 0 ? 200 : 16.7;
    now += time;
    quality.took(now, time);
  }
  assert.ok(levels.filter((level) => level === 0).length < 20);
});

test("a movement that is expected begins with its first change", () => {
  const quality = new Quality();
  quality.expected = true;
  assert.equal(quality.next(5000, true), LEVELS[1]);
});
