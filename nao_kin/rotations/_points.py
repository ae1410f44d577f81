"""The rotation of a body from points on it, seen before and after."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats, as_numbers
from nao_kin._common.vectors import as_vectors, common_batch, cross, dot, first_index, unit
from nao_kin.errors import BadArgument, DegeneratePoints, UnknownName, WrongShape, at_index
from nao_kin.rotations._checks import nearest_rotation

Method = Literal["least_squares", "triads"]

# σ₂/σ₁ of the points at which they count as one line. Triads lose digits of the turn about it as 1/thinness, least
# squares as its square, for the product of both point sets has the squares of their singular values.
THINNEST = {"triads": 1e-8, "least_squares": 1e-6}


def rotation_from_points(before: ArrayLike, after: ArrayLike, *, method: Method = "least_squares") -> Floats:
    """The rotation R that takes points of a body before a motion to the same points after it, whatever the shift.

    least_squares: the R that minimises Σ ‖(p'ᵢ − p̄') − R (pᵢ − p̄)‖², the rotation nearest to Σ (p'ᵢ − p̄')(pᵢ − p̄)ᵀ;
    for n ≥ 3 points.
    triads: R = [e1' e2' e3'] [e1 e2 e3]ᵀ from exactly three points a, b, c, with e1 along b − c, e2 along the part of
    a − (b + c)/2 normal to e1, and e3 = e1 × e2; it maps the line of b and c exactly, and the plane of the three.
    For points of a rigid body without errors both give the same R. Of points near one line, the turn about it is right
    to about 1e-16/thinness by triads and 1e-16/thinness² by least squares, with thinness their width by their length.

    Args:
        before: points before the motion, shape (..., n, 3) [m].
        after: the same points after it, shape (..., n, 3) [m]; batch axes broadcast.
        method: "least_squares" or "triads".

    Returns:
        Rotation matrices, shape (..., 3, 3), determinant +1 also where the points lie in a plane.

    Raises:
        DegeneratePoints: fewer than three points, points on one line (thinner than 1e-6 of their length for least
            squares, 1e-8 for triads), or after points that are as near to a mirror image as to a rotated one, so that
            no single rotation fits best.
        WrongShape: not of shape (..., n, 3), different n, mismatched batch shapes, n ≠ 3 for triads.
        UnknownName: no such method.
        BadArgument, NotFinite: not numbers, outside ±1e150, NaN or infinity.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3 (triads); Umeyama, IEEE PAMI 13(4), 1991.

    Examples:
        >>> before = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        >>> after = [[5, 5, 5], [5, 6, 5], [4, 5, 5]]
        >>> np.allclose(nk.rotations.rotation_from_points(before, after), nk.rotations.rot_z(np.pi / 2))
        True
    """
    if not isinstance(method, str) or method not in ("least_squares", "triads"):
        raise UnknownName("method", method, ("least_squares", "triads"))
    P, Q = _as_points(before, "points before"), _as_points(after, "points after")
    count = P.shape[-2]
    if Q.shape[-2] != count:
        raise WrongShape("points after", f"(..., {count}, 3), as many as before", Q.shape)
    if method == "triads" and count != 3:
        raise WrongShape("points for two triads", "(..., 3, 3)", P.shape)
    common_batch("points before and after", P.shape[:-2], Q.shape[:-2])
    thinnest = THINNEST[method]
    P, Q = _centred(P, "points before", thinnest), _centred(Q, "points after", thinnest)
    if method == "triads":
        return np.asarray(_triad(Q) @ np.swapaxes(_triad(P), -1, -2))
    return best_fit(P, Q, "points")


def best_fit(before: Floats, after: Floats, what: str) -> Floats:
    """The R with least Σ ‖bᵢ − R aᵢ‖² over the rows, shape (..., n, 3): the rotation nearest to Σ bᵢ aᵢᵀ."""
    try:
        return nearest_rotation(np.swapaxes(after, -1, -2) @ before)
    except BadArgument as error:
        raise DegeneratePoints(f"no single rotation fits the {what} best: {error}") from None


def refuse_one_line(rows: Floats, what: str, thinnest: float, coincident: NDArray[np.bool_] | bool = False) -> None:
    """Refuse vectors (..., n, 3) all along one line, and those that are known to be `coincident`."""
    # In a row, for the SVD takes fewer batch axes than arrays may have.
    row = np.linalg.svd(rows.reshape(-1, *rows.shape[-2:]), compute_uv=False)
    sigma = row.reshape(*rows.shape[:-2], row.shape[-1])
    thin = (sigma[..., 1] <= thinnest * sigma[..., 0]) | coincident
    if thin.any():
        which = f"{what}{at_index(first_index(thin))}"
        raise DegeneratePoints(
            f"{which} lie on one line to {thinnest:.0e} of its length: a turn about it would not be seen"
        )


def _as_points(value: ArrayLike, what: str) -> Floats:
    points = as_numbers(value, what)
    if points.ndim < 2 or points.shape[-1] != 3:
        raise WrongShape(what, "(..., n, 3)", points.shape)
    if points.shape[-2] < 3:
        raise DegeneratePoints(f"{what}: a rotation needs at least three, got {points.shape[-2]}")
    return as_vectors(points, what, rows=True)


def _centred(points: Floats, what: str, thinnest: float) -> Floats:
    """Points about their centroid, at a scale of about 1; collinear ones refused."""
    arms: Floats = points - points.mean(axis=-2, keepdims=True)
    scale = np.abs(arms).max(axis=(-2, -1), keepdims=True, initial=0.0)
    # The directions of coincident points are rounding errors, which their coordinates give away.
    rounding = 1e-15 * np.abs(points).max(axis=(-2, -1), keepdims=True, initial=0.0)
    arms /= np.where(scale > 0.0, scale, 1.0)
    refuse_one_line(arms, what, thinnest, (scale <= rounding)[..., 0, 0])
    return arms


def _triad(points: Floats) -> Floats:
    """The axes e1, e2, e3 as columns."""
    a, b, c = points[..., 0, :], points[..., 1, :], points[..., 2, :]
    e1, _ = unit(b - c, "b − c")
    e3, _ = unit(cross(e1, a - 0.5 * (b + c)), "normal of the points")
    # Of points near one line the product is short, and its rounding leans it towards the line.
    e3, _ = unit(e3 - dot(e3, e1)[..., None] * e1, "normal of the points")
    return np.stack([e1, cross(e3, e1), e3], axis=-1)
