import type { About, JointAbout } from "../types.ts";

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

/**
 * The name of a frame that is the link's own: the link's if it has one, else that of the nearest link which carries it.
 */
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
