const SVG = "http://www.w3.org/2000/svg";

/** The strokes of each icon on a square of 16 × 16, drawn with a line width of 1.5. */
const STROKES = {
  undo: "M3 6.5h6.5a3.5 3.5 0 0 1 0 7H6M5.5 4 3 6.5 5.5 9",
  redo: "M13 6.5H6.5a3.5 3.5 0 0 0 0 7H10M10.5 4 13 6.5 10.5 9",
  reset: "M3.2 9.5A5 5 0 1 0 4.6 4.4L3 6M3 2.8V6h3.2",
  mirror: "M8 2v2M8 7v2M8 12v2M5.5 4.5v7L1.8 11.5zM10.5 4.5v7l3.7 0z",
  copy: "M6.2 5.5h6.6a.7.7 0 0 1 .7.7v6.6a.7.7 0 0 1-.7.7H6.2a.7.7 0 0 1-.7-.7V6.2a.7.7 0 0 1 .7-.7zM3.5 10.5h-.3a.7.7 0 0 1-.7-.7V3.2a.7.7 0 0 1 .7-.7h6.6a.7.7 0 0 1 .7.7v.3",
  paste:
    "M10.5 3.5h1.8a.7.7 0 0 1 .7.7v8.6a.7.7 0 0 1-.7.7H3.7a.7.7 0 0 1-.7-.7V4.2a.7.7 0 0 1 .7-.7h1.8M6 2.5h4v2H6zM8 7v4M6.2 9.3 8 11l1.8-1.7",
  settings: "M2.5 4.5h6M11.5 4.5h2M2.5 11.5h2M7.5 11.5h6M10 3v3M6 10v3",
  panel: "M3.2 3h9.6a.7.7 0 0 1 .7.7v8.6a.7.7 0 0 1-.7.7H3.2a.7.7 0 0 1-.7-.7V3.7a.7.7 0 0 1 .7-.7zM9.8 3v10",
  record: "M8 4a4 4 0 1 1 0 8a4 4 0 1 1 0-8z",
  key: "M8 2.8 13.2 8 8 13.2 2.8 8z",
  replace: "M2.8 6.2A5.4 5.4 0 0 1 12.6 5M13 2.5V5.3h-2.8M13.2 9.8A5.4 5.4 0 0 1 3.4 11M3 13.5v-2.8h2.8",
  trash: "M3 4.5h10M6.5 4.5V3h3v1.5M4.5 4.5l.6 8.5h5.8l.6-8.5M6.8 7v3.7M9.2 7v3.7",
  plot: "M2.8 2.5v11h10.7M5 10.5l2.2-4 2.4 2.3L13 4",
  file: "M4 2.5h5l3 3v8h-8zM9 2.5v3h3M8 7.5v4M6.2 9.8 8 11.5l1.8-1.700",
  measure: "M2.5 4v8M13.5 4v8M3 8h10M5 6 3 8l2 2M11 6l2 2-2 2",
  more: "m4 10 4-4 4 4",
  close: "m4 4 8 8M12 4l-8 8",
};

export type IconName = keyof typeof STROKES;

/** An icon; the text beside it or its button's label gives its meaning. */
function icon(name: IconName) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  svg.classList.add("icon");
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", STROKES[name]);
  svg.append(path);
  return svg;
}

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

/** A new `div` with a class and children. */
export const div = (className: string, ...children: (string | Node)[]) => element("div", { className }, ...children);

/** A new list to choose from; an option is its value, or its value and its text. */
export function select(ariaLabel: string, options: (string | [string, string])[], onchange = () => {}) {
  const made = options.map((option) => {
    const [value, text] = typeof option === "string" ? [option, option] : option;
    return new Option(text, value);
  });
  return element("select", { ariaLabel, onchange }, ...made);
}

/** Write a text into an element, which is hidden without any; an unchanged text is not written, for screen readers would read it again. */
export function write(line: HTMLElement, text: string) {
  if (line.textContent !== text) line.textContent = text;
  line.hidden = text === "";
}

/** A button with a text. */
export const button = (text: string, onclick: () => void) => element("button", { type: "button", onclick }, text);

/**
 * A button with an icon; its label says what it does, and its tool tip also names the keys.
 *
 * @param word a word of the label that is shown where there is room
 */
export function iconButton(name: IconName, label: string, onclick: () => void, keys: string = "", word: string = "") {
  const title = keys ? `${label} (${keys})` : label;
  const made = { type: "button", className: "icon-button", ariaLabel: label, title, onclick } as const;
  return element("button", made, icon(name), ...(word ? [element("span", { className: "word" }, word)] : []));
}

/**
 * Copy a text to the clipboard. If the browser does not allow it, a dialog shows the text, selected, for you to copy.
 *
 * @returns whether it is on the clipboard
 */
export async function copyText(text: string, what: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const field = element("textarea", { value: text, readOnly: true, rows: 8, ariaLabel: what });
    const keys = element(
      "p",
      {},
      "The browser does not let this page use the clipboard: copy the text with Ctrl+C or ⌘C.",
    );
    openDialog(`Copy: ${what}`, keys, field);
    field.focus();
    field.select();
    return false;
  }
}

/** Open a dialog over the page; it is removed when it closes. Escape and its button close it. */
export function openDialog(title: string, ...children: (string | Node)[]) {
  const heading = element("h2", { id: "dialog-title" }, title);
  const dialog = element(
    "dialog",
    {},
    element(
      "header",
      {},
      heading,
      iconButton("close", "Close", () => dialog.close()),
    ),
    ...children,
  );
  dialog.setAttribute("aria-labelledby", heading.id);
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}

/**
 * Run the action of a key, unless Ctrl, Alt or Meta is held, which makes it a command of the browser.
 *
 * @returns whether the key has an action
 */
export function handleKey(event: KeyboardEvent, does: Record<string, () => void>) {
  if (!Object.hasOwn(does, event.key) || event.ctrlKey || event.metaKey || event.altKey) return false;
  event.preventDefault();
  does[event.key]();
  return true;
}

/** The drawing context of a new canvas. */
export function makeInk(width: number, height: number) {
  const canvas = element("canvas", { width, height });
  return canvas.getContext("2d") as CanvasRenderingContext2D;
}

/** Put buttons into a bar with a single Tab stop: arrow keys, Home and End move the focus between the buttons. */
export function toolbar(bar: HTMLElement, label: string, ...children: HTMLElement[]) {
  bar.replaceChildren(...children);
  Object.assign(bar, { role: "toolbar", ariaLabel: label });
  const buttons = [...bar.querySelectorAll("button")];
  buttons.forEach((one, i) => (one.tabIndex = i === 0 ? 0 : -1));
  bar.addEventListener("focusin", ({ target }) => {
    for (const one of buttons) one.tabIndex = one === target ? 0 : -1;
  });
  bar.addEventListener("keydown", (event) => {
    const there = buttons.filter(({ hidden }) => !hidden);
    const at = there.indexOf(event.target as HTMLButtonElement);
    const go = (to: number) => () => there.at(to % there.length)?.focus();
    const [next, before] = [go(at + 1), go(at - 1)];
    const keys = { ArrowRight: next, ArrowDown: next, ArrowLeft: before, ArrowUp: before, Home: go(0), End: go(-1) };
    if (at >= 0) handleKey(event, keys);
  });
  return bar;
}

let count = 0;

/** Make the menu that a button opens. Escape and a press outside the menu close it. */
export function menu(opener: HTMLButtonElement, label: string, ...children: Node[]) {
  const named = { className: "menu", id: `menu-${count++}`, popover: "auto", role: "group", ariaLabel: label };
  const sheet = element("div", named, ...children);
  opener.setAttribute("aria-expanded", "false");
  opener.setAttribute("popovertarget", sheet.id);
  sheet.addEventListener("toggle", () => {
    const open = sheet.matches(":popover-open");
    opener.setAttribute("aria-expanded", String(open));
    if (open) place(sheet, opener);
    if (open) (sheet.querySelector("button, input:checked") as HTMLElement | null)?.focus();
  });
  return sheet;
}

/** Place a sheet below a button, or above it if there is more room, inside the window; a high sheet scrolls. */
function place(sheet: HTMLElement, opener: HTMLElement) {
  const gap = 4;
  const { left, right, top, bottom } = opener.getBoundingClientRect();
  sheet.style.maxHeight = `${Math.max(top, innerHeight - bottom, innerHeight / 2) - 2 * gap}px`;
  const { offsetWidth: width, offsetHeight: height } = sheet;
  const x = Math.min(left + width > innerWidth - gap ? right - width : left, innerWidth - width - gap);
  const below = bottom + gap + height <= innerHeight || innerHeight - bottom >= top;
  const y = below ? Math.min(bottom + gap, innerHeight - height - gap) : top - gap - height;
  sheet.style.left = `${Math.max(gap, x)}px`;
  sheet.style.top = `${Math.max(gap, y)}px`;
}
