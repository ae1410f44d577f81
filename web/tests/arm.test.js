import assert from "node:assert/strict";
import test from "node:test";
import { Arm } from "../src/ik/arm.ts";
import { ArmPlace } from "../src/ik/arm_place.ts";
import {
  areInside,
  assertBlamed,
  assertClose,
  assertSorted,
  forwardIn,
  hasBranch,
  movedBy,
  numbersOf,
  placeIn,
  poseOf,
  randomValues,
  turnedAbout,
  turnedFrame,
  unit,
  unlimited,
} from "./chains.js";

const squared = (a, b) => a.reduce((sum, value, i) => sum + (value - b[i]) ** 2, 0);

for (const frame of ["LArm", "RArm"]) {
  const numbers = numbersOf(frame);
  const free = unlimited(numbers);
  const arm = new Arm(numbers);
  const { shoulder, elbow_x, elbow_y, place } = numbers.geometry;
  const [x, y, z] = shoulder;
  const [hand_x, hand_y, hand_z] = place;
  const [upper, lower] = [Math.hypot(elbow_x, elbow_y), Math.hypot(...place)];
  const configurations = randomValues(numbers, 200, 3);
  const references = randomValues(numbers, 200, 4);

  test(`${frame} has four branches for a pose without limits, and with limits those inside them`, () => {
    let fewer = 0;
    configurations.forEach((q, i) => {
      const T = poseOf(numbers, q);
      const all = arm.solve(T, [0, 0, 0, 0, 0], false);
      assert.equal(all.branches.length, 4);
      assertSorted(all);
      const answer = arm.solve(T, references[i]);
      assertSorted(answer);
      assert.ok(hasBranch(answer, q));
      const inside = all.branches.filter(({ values }) => areInside(numbers, values));
      assert.equal(answer.branches.length, inside.length);
      fewer += inside.length < 4;
      for (const { values } of [...all.branches, ...answer.branches]) assertClose(poseOf(numbers, values), T, 2e-10);
    });
    assert.ok(fewer > 0);
  });

  test(`${frame} places a frame that is turned in its link`, () => {
    const turned = turnedFrame(numbers);
    for (const q of configurations.slice(0, 20)) {
      const T = poseOf(turned, q);
      const answer = new Arm(turned).solve(T, q, false);
      assertClose(answer.branches[0].values, q, 1e-7);
      for (const { values } of answer.branches) assertClose(poseOf(turned, values), T, 2e-10);
    }
  });

  test(`with the forearm of ${frame} in line with the shoulder any turn about it will do`, () => {
    const radius = Math.hypot(hand_y, hand_z);
    const away = hand_x + Math.sqrt((upper - radius) * (upper + radius));
    for (const along of [unit([1, 0.2, 0.1]), unit([0.1, 0.9, -0.4])]) {
      const target = [x, y, z].map((value, k) => value + away * along[k]);
      const answer = arm.solveDirection(target, along, references[0], false);
      assert.ok(answer.branches.length > 0);
      for (const { values } of answer.branches) {
        const made = poseOf(numbers, values);
        assertClose([...placeIn(made), ...forwardIn(made)], [...target, ...along]);
      }
    }
  });

  test(`${frame} has up to eight branches for a place and the direction of the forearm`, () => {
    const counts = new Set();
    configurations.forEach((q, i) => {
      const T = poseOf(numbers, q);
      const along = forwardIn(T).map((value) => 3 * value);
      const all = arm.solveDirection(placeIn(T), along, references[i], false);
      counts.add(all.branches.length);
      assertSorted(all);
      const answer = arm.solveDirection(placeIn(T), along, references[i]);
      assert.ok(hasBranch(all, q) && hasBranch(answer, q));
      assert.ok(answer.branches.every(({ values }) => areInside(numbers, values)));
      for (const { values } of [...all.branches, ...answer.branches]) {
        const made = poseOf(numbers, values);
        assertClose([...placeIn(made), ...forwardIn(made)], [...placeIn(T), ...forwardIn(T)]);
      }
    });
    assert.deepEqual(counts, new Set([8]));
  });

  test(`${frame} meets a place alone inside its limits, as near to the reference as a search of its poses finds`, () => {
    configurations.slice(0, 20).forEach((q, i) => {
      const T = poseOf(numbers, q);
      const answer = new ArmPlace(arm, placeIn(T), references[i]).solve();
      assert.equal(answer.reason, "REACHED");
      const [{ values, family, distance }] = answer.branches;
      assert.equal(family, "REDUNDANT");
      assert.ok(areInside(numbers, values));
      assertClose(placeIn(poseOf(numbers, values)), placeIn(T));
      assertClose([distance], [squared(values, references[i])]);
      // The search may end a little early where a limit of a joint that is not searched for is in the way.
      const isAtLimit = values.some((value, k) => Math.min(value - arm.lower[k], arm.upper[k] - value) < 1e-3);
      const slack = isAtLimit ? 0.02 * distance : 1e-9;
      // Anywhere, and beside the one that was found.
      const found = forwardIn(poseOf(numbers, values));
      const others = randomValues({ lower: [-1, -1, -1], upper: [1, 1, 1] }, 200, 5 + i);
      const beside = others.map((by) => found.map((value, k) => value + 0.01 * by[k]));
      for (const forearm of [...others, ...beside]) {
        for (const other of arm.solveDirection(placeIn(T), forearm, references[i]).branches) {
          assert.ok(distance <= other.distance + slack);
        }
      }
    });
  });

  test(`a place that ${frame} reaches only beyond a limit names the joint`, () => {
    const sideways = y > 0 ? -0.12 : 0.12;
    const answer = new ArmPlace(arm, [x - 0.14, y + sideways, z], references[0]).solve();
    assert.equal(answer.reason, "JOINT_LIMIT");
    assert.equal(answer.branches.length, 0);
    const { joint, needed, limit } = answer;
    assert.ok(limit === numbers.lower[joint] ? needed < limit : limit === numbers.upper[joint] && needed > limit);
  });

  test(`where ${frame} has met a place it stays, searched for near the reference or everywhere`, () => {
    const q = configurations[0];
    for (const near of [false, true]) {
      const answer = new ArmPlace(arm, placeIn(poseOf(numbers, q)), q).solve({ near });
      assertClose(answer.branches[0].values, q, 1e-7);
      const anywhere = new ArmPlace(arm, placeIn(poseOf(numbers, q)), q, false).solve({ near });
      assertClose(anywhere.branches[0].values, q, 1e-7);
    }
  });

  test(`${frame} out of reach says by how much, stretched or folded`, () => {
    const away = unit([1, 2, -1]);
    const target = (far) => [x, y, z].map((value, k) => value + far * away[k]);
    const posed = (far) => movedBy([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], target(far));
    for (const [far, by] of [
      [upper + lower + 0.03, 0.03],
      [0, Math.abs(upper - lower)],
    ]) {
      const [reference] = references;
      assertBlamed(arm.solve(posed(far), reference), "OUT_OF_REACH", -1, by, 0);
      assertBlamed(arm.solveDirection(target(far), [1, 0, 0], reference), "OUT_OF_REACH", -1, by, 0);
      assertBlamed(new ArmPlace(arm, target(far), reference).solve(), "OUT_OF_REACH", -1, by, 0);
    }
  });

  test(`five joints of ${frame} do not make every pose, nor every direction at a place`, () => {
    const q = configurations[1];
    const T = poseOf(numbers, q);
    const turned = T.slice();
    for (const column of [0, 1, 2]) {
      const axis = turnedAbout([0, 0, 1], 0.3, [T[column], T[4 + column], T[8 + column]]);
      [turned[column], turned[4 + column], turned[8 + column]] = axis;
    }
    assertBlamed(arm.solve(turned, q), "NOT_ENOUGH_JOINTS", -1, 0, 0);
    // Stretched, the forearm goes away from the shoulder and not back to it.
    const far = [x + upper + lower - 1e-4, y, z];
    assertBlamed(arm.solveDirection(far, [-1, 0, 0], q), "NOT_ENOUGH_JOINTS", -1, 0, 0);
    assertBlamed(arm.solve(movedBy(T, [NaN, 0, 0]), q), "NOT_RIGID", -1, 0, 0);
  });

  test(`the joint that keeps ${frame} from a pose is named, with what it needs and its limit`, () => {
    const wrist = 4;
    const q = [0.4, 0, 0.3, 0.5 * (numbers.lower[3] + numbers.upper[3]), numbers.upper[4] + 0.01];
    assertBlamed(arm.solve(poseOf(numbers, q), q), "JOINT_LIMIT", wrist, q[wrist], numbers.upper[wrist]);
    q[wrist] = numbers.lower[wrist] - 0.01;
    assertBlamed(arm.solve(poseOf(numbers, q), q), "JOINT_LIMIT", wrist, q[wrist], numbers.lower[wrist]);
  });

  test(`with ${frame} stretched the pair of ElbowYaw and WristYaw nearest to the reference is taken`, () => {
    const locked = [0.4, 0.1, 0.3, 0, -0.2];
    const T = poseOf(numbers, locked);
    for (const [limb, enforce] of [
      [arm, false],
      [new Arm(free), true],
    ]) {
      const beside = locked.map((value, i) => (i === 2 ? value + 0.2 : value));
      const [{ values, family }] = limb.solve(T, beside, enforce).branches;
      assert.equal(family, "ELBOW_LOCK");
      assertClose(values, [0.4, 0.1, 0.4, 0, -0.3], 1e-7);
      assertClose(poseOf(numbers, values), T);
    }
  });

  test(`with its elbow on the axis of ShoulderPitch ${frame} may turn about it`, () => {
    const q = [0.7, Math.PI / 2 - Math.atan2(elbow_y, elbow_x), 0.3, 0.8, -0.2];
    const T = poseOf(numbers, q);
    for (const [limb, enforce] of [
      [arm, false],
      [new Arm(free), true],
    ]) {
      const answer = limb.solve(T, q, enforce);
      assert.equal(answer.branches[0].family, "SHOULDER_AXIS");
      assertClose(answer.branches[0].values, q, 1e-6);
      for (const { values } of answer.branches) assertClose(poseOf(numbers, values), T, 2e-10);
    }
  });
}
