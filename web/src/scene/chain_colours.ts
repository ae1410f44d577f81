import type { About } from "../types.ts";

/** Colours of chains, apart from each other for the colour-blind too (Okabe and Ito), without orange and red. */
const CHAIN_COLOURS = ["#56b4e9", "#009e73", "#f0e442", "#0072b2", "#cc79a7", "#8f9aa8", "#7c4ddb", "#b08900"];

/**
 * The colour of each chain of a robot, and of all links that the joints of the chain carry, up to those of another chain.
 */
export function chainColours(about: About): {
  chains: { title: string; colour: string }[];
  links: Map<number, string>;
} {
  const links = new Map();
  const chains = about.chains.map(({ title, joints }, i) => {
    const colour = CHAIN_COLOURS[i % CHAIN_COLOURS.length];
    const names = new Set(joints.map(({ name }) => name));
    for (const { name, link } of about.joints) if (names.has(name)) links.set(link, colour);
    return { title, colour };
  });
  // What is fixed to a link, or follows it as fingers do, has its colour: parents come first.
  const numbers = new Map(about.links.map(({ path }, link) => [path.join("/"), link]));
  about.links.forEach(({ path }, link) => {
    if (links.has(link)) return;
    for (let end = path.length - 1; end > 0; end--) {
      const holder = numbers.get(path.slice(0, end).join("/"));
      if (holder === undefined) continue;
      if (links.has(holder)) links.set(link, links.get(holder));
      break;
    }
  });
  return { chains, links };
}
