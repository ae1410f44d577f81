import { product, transposed } from "../math/rotations.ts";
import type { Matrix3, Pose, Rotation } from "../math/types.ts";

// The largest defect of a rotation, and the largest of one that is left as it is.
const RIGID = 1e-6;
const EXACT = 1e-14;

/** The rotation of a rigid transform, brought nearer to one by a step of R ← R (3 − RᵀR)/2; null if it is none. */
export function rigidRotation(T: Pose): Rotation | null {
  const R: Rotation = [T[0], T[1], T[2], T[4], T[5], T[6], T[8], T[9], T[10]];
  const [a, b, c, d, e, f, g, h, i] = R;
  const left = product(transposed(R), R).map((value, k) => (k % 4 === 0 ? 1 : 0) - value);
  const defect = Math.max(...left.map(Math.abs));
  const determinant = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g);
  const below = Math.abs(T[12]) + Math.abs(T[13]) + Math.abs(T[14]) + Math.abs(T[15] - 1);
  // Comparisons with NaN are false.
  if (!(defect <= RIGID && Math.abs(determinant - 1) <= RIGID && below <= RIGID)) return null;
  if (!Number.isFinite(T[3] + T[7] + T[11])) return null;
  if (defect <= EXACT) return R;
  const step = product(R, left as Matrix3);
  return R.map((value, k) => value + 0.5 * step[k]) as Rotation;
}
