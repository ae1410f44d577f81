import { element } from "./element.ts";

let count = 0;

/**
 * A button that opens what hangs under it. Escape and a press beside it close it.
 *
 * @param label of what opens
 */
export function menu(button: HTMLButtonElement, label: string, ...children: Node[]) {
  const sheet = element("div", { className: "menu", id: `menu-${count++}` }, ...children);
  sheet.setAttribute("popover", "auto");
  sheet.setAttribute("role", "group");
  sheet.setAttribute("aria-label", label);
  button.setAttribute("aria-expanded", "false");
  button.setAttribute("popovertarget", sheet.id);
  sheet.addEventListener("toggle", () => {
    const open = sheet.matches(":popover-open");
    button.setAttribute("aria-expanded", String(open));
    if (open) place(sheet, button);
    if (open) (sheet.querySelector("button, input:checked") as HTMLElement | null)?.focus();
  });
  return sheet;
}

/** Put a sheet under a button, or over it where there is more room, inside the window. */
function place(sheet: HTMLElement, button: HTMLElement) {
  const gap = 4;
  const { left, right, top, bottom } = button.getBoundingClientRect();
  const { offsetWidth: width, offsetHeight: height } = sheet;
  const x = Math.min(left + width > innerWidth - gap ? right - width : left, innerWidth - width - gap);
  const below = bottom + gap + height <= innerHeight || innerHeight - bottom >= top;
  const y = below ? Math.min(bottom + gap, innerHeight - height - gap) : top - gap - height;
  sheet.style.left = `${Math.max(gap, x)}px`;
  sheet.style.top = `${Math.max(gap, y)}px`;
}
