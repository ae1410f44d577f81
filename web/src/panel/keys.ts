import type { App } from "../app.ts";
import { THREE } from "../three.ts";
import { div, element, handleKey, openDialog } from "./element.ts";
import type { Panel } from "./panel.ts";
import { remember } from "./settings.ts";

/** The list of keys: for each place the keys and what they do. */
const LIST = {
  Everywhere: [
    ["Ctrl+Z", "undo"],
    ["Ctrl+Shift+Z, Ctrl+Y", "redo"],
    ["Ctrl+V", "paste a configuration"],
    ["Space", "play or pause the motion; press the button or open the list that has the focus"],
    ["K", "add a key frame, while the key frames are open"],
    ["/", "filter the joints"],
    ["P", "show or hide the panel"],
    ["?", "show this list"],
  ],
  "Sliders and numbers of joints": [
    ["↑ ↓ ← →", "one step (in the field only ↑ ↓): 1°, 1\u00a0mm, 1\u00a0%, 0.01\u00a0rad"],
    ["with Ctrl or Alt", "a tenth of a step"],
    ["with Shift", "ten steps, as Page up and Page down"],
    ["Home, End", "go to the limits (sliders)"],
    ["Delete, double click", "back to the posture chosen last (sliders)"],
    ["Enter, a digit", "type the number; Enter sets it, Escape restores the old one"],
  ],
  "Key frames": [
    ["← →", "move it 0.1 s earlier or later; with Shift 0.01 s"],
    ["↑ ↓, Home, End", "go to the previous, the next, the first, the last key frame"],
    ["Delete", "delete the key frame"],
    ["+ −", "show a shorter or a longer part of the time; also by the wheel or two fingers"],
  ],
  "Handles (Tab, after the buttons over the picture)": [
    ["← → ↑ ↓", "move it by 1 mm; with Shift by 10 mm"],
    ["X, Y, Z", "turn it by 1° about an axis of its frame; with Shift the other way"],
    ["Enter, Escape", "let go, or undo the move"],
  ],
  "The picture": [
    ["← → ↑ ↓", "move the camera around the robot; with Shift three times as far"],
    ["+ −", "move the camera nearer or farther away"],
    ["1 … 9", "choose a camera, in the order of their buttons"],
    ["0, Home", "show the whole robot"],
  ],
  "The line beside the panel": [
    ["Arrows, Home, End", "resize the panel"],
    ["Enter", "hide the panel"],
  ],
};

/** Show a hint on dragging, clicking and keys, until the user first does something; it is shown only once. */
export function giveHint({ page, settings }: Panel) {
  if (!settings.own || settings.kept("hint") === "seen") return;
  const { joints } = page.robot.about;
  const isTouch = matchMedia("(pointer: coarse)").matches;
  const hints = ["Drag to turn"];
  if (joints.length > 0) hints.push(`${isTouch ? "Tap" : "Click"} a limb to drag it`);
  if (joints.length > 0) hints.push("Pull a ring");
  if (!isTouch) hints.push("? lists the keys");
  const line = document.getElementById("hint") as HTMLElement;
  line.replaceChildren(...hints.map((hint) => element("span", {}, hint)));
  line.hidden = false;
  const acted = new AbortController();
  for (const action of ["pointerdown", "keydown", "wheel"]) {
    const { signal } = acted;
    addEventListener(action, () => acted.abort(), { capture: true, passive: true, signal });
  }
  acted.signal.onabort = () => {
    line.hidden = true;
    remember("hint", "seen");
  };
}

/** Keys that work wherever the focus is, except in a text field. */
export class Keys {
  constructor(readonly panel: Panel) {
    document.addEventListener("keydown", (event) => this.press(event));
    document.addEventListener("paste", (event) => this.paste(event));
  }

  press(event: KeyboardEvent) {
    const { target } = event;
    if (event.defaultPrevented || !(target instanceof Element) || target.closest("dialog")) return;
    const does =
      event.ctrlKey || event.metaKey ? this.withCtrl(event, target) : event.altKey ? null : this.alone(event, target);
    if (!does) return;
    event.preventDefault();
    does();
  }

  withCtrl({ key, shiftKey }: KeyboardEvent, target: Element) {
    // A text field has its own undo; the field of a joint's number only while the user types in it.
    if (isTyped(target) && (target.closest(".joint") ? target.matches("[data-typed]") : target.value)) return null;
    const { past } = this.panel;
    const lower = key.toLowerCase();
    if (lower === "y" || (lower === "z" && shiftKey)) return () => past.redo();
    return lower === "z" ? () => past.undo() : null;
  }

  /** Whether a key plays or pauses the motion: Space, unless it types a space, presses a button or opens a list. */
  plays({ key, target }: KeyboardEvent) {
    if (key !== " " || !this.panel.page.player.loaded || !(target instanceof Element)) return false;
    const own = 'dialog, button, select, summary, a, input:is([type="checkbox"], [type="radio"])';
    return !isTyped(target) && !target.closest(own);
  }

  alone(event: KeyboardEvent, target: Element) {
    const { page, layout, joints, settings } = this.panel;
    if (this.plays(event)) return () => event.repeat || page.player.toggle();
    if (!settings.keys || isTyped(target) || target.closest("[popover]")) return null;
    const does: Record<string, () => void> = {
      "?": () => this.help(),
      p: () => layout.fold(!layout.folded),
      "/": () => {
        layout.fold(false);
        joints.search.focus();
      },
    };
    return does[event.key.toLowerCase()] ?? null;
  }

  paste(event: ClipboardEvent) {
    if (!(event.target instanceof Element) || isTyped(event.target)) return;
    if (document.querySelector("dialog[open]")) return;
    event.preventDefault();
    this.panel.exchange.take(event.clipboardData?.getData("text") ?? "");
  }

  help() {
    const sections = Object.entries(LIST).map(([where, rows]) =>
      element(
        "section",
        {},
        element("h3", {}, where),
        element(
          "dl",
          {},
          ...rows.map(([keys, does]) =>
            element("div", {}, element("dt", {}, ...keysOf(keys)), element("dd", {}, does)),
          ),
        ),
      ),
    );
    openDialog("Keys", div("keys", ...sections));
  }
}

/** The keys of a line of the list, each unbroken. */
const keysOf = (keys: string) =>
  keys.split(", ").flatMap((key, i) => (i > 0 ? [", ", element("kbd", {}, key)] : [element("kbd", {}, key)]));

/** Whether keys pressed in this element are typed text. */
function isTyped(target: Element): target is HTMLInputElement | HTMLTextAreaElement {
  return target.matches('textarea, [contenteditable], input:not([type="range"], [type="radio"], [type="checkbox"])');
}

// How far [rad] an arrow key moves the camera around the robot, the factor of distance of a step nearer, and how close
// [rad] the camera may come to straight above or below.
const TURN = Math.PI / 36;
const NEARER = 1 / 1.15;
const POLE = 0.02;

/** Let keys move the camera while the picture has the focus. */
export function bindViewKeys(page: App) {
  const canvas = page.viewer.renderer.domElement;
  const { name, cameras } = page.robot.about;
  const ariaLabel = `${name}, seen by a camera that arrow keys, plus, minus and numbers move`;
  Object.assign(canvas, { tabIndex: 0, role: "application", ariaLabel });
  const presets = cameras.slice(0, 9).map((camera, i) => [String(i + 1), () => page.camera(camera.name)]);
  canvas.addEventListener("keydown", (event) => {
    const turn = event.shiftKey ? 3 * TURN : TURN;
    const go = (around: number, down: number, further: number) => () => orbit(page, around, down, further);
    const [nearer, further, all] = [go(0, 0, NEARER), go(0, 0, 1 / NEARER), () => page.camera(whole(page))];
    handleKey(event, {
      ...{
        ArrowLeft: go(-turn, 0, 1),
        ArrowRight: go(turn, 0, 1),
        ArrowUp: go(0, -turn, 1),
        ArrowDown: go(0, turn, 1),
      },
      ...{ "+": nearer, "=": nearer, "-": further, _: further, 0: all, Home: all },
      ...Object.fromEntries(presets),
    });
  });
}

/** The preset chosen last if it shows the whole body, else the default one. */
export function whole({ view, robot }: App) {
  const chosen = robot.about.cameras.find(({ name }) => name === view);
  return chosen && chosen.links.length === 0 ? chosen.name : "three-quarter";
}

/** Move the camera around the point that it looks at. */
function orbit(page: App, around: number, down: number, further: number) {
  const { camera, controls } = page.viewer;
  const place = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target));
  place.theta += around;
  place.phi = THREE.MathUtils.clamp(place.phi + down, POLE, Math.PI - POLE);
  place.radius = THREE.MathUtils.clamp(place.radius * further, 3 * camera.near, 0.5 * camera.far);
  camera.position.setFromSpherical(place).add(controls.target);
  controls.update();
  page.viewer.set_dirty();
}
