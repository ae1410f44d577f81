import { clamp } from "../math/numbers.ts";
import { isInside } from "../robot/nodes.ts";
import type { Robot } from "../robot/robot.ts";
import { THREE, cornersOf } from "../three.ts";
import type { MeshcatViewer } from "../types.ts";

// The largest number of letters (`most`), and sizes in pixels for a picture whose shorter side is `across`.
const BUBBLE = { most: 280, gap: 16, corner: 14, tail: 11, across: 560 };

/** The side of the head on which the bubble is. */
type Side = "right" | "left" | "above" | "below";

/** A speech bubble beside the head with the words of the robot; screen readers read it. */
export class Speech {
  node;
  corners: THREE.Vector3[];

  constructor(
    readonly viewer: MeshcatViewer,
    robot: Robot,
    public bubble: HTMLElement,
    readonly bar: HTMLElement,
  ) {
    const link = robot.about.head ?? 0;
    this.node = robot.nodes[link];
    const box = robot.boxIn(
      link,
      robot.meshes.filter(({ mesh }) => isInside(mesh, this.node)),
    );
    this.corners = cornersOf(box);
  }

  say(text: string) {
    const letters = [...text.trim()];
    const { most } = BUBBLE;
    this.bubble.textContent = letters.length > most ? `${letters.slice(0, most).join("")}…` : letters.join("");
    this.viewer.set_dirty();
  }

  /** Put the bubble beside the head; called for every frame. */
  place() {
    if (!this.bubble.textContent) return;
    const pane = this.viewer.renderer.domElement;
    const { x, y, tail, side } = this.spot(
      pane.clientWidth,
      pane.clientHeight,
      this.bar.offsetTop + this.bar.offsetHeight,
    );
    this.bubble.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px)`;
    this.bubble.dataset.side = side;
    // The style draws it beyond the bubble's box by the length of the tail.
    const outline = this.outline(side, Math.round(tail), BUBBLE.tail);
    this.bubble.style.setProperty("--outline", `path("${outline}")`);
  }

  /**
   * Place the bubble in a picture of this size under a bar: its position, the side of the head, and the position of the tail
   * along its edge. It takes the first side with room, or below the head if there is none.
   */
  spot(width: number, height: number, bar: number): { x: number; y: number; side: Side; tail: number } {
    const { gap, corner } = BUBBLE;
    const { offsetWidth: w, offsetHeight: h } = this.bubble;
    const seen = this.corners.map((place) =>
      place.clone().applyMatrix4(this.node.matrixWorld).project(this.viewer.camera),
    );
    const xs = seen.map(({ x }) => ((1 + x) / 2) * width);
    const ys = seen.map(({ y }) => ((1 - y) / 2) * height);
    const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    const within = (value: number, least: number, most: number) => clamp(value, least, Math.max(least, most));
    const rooms: Record<string, number> = { right: width - right - w, left: left - w, above: top - bar - h };
    const side = (Object.keys(rooms).find((name) => rooms[name] >= 2 * gap) ?? "below") as Side;
    const [across, mouth] = [(left + right) / 2, top + 0.62 * (bottom - top)];
    const wanted = {
      right: [right + gap, mouth - h + 2 * corner],
      left: [left - gap - w, mouth - h + 2 * corner],
      above: [across - w / 2, top - gap - h],
      below: [across - w / 2, bottom + gap],
    }[side];
    const [x, y] = [within(wanted[0], gap, width - gap - w), within(wanted[1], bar + gap, height - gap - h)];
    const [at, edge] = side === "above" || side === "below" ? [across - x, w] : [mouth - y, h];
    return { x, y, side, tail: within(at, 1.5 * corner, edge - 1.5 * corner) };
  }

  /**
   * The outline of the bubble and its tail as a path of SVG.
   *
   * @param tail position of the tail along the side
   * @param shift of the path to the right and down
   */
  outline(side: Side, tail: number, shift: number) {
    const { corner: r, tail: size } = BUBBLE;
    const { offsetWidth: w, offsetHeight: h } = this.bubble;
    const [before, after] = [tail - size, tail + size / 2];
    // Clockwise, as the box.
    const tip = {
      right: [1, before, 1, after, -size, after],
      left: [w - 1, before, w + size, after, w - 1, after],
      above: [after, h - 1, after, h + size, before, h - 1],
      below: [before, 1, after, -size, after, 1],
    }[side].map((place) => place + shift);
    const turn = (x: number, y: number) => `a${r} ${r} 0 0 1 ${x} ${y}`;
    const [across, down] = [w - 2 * r, h - 2 * r];
    const box = `h${across}${turn(r, r)}v${down}${turn(-r, r)}h${-across}${turn(-r, -r)}v${-down}${turn(r, -r)}`;
    return `M${r + shift} ${shift}${box}ZM${tip.join(" ")}Z`;
  }

  /** Paint the bubble on a picture. */
  paint(ink: CanvasRenderingContext2D, width: number, height: number) {
    if (!this.bubble.textContent) return;
    const scale = Math.min(width, height) / BUBBLE.across;
    const { x, y, tail, side } = this.spot(width / scale, height / scale, 0);
    const style = getComputedStyle(this.bubble);
    ink.save();
    ink.scale(scale, scale);
    ink.translate(x, y);
    Object.assign(ink, { shadowColor: "rgba(29,36,51,0.22)", shadowBlur: 22 * scale, shadowOffsetY: 6 * scale });
    ink.fillStyle = getComputedStyle(this.bubble, "::before").backgroundColor;
    ink.fill(new Path2D(this.outline(side, tail, 0)));
    ink.shadowColor = "transparent";
    Object.assign(ink, { font: `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`, fillStyle: style.color });
    ink.textBaseline = "middle";
    for (const { text, left, middle } of this.lines()) ink.fillText(text, left, middle);
    ink.restore();
  }

  /** The lines into which the browser has broken the text, and their positions in the bubble. */
  lines() {
    const node = this.bubble.firstChild as Text;
    const { left, top } = this.bubble.getBoundingClientRect();
    const range = document.createRange();
    const lines: { text: string; top: number; left: number; middle: number }[] = [];
    let from = 0;
    for (const letter of node.data) {
      range.setStart(node, from);
      range.setEnd(node, (from += letter.length));
      const box = range.getBoundingClientRect();
      const line = lines[lines.length - 1];
      if (line && Math.abs(box.top - line.top) < box.height / 2) line.text += letter;
      else lines.push({ text: letter, top: box.top, left: box.left - left, middle: box.top + box.height / 2 - top });
    }
    return lines;
  }
}
