/**
 * Slopes of the monotone cubic through the keys of one number, as nao_kin.motion.smooth_slopes gives them: zero at the
 * first and the last key and where the straight lines beside a key differ in sign, else their weighted harmonic mean.
 *
 * Source: F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300–304.
 *
 * @param times strictly ascending
 * @param value at a key
 * @returns one for each key
 */
export function smoothSlopes(times: ArrayLike<number>, value: (key: number) => number): Float64Array {
  const slopes = new Float64Array(times.length);
  for (let key = 1; key < times.length - 1; key++) {
    const [before, after] = [times[key] - times[key - 1], times[key + 1] - times[key]];
    const rising = (value(key) - value(key - 1)) / before;
    const going = (value(key + 1) - value(key)) / after;
    if (!(Math.sign(rising) * Math.sign(going) > 0)) continue;
    const [w1, w2] = [before + 2 * after, 2 * before + after];
    slopes[key] = (w1 + w2) / (w1 / rising + w2 / going);
  }
  return slopes;
}
