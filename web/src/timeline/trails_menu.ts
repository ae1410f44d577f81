import { element, iconButton } from "../panel/element.ts";
import { menu } from "../panel/menu.ts";
import type { Mode, Trails } from "../scene/trails.ts";

const MODES: Record<Mode, string> = { off: "None", behind: "Behind what moves", whole: "Of all that is played" };

/** Which frames leave a trail, and when. */
export class TrailsMenu {
  button = iconButton("trail", "Trails of frames", () => {});
  menu: HTMLDivElement;

  constructor(trails: Trails) {
    const modes = (Object.keys(MODES) as Mode[]).map((mode) => {
      const radio = element("input", { type: "radio", name: "trails", checked: mode === trails.mode });
      radio.onchange = () => {
        trails.setMode(mode);
        this.button.classList.toggle("on", mode !== "off");
      };
      return element("label", {}, radio, MODES[mode]);
    });
    const { about } = trails.app.robot;
    const others = about.frames.map(({ name }) => name).filter((name) => !about.effectors.includes(name));
    const frames = [...about.effectors, ...others].map((name) => {
      const box = element("input", { type: "checkbox", checked: trails.frames.has(name) });
      box.onchange = () => trails.choose(name, box.checked);
      return element("label", {}, box, name);
    });
    this.menu = menu(
      this.button,
      "Trails of frames",
      element("fieldset", { className: "modes" }, element("legend", {}, "Trails"), ...modes),
      element("fieldset", { className: "frames" }, element("legend", {}, "Frames"), ...frames),
    );
    this.menu.classList.add("trails");
  }
}
