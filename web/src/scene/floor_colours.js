import { THREE } from "../three.js";

/**
 * Give the floor of the scene the colours that the styles have for it: in light or dark, with more contrast or less.
 *
 * @param {import("./studio.js").Studio} studio
 */
export function paintFloor({ floor, viewer }) {
  const styles = getComputedStyle(document.documentElement);
  const { ink, shade, strength } = floor.uniforms;
  ink.value.copy(colourOf(styles, "--floor-lines").colour);
  const { colour, alpha } = colourOf(styles, "--floor-shade");
  shade.value.copy(colour);
  strength.value = alpha;
  viewer.set_dirty();
}

/**
 * A registered property of the styles, which browsers give as rgb(…) or rgba(…).
 *
 * @param {CSSStyleDeclaration} styles
 * @param {string} property
 */
function colourOf(styles, property) {
  const [red, green, blue, alpha = 1] = (styles.getPropertyValue(property).match(/[\d.]+/g) ?? []).map(Number);
  return { colour: new THREE.Color(red / 255, green / 255, blue / 255).convertSRGBToLinear(), alpha };
}
