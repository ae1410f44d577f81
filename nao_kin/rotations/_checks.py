"""Checks of rotation matrices, and the rotation nearest to a matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, as_numbers, check_tolerance, first_index, refuse_non_finite
from nao_kin._core.kernels import Functions, Kernel, Number, OutOfScale, evaluate, rescaled
from nao_kin._core.text import one_line, one_line_repr
from nao_kin.errors import BadArgument, NotARotation, WrongShape, at_index

TOLERANCE = 1e-6  # a rotation rounded to float32 passes (1e-7), one typed to five digits does not
ROUNDING = 2.0**-46  # above the defects of a product of a few dozen float64 rotations


@one_line_repr
@dataclass(frozen=True, eq=False)
class RotationDefects:
    """How far matrices are from being rotations.

    Attributes:
        determinant: det R − 1, shape (...).
        orthogonality: largest absolute entry of RᵀR − 1, shape (...).
    """

    determinant: Floats
    orthogonality: Floats


def is_rotation(R: ArrayLike, tolerance: float = TOLERANCE) -> NDArray[np.bool_]:
    """Return whether matrices are rotations: |det R − 1| ≤ tolerance and |RᵀR − 1| ≤ tolerance in every entry.

    Args:
        R: matrices, shape (..., 3, 3); False for a matrix with NaN or infinity.
        tolerance: largest defect allowed.

    Returns:
        Booleans, shape (...).

    Examples:
        >>> nk.rotations.is_rotation([nk.rotations.rot_x(0.3), np.diag([1.0, 1.0, -1.0])])
        array([ True, False])
    """
    matrices = as_matrices(R)
    check_tolerance(tolerance)
    defects = _defects(matrices)
    fine = (np.abs(defects.determinant) <= tolerance) & (defects.orthogonality <= tolerance)
    return np.asarray(fine)


def check_rotation(R: ArrayLike, tolerance: float = TOLERANCE, *, name: str = "") -> RotationDefects:
    """Return the defects of rotation matrices, and raise `NotARotation` for the first matrix that is not a rotation.

    Every function of this package checks its rotation matrices in this way, with the default tolerance, and replaces a
    matrix with defects above rounding (1.4e-14) by the nearest rotation.

    Args:
        R: matrices, shape (..., 3, 3).
        tolerance: largest defect allowed; the default accepts rotations rounded to float32.
        name: name of the matrices in the error message, such as that of an argument.

    Returns:
        det R − 1 and max |RᵀR − 1| of each matrix.

    Examples:
        >>> nk.rotations.check_rotation(np.diag([1.0, 1.0, -1.0]))
        Traceback (most recent call last):
        nao_kin.errors.NotARotation: not a rotation matrix: det R − 1 = -2, max |RᵀR − 1| = 0
    """
    matrices = as_matrices(R)
    check_tolerance(tolerance)
    refuse_non_finite(matrices, "rotation matrix")
    defects = _defects(matrices)
    bad = ~((np.abs(defects.determinant) <= tolerance) & (defects.orthogonality <= tolerance))
    if bad.any():
        index = first_index(bad)
        error = NotARotation(index, float(defects.determinant[index]), float(defects.orthogonality[index]))
        if name:
            error.args = (one_line(f"{name}: {error}"),)
        raise error
    return defects


def nearest_rotation(M: ArrayLike) -> Floats:
    """The rotation nearest to a matrix in the Frobenius norm.

    With M = U Σ Vᵀ it is R = U diag(1, 1, det U det V) Vᵀ, whose determinant is +1 even if det M < 0.

    Args:
        M: matrices, shape (..., 3, 3), for instance rotations with measurement or rounding errors.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Raises:
        BadArgument: a matrix without a single nearest rotation: σ₂ + det(U) det(V) σ₃ = 0 (rank below two, or a
            reflection whose two smaller singular values are equal).

    Source: Umeyama, IEEE PAMI 13(4), 1991, lemma.

    Examples:
        >>> nk.rotations.nearest_rotation([[0.0, -2.0, 0.0], [2.1, 0.0, 0.0], [0.0, 0.0, 1.9]])[0] + 0.0
        array([ 0., -1.,  0.])
    """
    matrices = as_matrices(M)
    refuse_non_finite(matrices, "matrix")
    scale = np.abs(matrices).max(axis=(-2, -1), keepdims=True, initial=0.0)
    U, sigma, Vt = np.linalg.svd(matrices / np.where(scale > 0.0, scale, 1.0))
    sign = np.where(np.linalg.det(U) * np.linalg.det(Vt) < 0.0, -1.0, 1.0)
    ambiguous = ~(sigma[..., 1] + sign * sigma[..., 2] > 1e-12 * sigma[..., 0])
    if ambiguous.any():
        index = first_index(ambiguous)
        values = ", ".join(f"{value:.3g}" for value in (scale * sigma[..., np.newaxis])[index].ravel())
        raise BadArgument(f"the matrix{at_index(index)} has no single nearest rotation: singular values {values}")
    U[..., :, 2] *= sign[..., np.newaxis]
    return np.asarray(U @ Vt)


def defects_of(f: Functions, *m: Number) -> tuple[Number, ...]:
    """The kernel from nine entries to det R − 1 and the six different entries of RᵀR − 1."""
    m00, m01, m02, m10, m11, m12, m20, m21, m22 = m
    return (
        m00 * (m11 * m22 - m12 * m21) + m01 * (m12 * m20 - m10 * m22) + m02 * (m10 * m21 - m11 * m20) - 1.0,
        m00 * m00 + m10 * m10 + m20 * m20 - 1.0,
        m01 * m01 + m11 * m11 + m21 * m21 - 1.0,
        m02 * m02 + m12 * m12 + m22 * m22 - 1.0,
        m00 * m01 + m10 * m11 + m20 * m21,
        m00 * m02 + m10 * m12 + m20 * m22,
        m01 * m02 + m11 * m12 + m21 * m22,
    )


def as_rotations(R: ArrayLike) -> Floats:
    """Return `R` as rotation matrices, shape (..., 3, 3), checked and projected as in `evaluate_rotations`."""
    return evaluate_rotations(_entries, R, (3, 3))[0]


def evaluate_rotations(kernel: Kernel, R: ArrayLike, *tails: tuple[int, ...]) -> list[Floats]:
    """Return the results of `evaluate` for the nine entries of each rotation matrix, and check the matrices.

    A matrix that is a rotation within the tolerance, but not to rounding, is replaced by the nearest rotation.
    """
    matrices = as_matrices(R)

    def checked(f: Functions, *entries: Number) -> tuple[Number, ...]:
        defects = defects_of(f, *entries)
        if not all(f.within(defect, ROUNDING) for defect in defects):
            if not all(f.within(defect, TOLERANCE) for defect in defects):
                check_rotation(matrices)
            entries = _projected(f, entries, defects[1:])
        return kernel(f, *entries)

    return evaluate(checked, [matrices.reshape(*matrices.shape[:-2], 9)], *tails)


def evaluate_vectors(kernel: Kernel, v: ArrayLike, *tails: tuple[int, ...]) -> list[Floats]:
    """Return the results of `evaluate` for the components of rotation vectors."""
    return evaluate(kernel, [as_floats(v, (3,), "rotation vector")], *tails)


def evaluate_normalised(
    kernel: Kernel, vectors: Floats, what: str, *others: Floats, tail: tuple[int, ...] = (3, 3)
) -> Floats:
    """Return the result of `evaluate` for vectors of any length but zero, and for other arrays."""
    try:
        return evaluate(kernel, [vectors, *others], tail)[0]
    except OutOfScale:
        return evaluate(kernel, [rescaled(vectors, what), *others], tail)[0]


def _entries(f: Functions, *m: Number) -> tuple[Number, ...]:
    return m


def _projected(f: Functions, m: Sequence[Number], defects: Sequence[Number]) -> tuple[Number, ...]:
    """R (1 + D)^(−1/2), the rotation nearest to R, for D = RᵀR − 1 up to the tolerance.

    1 − D/2 + 3 D²/8 has an error of 5 D³/16, which is below rounding. Matrices that are exact to rounding stay
    unchanged, because the signs of half turns depend on entries that are exactly zero.
    """
    largest = abs(defects[0])
    for defect in defects[1:]:
        largest = f.larger(largest, abs(defect))
    exact = largest <= ROUNDING
    xx, yy, zz, xy, xz, yz = (f.where(exact, 0.0, defect) for defect in defects)
    a, b = 0.375 * (xx * xx + xy * xy + xz * xz), 0.375 * (xx * xy + xy * yy + xz * yz)
    c = 0.375 * (xx * xz + xy * yz + xz * zz)
    d, e = 0.375 * (xy * xy + yy * yy + yz * yz), 0.375 * (xy * xz + yy * yz + yz * zz)
    g = 0.375 * (xz * xz + yz * yz + zz * zz)
    sxx, syy, szz = a - 0.5 * xx, d - 0.5 * yy, g - 0.5 * zz
    sxy, sxz, syz = b - 0.5 * xy, c - 0.5 * xz, e - 0.5 * yz
    found: list[Number] = []
    for x, y, z in (m[0:3], m[3:6], m[6:9]):
        found += [
            x + (x * sxx + y * sxy + z * sxz),
            y + (x * sxy + y * syy + z * syz),
            z + (x * sxz + y * syz + z * szz),
        ]
    return tuple(found)


def as_matrices(R: ArrayLike) -> Floats:
    matrices = as_numbers(R, "rotation matrix")
    if matrices.shape[-2:] != (3, 3):
        raise WrongShape("rotation matrix", "(..., 3, 3)", matrices.shape)
    return matrices


def _defects(matrices: Floats) -> RotationDefects:
    determinant, orthogonality = evaluate(_largest_defects, [matrices.reshape(*matrices.shape[:-2], 9)], (), ())
    return RotationDefects(determinant, orthogonality)


def _largest_defects(f: Functions, *m: Number) -> tuple[Number, ...]:
    determinant, *entries = defects_of(f, *m)
    largest = abs(entries[0])
    for entry in entries[1:]:
        largest = f.larger(largest, abs(entry))
    return determinant, largest


# --- Weights of means and fits.


def as_shares(weights: ArrayLike | None, count: int) -> Floats:
    """Return `weights`, shape (..., count), scaled to a sum of 1; equal shares for None."""
    if weights is None:
        return np.full(count, 1.0 / count)
    values = as_floats(weights, (count,), "weights")
    if (values < 0.0).any():
        index = first_index(values < 0.0)
        raise BadArgument(f"weights must not be negative, got {values[index]:g}{at_index(index)}")
    largest = values.max(axis=-1, keepdims=True)
    if not largest.all():
        where = at_index(first_index(largest[..., 0] == 0.0))
        raise BadArgument(f"at least one weight must be positive, got zeros only{where}")
    scaled = values / largest
    return np.asarray(scaled / scaled.sum(axis=-1, keepdims=True))
