"""The matrix T = 1 + u vᵀ in three dimensions: determinant, inverse, eigenvalues and eigenvectors in closed form.

T w = w for every w ⟂ v, and T u = (1 + u·v) u. Two cases are special. If u·v = 0 (and neither vector is zero), u is
itself one of the w: T is a shear and has no third eigenvector. If u·v = −1, T is singular.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, common_batch, cross, dot, first_index, norm, unit
from nao_kin.errors import SingularMatrix

__all__ = [
    "RankOneEigen",
    "determinant",
    "eigen",
    "inverse",
    "matrix",
]


# The rounding error of u·v is at most this times Σ|uᵢ vᵢ|; a smaller u·v counts as zero.
_ROUNDING = 4.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class RankOneEigen:
    """Eigenvalues, eigenvectors and Jordan form of T = 1 + u vᵀ.

    Attributes:
        values: eigenvalues (1, 1, 1 + u·v), shape (..., 3).
        vectors: unit eigenvectors as columns, shape (..., 3, 3): two perpendicular to v and to one another, the first
            also to u where the sine of the angle between u and v exceeds 0.1, then u/‖u‖. Where T is defective the last
            two columns are the same vector; where u or v is zero, and T is the identity, the last is v/‖v‖ (u/‖u‖ for
            v = 0) and the three are orthonormal.
        defective: where u·v = 0 and neither vector is zero, shape (...): the eigenvalue 1 counts three times and has
            only two independent eigenvectors.
        singular: where u·v = −1, shape (...).
        jordan_basis: columns P with T P = P J, shape (..., 3, 3): the eigenvectors; where T is defective the last is
            the generalised one g = v/(‖u‖ ‖v‖²), with T g = g + u/‖u‖. |det P| is |cos ∠(u, v)|, or 1/(‖u‖ ‖v‖) where
            T is defective, or 1 for the identity. P is invertible, except for a singular T with ‖u‖ ‖v‖ above 1e15,
            whose cosine rounds to 0.
        jordan_form: J, shape (..., 3, 3): diagonal; where T is defective, its last block is [[1, 1], [0, 1]].
    """

    values: Floats
    vectors: Floats
    defective: NDArray[np.bool_]
    singular: NDArray[np.bool_]
    jordan_basis: Floats
    jordan_form: Floats


def matrix(u: ArrayLike, v: ArrayLike) -> Floats:
    """T = 1 + u vᵀ.

    Args:
        u: shape (..., 3).
        v: shape (..., 3).

    Returns:
        T, shape (..., 3, 3).

    Examples:
        >>> nk.rotations.rank_one.matrix([1, 2, 3], [0, 0, 1])[2]
        array([0., 0., 4.])
    """
    return _matrix(*_checked(u, v))


def determinant(u: ArrayLike, v: ArrayLike) -> Floats:
    """det(1 + u vᵀ) = 1 + u·v, shape (...), with the arguments of `matrix`.

    Examples:
        >>> nk.rotations.rank_one.determinant([1, 2, 3], [0, 0, 1]).tolist()
        4.0
    """
    return 1.0 + dot(*_checked(u, v))


def inverse(u: ArrayLike, v: ArrayLike) -> Floats:
    """(1 + u vᵀ)⁻¹ = 1 − u vᵀ/(1 + u·v), shape (..., 3, 3), with the arguments of `matrix`.

    Raises:
        SingularMatrix: u·v = −1 up to the rounding of the product; carries the index.

    Source: Sherman and Morrison, Annals of Mathematical Statistics 21 (1950), doi:10.1214/aoms/1177729893.

    Examples:
        >>> nk.rotations.rank_one.inverse([1, 2, 3], [0, 0, 1])[2]
        array([0.  , 0.  , 0.25])
    """
    u, v = _checked(u, v)
    product = dot(u, v)
    singular = _is_minus_one(product, u, v)
    if singular.any():
        raise SingularMatrix("1 + u vᵀ", "u·v = −1", first_index(singular))
    return _matrix(-u / (1.0 + product)[..., None], v)


def eigen(u: ArrayLike, v: ArrayLike) -> RankOneEigen:
    """Eigenvalues, eigenvectors and Jordan form of T = 1 + u vᵀ, with the arguments of `matrix`.

    Where u or v is zero, T is the identity and the eigenvectors are an orthonormal basis that
    contains the direction of v, or of u for v = 0. A u·v or 1 + u·v that is zero up to its rounding counts as zero.

    Examples:
        >>> nk.rotations.rank_one.eigen([1, 2, 3], [0, 0, 1]).values
        array([1., 1., 4.])
    """
    u, v = _checked(u, v)
    product = dot(u, v)
    u_is_zero, v_is_zero = (u == 0.0).all(axis=-1, keepdims=True), (v == 0.0).all(axis=-1, keepdims=True)
    x_axis = np.array([1.0, 0.0, 0.0])
    normal_v, length_v = unit(np.where(v_is_zero, np.where(u_is_zero, x_axis, u), v), "v")
    along_u, length_u = unit(np.where(u_is_zero, normal_v, u), "u")
    sheared = ~(u_is_zero | v_is_zero)[..., 0]
    along_u = np.where(sheared[..., None], along_u, normal_v)
    singular = _is_minus_one(product, u, v)
    cosine = dot(along_u, normal_v)
    defective = sheared & ~singular & (np.abs(cosine) <= _ROUNDING * dot(np.abs(along_u), np.abs(normal_v)))

    w1 = _perpendicular_to_both(normal_v, along_u)
    w2 = cross(w1, normal_v)
    # The u of a shear is normal to v, so w2 is u up to rounding: use the same vector.
    w2 = np.where(defective[..., None], along_u, w2)

    one = np.ones_like(product)
    values = np.stack([one, one, np.where(defective, 1.0, 1.0 + product)], axis=-1)
    generalised = normal_v / np.where(sheared, length_u * length_v, 1.0)[..., None]
    last = np.where(defective[..., None], generalised, along_u)
    form = np.zeros((*product.shape, 3, 3))
    form[..., range(3), range(3)] = values
    form[..., 1, 2] = defective
    return RankOneEigen(
        values=values,
        vectors=np.stack([w1, w2, along_u], axis=-1),
        defective=defective,
        singular=singular,
        jordan_basis=np.stack([w1, w2, last], axis=-1),
        jordan_form=form,
    )


def _checked(u: ArrayLike, v: ArrayLike) -> tuple[Floats, Floats]:
    u, v = as_floats(u, (3,), "u"), as_floats(v, (3,), "v")
    shape = (*common_batch("u and v", u.shape[:-1], v.shape[:-1]), 3)
    return np.broadcast_to(u, shape), np.broadcast_to(v, shape)


def _matrix(u: Floats, v: Floats) -> Floats:
    return np.eye(3) + u[..., :, None] * v[..., None, :]


def _is_minus_one(product: Floats, u: Floats, v: Floats) -> NDArray[np.bool_]:
    """Return whether u·v is −1 up to its rounding error, and nearer to −1 than to 0."""
    blur = _ROUNDING * (1.0 + dot(np.abs(u), np.abs(v)))
    return np.asarray((np.abs(1.0 + product) <= blur) & (product < -0.5))


def _perpendicular_to_both(a: Floats, b: Floats) -> Floats:
    """Unit vectors ⟂ the unit vector a, and ⟂ b where b is not nearly along a."""
    crossed = cross(a, b)
    # If b gives no clear direction, take the coordinate axis farthest from a.
    axis = np.eye(3)[np.abs(a).argmin(axis=-1)]
    clear = norm(crossed) > 0.1
    return unit(np.where(clear[..., None], crossed, cross(a, axis)), "normal")[0]
