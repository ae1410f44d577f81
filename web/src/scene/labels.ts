import { leaderFrom, placeLabels, type Anchor, type Rectangle } from "../math/label_layout.ts";
import { THREE } from "../three.ts";
import type { MeshcatViewer } from "../types.ts";

interface Label {
  text: string;
  node: THREE.Object3D;
  colour: string | null;
  anchor: Anchor;
  /** from the camera, in [−1, 1] */
  depth: number;
}

const FONT = "600 12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
const [HEIGHT, PADDING, LONGEST] = [17, 5, 60];

/** Names over the picture, each with a line to what it names; none covers another. */
export class Labels {
  canvas = document.createElement("canvas");
  ink: CanvasRenderingContext2D;
  /** Labels of each who draws them. */
  owners: Map<object, Label[]> = new Map();
  point = new THREE.Vector3();
  /** What was placed last: the texts, and where. */
  shown: { text: string; at: Rectangle }[] = [];

  /** @param bar over the picture, which labels keep clear of */
  constructor(
    readonly viewer: MeshcatViewer,
    readonly pane: HTMLElement,
    readonly bar: HTMLElement,
  ) {
    this.canvas.id = "labels";
    this.canvas.ariaHidden = "true";
    this.canvas.hidden = true;
    pane.after(this.canvas);
    this.ink = this.canvas.getContext("2d") as CanvasRenderingContext2D;
  }

  /**
   * Write the labels of one who draws them anew.
   *
   * @param labels at the origins of nodes
   */
  set(owner: object, labels: { text: string; node: THREE.Object3D; colour?: string }[]) {
    this.ink.font = FONT;
    const made = labels.map(({ text, node, colour = null }) => {
      const letters = [...text];
      const short = letters.length > LONGEST ? `${letters.slice(0, LONGEST).join("")}…` : text;
      const width = this.ink.measureText(short).width + 2 * PADDING + (colour ? 11 : 0);
      return { text: short, node, colour, depth: 0, anchor: { x: 0, y: 0, width, height: HEIGHT, place: -1 } };
    });
    this.owners.set(owner, made);
    this.canvas.hidden = [...this.owners.values()].every(({ length }) => length === 0);
  }

  /** Draw them where the last picture has what they name. */
  draw() {
    this.shown = [];
    if (this.canvas.hidden) return;
    const { clientWidth: width, clientHeight: height } = this.pane;
    const ratio = window.devicePixelRatio;
    const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== wide || this.canvas.height !== high) {
      Object.assign(this.canvas, { width: wide, height: high });
    }
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
    this.ink.setTransform(1, 0, 0, 1, 0, 0);
    this.ink.clearRect(0, 0, wide, high);
    this.ink.setTransform(ratio, 0, 0, ratio, 0, 0);
    const eye = document.getElementById("eye");
    const { offsetLeft: x = 0, offsetTop: y = 0, offsetWidth = 0, offsetHeight = 0 } = eye ?? {};
    const covered = { x, y, width: offsetWidth, height: offsetHeight };
    this.paint(this.ink, width, height, this.bar.offsetTop + this.bar.offsetHeight, offsetWidth ? [covered] : []);
  }

  /**
   * Draw them on a picture of the scene.
   *
   * @param width of the picture, in the pixels that letters are measured in
   * @param top height of what covers the picture's upper edge
   * @param covered other parts that are
   */
  paint(ink: CanvasRenderingContext2D, width: number, height: number, top: number = 0, covered: Rectangle[] = []) {
    const { camera } = this.viewer;
    const labels = [...this.owners.values()].flat();
    for (const label of labels) {
      const { node, anchor } = label;
      const { x, y, z } = this.point.setFromMatrixPosition(node.matrixWorld).project(camera);
      anchor.x = z < 1 ? (0.5 + 0.5 * x) * width : NaN;
      anchor.y = (0.5 - 0.5 * y) * height;
      label.depth = z;
    }
    // The nearest come first to a place.
    labels.sort((a, b) => a.depth - b.depth);
    const picture = { x: 4, y: top + 4, width: width - 8, height: height - top - 8 };
    const places = placeLabels(
      labels.map(({ anchor }) => anchor),
      picture,
      covered,
    );
    const style = getComputedStyle(this.pane);
    const [text, paper] = [style.getPropertyValue("--ink"), style.getPropertyValue("--panel")];
    Object.assign(ink, { font: FONT, textBaseline: "middle", lineWidth: 1 });
    this.shown = labels.flatMap((label, i) => (places[i] ? [{ text: label.text, at: places[i] }] : []));
    // First all lines: a name may cover another's line, but no line a name.
    ink.strokeStyle = ink.fillStyle = text;
    labels.forEach(({ anchor }, i) => {
      const at = places[i];
      if (!at) return;
      const from = leaderFrom(at, anchor);
      ink.globalAlpha = 0.55;
      ink.beginPath();
      ink.moveTo(from.x, from.y);
      ink.lineTo(anchor.x, anchor.y);
      ink.stroke();
      ink.globalAlpha = 0.9;
      ink.beginPath();
      ink.arc(anchor.x, anchor.y, 2, 0, 2 * Math.PI);
      ink.fill();
    });
    labels.forEach((label, i) => {
      const at = places[i];
      if (at) paintLabel(ink, label, at, text, paper);
    });
    ink.globalAlpha = 1;
  }
}

/**
 * @param text colour
 * @param paper colour
 */
function paintLabel(
  ink: CanvasRenderingContext2D,
  label: Label,
  { x, y, width, height }: Rectangle,
  text: string,
  paper: string,
) {
  ink.beginPath();
  ink.roundRect(x, y, width, height, 4);
  ink.globalAlpha = 0.86;
  ink.fillStyle = paper;
  ink.fill();
  ink.globalAlpha = 1;
  let left = x + PADDING;
  if (label.colour) {
    ink.fillStyle = label.colour;
    ink.beginPath();
    ink.arc(left + 3.5, y + height / 2, 3.5, 0, 2 * Math.PI);
    ink.fill();
    left += 11;
  }
  ink.fillStyle = text;
  ink.fillText(label.text, left, y + height / 2 + 0.5);
}
