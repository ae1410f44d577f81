import { element, iconButton } from "./element.ts";

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
