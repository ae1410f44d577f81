// Red, green and blue as shares of luma in BT.709; how far luma and colours reach in the limited range, of 255.
const [RED, GREEN, BLUE] = [0.2126, 0.7152, 0.0722];
const [LUMA, COLOUR] = [219 / 255, 224 / 255];

/** The colours of the planes that `toPlanes` returns, as WebCodecs names them. */
export const COLOURS = { matrix: "bt709", primaries: "bt709", transfer: "bt709", fullRange: false } as const;

/**
 * Convert a picture for a video: a plane of luma, then one each of the colours blue and red with half the resolution, in the
 * limited range of BT.709.
 *
 * Browsers convert pictures by themselves, but Chromium to the full range, which most players take for the limited one, and
 * so show too bright.
 *
 * @param data four bytes for each pixel: red, green, blue and opacity, which is not used
 */
export function toPlanes(data: ArrayLike<number>, width: number, height: number): Uint8ClampedArray<ArrayBuffer> {
  const [across, down] = [Math.ceil(width / 2), Math.ceil(height / 2)];
  const [blueAt, redAt] = [width * height, width * height + across * down];
  const planes = new Uint8ClampedArray(redAt + across * down);
  const [blues, reds] = [new Float32Array(across * down), new Float32Array(across * down)];
  for (let y = 0, from = 0, to = 0; y < height; y++) {
    const row = (y >> 1) * across;
    for (let x = 0; x < width; x++, from += 4, to++) {
      const luma = RED * data[from] + GREEN * data[from + 1] + BLUE * data[from + 2];
      planes[to] = 16 + LUMA * luma;
      reds[row + (x >> 1)] += data[from] - luma;
      blues[row + (x >> 1)] += data[from + 2] - luma;
    }
  }
  for (let i = 0; i < blues.length; i++) {
    // At an odd edge there are fewer pixels.
    const wide = i % across === across - 1 && width % 2 ? 1 : 2;
    const count = wide * (i >= across * (down - 1) && height % 2 ? 1 : 2);
    planes[blueAt + i] = 128 + (COLOUR * blues[i]) / (count * 2 * (1 - BLUE));
    planes[redAt + i] = 128 + (COLOUR * reds[i]) / (count * 2 * (1 - RED));
  }
  return planes;
}
