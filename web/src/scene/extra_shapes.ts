import { THREE } from "../three.ts";
import type { Vector } from "../types.ts";

/** @param colour as on screens, from 0 to 1 */
const screenColour = (colour: Vector) => new THREE.Color(...colour).convertSRGBToLinear();

/**
 * Points as discs that keep their size in the scene.
 *
 * @param message colours as on screens
 */
export function makePoints({
  positions,
  colour,
  colours,
  size,
}: {
  positions: Float32Array;
  colour: Vector;
  colours: Uint8Array | null;
  size: number;
}) {
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
  // three.js takes the size for that of a camera with a right angle of view.
  points.onBeforeRender = (_renderer, _scene, camera) => {
    material.size = size * camera.projectionMatrix.elements[5];
  };
  return points;
}

/** @param message geometries as three.js's loader takes them */
export function makeMesh({ parts }: { parts: { geometry: any; colour: Vector; opacity: number }[] }) {
  const group = new THREE.Group();
  for (const { geometry, colour, opacity } of parts) {
    const { position, normal } = geometry.attributes;
    const made = new THREE.BufferGeometry();
    made.setAttribute("position", new THREE.BufferAttribute(position.array, 3));
    made.setAttribute("normal", new THREE.BufferAttribute(normal.array, 3, true));
    made.setIndex(new THREE.BufferAttribute(geometry.index.array, 1));
    const material = shiny(colour, opacity);
    material.side = THREE.DoubleSide;
    const mesh = new THREE.Mesh(made, material);
    mesh.castShadow = mesh.receiveShadow = opacity === 1;
    group.add(mesh);
  }
  return group;
}

/** A round line: a cylinder for each of its pieces, a ball at each of its points. */
export function makeLine({ positions, colour, width }: { positions: Float32Array; colour: Vector; width: number }) {
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
    mesh.frustumCulled = false; // what is reckoned for one piece does not hold for all
    mesh.castShadow = true;
    group.add(mesh);
  }
  return group;
}

function shiny(colour: Vector, opacity: number) {
  const look = { color: screenColour(colour), specular: 0x2a2a2a, shininess: 48, opacity, transparent: opacity < 1 };
  return new THREE.MeshPhongMaterial(look);
}

/** Colours as light is reckoned, of those on screens; with 16 bits, for the dark ones lie close. */
function linear(colours: Uint8Array) {
  const table = Uint16Array.from({ length: 256 }, (_, i) =>
    Math.round(65535 * new THREE.Color(i / 255, 0, 0).convertSRGBToLinear().r),
  );
  return Uint16Array.from(colours, (value) => table[value]);
}

// What a point looks like: it shows where this is white.
function disc() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const ink = canvas.getContext("2d") as CanvasRenderingContext2D;
  ink.fillStyle = "#000000";
  ink.fillRect(0, 0, 64, 64);
  ink.fillStyle = "#ffffff";
  ink.beginPath();
  ink.arc(32, 32, 31, 0, 2 * Math.PI);
  ink.fill();
  return new THREE.CanvasTexture(canvas);
}
