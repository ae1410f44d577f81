import { THREE } from "../three.ts";
import type { Studio } from "./studio.ts";

/**
 * Give the floor of the scene the colours that the styles have for it: in light or dark, with more contrast or less.
 */
export function paintFloor({ floor, viewer }: Studio) {
  const styles = getComputedStyle(document.documentElement);
  const { ink, shade, strength } = floor.uniforms;
  ink.value.copy(colourOf(styles, "--floor-lines").colour);
  const { colour, alpha } = colourOf(styles, "--floor-shade");
  shade.value.copy(colour);
  strength.value = alpha;
  viewer.set_dirty();
}

/** A registered property of the styles, which browsers give as rgb(…) or rgba(…). */
function colourOf(styles: CSSStyleDeclaration, property: string) {
  const [red, green, blue, alpha = 1] = (styles.getPropertyValue(property).match(/[\d.]+/g) ?? []).map(Number);
  return { colour: new THREE.Color(red / 255, green / 255, blue / 255).convertSRGBToLinear(), alpha };
}
