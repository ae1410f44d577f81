import assert from "node:assert/strict";
import test from "node:test";
import { Answer, Limb, leastCost, rigidRotation } from "../src/ik/limb.ts";
import { LIMB_CLASSES } from "../src/ik/limbs.ts";
import { LIMBS, areInside, assertClose, numbersOf, poseOf, randomValues, unlimited } from "./chains.js";

const leg = new Limb(numbersOf("LLeg"));

test("every limb of the robot has a closed form", () => {
  for (const numbers of LIMBS) assert.equal(new LIMB_CLASSES[numbers.kind](numbers).frame, numbers.frame);
});

test("values of joints go into a configuration and come out of it again", () => {
  const scaled = new Limb({
    ...numbersOf("Head"),
    columns: [3, 1],
    multiplier: [-1, 2],
    offset: [0.5, 0],
  });
  const q = [9, 0.2, 8, 0.1];
  assertClose(scaled.values(q), [0.4, 0.4]);
  assertClose(scaled.merged(q, [-0.5, 1]), [9, 0.5, 8, 1]);
  assert.deepEqual(q, [9, 0.2, 8, 0.1]);
});

test("a joint without a limit is inside wherever it is", () => {
  const open = new Limb({ ...unlimited(numbersOf("Head")), lower: [null, -1], upper: [null, 1] });
  assert.ok(open.isInside([1e9, 0.5]) && open.isInside([-1e9, 0.5]));
  assert.ok(!open.isInside([1e9, 1.5]));
  assert.deepEqual(open.tableRange(0), [-Infinity, Infinity]);
});

test("values are inside where their own ranges and the table have them, and the excess says how far outside", () => {
  let outside = 0;
  const wide = { lower: leg.lower.map((low) => low - 0.2), upper: leg.upper.map((high) => high + 0.2) };
  for (const values of [...randomValues(leg, 300, 1), ...randomValues(wide, 300, 2)]) {
    assert.equal(leg.isInside(values), areInside(leg, values, 1e-9));
    assert.equal(leg.isInside(values), leg.excess(values) <= 1e-9);
    outside += !leg.isInside(values);
  }
  assert.ok(outside > 100 && outside < 500);
  const middle = leg.lower.map((low, i) => 0.5 * (low + leg.upper[i]));
  middle[3] = leg.upper[3] + 0.25;
  assertClose([leg.excess(middle)], [0.25]);
});

test("the pair of two joints about one line keeps its total, inside the ranges and nearest to the reference", () => {
  const limb = new Limb({ ...unlimited(numbersOf("Head")), lower: [-2, -1], upper: [2, 1] });
  const values = [0, 0];
  for (const [total, sign, reference, expected] of [
    [1, 1, [0.5, 0.5], [0.5, 0.5]],
    [1, 1, [0.7, 0.5], [0.6, 0.4]],
    [1, -1, [0.7, -0.5], [0.6, -0.4]],
    // The second is at its end, and the first takes what is left.
    [2.8, 1, [1, 1.8], [1.8, 1]],
    [2.8, -1, [1, -1.8], [1.8, -1]],
    // A total that is met a turn later.
    [0.5 + 2 * Math.PI, 1, [0.5, 0], [0.5, 0]],
    [0.5 - 2 * Math.PI, -1, [0.5, 0], [0.5, 0]],
  ]) {
    limb.lockPair([0, 1], total, sign, new Answer(limb, reference, true), values);
    assertClose(values, expected, 1e-12);
  }
  // Without limits the whole turns of the reference are kept.
  limb.lockPair([0, 1], 0.5, 1, new Answer(limb, [7, 0.1], false), values);
  const more = 7.1 - 0.5 - 2 * Math.PI;
  assertClose(values, [7 - more / 2, 0.1 - more / 2], 1e-12);
  limb.lockPair([0, 1], 0.5, -1, new Answer(limb, [7, -0.1], false), values);
  assertClose(values, [7 - more / 2, -0.1 + more / 2], 1e-12);
  // No pair is inside: the one that is least outside.
  limb.lockPair([0, 1], 3.1, 1, new Answer(limb, [0, 0], true), values);
  assertClose(values, [2, 1.1], 1e-12);
});

test("of a family the least cost is found in a valley and at an end, and the last try is the best", () => {
  for (const [low, high, own, cost, expected] of [
    [-1, 1, 0, (x) => (x - 0.3) ** 2, 0.3],
    [-1, 1, 0, (x) => x, -1],
    [-1, 1, 0.123, (x) => (x === 0.123 ? 0 : 1), 0.123],
    [-1, 1, 5, (x) => -x, 1],
  ]) {
    let last = NaN;
    const least = leastCost(low, high, own, (value) => cost((last = value)));
    assert.ok(Math.abs(least - expected) < 1e-7);
    assert.equal(last, least);
  }
  assert.equal(
    leastCost(-1, 1, 0, () => Infinity),
    null,
  );
});

test("the branch that is least outside gives the reason, whichever comes first", () => {
  const middle = leg.lower.map((low, i) => 0.5 * (low + leg.upper[i]));
  const beyond = (joint, by) => middle.map((value, i) => (i === joint ? leg.upper[joint] + by : value));
  const [near, far] = [beyond(3, 0.1), beyond(1, 0.3)];
  for (const tried of [
    [near, far],
    [far, near],
  ]) {
    const answer = new Answer(leg, middle, true);
    for (const values of tried) assert.ok(!answer.checkLimits(values));
    assert.deepEqual(
      [answer.reason, answer.joint, answer.needed, answer.limit],
      ["JOINT_LIMIT", 3, near[3], leg.upper[3]],
    );
  }
});

test("a branch that forward kinematics does not verify is left out, and the nearest comes first", () => {
  const answer = new Answer(leg, [0, 0, 0, 0, 0, 0], false);
  answer.addBranch([0.3, 0, 0, 0, 0, 0], [0, 0]);
  answer.addBranch([0.1 + 2 * Math.PI, 0, 0, 0, 0, 0], [1e-11, 1e-11]);
  answer.addBranch([0.2, 0, 0, 0, 0, 0], [0, 2e-10]);
  answer.addBranch([0.2, 0, 0, 0, 0, 0], [NaN, 0]);
  answer.finish();
  assert.equal(answer.reason, "REACHED");
  assertClose(
    answer.branches.map(({ values }) => values[0]),
    [0.1, 0.3],
  );
});

test("a rotation a little off is corrected, and a matrix that is not a rotation is refused", () => {
  const T = poseOf(leg, [0.1, 0.2, -0.3, 0.4, 0.5, 0.1]);
  const R = [0, 1, 2, 4, 5, 6, 8, 9, 10].map((i) => T[i]);
  assertClose(rigidRotation(T), R, 1e-15);
  const stretched = T.map((value, i) => (i % 4 < 3 && i < 12 ? value * (1 + 1e-7) : value));
  assertClose(rigidRotation(stretched), R, 1e-13);
  const changed = (i, value) => T.map((old, k) => (k === i ? value : old));
  for (const none of [
    changed(0, T[0] + 1e-3),
    changed(15, 2),
    changed(12, 1e-3),
    changed(3, NaN),
    changed(7, Infinity),
    changed(0, NaN),
    T.map((value, i) => (i % 4 === 0 ? -value : value)),
  ]) {
    assert.equal(rigidRotation(none), null);
  }
});
