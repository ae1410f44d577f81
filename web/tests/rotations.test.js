import assert from "node:assert/strict";
import test from "node:test";
import { angleBetween, product, rotationAbout } from "../src/math/rotations.ts";
import { generator } from "./generator.js";

test("the angle between two rotations is the one that leads from one to the other, up to half a turn", () => {
  const random = generator(1);
  for (const angle of [0, 1e-12, 1e-3, 1, 3, Math.PI]) {
    for (let i = 0; i < 200; i++) {
      const R = product(
        rotationAbout([0, 0, 1], 6 * random()),
        product(rotationAbout([0, 1, 0], 6 * random()), rotationAbout([1, 0, 0], 6 * random())),
      );
      // Near half a turn a sine says little: half the digits are lost there.
      const tolerance = angle > 3.1 ? 1e-7 : 1e-14;
      const found = angleBetween(R, product(R, rotationAbout([0, 1, 0], angle)));
      assert.ok(Math.abs(found - angle) < tolerance, `${found} is not ${angle}`);
    }
  }
});
