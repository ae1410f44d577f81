import { leaderFrom, placeLabels } from "../math/label_layout.js";
import { THREE } from "../three.js";

/** @typedef {import("../math/label_layout.js").Anchor} Anchor */
/** @typedef {{ text: string, node: THREE.Object3D, colour: string | null, anchor: Anchor }} Label */

const FONT = "600 12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
const [HEIGHT, PADDING, LONGEST] = [17, 5, 60];

/** Names over the picture, each with a line to what it names; none covers another. */
export class Labels {
  /**
   * @param {import("../types.js").MeshcatViewer} viewer
   * @param {HTMLElement} pane
   * @param {HTMLElement} bar over the picture, which labels keep clear of
   */
  constructor(viewer, pane, bar) {
    this.viewer = viewer;
    this.bar = bar;
    this.pane = pane;
    this.canvas = document.createElement("canvas");
    this.canvas.id = "labels";
    this.canvas.ariaHidden = "true";
    this.canvas.hidden = true;
    pane.after(this.canvas);
    this.ink = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d"));
    /** Labels of each who draws them. @type {Map<object, Label[]>} */
    this.owners = new Map();
    this.point = new THREE.Vector3();
    /** What was placed last: the texts, and where. @type {{ text: string, at: import("../math/label_layout.js").Rectangle }[]} */
    this.shown = [];
  }

  /**
   * Write the labels of one who draws them anew.
   *
   * @param {object} owner
   * @param {{ text: string, node: THREE.Object3D, colour?: string }[]} labels at the origins of nodes
   */
  set(owner, labels) {
    this.ink.font = FONT;
    const made = labels.map(({ text, node, colour = null }) => {
      const letters = [...text];
      const short = letters.length > LONGEST ? `${letters.slice(0, LONGEST).join("")}…` : text;
      const width = this.ink.measureText(short).width + 2 * PADDING + (colour ? 11 : 0);
      return { text: short, node, colour, anchor: { x: 0, y: 0, width, height: HEIGHT, place: -1 } };
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
    this.paint(this.ink, width, height, this.bar.offsetTop + this.bar.offsetHeight);
  }

  /**
   * Draw them on a picture of the scene.
   *
   * @param {CanvasRenderingContext2D} ink
   * @param {number} width of the picture, in the pixels that letters are measured in
   * @param {number} height
   * @param {number} top height of what covers the picture's upper edge
   */
  paint(ink, width, height, top = 0) {
    const labels = [...this.owners.values()].flat();
    const { camera } = this.viewer;
    for (const { node, anchor } of labels) {
      const { x, y, z } = this.point.setFromMatrixPosition(node.matrixWorld).project(camera);
      anchor.x = z < 1 ? (0.5 + 0.5 * x) * width : NaN;
      anchor.y = (0.5 - 0.5 * y) * height;
    }
    const picture = { x: 4, y: top + 4, width: width - 8, height: height - top - 8 };
    const places = placeLabels(
      labels.map(({ anchor }) => anchor),
      picture,
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
 * @param {CanvasRenderingContext2D} ink
 * @param {Label} label
 * @param {import("../math/label_layout.js").Rectangle} at
 * @param {string} text colour
 * @param {string} paper colour
 */
function paintLabel(ink, label, { x, y, width, height }, text, paper) {
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
