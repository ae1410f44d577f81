import assert from "node:assert/strict";
import test from "node:test";
import { History } from "../src/panel/past.ts";

test("a history goes back and forth, forgets what a new step replaces, and is bounded", () => {
  const history = new History(3);
  for (const state of ["a", "b", "c", "d"]) history.push(state);
  assert.equal(history.undo("e"), "d");
  assert.equal(history.redo("d"), "e");
  assert.deepEqual(
    ["e", "d", "c", "b"].map((now) => history.undo(now)),
    ["d", "c", "b", undefined],
  );
  assert.equal(history.future.length, 3);
  history.push("x");
  assert.equal(history.redo("y"), undefined);
});
