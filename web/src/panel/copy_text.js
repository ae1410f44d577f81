import { element } from "./element.js";

/**
 * Put a text on the clipboard. Where the browser does not allow it, the text is shown, selected, to be copied by hand.
 *
 * @param {string} text
 * @param {string} what it is
 * @returns {Promise<Node | string>} what there is to say
 */
export async function copyText(text, what) {
  try {
    await navigator.clipboard.writeText(text);
    return `Copied: ${what}.`;
  } catch {
    const field = element("textarea", { value: text, readOnly: true, rows: 3, ariaLabel: what });
    requestAnimationFrame(() => {
      field.focus();
      field.select();
    });
    const label = element(
      "label",
      { className: "by-hand" },
      "The browser keeps the clipboard shut; copy it from here:",
    );
    label.append(field);
    return label;
  }
}
