import assert from "node:assert/strict";
import { test } from "node:test";

import { differences } from "../src/values/configurations.ts";
import { ABOUT, Q } from "./small_robot.js";

test("the joint that differs most comes first, and equal joints are left out", () => {
  const other = Q.with(0, Q[0] + 0.1).with(3, Q[3] - 0.3);
  const found = differences(ABOUT, Q, other);
  assert.deepEqual(
    found.map(({ joint, unit }) => [joint, unit]),
    [
      ["LArm", "m"],
      ["HeadYaw", "rad"],
    ],
  );
  assert.ok(Math.abs(found[0].value + 0.3) < 1e-12);
  assert.deepEqual(differences(ABOUT, Q, [...Q]), []);
});
