import { THREE } from "../three.ts";
import type { MeshcatViewer } from "../types.ts";

interface Label {
  text: string;
  node: THREE.Object3D;
  colour: string | null;
  anchor: Anchor;
  /** The depth seen from the camera, in [−1, 1]. */
  depth: number;
}

const FONT = "600 12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
const [HEIGHT, PADDING, LONGEST] = [17, 5, 60];

/** Labels over the picture, each with a line to its point; no label covers another. */
export class Labels {
  canvas = document.createElement("canvas");
  ink = this.canvas.getContext("2d") as CanvasRenderingContext2D;
  /** The labels by their owner, the part of the page that sets them. */
  owners: Map<object, Label[]> = new Map();
  point = new THREE.Vector3();
  /** The texts, places and points of the labels drawn last. */
  shown: { text: string; at: Rectangle; point: Anchor }[] = [];

  /** @param bar the bar over the picture, which labels must not cover */
  constructor(
    readonly viewer: MeshcatViewer,
    readonly pane: HTMLElement,
    readonly bar: HTMLElement,
  ) {
    this.canvas.id = "labels";
    this.canvas.ariaHidden = "true";
    this.canvas.hidden = true;
    pane.after(this.canvas);
  }

  /**
   * Replace the labels of an owner.
   *
   * @param labels each is at the origin of its node
   */
  set(owner: object, labels: { text: string; node: THREE.Object3D; colour?: string }[]) {
    // Only if there are labels, because a canvas is slow to load its first font.
    if (labels.length > 0) this.ink.font = FONT;
    const made = labels.map(({ text, node, colour = null }) => {
      const letters = [...text];
      const short = letters.length > LONGEST ? `${letters.slice(0, LONGEST).join("")}…` : text;
      const width = this.ink.measureText(short).width + 2 * PADDING + (colour ? 11 : 0);
      return { text: short, node, colour, depth: 0, anchor: { x: 0, y: 0, width, height: HEIGHT, place: -1 } };
    });
    this.owners.set(owner, made);
    this.hide();
  }

  /** Remove an owner and its labels. */
  remove(owner: object) {
    this.owners.delete(owner);
    this.hide();
  }

  hide() {
    this.canvas.hidden = [...this.owners.values()].every(({ length }) => length === 0);
  }

  /** The text of the label under a pointer, or of the one whose point is there; labels that are left out have neither. */
  at({ clientX, clientY }: { clientX: number; clientY: number }) {
    const { left, top } = this.pane.getBoundingClientRect();
    const [x, y] = [clientX - left, clientY - top];
    const isHere = ({ at, point }: Labels["shown"][0]) =>
      contains(at, x, y) || Math.hypot(point.x - x, point.y - y) < 6;
    return this.shown.find(isHere)?.text;
  }

  /** Draw the labels for the last picture. */
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
   * Draw the labels on a picture of the scene.
   *
   * @param width of the picture, in the pixels that letters are measured in
   * @param top height of the bar over the picture's upper edge
   * @param covered other parts of the picture that are covered
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
    // The nearest labels choose their place first.
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
    this.shown = labels.flatMap((label, i) =>
      places[i] ? [{ text: label.text, at: places[i], point: { ...label.anchor } }] : [],
    );
    // All lines first: a label may cover another label's line, but no line may cover a label.
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

/** The top left corner and the size. */
interface Rectangle {
  x: number;
  y: number;
  width: number;
  height: number;
}

/**
 * A label to place: its point and its size, in pixels. `place` is the index of its place in the last picture, which
 * `placeLabels` updates.
 */
interface Anchor extends Rectangle {
  place: number;
}

// The possible places around a point, nearest first: a ring of directions at each distance [px].
const DISTANCES = [9, 22, 38, 58, 84, 116, 156, 204];
const DIRECTIONS = 12;
const PLACES = DISTANCES.flatMap((distance, ring) =>
  Array.from({ length: DIRECTIONS }, (_, i) => {
    const angle = (2 * Math.PI * (i + 0.5 * (ring % 2))) / DIRECTIONS - 0.35;
    return { x: Math.cos(angle), y: Math.sin(angle), distance };
  }),
);
// If there are more than MANY labels, only those that find room within CLOSE [px] of their point are drawn, because many
// long lines would cross.
const [MANY, CLOSE] = [40, 22];
// Free space around each label [px].
const GAP = 2;

/**
 * Place labels so that none covers another or leaves the picture. Each label keeps its last place if that is still free, so
 * that labels do not jump during a movement; otherwise it takes the nearest free place.
 *
 * @param anchors the most important first
 * @param covered parts of the picture that are covered
 * @returns null for a label without room, or whose point is outside the picture
 */
export function placeLabels(anchors: Anchor[], picture: Rectangle, covered: Rectangle[] = []): (Rectangle | null)[] {
  const taken = [...covered];
  const farthest = anchors.length > MANY ? CLOSE : Infinity;
  return anchors.map((anchor) => {
    if (!contains(picture, anchor.x, anchor.y) || covered.some((part) => contains(part, anchor.x, anchor.y))) {
      return null;
    }
    const isFree = (at: Rectangle) => isInside(at, picture) && !taken.some((other) => overlap(at, other));
    for (let i = -1; i < PLACES.length; i++) {
      const place = i < 0 ? anchor.place : i;
      if (place < 0 || PLACES[place].distance > farthest) continue;
      const at = placed(anchor, PLACES[place]);
      if (!isFree(at)) continue;
      anchor.place = place;
      taken.push(at);
      return at;
    }
    return null;
  });
}

/** The rectangle of a label in a direction from its point, with the nearest point of its edge at the given distance. */
function placed({ x, y, width, height }: Anchor, place: { x: number; y: number; distance: number }): Rectangle {
  const centreX = x + place.x * (place.distance + 0.5 * width * Math.abs(place.x));
  const centreY = y + place.y * (place.distance + 0.5 * height);
  // Half the height is added in every direction, so that a label above or below its point does not cover it.
  return {
    x: centreX - 0.5 * width + 0.35 * width * Math.sign(place.x) * (1 - Math.abs(place.x)),
    y: centreY - 0.5 * height,
    width,
    height,
  };
}

/** Where the line from a label to its point begins: the point of the label's edge nearest to it. */
export function leaderFrom(label: Rectangle, { x, y }: { x: number; y: number }) {
  return {
    x: Math.min(Math.max(x, label.x), label.x + label.width),
    y: Math.min(Math.max(y, label.y), label.y + label.height),
  };
}

export function overlap(a: Rectangle, b: Rectangle) {
  return (
    a.x < b.x + b.width + GAP && b.x < a.x + a.width + GAP && a.y < b.y + b.height + GAP && b.y < a.y + a.height + GAP
  );
}

function isInside(inner: Rectangle, outer: Rectangle) {
  return contains(outer, inner.x, inner.y) && contains(outer, inner.x + inner.width, inner.y + inner.height);
}

function contains(rectangle: Rectangle, x: number, y: number) {
  return (
    x >= rectangle.x && y >= rectangle.y && x <= rectangle.x + rectangle.width && y <= rectangle.y + rectangle.height
  );
}
