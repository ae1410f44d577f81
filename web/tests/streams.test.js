import assert from "node:assert/strict";
import test from "node:test";
import { Streams } from "../src/plot/streams.ts";

const message = (name, values, margins = false) => {
  const [times, numbers] = [new Float64Array(values.map((_, i) => 0.1 * i)), new Float64Array(values)];
  return { name, run: 1, lines: ["a"], first: 0, margins, times, values: numbers };
};

test("margins stay margins, and a value that is no number is a gap", () => {
  const streams = new Streams();
  streams.add(message("Force", [1, 2]));
  streams.add(message("Balance", [3, NaN, -4], true));
  const curves = streams.curves(null);
  assert.deepEqual(
    [...curves].map(([name, { margins, values }]) => [name, margins, values]),
    [
      ["Force", false, [[1, 2]]],
      ["Balance", true, [[3, null, -4]]],
    ],
  );
});
