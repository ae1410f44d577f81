import { element, iconButton } from "../panel/element.ts";
import type { Editor } from "./editor.ts";

/** The buttons over the track of key frames, and what they say of keys that are too fast. */
export class KeyTools {
  add = element("button", { type: "button", className: "add", title: "Add key (K)" }, "Add key");
  ofKey: HTMLButtonElement[];
  interpolation = element(
    "select",
    { ariaLabel: "Between the keys", title: "Between the keys" },
    element("option", { value: "linear" }, "Linear"),
    element("option", { value: "smooth" }, "Smooth"),
  );
  back: HTMLButtonElement;
  again: HTMLButtonElement;
  problem = element("span", { className: "problem" });
  slow = element("button", { type: "button" }, "Slow down");
  element: HTMLDivElement;

  constructor(readonly editor: Editor) {
    this.add.onclick = () => editor.adding();
    /** What is done to the key that is selected. */
    this.ofKey = [
      iconButton("replace", "Replace by what is shown", () => editor.replacing()),
      iconButton("copy", "Duplicate the key", () => editor.duplicating()),
      iconButton("trash", "Delete the key", () => editor.deleting(), "Del"),
    ];
    this.interpolation.onchange = () => editor.interpolate(this.interpolation.value === "smooth" ? "smooth" : "linear");
    this.back = iconButton("undo", "Undo the change of key frames", () => editor.undo(), "Ctrl+Z");
    this.again = iconButton("redo", "Redo the change of key frames", () => editor.redo(), "Ctrl+Shift+Z");
    this.problem.setAttribute("role", "status");
    this.slow.onclick = () => editor.slowDown();
    const actions = [this.add, ...this.ofKey, this.interpolation, this.back, this.again];
    this.element = element(
      "div",
      { className: "head" },
      element("div", { className: "actions" }, ...actions),
      element("div", { className: "tooFast" }, this.problem, this.slow),
    );
  }

  refresh(tooFast: { text: string }[]) {
    const { history, selected, frames } = this.editor;
    const more = tooFast.length > 1 ? ` and ${tooFast.length - 1} more` : "";
    const problem = tooFast.length > 0 ? `${tooFast[0].text}${more}` : "";
    // A text that stays is not read out again.
    if (this.problem.textContent !== problem) this.problem.textContent = problem;
    this.slow.hidden = tooFast.length === 0;
    this.interpolation.value = frames.interpolation;
    // A disabled button would lose the focus to nothing.
    const disable = (tool: HTMLButtonElement, on: boolean) => tool.setAttribute("aria-disabled", String(on));
    for (const tool of this.ofKey) disable(tool, selected < 0);
    disable(this.back, history.past.length === 0);
    disable(this.again, history.future.length === 0);
  }
}
