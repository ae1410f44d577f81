import { icon } from "./icons.js";

/**
 * A new element with properties and children.
 *
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Partial<HTMLElementTagNameMap[Tag]>} [properties]
 * @param {...(string | Node)} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  Object.assign(made, properties);
  made.append(...children);
  return made;
}

/**
 * A button with a text.
 *
 * @param {string} text
 * @param {() => void} onclick
 */
export const button = (text, onclick) => element("button", { type: "button", onclick }, text);

/**
 * A button that is a picture; its label says what it does, its tool tip by which keys too.
 *
 * @param {import("./icons.js").IconName} name
 * @param {string} label
 * @param {() => void} onclick
 * @param {string} [keys]
 */
export function iconButton(name, label, onclick, keys = "") {
  const title = keys ? `${label} (${keys})` : label;
  return element("button", { type: "button", className: "icon-button", ariaLabel: label, title, onclick }, icon(name));
}
