import type { App } from "../app.ts";
import { Refused } from "../values/literals.ts";
import { readConfiguration } from "../values/reading.ts";
import { motionOf } from "../timeline/formats.ts";
import { FORMATS } from "../values/configurations.ts";
import { button, copyText, element, openDialog } from "./element.ts";
import type { Messages } from "./tools.ts";

/** Copies and pastes configurations as text: by the clipboard, or by a text field if the browser forbids that. */
export class Exchange {
  constructor(
    readonly page: App,
    readonly messages: Messages,
  ) {}

  /** The formats in which a configuration of this robot can be copied. */
  get formats() {
    return Object.entries(FORMATS).filter(([, { naoqi }]) => !naoqi || this.page.robot.about.naoqi.length > 0);
  }

  copyConfiguration(format: string) {
    const { robot, stance } = this.page;
    const { title, write } = FORMATS[format];
    return this.copy(write(robot.about, stance.q, robot.outside(stance.q).size === 0), title);
  }

  async copy(text: string, what: string) {
    if (await copyText(text, what)) this.messages.say(`${what} copied`);
  }

  // Paste the text of the clipboard if the page may read it; else open a field to paste into.
  async paste() {
    let text;
    try {
      text = await navigator.clipboard.readText();
    } catch {
      return this.askForText();
    }
    this.take(text);
  }

  askForText() {
    const field = element("textarea", { rows: 8, spellcheck: false, ariaLabel: "Text of a configuration" });
    const problem = element("p", { className: "problem", id: "paste-problem", role: "alert" });
    field.setAttribute("aria-describedby", problem.id);
    const apply = button("Show it", () => {
      const reason = this.show(field.value);
      problem.textContent = reason ?? "";
      field.setAttribute("aria-invalid", String(reason !== null));
      if (reason === null) field.closest("dialog")?.close();
    });
    openDialog(
      "Paste a configuration",
      element(
        "p",
        {},
        "Values in radians: JSON, a CSV row under its header, Python, a list of all values, calls of NAOqi’s setAngles or angleInterpolation, or a timeline that Choregraphe exported.",
      ),
      field,
      problem,
      element("footer", {}, apply),
    );
    field.focus();
  }

  take(text: string) {
    const reason = this.show(text);
    if (reason !== null) this.messages.say(`Not pasted: ${reason}`, { bad: true });
  }

  /**
   * Show the configuration in a text, or play its motion.
   *
   * @returns why nothing changed, or null if the configuration is shown
   */
  show(text: string): string | null {
    const { robot, stance, player } = this.page;
    try {
      const read = readConfiguration(robot.about, stance.q, text);
      if (read.tracks) {
        player.files.take(read.kind, motionOf(robot.about, read.tracks, read.q));
        return null;
      }
      stance.jump(read.q, stance.up);
      stance.settle();
      const outside = robot.outside(read.q).size;
      const values = `${read.count} value${read.count === 1 ? "" : "s"} from ${read.kind}`;
      this.messages.say(outside ? `${values}; ${outside} outside the limits` : values);
      return null;
    } catch (error) {
      if (error instanceof Refused) return error.message;
      throw error;
    }
  }
}
