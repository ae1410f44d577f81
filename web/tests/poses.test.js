import assert from "node:assert/strict";
import { test } from "node:test";
import { readPoses } from "../src/panel/postures.ts";

test("poses of this robot are read, and whatever else the browser has is left out", () => {
  const good = [
    { name: "wave", q: [0.1, 0.2], up: null },
    { name: "on the side", q: [0, 0], up: [0, 1, 0] },
  ];
  const bad = [null, 3, { name: "", q: [0, 0], up: null }, { name: "of another robot", q: [0], up: null }];
  assert.deepEqual(readPoses(JSON.stringify([...bad, ...good]), 2), good);
  for (const text of ["", "{", "{}", "null"]) assert.deepEqual(readPoses(text, 2), []);
});
