import assert from "node:assert/strict";
import test from "node:test";
import { Leg } from "../src/ik/leg.ts";
import {
  areInside,
  assertBlamed,
  assertClose,
  assertLeastOutside,
  assertSorted,
  hasBranch,
  movedBy,
  numbersOf,
  placeIn,
  poseOf,
  randomValues,
  turnedAbout,
  turnedFrame,
  unlimited,
} from "./chains.js";

const KNEE = 3;
const PITCH = 4;
const ROLL = 5;

function assertMet(numbers, { branches }, T) {
  for (const { values } of branches) assertClose(poseOf(numbers, values), T, 2e-10);
}

for (const frame of ["LLeg", "RLeg"]) {
  const numbers = numbersOf(frame);
  const leg = new Leg(numbers);
  const configurations = randomValues(numbers, 200, 1);
  const references = randomValues(numbers, 200, 2);

  test(`${frame} has eight branches without limits, which all make the pose of the foot`, () => {
    configurations.forEach((q, i) => {
      const T = poseOf(numbers, q);
      const answer = leg.solve(T, references[i], false);
      assert.equal(answer.reason, "REACHED");
      assert.equal(answer.branches.length, 8);
      assert.ok(hasBranch(answer, q));
      assertMet(numbers, answer, T);
      assertSorted(answer);
      for (const { values } of answer.branches) {
        assert.ok(values.every((value, k) => Math.abs(value - references[i][k]) <= Math.PI + 1e-12));
      }
    });
  });

  test(`${frame} places a frame that is turned in its link`, () => {
    const turned = turnedFrame(numbers);
    for (const q of configurations.slice(0, 20)) {
      const T = poseOf(turned, q);
      const answer = new Leg(turned).solve(T, q, false);
      assertClose(answer.branches[0].values, q, 1e-7);
      assertMet(turned, answer, T);
    }
  });

  test(`with limits ${frame} has those of its branches that are inside them`, () => {
    let [met, refused] = [0, 0];
    configurations.forEach((q, i) => {
      const T = poseOf(numbers, q);
      const answer = leg.solve(T, references[i]);
      // Without limits the branches near zero are those within (−π, π].
      const all = leg.solve(T, [0, 0, 0, 0, 0, 0], false);
      const inside = all.branches.filter(({ values }) => areInside(numbers, values));
      assert.equal(answer.branches.length, inside.length);
      for (const { values } of inside) assert.ok(hasBranch(answer, values));
      assertMet(numbers, answer, T);
      assertSorted(answer);
      if (answer.branches.length > 0) met += 1;
      else refused += 1;
      assert.equal(answer.reason === "REACHED", answer.branches.length > 0);
    });
    assert.ok(met > 50 && refused > 10);
  });

  test(`where no branch of ${frame} is inside the limits, the joint of the one that is least outside is named`, () => {
    const zeros = [0, 0, 0, 0, 0, 0];
    for (const q of randomValues(unlimited(numbers), 500, 4)) {
      const T = poseOf(numbers, q);
      const answer = leg.solve(T, zeros);
      if (answer.branches.length === 0) assertLeastOutside(leg, answer, leg.solve(T, zeros, false));
    }
  });

  test(`${frame} out of reach says by how much, stretched or folded`, () => {
    const { hip, thigh, tibia, place } = numbers.geometry;
    const T = poseOf(numbers, [0, 0, 0, 0, 0, 0]);
    const far = leg.solve(movedBy(T, [0, 0, -0.05]), references[0]);
    assertBlamed(far, "OUT_OF_REACH", -1, 0.05, 0);
    const folding = [hip[0], hip[1], hip[2] + place[2]];
    const folded = leg.solve(
      T.map((value, i) => (i % 4 === 3 && i < 12 ? folding[(i - 3) / 4] : value)),
      references[0],
    );
    assertBlamed(folded, "OUT_OF_REACH", -1, Math.abs(thigh - tibia), 0);
  });

  test(`a straight knee of ${frame} has one angle`, () => {
    const q = [0.1, 0.1, -0.3, 0, 0.2, 0.05];
    const answer = leg.solve(poseOf(numbers, q), q, false);
    assert.equal(answer.branches.length, 4);
    for (const { values } of answer.branches) assert.equal(values[KNEE], 0);
    assertClose(answer.branches[0].values, q);
  });

  test(`the joint that keeps ${frame} from a pose is named, with what it needs and its limit`, () => {
    const q = [0, 0, -0.6, numbers.upper[KNEE] + 0.01, -0.6, 0];
    assertBlamed(leg.solve(poseOf(numbers, q), q), "JOINT_LIMIT", KNEE, q[KNEE], numbers.upper[KNEE]);
    const low = [0, 0, -0.3, 0.6, numbers.lower[PITCH] - 0.01, 0];
    assertBlamed(leg.solve(poseOf(numbers, low), low), "JOINT_LIMIT", PITCH, low[PITCH], numbers.lower[PITCH]);
  });

  test(`AnklePitch leaves the AnkleRoll of ${frame} less than its own range`, () => {
    const { at, lower, upper } = numbers.table;
    const ends = at.flatMap((pitch, i) => [
      { pitch, bound: lower[i], outwards: -0.01 },
      { pitch, bound: upper[i], outwards: 0.01 },
    ]);
    const [least, most] = [numbers.lower[ROLL] + 0.02, numbers.upper[ROLL] - 0.02];
    const coupled = ends.filter(({ pitch, bound }) => Math.abs(pitch) < 0.9 && bound > least && bound < most);
    assert.ok(coupled.length >= 4);
    for (const { pitch, bound, outwards } of coupled) {
      const q = [0, 0, -0.4, 0.7, pitch, bound + outwards];
      assertBlamed(leg.solve(poseOf(numbers, q), q), "COUPLED_LIMIT", ROLL, q[ROLL], bound);
      q[ROLL] = bound - outwards;
      assertClose(leg.solve(poseOf(numbers, q), q).branches[0].values, q, 1e-9);
    }
  });

  test(`where the hip of ${frame} locks, the pair nearest to the reference is taken`, () => {
    const free = unlimited(numbers);
    const locked = [0.3, numbers.geometry.kappa, -0.5, 0.9, -0.4, 0.1];
    const T = poseOf(numbers, locked);
    for (const [limb, enforce] of [
      [leg, false],
      [new Leg(free), true],
    ]) {
      const answer = limb.solve(T, locked, enforce);
      assertMet(numbers, answer, T);
      assert.equal(answer.branches[0].family, "HIP_LOCK");
      assertClose(answer.branches[0].values, locked, 1e-7);
      // A reference whose sum of both turns is 0.2 more: each gives up half.
      const beside = locked.map((value, i) => (i === 0 ? value + 0.2 : value));
      const [{ values }] = limb.solve(T, beside, enforce).branches;
      assertClose([values[0], values[2]], [locked[0] + 0.1, locked[2] - 0.1], 1e-7);
    }
  });

  test(`with the hip on the axis of AnkleRoll ${frame} may turn about it`, () => {
    const { thigh, tibia } = numbers.geometry;
    const ankle = 0.85;
    const knee = Math.acos((-tibia * Math.cos(ankle)) / thigh) - ankle;
    const q = [-0.2, 0.1, -0.9, knee, ankle, 0.02];
    const T = poseOf(numbers, q);
    for (const enforce of [true, false]) {
      const answer = leg.solve(T, q, enforce);
      assert.equal(answer.branches[0].family, "ANKLE_AXIS");
      assertMet(numbers, answer, T);
      assertClose(answer.branches[0].values, q, 1e-6);
      if (enforce) assert.ok(answer.branches.every(({ values }) => areInside(numbers, values)));
    }
  });

  test(`${frame} stands on its place with another turn of the hips, its sole as it was`, () => {
    let stood = 0;
    configurations.forEach((q, i) => {
      const T = poseOf(numbers, q);
      const answer = leg.stand(T, references[i][0], q);
      for (const { values, yaw } of answer.branches) {
        stood += 1;
        assert.equal(values[0], references[i][0]);
        assert.ok(areInside(numbers, values));
        const made = poseOf(numbers, values);
        const [normal, toes] = [
          [T[2], T[6], T[10]],
          [T[0], T[4], T[8]],
        ];
        assertClose(placeIn(made), placeIn(T));
        assertClose([made[2], made[6], made[10]], normal);
        assertClose([made[0], made[4], made[8]], turnedAbout(normal, yaw, toes));
      }
      if (!areInside(numbers, q)) return;
      const [same] = leg.stand(T, q[0], q).branches;
      assertClose([...same.values, same.yaw], [...q, 0], 1e-7);
    });
    assert.ok(stood > 30);
  });

  test(`${frame} does not stand at a pose out of reach, nor at a matrix that is not a pose`, () => {
    const T = poseOf(numbers, [0, 0, 0, 0, 0, 0]);
    assertBlamed(leg.stand(movedBy(T, [0, 0, -0.05]), 0, references[0]), "OUT_OF_REACH", -1, 0.05, 0);
    assertBlamed(leg.stand(movedBy(T, [NaN, 0, 0]), 0, references[0]), "NOT_RIGID", -1, 0, 0);
  });
}
