/**
 * Roll, pitch and yaw [rad] of R = Rz(yaw) Ry(pitch) Rx(roll): the yaw first, turned back out, and the other two from what
 * is left, so that nothing is lost where the pitch is a right angle. (three.js's Euler loses 4e-4 rad there.)
 *
 * @param matrix by columns
 */
export function rollPitchYaw({ elements: m }: { elements: ArrayLike<number> }): [number, number, number] {
  const yaw = Math.atan2(m[1], m[0]);
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  const pitch = Math.atan2(-m[2], c * m[0] + s * m[1]);
  const roll = Math.atan2(s * m[8] - c * m[9], c * m[5] - s * m[4]);
  return [roll, pitch, yaw];
}
