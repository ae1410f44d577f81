import assert from "node:assert/strict";
import test from "node:test";
import { frameOf, jointOf, joints, pairOf } from "../src/pick/facts.ts";

const about = {
  places: [],
  links: [
    { name: "base", path: ["robot", "base"] },
    { name: "arm", path: ["robot", "base", "arm"] },
    { name: "__proto__", path: ["robot", "base", "arm", "__proto__"] },
    { name: "army", path: ["robot", "base", "army"] },
  ],
  joints: [
    { name: "tip", link: 2, slides: true, pair: "" },
    { name: "shoulder", link: 1, slides: false, pair: "universal" },
  ],
  frames: [
    { name: "base", link: 0 },
    { name: "shoulder", link: 1 },
    { name: "arm", link: 1 },
    { name: "army", link: 3 },
  ],
};

test("the joints that carry a link come from the root outwards, and the last moves it", () => {
  assert.deepEqual(
    joints(about, 2).map(({ name }) => name),
    ["shoulder", "tip"],
  );
  assert.equal(jointOf(about, 2).name, "tip");
  assert.equal(jointOf(about, 0), null);
  assert.equal(jointOf(about, 3), null);
});

test("the frame of a link has its name, or that of the nearest link that carries it", () => {
  assert.equal(frameOf(about, 1), "arm");
  assert.equal(frameOf(about, 2), "arm");
  assert.equal(frameOf({ ...about, frames: [{ name: "only", link: 2 }] }, 2), "only");
  assert.equal(frameOf({ ...about, frames: [] }, 2), null);
});

test("a joint is called by its own pair and by the one that it is a part of", () => {
  assert.equal(pairOf(about.joints[1]), "revolute, of a universal pair");
  assert.equal(pairOf(about.joints[0]), "prismatic pair");
  assert.equal(pairOf({ slides: false, pair: "revolute" }), "revolute pair");
});
