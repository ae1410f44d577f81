import type { App } from "../app.ts";
import { makeInk } from "../panel/element.ts";
import { asMark, dispose } from "../robot/nodes.ts";
import { makeGeometry } from "../robot/robot.ts";
import { THREE } from "../three.ts";
import { isParallel } from "./camera.ts";
import type { Vector } from "../types.ts";
import type { Received } from "../received.ts";

/** The fields of a message with a shape; each kind of shape uses some of them. */
type Shape = Required<Received["extra"]>;

/** @param colour in sRGB, from 0 to 1 */
const screenColour = (colour: Vector) => new THREE.Color(...colour).convertSRGBToLinear();

/**
 * Points as discs that keep their size in the scene.
 *
 * @param message with colours in sRGB
 */
function makePoints({ positions, colour, colours, size }: Shape) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  if (colours) geometry.setAttribute("color", new THREE.BufferAttribute(linear(colours), 3, true));
  const material = new THREE.PointsMaterial({
    color: colours ? 0xffffff : screenColour(colour),
    vertexColors: colours !== null,
    alphaMap: disc(),
    alphaTest: 0.5,
  });
  const points = new THREE.Points(geometry, material);
  // three.js assumes a camera with a field of view of 90°, so the size is scaled by the camera's own.
  points.onBeforeRender = (renderer, _scene, camera) => {
    const share = isParallel(camera) ? renderer.getSize(new THREE.Vector2()).y / 2 : 1;
    material.size = size * camera.projectionMatrix.elements[5] * share;
  };
  return points;
}

function makeMesh({ parts }: Shape) {
  const group = new THREE.Group();
  for (const { geometry, colour, opacity } of parts) {
    const material = shiny(colour, opacity);
    material.side = THREE.DoubleSide;
    const mesh = new THREE.Mesh(makeGeometry(geometry), material);
    mesh.castShadow = mesh.receiveShadow = opacity === 1;
    group.add(mesh);
  }
  return group;
}

/** A round line: a cylinder for each segment and a ball at each point. */
function makeLine({ positions, colour, width }: Shape) {
  const { Vector3 } = THREE;
  const count = positions.length / 3;
  const points = Array.from({ length: count }, (_, i) => new Vector3().fromArray(positions, 3 * i));
  const sides = count > 5000 ? 6 : 12;
  const rod = new THREE.CylinderGeometry(width / 2, width / 2, 1, sides, 1, true);
  const ball = new THREE.SphereGeometry(width / 2, sides, sides / 2);
  const material = shiny(colour, 1);
  const rods = new THREE.InstancedMesh(rod, material, count - 1);
  const balls = new THREE.InstancedMesh(ball, material, count);
  const along = new Vector3();
  const matrix = new THREE.Matrix4();
  const turn = new THREE.Quaternion();
  points.forEach((point, i) => {
    balls.setMatrixAt(i, matrix.makeTranslation(point.x, point.y, point.z));
    if (i === 0) return;
    along.subVectors(point, points[i - 1]);
    const length = along.length();
    turn.setFromUnitVectors(new Vector3(0, 1, 0), length > 0 ? along.divideScalar(length) : along.set(0, 1, 0));
    const middle = points[i - 1].clone().add(point).divideScalar(2);
    rods.setMatrixAt(i - 1, matrix.compose(middle, turn, new Vector3(1, length, 1)));
  });
  const group = new THREE.Group();
  for (const mesh of [rods, balls]) {
    mesh.frustumCulled = false; // three.js would test the bounds of a single piece
    mesh.castShadow = true;
    group.add(mesh);
  }
  return group;
}

export function shiny(colour: Vector, opacity: number) {
  const look = { color: screenColour(colour), specular: 0x2a2a2a, shininess: 48, opacity, transparent: opacity < 1 };
  return new THREE.MeshPhongMaterial(look);
}

/** Convert sRGB colours to linear ones, with 16 bits, because dark colours lie close together. */
function linear(colours: Uint8Array) {
  const table = Uint16Array.from({ length: 256 }, (_, i) =>
    Math.round(65535 * new THREE.Color(i / 255, 0, 0).convertSRGBToLinear().r),
  );
  return Uint16Array.from(colours, (value) => table[value]);
}

// The mask of a point, which is visible where the mask is white.
function disc() {
  const ink = makeInk(64, 64);
  ink.fillStyle = "#000000";
  ink.fillRect(0, 0, 64, 64);
  ink.fillStyle = "#ffffff";
  ink.beginPath();
  ink.arc(32, 32, 31, 0, 2 * Math.PI);
  ink.fill();
  return new THREE.CanvasTexture(ink.canvas);
}

/** An arrow: a round shaft with a head, which is shorter on a short arrow. */
function makeArrow({ positions, colour, width }: Shape) {
  const [from, along] = [0, 3].map((at) => new THREE.Vector3().fromArray(positions, at));
  const length = along.sub(from).length();
  const head = Math.min(4 * width, 0.6 * length);
  const material = shiny(colour, 1);
  const shaft = new THREE.CylinderGeometry(width / 2, width / 2, length - head, 16);
  const tip = new THREE.ConeGeometry((3 * head) / 8, head, 24);
  const arrow = new THREE.Group();
  arrow.visible = length > 0;
  arrow.position.copy(from);
  if (length > 0) arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.divideScalar(length));
  for (const [geometry, middle] of [
    [shaft, (length - head) / 2],
    [tip, length - head / 2],
  ] as [THREE.BufferGeometry, number][]) {
    const mesh = new THREE.Mesh(geometry, material);
    mesh.position.y = middle;
    mesh.castShadow = true;
    arrow.add(mesh);
  }
  return arrow;
}

/** The place of a label. */
function makePlace({ positions }: Shape) {
  const place = new THREE.Object3D();
  place.position.fromArray(positions);
  return place;
}

const MAKERS: Record<string, (message: Shape) => THREE.Object3D> = {
  points: makePoints,
  mesh: makeMesh,
  line: makeLine,
  arrow: makeArrow,
  label: makePlace,
};

/** Shapes that are not part of a robot, by name: in the world, or carried by a frame of the page's own robot. */
export class Extras {
  shapes: Map<string, THREE.Object3D> = new Map();

  constructor(readonly page: App) {}

  /** Draw a shape, which replaces the one of the same name. */
  add(message: Received["extra"]) {
    const { name, shape, frame } = message;
    if (!Object.hasOwn(MAKERS, shape)) return;
    this.remove(name);
    const made = asMark(MAKERS[shape](message as Shape));
    made.userData.isThing = ["points", "mesh", "line"].includes(shape);
    (frame === null ? this.page.viewer.scene : this.page.robot.frameNode(frame)).add(made);
    this.shapes.set(name, made);
    if (message.text) this.page.labels.set(made, [{ text: message.text, node: made }]);
    this.page.studio.moved();
  }

  /** Remove all shapes but these. */
  keep(names: string[]) {
    const kept = new Set(names);
    for (const name of [...this.shapes.keys()]) if (!kept.has(name)) this.remove(name);
  }

  remove(name: string) {
    const shape = this.shapes.get(name);
    if (!shape) return;
    shape.traverse((node) => node instanceof THREE.InstancedMesh && node.dispose());
    dispose(shape);
    this.page.labels.remove(shape);
    this.shapes.delete(name);
    this.page.studio.moved();
  }
}
