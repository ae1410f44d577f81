import { element, iconButton } from "./element.ts";

// How long [ms] a message stays that nothing has to be done about.
const STAY = 6000;

/** The line under the picture that says what a command did, or why it did nothing. */
export class Messages {
  timer = 0;

  constructor(readonly line: HTMLElement) {}

  /** @param options what went wrong stays until it is closed */
  say(text: string, { bad = false }: { bad?: boolean } = {}) {
    clearTimeout(this.timer);
    this.line.classList.toggle("bad", bad);
    this.line.replaceChildren(
      element("span", {}, text),
      iconButton("close", "Close the message", () => this.close()),
    );
    if (!bad) this.timer = setTimeout(() => this.close(), STAY);
  }

  close() {
    clearTimeout(this.timer);
    this.line.replaceChildren();
    this.line.classList.remove("bad");
  }
}
