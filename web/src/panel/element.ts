import { icon, type IconName } from "./icons.ts";

/** A new element with properties and children. */
export function element<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  properties: Partial<HTMLElementTagNameMap[Tag]> = {},
  ...children: (string | Node)[]
): HTMLElementTagNameMap[Tag] {
  const made = document.createElement(tag);
  Object.assign(made, properties);
  made.append(...children);
  return made;
}

/** A button with a text. */
export const button = (text: string, onclick: () => void) => element("button", { type: "button", onclick }, text);

/** A button that is a picture; its label says what it does, its tool tip by which keys too. */
export function iconButton(name: IconName, label: string, onclick: () => void, keys: string = "") {
  const title = keys ? `${label} (${keys})` : label;
  return element("button", { type: "button", className: "icon-button", ariaLabel: label, title, onclick }, icon(name));
}
