import assert from "node:assert/strict";
import test from "node:test";
import { product, rollPitchYaw, rotationAbout } from "../src/math/rotations.ts";

// Sixteen numbers by columns of a rotation's nine by rows.
const columns = (R) => [0, 1, 2].flatMap((j) => [R[j], R[3 + j], R[6 + j], 0]).concat([0, 0, 0, 1]);

const rotation = ([roll, pitch, yaw]) =>
  product(product(rotationAbout([0, 0, 1], yaw), rotationAbout([0, 1, 0], pitch)), rotationAbout([1, 0, 0], roll));

for (const pitch of [0, 1.2, 1.5707, Math.PI / 2, -Math.PI / 2, Math.PI / 2 - 1e-9]) {
  test(`roll, pitch and yaw make the same rotation again at a pitch of ${pitch}`, () => {
    for (const [roll, yaw] of [
      [0.4, -1.1],
      [-3.1, 3.1],
      [0, 0],
      [Math.PI, -Math.PI / 2],
    ]) {
      const R = rotation([roll, pitch, yaw]);
      const again = rotation(rollPitchYaw({ elements: columns(R) }));
      for (const [i, value] of again.entries()) assert.ok(Math.abs(value - R[i]) < 1e-14);
    }
  });
}

test("away from a right angle the angles are those that were given", () => {
  const angles = [0.4, -0.9, 2.3];
  rollPitchYaw({ elements: columns(rotation(angles)) }).forEach((value, i) => {
    assert.ok(Math.abs(value - angles[i]) < 1e-14);
  });
});
