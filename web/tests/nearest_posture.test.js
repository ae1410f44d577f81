import assert from "node:assert/strict";
import test from "node:test";

import { nearestPosture } from "../src/robot/settling.ts";

const postures = [{ q: [0, 0, 0, 0] }, { q: [1, 1, 1, 0] }, { q: [-1, 0, 1, 1] }];

test("a configuration is nearest to the posture that most of its joints have", () => {
  assert.equal(nearestPosture([0, 0, 0, 0], postures), 0);
  assert.equal(nearestPosture([0, 0, 3, 0], postures), 0); // one joint, however far
  assert.equal(nearestPosture([0.4, 0.4, 3, 0], postures), 0);
  assert.equal(nearestPosture([0.9, 1, 1.2, 0.1], postures), 1);
});

test("of postures as near the first one is taken", () => {
  assert.equal(nearestPosture([0, 0], [{ q: [0.1, 0] }, { q: [0, 0.1] }]), 0);
});

test("the posture of the step before stays until another one is clearly nearer", () => {
  const path = Array.from({ length: 101 }, (_, i) => [i / 100, i / 100, i / 100, 0]);
  /** @type {(qs: number[][]) => number} */
  const change = (qs) => {
    let before = nearestPosture(qs[0], postures);
    const first = before;
    return qs.findIndex((q) => (before = nearestPosture(q, postures, before)) !== first);
  };
  const there = change(path);
  const back = 100 - change([...path].reverse());
  assert.ok(there > 50 && back < 50 && there - back < 20);
});
