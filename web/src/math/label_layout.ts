/** top left corner and size */
export interface Rectangle {
  x: number;
  y: number;
  width: number;
  height: number;
}

/**
 * What wants a label: the point that it belongs to and its size, in pixels. `place` is the number of the place it was given
 * before, and is written.
 */
export interface Anchor {
  x: number;
  y: number;
  width: number;
  height: number;
  place: number;
}

// Places around a point, nearest first: a ring of directions at each distance [px].
const DISTANCES = [9, 22, 38, 58, 84, 116, 156, 204];
const DIRECTIONS = 12;
const PLACES = DISTANCES.flatMap((distance, ring) =>
  Array.from({ length: DIRECTIONS }, (_, i) => {
    const angle = (2 * Math.PI * (i + 0.5 * (ring % 2))) / DIRECTIONS - 0.35;
    return { x: Math.cos(angle), y: Math.sin(angle), distance };
  }),
);
// Of more labels than that, only those that find room close to their points stay: long lines crossing each other help nobody.
const [MANY, CLOSE] = [40, 22];
// Pixels kept free around each label.
const GAP = 2;

/**
 * Where labels stand so that none covers another or leaves the picture. Each takes the place that it had, if that is still
 * free, so that labels do not jump about while something moves, else the nearest one.
 *
 * @param anchors the most important first
 * @param covered parts of the picture that are
 * @returns null for a label that no room is left for, or whose point is outside the picture
 */
export function placeLabels(anchors: Anchor[], picture: Rectangle, covered: Rectangle[] = []): (Rectangle | null)[] {
  const taken = [...covered];
  const farthest = anchors.length > MANY ? CLOSE : Infinity;
  return anchors.map((anchor) => {
    if (!contains(picture, anchor.x, anchor.y) || covered.some((part) => contains(part, anchor.x, anchor.y)))
      return null;
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

/** The label in a direction from its point: beside it, with the nearest point of its edge at that distance. */
function placed({ x, y, width, height }: Anchor, place: { x: number; y: number; distance: number }): Rectangle {
  const centreX = x + place.x * (place.distance + 0.5 * width * Math.abs(place.x));
  const centreY = y + place.y * (place.distance + 0.5 * height);
  // A direction that is mostly up or down still clears the label's height.
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
