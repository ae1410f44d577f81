import assert from "node:assert/strict";
import test from "node:test";

import { leaderFrom, overlap, placeLabels } from "../src/scene/labels.ts";

const PICTURE = { x: 0, y: 0, width: 800, height: 600 };
const anchor = (x, y, width = 90) => ({ x, y, width, height: 17, place: -1 });

/** Points that do not repeat, the same in every run. */
function scattered(count, { x, y, width, height }) {
  return Array.from({ length: count }, (_, i) =>
    anchor(x + ((i * 0.6180339) % 1) * width, y + ((i * 0.7548777) % 1) * height, 60 + (i % 5) * 20),
  );
}

test("no label covers another or leaves the picture, however close their points are", () => {
  for (const crowd of [
    { x: 100, y: 100, width: 600, height: 400 },
    { x: 390, y: 290, width: 20, height: 20 },
  ]) {
    const places = placeLabels(scattered(40, crowd), PICTURE).filter((place) => place !== null);
    assert.ok(places.length >= 30, `${places.length} of 40 labels`);
    for (const [i, place] of places.entries()) {
      assert.ok(place.x >= 0 && place.y >= 0 && place.x + place.width <= 800 && place.y + place.height <= 600);
      assert.ok(!places.slice(i + 1).some((other) => overlap(place, other)));
    }
  }
});

test("a label alone stands beside its point and does not cover it", () => {
  const [{ x, y, width, height }] = placeLabels([anchor(400, 300)], PICTURE);
  assert.ok(x > 400 || x + width < 400 || y > 300 || y + height < 300);
  const edge = leaderFrom({ x, y, width, height }, { x: 400, y: 300 });
  assert.ok(Math.hypot(edge.x - 400, edge.y - 300) < 20);
});

test("labels keep their places while their points move a little", () => {
  const anchors = scattered(12, { x: 200, y: 150, width: 400, height: 300 });
  placeLabels(anchors, PICTURE);
  const before = anchors.map(({ place }) => place);
  assert.ok(before.every((place) => place >= 0));
  for (const point of anchors) point.x += 1;
  placeLabels(anchors, PICTURE);
  assert.deepEqual(
    anchors.map(({ place }) => place),
    before,
  );
});

test("points outside the picture, or behind the camera, have no labels", () => {
  assert.deepEqual(placeLabels([anchor(-5, 10), anchor(NaN, 10), anchor(10, 700)], PICTURE), [null, null, null]);
});

test("a label stays where it had to go when the room beside its point is free again", () => {
  const [one, other] = [anchor(400, 300), anchor(401, 300)];
  const [, crowded] = placeLabels([one, other], PICTURE);
  assert.notDeepEqual(crowded, placeLabels([anchor(401, 300)], PICTURE)[0]);
  assert.deepEqual(placeLabels([other], PICTURE)[0], crowded);
});
