import { rollPitchYaw } from "../math/rotations.ts";
import type { About, JointAbout } from "../types.ts";
import { spoken, unitOf, type Choice } from "../values/units.ts";

/**
 * A value of a coordinate as the panel writes it, with its unit.
 *
 * @param kind "rad", "m" or "1", as the coordinate is described
 */
export function unitText(value: number, kind: string, choice: Choice) {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  return spoken(value, unitOf(kind, choice));
}

/** The joints that carry a link, from the root outwards. */
export function joints(about: About, link: number) {
  const { path } = about.links[link];
  const pathOf = (joint: JointAbout) => about.links[joint.link].path;
  return about.joints
    .filter((joint) => pathOf(joint).every((name, i) => name === path[i]))
    .sort((a, b) => pathOf(a).length - pathOf(b).length);
}

/** The joint that moves a link, the last of those that carry it; null for a link that is fixed to the root. */
export const jointOf = (about: About, link: number): JointAbout | null => joints(about, link).at(-1) ?? null;

/** Whether two links are of one limb: joints of one chain move them. */
export function isOneLimb(about: About, link: number, other: number) {
  const [one, two] = [link, other].map((number) => {
    const joint = jointOf(about, number);
    const has = (name: string | undefined) =>
      about.chains.find(({ joints }) => joints.some((own) => own.name === name));
    return has(joint?.name) ?? has(joint?.follows) ?? joint;
  });
  return one !== null && one === two;
}

/** The name of a frame that is the link's own: the link's if it has one, else that of the nearest link which carries it. */
export function frameOf(about: About, link: number) {
  const { path } = about.links[link];
  const names = new Set(about.frames.map(({ name }) => name));
  const carriers = about.links
    .filter((other) => names.has(other.name) && other.path.every((name, i) => name === path[i]))
    .sort((a, b) => b.path.length - a.path.length);
  return carriers[0]?.name ?? about.frames.find((frame) => frame.link === link)?.name ?? null;
}

/** What kind of joint it is: the lower pair that it is, or is a part of. */
export function pairOf({ pair, slides }: JointAbout) {
  const own = slides ? "prismatic" : "revolute";
  return !pair || pair === own ? `${own} pair` : `${own}, of a ${pair} pair`;
}

/**
 * A pose in numbers, in metres and radians. Quaternions are scalar first, with r0 > 0, or r0 = 0 and the first other
 * number that is not zero above it: what `nao_kin.rotations.quat_from_matrix` gives.
 *
 * @param matrix by columns
 */
export function poseNumbers(matrix: { elements: ArrayLike<number> }) {
  const { elements: m } = matrix;
  const rows = [0, 1, 2, 3].map((row) => [0, 1, 2, 3].map((column) => m[row + 4 * column] + 0));
  const quaternion = quaternionOf(matrix);
  const [r0, ...r] = quaternion;
  const length = Math.hypot(...r);
  return {
    position: [m[12], m[13], m[14]],
    rpy: rollPitchYaw(matrix),
    quaternion,
    axis: length > 0 ? r.map((value) => value / length) : [0, 0, 0],
    angle: 2 * Math.atan2(length, r0),
    rows,
  };
}

/**
 * The unit quaternion of a rotation, from the longest row of the matrix 4 r rᵀ: exact at half a turn too.
 *
 * @param matrix by columns
 * @returns scalar first, in canonical sign
 */
export function quaternionOf({ elements: m }: { elements: ArrayLike<number> }): number[] {
  const [d01, d02, d03] = [m[6] - m[9], m[8] - m[2], m[1] - m[4]];
  const [d12, d13, d23] = [m[1] + m[4], m[8] + m[2], m[6] + m[9]];
  const rows = [
    [1 + m[0] + m[5] + m[10], d01, d02, d03],
    [d01, 1 + m[0] - m[5] - m[10], d12, d13],
    [d02, d12, 1 - m[0] + m[5] - m[10], d23],
    [d03, d13, d23, 1 - m[0] - m[5] + m[10]],
  ];
  const longest = rows.reduce((best, row, i) => (row[i] > rows[best][best] ? i : best), 0);
  const row = rows[longest];
  const first = row.find((value) => value !== 0) ?? 1;
  const scale = Math.sign(first) / Math.hypot(...row);
  return row.map((value) => value * scale + 0);
}

const list = (values: number[]) => `[${values.map((value) => String(value + 0)).join(", ")}]`;

/**
 * What is copied of a pose: the name of a button, and the text for the clipboard, in metres and radians with every digit.
 */
export const COPIES: { name: string; title: string; text(pose: ReturnType<typeof poseNumbers>): string }[] = [
  {
    name: "4×4 matrix",
    title: "NumPy array, in m",
    text: ({ rows }) => `np.array([${rows.map(list).join(", ")}])`,
  },
  {
    name: "position6d",
    title: "NAOqi's [x, y, z, wx, wy, wz], in m and rad",
    text: ({ position, rpy }) => list([...position, ...rpy]),
  },
  { name: "rpy", title: "roll, pitch, yaw in rad", text: ({ rpy }) => list(rpy) },
  { name: "quaternion", title: "scalar first", text: ({ quaternion }) => list(quaternion) },
];
