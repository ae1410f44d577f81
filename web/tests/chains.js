// NAO's limbs as chains of rotations and displacements, from their definition, to check the closed forms against.
import assert from "node:assert/strict";

// The limbs of a NAO V6, from `nk.ik.limbs`.
import LIMBS from "./limbs.json";

export { LIMBS };

export const numbersOf = (frame) => LIMBS.find((limb) => limb.frame === frame);

/** The same limb whose joints may turn all the way round. */
export const unlimited = (numbers) => ({
  ...numbers,
  lower: numbers.lower.map(() => -Math.PI),
  upper: numbers.upper.map(() => Math.PI),
  table: null,
});

/** The same limb with its frame turned in the link, as CameraBottom is in the head. */
export function turnedFrame(numbers) {
  const { rotation } = numbersOf("CameraBottom").geometry;
  const geometry = { ...numbers.geometry, rotation, turned: 1 };
  return { ...numbers, geometry };
}

const [X, Y, Z] = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];

// From the torso outwards: axes of joints, and displacements in the link between them.
const CHAINS = {
  leg: ({ kappa, hip, thigh, tibia, place }) => [
    { by: hip },
    { axis: [0, Math.cos(kappa), Math.sin(kappa)] },
    { axis: X },
    { axis: Y },
    { by: [0, 0, -thigh] },
    { axis: Y },
    { by: [0, 0, -tibia] },
    { axis: Y },
    { axis: X },
    { by: place },
  ],
  arm: ({ shoulder, elbow_x, elbow_y, place }) => [
    { by: shoulder },
    { axis: Y },
    { axis: Z },
    { by: [elbow_x, elbow_y, 0] },
    { axis: X },
    { axis: Z },
    { axis: X },
    { by: place },
  ],
  head: ({ neck, place }) => [{ by: neck }, { axis: Z }, { axis: Y }, { by: place }],
};
CHAINS.gaze = CHAINS.head;

const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];

const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);

/** v turned about a unit vector: v cos φ + a × v sin φ + a (a · v) (1 − cos φ), Rodrigues' formula. */
export function turnedAbout(a, angle, v) {
  const [c, s, axv] = [Math.cos(angle), Math.sin(angle), cross(a, v)];
  return v.map((value, i) => value * c + axv[i] * s + a[i] * dot(a, v) * (1 - c));
}

// A point or direction of the last link in the torso.
function carried({ kind, geometry }, q, v, isPoint) {
  const values = [...q];
  return CHAINS[kind](geometry).reduceRight((w, { axis, by }) => {
    if (axis) return turnedAbout(axis, values.pop(), w);
    return isPoint ? w.map((value, i) => value + by[i]) : w;
  }, v);
}

/** Pose of a limb's frame in the torso: sixteen numbers, row by row. */
export function poseOf(numbers, q) {
  const [a00, a01, a02, a10, a11, a12, a20, a21, a22] = numbers.geometry.rotation;
  const place = carried(numbers, q, [0, 0, 0], true);
  const axes = [
    [a00, a10, a20],
    [a01, a11, a21],
    [a02, a12, a22],
  ].map((axis) => carried(numbers, q, axis, false));
  return [...[0, 1, 2].flatMap((row) => [...axes.map((axis) => axis[row]), place[row]]), 0, 0, 0, 1];
}

export const placeIn = (T) => [T[3], T[7], T[11]];

/** The x axis of a pose. */
export const forwardIn = (T) => [T[0], T[4], T[8]];

/** A pose with its place moved. */
export const movedBy = (T, by) => T.map((value, i) => (i % 4 === 3 && i < 12 ? value + by[(i - 3) / 4] : value));

export const unit = (v) => v.map((value) => value / Math.hypot(...v));

/** Numbers in [0, 1) that are the same in every run (mulberry32). */
export function generator(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** A number of random joint values, within the joints' own ranges but not the coupled ones. */
export function randomValues(numbers, count, seed) {
  const random = generator(seed);
  return Array.from({ length: count }, () => numbers.lower.map((low, i) => low + (numbers.upper[i] - low) * random()));
}

/** Whether values are inside the limits, with an independent reading of the coupled limits. */
export function areInside({ lower, upper, table }, values, slack = 2e-9) {
  if (values.some((value, i) => value < lower[i] - slack || value > upper[i] + slack)) return false;
  if (!table) return true;
  const { at, of, joint } = table;
  const x = Math.min(Math.max(values[of], at[0]), at[at.length - 1]);
  const i = Math.max(1, at.filter((bend) => bend < x).length);
  const share = (x - at[i - 1]) / (at[i] - at[i - 1]);
  const [low, high] = [table.lower, table.upper].map((bounds) => bounds[i - 1] * (1 - share) + bounds[i] * share);
  return low - slack <= values[joint] && values[joint] <= high + slack;
}

export function assertClose(actual, expected, tolerance = 1e-10) {
  const off = Math.max(...actual.map((value, i) => Math.abs(value - expected[i])));
  assert.ok(actual.length === expected.length && off <= tolerance, `[${actual}] is not [${expected}]`);
}

/** The difference of two angles without whole turns. */
export const apart = (a, b) => Math.abs(Math.atan2(Math.sin(a - b), Math.cos(a - b)));

/** Whether some branch has these values, up to whole turns. */
export const hasBranch = ({ branches }, q, tolerance = 1e-7) =>
  branches.some(({ values }) => values.every((value, i) => apart(value, q[i]) < tolerance));

/** Check that the branches are sorted by their distance from the reference and are all different. */
export function assertSorted({ branches, reference }) {
  const away = branches.map(({ values }) => values.reduce((sum, value, i) => sum + (value - reference[i]) ** 2, 0));
  assertClose(
    branches.map(({ distance }) => distance),
    away,
  );
  for (let i = 1; i < away.length; i++) {
    assert.ok(away[i - 1] <= away[i]);
    const [one, other] = [branches[i - 1].values, branches[i].values];
    assert.ok(one.some((value, k) => Math.abs(value - other[k]) > 1e-9));
  }
}

/** Check that the answer names the joint, the value that it would need, and the end of its range. */
export function assertBlamed(answer, reason, joint, needed, limit) {
  assert.equal(answer.reason, reason);
  assert.equal(answer.joint, joint);
  assert.equal(answer.branches.length, 0);
  assertClose([answer.needed, answer.limit], [needed, limit], 1e-8);
}

/** Check that the reason comes from the branch, of all branches without limits, that exceeds the limits least. */
export function assertLeastOutside(limb, answer, { branches }) {
  const least = Math.min(...branches.map(({ values }) => limb.excess(values)));
  assertClose([Math.abs(answer.needed - answer.limit)], [least], 1e-8);
}
