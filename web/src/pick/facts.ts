import { carrierOf, Chain } from "../ik/chain.ts";
import { quaternionOf, rollPitchYaw } from "../math/rotations.ts";
import type { About, JointAbout } from "../types.ts";
import { spoken, unitOf, type Choice } from "../values/units.ts";

/**
 * Write a value of a coordinate as the panel does, with its unit.
 *
 * @param kind the coordinate's unit: "rad", "m" or "1"
 */
export function unitText(value: number, kind: string, choice: Choice) {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  return spoken(value, unitOf(kind, choice));
}

/** The joints that carry a link, from the root outwards. */
export const joints = (about: About, link: number) => new Chain(about, link).joints;

/** The last joint that carries a link; null for a link that is fixed to the root. */
export const jointOf = (about: About, link: number) => carrierOf(about, about.links[link].path) ?? null;

/** Whether two links belong to one limb, that is, joints of the same chain move them. */
export function isOneLimb(about: About, link: number, other: number) {
  const [one, two] = [link, other].map((number) => {
    const joint = jointOf(about, number);
    const has = (name: string | undefined) =>
      about.chains.find((chain) => chain.joints.some((own) => own.name === name));
    return has(joint?.name) ?? has(joint?.follows) ?? joint;
  });
  return one !== null && one === two;
}

/** The name of the frame to select for a link: the link's own frame, else that of the nearest link that carries it. */
export function frameOf(about: About, link: number) {
  const { path } = about.links[link];
  const names = new Set(about.frames.map(({ name }) => name));
  const carriers = about.links
    .filter((other) => names.has(other.name) && other.path.every((name, i) => name === path[i]))
    .sort((a, b) => b.path.length - a.path.length);
  return carriers[0]?.name ?? about.frames.find((frame) => frame.link === link)?.name ?? null;
}

/** The kind of a joint: its lower pair, or the pair that it is a part of. */
export function pairOf({ pair, slides }: JointAbout) {
  const own = slides ? "prismatic" : "revolute";
  return !pair || pair === own ? `${own} pair` : `${own}, of a ${pair} pair`;
}

/**
 * A pose in numbers, in metres and radians. Quaternions are scalar first. As in `nao_kin.rotations.quat_from_matrix`,
 * r0 > 0, or r0 = 0 and the first other nonzero number is positive.
 *
 * @param matrix column by column
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

const list = (values: number[]) => `[${values.map((value) => String(value + 0)).join(", ")}]`;

/**
 * The forms in which a pose can be copied: the name of the button, and the text, in metres and radians with all digits.
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
