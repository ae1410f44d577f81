import { isClosed } from "../math/closed.ts";
import { THREE } from "../three.ts";
import type { RobotMesh } from "../types.ts";

/** What a surface is like, apart from its colour. */
interface Finish {
  roughness: number;
  metalness: number;
}

/** The finishes: painted shells, unpainted grey, rubber and what is dark. */
export const FINISHES: Record<"gloss" | "satin" | "rubber", Finish> = {
  gloss: { roughness: 0.3, metalness: 0 },
  satin: { roughness: 0.48, metalness: 0 },
  rubber: { roughness: 0.72, metalness: 0 },
};
// Luminance under which a colour is dark, and chroma from which one is paint.
const [DARK, PAINT, PALE] = [0.12, 0.25, 0.75];

/**
 * The finish that goes with a colour of a URDF, which says no more of a surface.
 *
 * @param colour as the screen has it
 */
export function finishOf({ r, g, b }: { r: number; g: number; b: number }): keyof typeof FINISHES {
  const luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  const chroma = Math.max(r, g, b) - Math.min(r, g, b);
  if (chroma > PAINT || luminance > PALE) return "gloss";
  return luminance < 2.5 * DARK ? "rubber" : "satin";
}

/**
 * Give a shape of the robot the material that its colour stands for. Colours in a URDF are those of a screen; light is
 * reckoned in linear ones.
 */
export function setMaterial(mesh: RobotMesh) {
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
