import assert from "node:assert/strict";
import test from "node:test";
import { delayAfter } from "../src/connection.ts";
import { isOutdated } from "../src/reports.ts";

test("each try waits twice as long as the one before, and none longer than ten seconds", () => {
  assert.deepEqual([0, 1, 2, 3, 4, 5, 6, 5000].map(delayAfter), [500, 1000, 2000, 4000, 8000, 10000, 10000, 10000]);
});

test("only a page's own report is outdated, and only while a newer one is on its way", () => {
  assert.equal(isOutdated("a 3", "a", 4), true);
  assert.equal(isOutdated("a 4", "a", 4), false);
  assert.equal(isOutdated("b 3", "a", 4), false);
  assert.equal(isOutdated("", "a", 4), false);
  assert.equal(isOutdated("a", "a", 4), false);
  assert.equal(isOutdated("a 4", "a", 4, true), true);
  assert.equal(isOutdated("b 4", "a", 4, true), false);
});
