import { openDialog } from "./dialog.ts";
import { element } from "./element.ts";

/**
 * Put a text on the clipboard. Where the browser does not allow it, the text is shown, selected, to be copied by hand.
 *
 * @param what it is
 * @returns whether it is on the clipboard
 */
export async function copyText(text: string, what: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const field = element("textarea", { value: text, readOnly: true, rows: 8, ariaLabel: what });
    const keys = element("p", {}, "The browser keeps the clipboard from this page: copy the text with Ctrl+C or ⌘C.");
    openDialog(`Copy: ${what}`, keys, field);
    field.focus();
    field.select();
    return false;
  }
}
