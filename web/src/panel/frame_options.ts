import { element } from "./element.ts";
import type { About } from "../types.ts";

/**
 * All frames for a list to choose from, the effectors first.
 *
 * @param prefix of the values, which are the names
 */
export function frameOptions(about: About, prefix: string = "") {
  const others = about.frames.map(({ name }) => name).filter((name) => !about.effectors.includes(name));
  return [group("effectors", about.effectors, prefix), group("all frames", others, prefix)];
}

function group(label: string, names: string[], prefix: string) {
  const made = element("optgroup", { label });
  made.append(...names.map((name) => element("option", { value: `${prefix}${name}` }, name)));
  return made;
}
