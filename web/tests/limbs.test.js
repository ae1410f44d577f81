import assert from "node:assert/strict";
import { test } from "node:test";

import { Chain } from "../src/ik/chain.ts";
import { descend, lookTask, placeTask, turnTask } from "../src/ik/least_squares.ts";
import { Follower, isStanding, limbsOf } from "../src/ik/limbs.ts";
import { clamp } from "../src/math/numbers.ts";
import { angleBetween, distance, product, rotationAbout } from "../src/math/rotations.ts";
import { generator } from "./generator.js";

// A torso with two arms of four joints; the first joints of both turn with the same coordinate, in opposite directions. The
// range of the elbow depends on the shoulder. A slide carries the hand.
const at = (x, y, z) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];
const empty = () => ({
  links: [{ name: "torso", path: ["torso"] }],
  places: [],
  joints: [],
  coordinates: [],
  tables: [],
});
const about = empty();
const addTo = (robot) => (name, parent, place, axis, column, more) => {
  const { path } = robot.links[parent];
  robot.places.push({ path: [...path, `${name} holder`], matrix: place });
  robot.links.push({ name, path: [...path, `${name} holder`, name] });
  const link = robot.links.length - 1;
  robot.joints.push({ name, link, axis, column, multiplier: 1, offset: 0, slides: false, follows: "", ...more });
  return link;
};
const add = addTo(about);
const waist = add("Waist", 0, at(0, 0, 0.1), [0, 0, 1], 8);
const hands = ["L", "R"].map((side, i) => {
  const out = i === 0 ? 1 : -1;
  const mimic = i === 0 ? {} : { multiplier: -1, follows: "LTurn" };
  const turn = add(`${side}Turn`, waist, at(0, 0.1 * out, 0.1), [0, 0, 1], 0, mimic);
  const lift = add(`${side}Lift`, turn, at(0, 0, 0), [0, 1, 0], 1 + 3 * i);
  const elbow = add(`${side}Elbow`, lift, at(0.2, 0, 0), [0, 1, 0], 2 + 3 * i);
  return add(`${side}Slide`, elbow, at(0.1, 0, 0), [1, 0, 0], 3 + 3 * i, { slides: true });
});
add("HeadYaw", waist, at(0, 0, 0.3), [0, 0, 1], 7);
about.coordinates = [
  ...[[-1, 1], [-1, 1], [-0.2, 1.5], [0, 0.1], [-1, 1], [0, 1.5], [0, 0.1], [-1, 1], [-1, 1]], // prettier-ignore
].map(([lower, upper], column) => ({ joint: `${column}`, column, lower, upper }));
about.tables = [{ joint: 2, of: 1, at: [-1, 1], lower: [-0.2, 0.4], upper: [1.5, 1.5] }];
Object.assign(about, {
  chains: [],
  frames: about.links.map(({ name }, link) => ({ name, link })),
  soles: [{ link: hands[1] }],
  eyes: [{ name: "HeadYaw" }],
  postures: [],
  neutral: about.coordinates.map(() => 0),
  root: "torso",
  ends: ["torso", "HeadYaw", "LSlide", "RSlide"].map((frame) => ({ frame, point: [0, 0, 0] })),
});
const Q = [0.1, 0.2, 0.6, 0.05, -0.1, 0.7, 0.02, 0.3, 0.2];

const random = generator(5);
const near = (q, by) => q.map((value) => value + by * (2 * random() - 1));
const inside = (q) =>
  about.coordinates.every(({ lower, upper }, i) => q[i] >= lower - 1e-12 && q[i] <= upper + 1e-12) &&
  q[2] >= -0.2 + 0.3 * (q[1] + 1) - 1e-12;

test("a chain's axes are the derivatives of its placement", () => {
  const chain = new Chain(about, hands[1]);
  const { p, R, screws } = chain.forward(Q);
  assert.deepEqual(screws.map(({ joint }) => joint.column), [8, 0, 4, 5, 6]); // prettier-ignore
  for (const { joint, axis, origin } of screws) {
    const moved = chain.forward(Q.with(joint.column, Q[joint.column] + 1e-6));
    const along = axis.map((value) => 1e-6 * joint.multiplier * value);
    const [ox, oy, oz] = p.map((value, i) => value - origin[i]);
    const [ax, ay, az] = along;
    const by = joint.slides ? along : [ay * oz - az * oy, az * ox - ax * oz, ax * oy - ay * ox];
    assert.ok(distance(moved.p, p.map((value, i) => value + by[i])) < 1e-11); // prettier-ignore
    const turn = joint.slides ? R : product(rotationAbout(axis, 1e-6 * joint.multiplier), R);
    assert.ok(angleBetween(moved.R, turn) < 1e-11);
  }
});

test("the rates of all tasks are the derivatives of their errors", () => {
  const chain = new Chain(about, hands[0]);
  const tasks = [
    placeTask(chain, [0.1, 0.2, 0.3], 3),
    turnTask(chain, rotationAbout([0.6, 0, 0.8], 2.5), [1, 2, 3]),
    lookTask(chain, [0.5, 0.1, 0.1]),
  ];
  const placed = chain.forward(Q);
  for (const task of tasks) {
    for (const { joint, axis, origin } of placed.screws) {
      const [ox, oy, oz] = placed.p.map((value, i) => value - origin[i]);
      const [ax, ay, az] = axis;
      const turning = [axis, [ay * oz - az * oy, az * ox - ax * oz, ax * oy - ay * ox]];
      const rates = task.rates(placed, ...(joint.slides ? [[0, 0, 0], axis] : turning));
      const errors = [1e-6, -1e-6].map((by) => {
        const { column } = joint;
        return task.errors(chain.forward(Q.with(column, Q[column] + by)));
      });
      rates.forEach((rate, i) => assert.ok(Math.abs(rate - (errors[0][i] - errors[1][i]) / 2e-6) < 1e-8));
    }
  }
});

test("limbs are those of the end effectors, and of the head the gaze", () => {
  const limbs = limbsOf(about);
  assert.deepEqual(
    limbs.map(({ frame, kind, columns, coupled }) => [frame, kind, columns, coupled.map(({ frame: name }) => name)]),
    [
      ["HeadYaw", "gaze", [8, 7], []],
      ["LSlide", "hand", [0, 1, 2, 3], ["RSlide"]],
      ["RSlide", "foot", [0, 4, 5, 6], ["LSlide"]],
    ],
  );
});

const within = (q) => q.map((value, k) => clamp(value, about.coordinates[k].lower, about.coordinates[k].upper));

test("a reachable place is reached, inside all limits, and the coupled limb stays", () => {
  const [, hand] = limbsOf(about);
  let tried = 0;
  for (let i = 0; i < 300; i++) {
    const q = within(near(Q, 0.1));
    // The shared coordinate stays, so that the other hand can stay too.
    const goal = within([q[0], ...near(q.slice(1, 4), 0.05), ...q.slice(4)]);
    if (!inside(q) || !inside(goal)) continue;
    tried++;
    const follower = new Follower(hand, q);
    const place = hand.chain.forward(goal).p;
    const { q: found } = follower.toPlace(place, q);
    assert.ok(inside(found), `${found}`);
    assert.ok(distance(hand.chain.forward(found).p, place) < 1e-4);
    const [{ limb, placed }] = follower.kept;
    assert.ok(distance(limb.chain.forward(found).p, placed.p) < 1e-4);
    assert.deepEqual(found.slice(7), q.slice(7));
  }
  assert.ok(tried > 100);
});

test("a place that only a shared coordinate reaches is not reached, for the coupled limb stays", () => {
  const [, hand] = limbsOf(about);
  const follower = new Follower(hand, Q);
  const place = hand.chain.forward(Q.with(0, Q[0] + 0.3)).p;
  const { q } = follower.toPlace(place, Q);
  const [{ limb, placed }] = follower.kept;
  assert.ok(distance(limb.chain.forward(q).p, placed.p) < 1e-3);
  assert.ok(distance(hand.chain.forward(q).p, place) > 0.01);
});

test("a limb whose first joint follows another turns by it too", () => {
  const foot = { ...limbsOf(about)[2], kind: "hand", coupled: [] };
  const place = foot.chain.forward(Q.with(0, Q[0] + 0.3)).p;
  const { q } = new Follower(foot, Q).toPlace(place, Q);
  assert.ok(distance(foot.chain.forward(q).p, place) < 1e-4 && q[0] > Q[0] + 0.2, `${q}`);
});

test("a coupled limit bounds a joint where the other joint has moved to", () => {
  const [, hand] = limbsOf(about);
  // The elbow is at its coupled limit; the shoulder comes down, and the elbow must bend with it.
  const q = [0.1, 0.2, 0.16, 0.05, 0, 0, 0, 0, 0];
  const far = hand.chain.forward([0.1, 0.6, 0.1, 0.05, 0, 0, 0, 0, 0]).p;
  const { q: found } = descend(about, [placeTask(hand.chain, far, 1)], [1, 2], q);
  assert.ok(inside(found), `${found}`);
});

test("out of reach the hand is at the nearest place, and the joints that hold it are named", () => {
  const [, hand] = limbsOf(about);
  const follower = new Follower({ ...hand, coupled: [] }, Q);
  follower.columns = [1, 2, 3];
  const far = [1, -0.2, -0.5];
  const { q, held } = descend(about, [placeTask(hand.chain, far, 1)], [1, 2, 3], Q);
  assert.ok(held.includes(3) && q[3] === 0.1);
  const away = distance(hand.chain.forward(q).p, far);
  for (let i = 0; i < 500; i++) {
    const other = [Q[0], ...near(q.slice(1, 4), 0.2), ...Q.slice(4)];
    if (inside(other)) assert.ok(distance(hand.chain.forward(other).p, far) >= away - 1e-9);
  }
});

test("a joint that is outside its limits comes back or stays, and goes no farther out", () => {
  const [, hand] = limbsOf(about);
  const outside = Q.with(3, 0.12);
  for (const by of [0.05, -0.05]) {
    const { p } = hand.chain.forward(outside);
    const { q } = descend(about, [placeTask(hand.chain, [p[0] + by, p[1], p[2]], 1)], [1, 2, 3], outside);
    assert.ok(q[3] <= 0.12 && q[3] >= 0);
  }
});

test("a stretched limb bends when it is pulled inwards", () => {
  const straight = [0, 0, 0.1, 0, 0, 0, 0, 0, 0];
  const hand = { ...limbsOf(about)[2], kind: "hand", coupled: [] };
  const { p } = hand.chain.forward(straight);
  const place = [p[0] - 0.01, p[1], p[2]];
  const { q } = new Follower(hand, straight).toPlace(place, straight);
  assert.ok(q[5] > 0.3 && distance(hand.chain.forward(q).p, place) < 1e-5, `${q}`);
});

test("a limb ends at a point of its frame", () => {
  const ends = [{ frame: "LSlide", point: [0.05, 0, 0.02] }];
  const [, hand] = limbsOf({ ...about, ends });
  const { p, R } = new Chain(about, hands[0]).forward(Q);
  const tip = p.map((value, i) => value + 0.05 * R[3 * i] + 0.02 * R[3 * i + 2]);
  assert.ok(distance(hand.chain.forward(Q).p, tip) < 1e-12);
});

test("the base moves and turns while its feet stay, or comes as near as they let it", () => {
  const standing = { ...about, soles: hands.map((link) => ({ link })) };
  assert.ok(isStanding(standing) && !isStanding({ ...about, soles: [] }));
  const base = limbsOf(standing).at(-1);
  assert.deepEqual([base.kind, base.frame], ["base", "torso"]);
  const q = [...Q, 0, 0, 0, 0, 0, 0];
  const follower = new Follower(base, q);
  const slip = (to) =>
    Math.max(...follower.kept.map(({ limb, placed }) => distance(limb.chain.forward(to).p, placed.p)));
  for (const [place, isNear] of [
    [[0.01, 0, -0.02], true],
    [[0.5, 0, 0], false],
  ]) {
    const { q: found } = follower.toPlace(place, q);
    assert.equal(distance(base.chain.forward(found).p, place) < 1e-4, isNear);
    assert.ok(slip(found) < 1e-5 && inside(found.slice(0, 9)), `${slip(found)}`);
  }
  const R = rotationAbout([0, 0, 1], 0.01);
  const { q: turned } = follower.toTurn(R, [0, 0, 1], q);
  const off = angleBetween(base.chain.forward(turned).R, R);
  assert.ok(off < 1e-4 && slip(turned) < 1e-5, `${off} ${slip(turned)}`);
});

test("a place in another branch is found, inside all limits, and one beyond the limb is not looked for", () => {
  const arm = { ...empty(), soles: [], eyes: [], root: "torso", ends: [{ frame: "c", point: [0.1, 0, 0] }] };
  const addJoint = addTo(arm);
  ["a", "b", "c"].forEach((name, i) => addJoint(name, i, at(0.1, 0, 0), [0, 0, 1], i));
  arm.frames = arm.links.map(({ name }, link) => ({ name, link }));
  arm.coordinates = [1.5, 2.5, 0.5].map((upper, column) => ({ joint: `${column}`, column, lower: -upper, upper }));
  const [limb] = limbsOf(arm);
  let [missed, found] = [0, 0];
  for (let i = 0; i < 60; i++) {
    const [q, goal] = [0, 1].map(() => arm.coordinates.map(({ upper }) => upper * (2 * random() - 1)));
    const place = limb.chain.forward(goal).p;
    const follower = new Follower(limb, q);
    const far = (to) => distance(limb.chain.forward(to).p, place);
    const { q: first } = follower.toPlace(place, q);
    if (far(first) < 1e-3) continue;
    missed++;
    const again = follower.anew(place, first);
    found += again && far(again.q) < 1e-3;
    if (again) again.q.forEach((value, k) => assert.ok(Math.abs(value) <= arm.coordinates[k].upper));
  }
  assert.ok(missed > 5 && found > 0.9 * missed, `${found} of ${missed}`);
  assert.equal(new Follower(limb, [0, 0, 0]).anew([0.5, 0, 0], [0.1, 0, 0]), null);
});
