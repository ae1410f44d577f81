import { isClosed } from "../math/closed.js";
import { THREE } from "../three.js";

/** @typedef {import("../types.js").RobotMesh} RobotMesh */
/** What a surface is like, apart from its colour. @typedef {{ roughness: number, metalness: number }} Finish */

/**
 * The finishes: painted shells, unpainted grey, rubber and what is dark.
 *
 * @type {Record<"gloss" | "satin" | "rubber", Finish>}
 */
export const FINISHES = {
  gloss: { roughness: 0.3, metalness: 0 },
  satin: { roughness: 0.48, metalness: 0 },
  rubber: { roughness: 0.72, metalness: 0 },
};
// Luminance under which a colour is dark, and chroma from which one is paint.
const [DARK, PAINT, PALE] = [0.12, 0.25, 0.75];

/**
 * The finish that goes with a colour of a URDF, which says no more of a surface.
 *
 * @param {{ r: number, g: number, b: number }} colour as the screen has it
 * @returns {keyof typeof FINISHES}
 */
export function finishOf({ r, g, b }) {
  const luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  const chroma = Math.max(r, g, b) - Math.min(r, g, b);
  if (chroma > PAINT || luminance > PALE) return "gloss";
  return luminance < 2.5 * DARK ? "rubber" : "satin";
}

/**
 * Give a shape of the robot the material that its colour stands for. Colours in a URDF are those of a screen; light is
 * reckoned in linear ones.
 *
 * @param {RobotMesh} mesh
 */
export function setMaterial(mesh) {
  const { color, opacity } = mesh.material;
  mesh.material.dispose();
  const finish = finishOf(color);
  const { attributes, index } = mesh.geometry;
  // Open or inside out, its backs are seen: they cost twice, and bear specks where their own shadow falls on them.
  const side = isClosed(attributes.position.array, index?.array ?? null) ? THREE.FrontSide : THREE.DoubleSide;
  mesh.material = new THREE.MeshStandardMaterial({
    ...FINISHES[finish],
    color: color.clone().convertSRGBToLinear(),
    side,
    opacity,
    transparent: opacity < 1,
  });
  Object.assign(mesh.userData, { own: mesh.material.color.clone(), opacity, side, finish });
  mesh.castShadow = mesh.receiveShadow = true;
}
