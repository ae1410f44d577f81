import { element } from "./element.js";

/**
 * All frames for a list to choose from, the effectors first.
 *
 * @param {import("../types.js").About} about
 * @param {string} prefix of the values, which are the names
 */
export function frameOptions(about, prefix = "") {
  const others = about.frames.map(({ name }) => name).filter((name) => !about.effectors.includes(name));
  return [group("effectors", about.effectors, prefix), group("all frames", others, prefix)];
}

/**
 * @param {string} label
 * @param {string[]} names
 * @param {string} prefix
 */
function group(label, names, prefix) {
  const made = element("optgroup", { label });
  made.append(...names.map((name) => element("option", { value: `${prefix}${name}` }, name)));
  return made;
}
