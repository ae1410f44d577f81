import assert from "node:assert/strict";
import test from "node:test";
import { SweptAngle, sweptDistance } from "../src/drag/swept_angle.ts";

const EYE = [0, 0, 2];
const Z = { origin: [0, 0, 0], direction: [0, 0, 1] };

const through = (point, eye = EYE) => {
  const way = point.map((value, k) => value - eye[k]);
  return { origin: eye, direction: way.map((value) => value / Math.hypot(...way)) };
};

const near = (value, expected) => assert.ok(Math.abs(value - expected) < 1e-12, `${value} is not ${expected}`);

test("about an axis seen from the front the angle is that between the places in the plane across it", () => {
  const swept = new SweptAngle(Z, [0.1, 0, 0.3], EYE, 0.01);
  near(swept.between(through([0.1, 0, 0.3]), through([0, 0.2, 0.3])), Math.PI / 2);
  near(swept.between(through([0.1, 0, 0.3]), through([0, -0.2, 0.3])), -Math.PI / 2);
});

test("over half a turn the angles of the steps add up", () => {
  const swept = new SweptAngle(Z, [0.1, 0, 0], EYE, 0.01);
  const at = (angle) => through([0.1 * Math.cos(angle), 0.1 * Math.sin(angle), 0]);
  let sum = 0;
  for (let i = 0; i < 40; i++) sum += swept.between(at(i / 8), at((i + 1) / 8));
  near(sum, 5);
});

test("a pointer on the axis says nothing", () => {
  const swept = new SweptAngle(Z, [0.1, 0, 0], EYE, 0.01);
  near(swept.between(through([0.1, 0, 0]), through([0.001, 0, 0])), 0);
});

test("about an axis seen from the side the near surface goes with the pointer", () => {
  const axis = { origin: [0, 0, 0], direction: [0, 1, 0] };
  // Turning about y takes the side towards the camera, at z > 0, to the right, along x.
  const swept = new SweptAngle(axis, [0, 0.3, 0.1], [0, 0.3, 2], 0.01);
  const eye = [0, 0.3, 2];
  near(swept.between(through([0, 0.3, 0.1], eye), through([0.02, 0.3, 0.1], eye)), 0.2);
  near(swept.between(through([0, 0.3, 0.1], eye), through([0, 0.5, 0.1], eye)), 0);
});

test("a point under the axis turns the way that is preferred when it is pulled up, and back when it is pulled down", () => {
  const axis = { origin: [0, 0, 0], direction: [1, 0, 0] };
  const eye = [0, -0.1, 2];
  for (const way of [1, -1]) {
    const swept = new SweptAngle(axis, [0, -0.1, 0], eye, 0.01);
    swept.prefer(way);
    near(swept.between(through([0, -0.1, 0], eye), through([0, -0.08, 0], eye)), way * 0.2);
    near(swept.between(through([0, -0.1, 0], eye), through([0, -0.12, 0], eye)), -way * 0.2);
  }
});

test("along a slide the point that is nearest to the ray goes with the pointer", () => {
  const point = [0, 0.1, 0];
  near(sweptDistance([1, 0, 0], point, through([0, 0.1, 0]), through([0.25, 0.1, 0])), 0.25);
  near(sweptDistance([1, 0, 0], point, through([0, 0.1, 0]), through([0, 0.4, 0])), 0);
});

test("a place behind the camera turns nothing", () => {
  const swept = new SweptAngle(Z, [0.1, 0, 0], EYE, 0.01);
  // The rays look away from the plane, and their lines meet it behind the camera.
  const away = (point) => {
    const { origin, direction } = through(point);
    return { origin, direction: direction.map((value) => -value) };
  };
  near(swept.between(through([0.1, 0, 0]), away([0, 0.2, 0])), 0);
  near(swept.between(away([0.1, 0, 0]), away([0, 0.2, 0])), 0);
});

test("a slide seen end on stays", () => {
  assert.equal(sweptDistance([0, 0, 1], [0, 0, 0], through([0, 0, 0]), through([0.01, 0, 0])), 0);
});
