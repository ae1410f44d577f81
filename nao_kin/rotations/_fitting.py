"""Rotations fitted to data: means, directions or points before and after a motion, and one or two angles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    Floats,
    as_floats,
    choice,
    common_batch,
    cross,
    dot,
    first_index,
    norm,
    unit,
)
from nao_kin._core.kernels import Functions, Number, evaluate
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument, DegeneratePoints, WrongShape, at_index
from nao_kin.rotations._checks import as_rotations, as_shares, evaluate_rotations, nearest_rotation
from nao_kin.rotations._exponential import exp, log
from nao_kin.rotations._quaternions import matrix_from_quat, quaternion_of
from nao_kin.rotations._three_angles import REQUIRED, Axes, find_short_sequence, scaled_axis

MeanMethod = Literal["geodesic", "chordal"]

_MAX_STEPS = 200
# Length of a step that changes only the last digit, and of a step that may be due to rounding alone [rad].
_LAST_STEP, _SHORT_STEP = 1e-15, 1e-12
# A lower bound of the curvature, above ½ so that no step increases the sum of squares.
_LEAST_CURVATURE = 0.55


@one_line_repr
@dataclass(frozen=True, eq=False)
class MeanRotation:
    """A mean of rotations, and their spread about it.

    Attributes:
        rotation: the mean R̄, shape (..., 3, 3).
        spread: root of the weighted mean of the squared angles to the mean, shape (...) [rad].
        covariance: weighted mean of v vᵀ with v = log(R̄ᵀ Rᵢ), in the axes of the mean's frame, shape (..., 3, 3)
            [rad²]; its trace is the spread squared.
    """

    rotation: Floats
    spread: Floats
    covariance: Floats


def mean_rotation(R: ArrayLike, weights: ArrayLike | None = None, *, method: MeanMethod = "geodesic") -> MeanRotation:
    """The weighted mean of rotations, with its spread.

    geodesic: the R̄ with least Σ wᵢ φᵢ², with φᵢ the angle from R̄ to Rᵢ (the Karcher mean). It is unique if all
    rotations are less than 90° from some rotation. Otherwise there may be several local minima; the result is the one
    reached from the chordal mean.
    chordal: the R̄ with least Σ wᵢ ‖Rᵢ − R̄‖², the rotation nearest to Σ wᵢ Rᵢ, which is also the eigenvector mean of
    unit quaternions. It is faster, is the global minimum if the mean exists, and is less sensitive to outliers.
    Both give the midpoint of two rotations of equal weight, and nearly the same for rotations close together.

    Args:
        R: rotation matrices, shape (..., n, 3, 3); the mean is over n ≥ 1.
        weights: shape (..., n), not negative, not all zero, of any scale; broadcasts with R. None for equal weights.
        method: "geodesic" or "chordal".

    Returns:
        Mean, spread and covariance.

    Raises:
        BadArgument: the weighted sum has no single nearest rotation (two rotations half a turn apart, or rotations
            scattered evenly over all directions).

    Source: Hartley, Trumpf, Dai and Li, Rotation averaging, IJCV 103, 2013.

    Examples:
        >>> mean = nk.rotations.mean_rotation(nk.rotations.rot_z([0.1, 0.2, 0.6]))
        >>> np.allclose(mean.rotation, nk.rotations.rot_z(0.3)), mean.spread
        (True, array(0.216))
    """
    choice(method, ("geodesic", "chordal"), "method")
    rotations = as_rotations(R)
    if rotations.ndim < 3:
        raise WrongShape("rotations", "(..., n, 3, 3)", rotations.shape)
    if rotations.shape[-3] == 0:
        raise BadArgument("a mean needs at least one rotation, got none")
    shares = as_shares(weights, rotations.shape[-3])
    batch = common_batch("rotations and weights", rotations.shape[:-2], shares.shape)
    rotations, shares = np.broadcast_to(rotations, (*batch, 3, 3)), np.broadcast_to(shares, batch)
    mean = _chordal(rotations, shares)
    if method == "geodesic":
        mean = _geodesic(mean, rotations, shares)
    arms = _arms(mean, rotations)
    covariance = np.swapaxes(shares[..., np.newaxis] * arms, -1, -2) @ arms
    return MeanRotation(mean, np.asarray(np.sqrt(dot(shares, dot(arms, arms)))), covariance)


def _chordal(rotations: Floats, shares: Floats) -> Floats:
    try:
        return nearest_rotation(np.einsum("...n,...nij->...ij", shares, rotations))
    except BadArgument as error:
        raise BadArgument(f"the rotations have no single mean: for their weighted sum, {error}") from None


def _geodesic(mean: Floats, rotations: Floats, shares: Floats) -> Floats:
    """Descend from `mean` by Newton steps, with a lower bound of the curvature (φ/2) cot(φ/2) across each arm.

    An arm is the rotation vector from the mean to a rotation. The squared angle has a curvature of at most 1, also at
    its kink at φ = π. So steps with curvatures above ½ never increase the sum, and need no line search.
    """
    previous = np.inf
    for _ in range(_MAX_STEPS):
        arms = _arms(mean, rotations)
        squares = dot(arms, arms)
        half = 0.5 * np.sqrt(squares)
        across = np.maximum(np.where(half > 0.0, half / np.tan(np.where(half > 0.0, half, 1.0)), 1.0), _LEAST_CURVATURE)
        # The curvature is `across` normal to the arm, and 1 along it.
        along = shares * (1.0 - across) / np.where(squares > 0.0, squares, 1.0)
        curvature = dot(shares, across)[..., np.newaxis, np.newaxis] * np.eye(3)
        curvature = curvature + np.swapaxes(along[..., np.newaxis] * arms, -1, -2) @ arms
        slope = np.einsum("...n,...ni->...i", shares, arms)
        step = np.linalg.solve(curvature, slope[..., np.newaxis])[..., 0]
        mean = mean @ exp(step)
        length = float(np.abs(step).max(initial=0.0))
        if length <= _LAST_STEP or 0.5 * previous <= length <= _SHORT_STEP:
            break
        previous = length
    return nearest_rotation(mean)


def _arms(mean: Floats, rotations: Floats) -> Floats:
    """The rotation vectors from the mean to each rotation, in the mean's frame, shape (..., n, 3)."""
    return log(np.swapaxes(mean, -1, -2)[..., np.newaxis, :, :] @ rotations)


# --- The rotation of a body from points on it before and after a motion.

PointsMethod = Literal["least_squares", "triads"]

# Ratio σ₂/σ₁ up to which points count as lying on one line. The error of the rotation about that line grows as
# 1/thinness with triads, and as 1/thinness² with least squares, because the product of both point sets has the squares
# of their singular values.
THINNEST = {"triads": 1e-8, "least_squares": 1e-6}


def rotation_from_points(before: ArrayLike, after: ArrayLike, *, method: PointsMethod = "least_squares") -> Floats:
    """The rotation R that maps points of a body before a motion to the same points after it, for any translation.

    least_squares: the R that minimises Σ ‖(p'ᵢ − p̄') − R (pᵢ − p̄)‖², the rotation nearest to Σ (p'ᵢ − p̄')(pᵢ − p̄)ᵀ;
    for n ≥ 3 points.
    triads: R = [e1' e2' e3'] [e1 e2 e3]ᵀ from exactly three points a, b, c, with e1 along b − c, e2 along the part of
    a − (b + c)/2 normal to e1, and e3 = e1 × e2; it maps the line of b and c exactly, and the plane of the three.
    For exact points of a rigid body both give the same R. For points near one line, the rotation about it is accurate
    to about 1e-16/thinness by triads and 1e-16/thinness² by least squares, with thinness = width / length.

    Args:
        before: points before the motion, shape (..., n, 3) [m].
        after: the same points after it, shape (..., n, 3) [m]; batch axes broadcast.
        method: "least_squares" or "triads".

    Returns:
        Rotation matrices, shape (..., 3, 3), with determinant +1 also for points in a plane.

    Raises:
        DegeneratePoints: fewer than three points, points on one line (thinner than 1e-6 of their length for least
            squares, 1e-8 for triads), or points as near to a mirror image as to a rotated image.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3 (triads); Umeyama, IEEE PAMI 13(4), 1991.

    Examples:
        >>> before, after = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[5, 5, 5], [5, 6, 5], [4, 5, 5]]
        >>> np.allclose(nk.rotations.rotation_from_points(before, after), nk.rotations.rot_z(np.pi / 2))
        True
    """
    choice(method, ("least_squares", "triads"), "method")
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


def refuse_one_line(rows: Floats, what: str, thinnest: float) -> None:
    """Refuse vectors (..., n, 3) along one line, and zeros."""
    sigma = np.linalg.svd(rows, compute_uv=False)
    thin = sigma[..., 1] <= thinnest * sigma[..., 0]
    if thin.any():
        which = f"{what}{at_index(first_index(thin))}"
        raise DegeneratePoints(
            f"{which} lie on one line to {thinnest:.0e} of its length: the rotation about it is not determined"
        )


def _as_points(value: ArrayLike, what: str) -> Floats:
    points = as_floats(value, (3,), what)
    if points.ndim < 2:
        raise WrongShape(what, "(..., n, 3)", points.shape)
    if points.shape[-2] < 3:
        raise DegeneratePoints(f"{what}: a rotation needs at least three, got {points.shape[-2]}")
    return points


def _centred(points: Floats, what: str, thinnest: float) -> Floats:
    """Points relative to their centroid, scaled to about 1; collinear points are refused."""
    arms: Floats = points - points.mean(axis=-2, keepdims=True)
    scale = np.abs(arms).max(axis=(-2, -1), keepdims=True, initial=0.0)
    # The directions of coincident points are rounding errors of their coordinates.
    rounding = 1e-15 * np.abs(points).max(axis=(-2, -1), keepdims=True, initial=0.0)
    arms = np.where(scale > rounding, arms / np.where(scale > 0.0, scale, 1.0), 0.0)
    refuse_one_line(arms, what, thinnest)
    return arms


def _triad(points: Floats) -> Floats:
    """The axes e1, e2, e3 as columns."""
    a, b, c = points[..., 0, :], points[..., 1, :], points[..., 2, :]
    e1, _ = unit(b - c, "b − c")
    e3, _ = unit(cross(e1, a - 0.5 * (b + c)), "normal of the points")
    # For points near one line the product is short, and rounding gives it a part along the line.
    e3, _ = unit(e3 - dot(e3, e1)[..., None] * e1, "normal of the points")
    return np.stack([e1, cross(e3, e1), e3], axis=-1)


# --- Rotations from directions: the shortest one between two, and the best fit to many.

# Largest ‖a + b‖ of unit vectors that are opposite to rounding.
_OPPOSITE = 4.0 * 2.0**-52


@one_line_repr
@dataclass(frozen=True, eq=False)
class DirectionFit:
    """The rotation that fits directions best.

    Attributes:
        rotation: R, shape (..., 3, 3).
        residual: root of the weighted mean of ‖bᵢ − R aᵢ‖² over the unit directions, shape (...): nearly the root mean
            square of `angles`.
        angles: the angle between R aᵢ and bᵢ, shape (..., n) [rad].
    """

    rotation: Floats
    residual: Floats
    angles: Floats


def rotation_between(a: ArrayLike, b: ArrayLike, *, axis: ArrayLike | None = None) -> Floats:
    """The rotation by the least angle that maps the direction of a to the direction of b, about a × b.

    For opposite directions every axis normal to a is possible. The function then uses the part of `axis` normal to a.
    Without `axis`, it uses the part normal to a of the coordinate axis along which a is smallest (x before y before z):
    a half turn about x maps z to −z, one about y maps x to −x. Directions are opposite if ‖a/‖a‖ + b/‖b‖‖ ≤ 4 × 2⁻⁵².

    Args:
        a: directions before, shape (..., 3), of any length but zero.
        b: directions after, shape (..., 3); broadcasts with a.
        axis: for opposite directions only, shape (..., 3); broadcasts with them.

    Returns:
        Rotation matrices, shape (..., 3, 3), with R a along b to a few 1e-16.

    Raises:
        BadArgument: an axis along a, if a and b are opposite.

    Examples:
        >>> R = nk.rotations.rotation_between([1, 0, 0], [0, 2, 0])
        >>> np.allclose(R, nk.rotations.rot_z(np.pi / 2))
        True
    """
    first, second = (_units(side, f"direction {name}") for side, name in ((a, "a"), (b, "b")))
    shapes = [first.shape[:-1], second.shape[:-1]]
    if axis is not None:
        about = _units(axis, "axis")
        shapes.append(about.shape[:-1])
    batch = common_batch("a, b and axis" if axis is not None else "a and b", *shapes)
    first, second = np.broadcast_to(first, (*batch, 3)), np.broadcast_to(second, (*batch, 3))
    total, difference = first + second, second - first
    near = (dot(first, second) >= 0.0)[..., np.newaxis]
    # a × b or its opposite, from the difference or the sum of the two: the shorter one is exact.
    normal = cross(first, np.where(near, difference, total))
    cosine, sine = norm(total), norm(difference)
    opposite = np.asarray(cosine <= _OPPOSITE)
    if opposite.any():
        farthest = np.eye(3)[np.abs(first).argmin(axis=-1)]
        wanted = farthest if axis is None else np.broadcast_to(about, (*batch, 3))
        normal = np.where(opposite[..., np.newaxis], _normal_part(wanted, first, opposite), normal)
        cosine = np.where(opposite, 0.0, cosine)
    length = norm(normal)
    same = length == 0.0
    vector = normal * np.where(same, 0.0, sine / np.where(same, 1.0, length))[..., np.newaxis]
    return matrix_from_quat(np.concatenate([cosine[..., np.newaxis], vector], axis=-1))


def rotation_from_directions(before: ArrayLike, after: ArrayLike, weights: ArrayLike | None = None) -> DirectionFit:
    """The rotation that best maps directions to their observed directions (Wahba's problem).

    It is the R with least Σ wᵢ ‖bᵢ − R aᵢ‖² over the unit directions aᵢ before and bᵢ after, and the rotation nearest
    to Σ wᵢ bᵢ aᵢᵀ. For points, use `rotation_from_points`.

    Args:
        before: directions, shape (..., n, 3), n ≥ 2, of any length but zero.
        after: the same directions after the rotation, shape (..., n, 3); batch axes broadcast.
        weights: shape (..., n), not negative, not all zero, of any scale; the best are 1/σᵢ² for standard
            deviations σᵢ of the directions [rad]. None for equal weights.

    Returns:
        Rotation, residual, and the remaining angle of each direction.

    Raises:
        DegeneratePoints: fewer than two directions, directions along one line (√wᵢ aᵢ or √wᵢ bᵢ thinner than 1e-6 of
            their length), or directions without a single best rotation.

    Source: Wahba, A least squares estimate of satellite attitude, SIAM Review 7(3), 1965; Markley, Attitude
    determination using vector observations and the SVD, J. Astronautical Sciences 36(3), 1988.

    Examples:
        >>> gravity, north = [0, 0, -1], [1, 0, 0]
        >>> fit = nk.rotations.rotation_from_directions([gravity, north], [gravity, [0, 1, 0]])
        >>> np.allclose(fit.rotation, nk.rotations.rot_z(np.pi / 2)), bool(fit.residual < 1e-15)
        (True, True)
    """
    A, B = (_units(side, f"directions {name}") for side, name in ((before, "before"), (after, "after")))
    for side, what in ((A, "directions before"), (B, "directions after")):
        if side.ndim < 2:
            raise WrongShape(what, "(..., n, 3)", side.shape)
    count = A.shape[-2]
    if B.shape[-2] != count:
        raise WrongShape("directions after", f"(..., {count}, 3), as many as before", B.shape)
    if count < 2:
        raise DegeneratePoints(f"a rotation needs at least two directions, got {count}")
    shares = as_shares(weights, count)
    batch = common_batch("directions and weights", A.shape[:-2], B.shape[:-2], shares.shape[:-1])
    A, B = np.broadcast_to(A, (*batch, count, 3)), np.broadcast_to(B, (*batch, count, 3))
    roots = np.sqrt(np.broadcast_to(shares, (*batch, count)))[..., np.newaxis]
    for side, what in ((A, "directions before"), (B, "directions after")):
        refuse_one_line(roots * side, what, THINNEST["least_squares"])
    R = best_fit(roots * A, roots * B, "directions")
    turned = A @ np.swapaxes(R, -1, -2)
    distances = norm(B - turned)
    residual = norm(roots[..., 0] * distances)
    angles = 2.0 * np.arctan2(distances, norm(B + turned))
    return DirectionFit(R, np.asarray(residual), np.asarray(angles))


def _units(value: ArrayLike, what: str) -> Floats:
    return unit(as_floats(value, (3,), what), what)[0]


def _normal_part(wanted: Floats, first: Floats, needed: NDArray[np.bool_]) -> Floats:
    """The part of unit vectors normal to others; refused if it is needed but zero."""
    part = wanted - dot(wanted, first)[..., np.newaxis] * first
    along = np.asarray(needed & (norm(part) <= _OPPOSITE))
    if along.any():
        raise BadArgument(
            f"the axis of a half turn between opposite directions{at_index(first_index(along))} must not lie along them"
        )
    # Rounding leaves a part along `first`, so it is subtracted again.
    part = part / np.where(needed, norm(part), 1.0)[..., np.newaxis]
    return np.asarray(part - dot(part, first)[..., np.newaxis] * first)


# --- The rotations about one or two axes that are nearest to a rotation.

# Normalising two parallel axes of any lengths leaves at most this sine between them.
_PARALLEL = 4.0 * 2.0**-52


@one_line_repr
@dataclass(frozen=True, eq=False)
class NearestAngles:
    """The angles of the rotations about one or two axes that are nearest to a rotation.

    Attributes:
        angles: in the order of the axes as written, shape (..., 1) or (..., 2), in [−π, π] [rad].
        residual: angle between the rotation and its approximation, shape (...) [rad]; 0 where they agree.
    """

    angles: Floats
    residual: Floats


def nearest_euler(R: ArrayLike, sequence: str, *, axes: Axes = REQUIRED) -> NearestAngles:
    """The angles about one or two coordinate axes nearest to a rotation, and the remaining angle.

    A general rotation is not a rotation about z alone, or about z and then y; the residual is its distance from such a
    rotation. For three axes use `euler_from_matrix`.

    For "i", α = 2 atan2(rᵢ, r0) with the unit quaternion (r0, r): the twist about the axis. For moving axes "ij" the
    products of half angles in the quaternion form a matrix of rank one. The nearest such matrix is found in closed
    form: α and β are the sum and the difference of atan2(rᵢ + rⱼ, r0 − s rₖ) and atan2(rᵢ − rⱼ, r0 + s rₖ), with k the
    third axis and s = ±1 such that eᵢ × eⱼ = s eₖ.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        sequence: one or two different letters of "x", "y", "z", lower case; angles are returned in this order.
        axes: "moving" or "fixed"; required.

    Returns:
        Angles and residual. The residual is at most π for one axis and π/2 for two; at this maximum the angles are not
        unique.

    Examples:
        >>> R = nk.rotations.matrix_from_euler([0.3, -0.4], "zy", axes="moving")
        >>> nk.rotations.nearest_euler(R, "zy", axes="moving").angles
        array([ 0.3, -0.4])
        >>> nk.rotations.nearest_euler(R, "z", axes="moving").residual
        array(0.4)
    """
    places = find_short_sequence(sequence, axes)
    units = [[float(row == place) for row in range(3)] for place in places]

    def kernel(f: Functions, *m: Number) -> tuple[Number, ...]:
        return _nearest(f, *quaternion_of(f, *m), *units)

    angles, residual = evaluate_rotations(kernel, R, (len(places),), ())
    # Rotations about fixed axes equal those about moving axes in the opposite order.
    return NearestAngles(np.ascontiguousarray(angles[..., ::-1]) if axes == "fixed" else angles, residual)


def nearest_davenport(R: ArrayLike, a1: ArrayLike, a2: ArrayLike | None = None) -> NearestAngles:
    """The angles about one or two arbitrary axes nearest to a rotation: Rot(a1, α) Rot(a2, β), or Rot(a1, α).

    This is `nearest_euler` for any axes, perpendicular or not. One axis gives the twist of a rotation about it; the
    rest, Rot(a1, −α) R, is its swing.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        a1: first axis, shape (..., 3), of any length but zero; broadcasts with R.
        a2: second axis, as moved by the first rotation, not parallel to the first; or None.

    Returns:
        Angles and residual; at the largest residual the angles are not unique.

    Examples:
        >>> R = nk.rotations.matrix_from_natural([1, 1, 0], 0.7)
        >>> nk.rotations.nearest_davenport(R, [2, 2, 0]).angles
        array([0.7])
    """
    given = [a1] if a2 is None else [a1, a2]
    units = [unit(scaled_axis(axis, f"axis a{i}"), "axis")[0] for i, axis in enumerate(given, 1)]
    matrices = as_rotations(R)
    batch = common_batch("R and the axes", matrices.shape[:-2], *(axis.shape[:-1] for axis in units))
    if len(units) == 2:
        parallel = np.asarray(norm(cross(*units)) <= _PARALLEL)
        if parallel.any():
            raise BadArgument(f"axes a1 and a2{at_index(first_index(parallel))} must not be parallel")
    entries = np.broadcast_to(matrices.reshape(*matrices.shape[:-2], 9), (*batch, 9))
    inputs = [entries, *(np.broadcast_to(axis, (*batch, 3)) for axis in units)]

    def kernel(f: Functions, *m: Number) -> tuple[Number, ...]:
        return _nearest(f, *quaternion_of(f, *m[:9]), *(m[start : start + 3] for start in range(9, len(m), 3)))

    return NearestAngles(*evaluate(kernel, inputs, (len(units),), ()))


def _nearest(f: Functions, r0: Number, x: Number, y: Number, z: Number, *axes: Number) -> tuple[Number, ...]:
    """The angles and the residual of a unit quaternion and one or two unit axes."""
    a0, a1, a2 = axes[0]
    along = x * a0 + y * a1 + z * a2
    if len(axes) == 1:
        half = f.atan2(along, r0)
        c, s = f.cos(half), f.sin(half)
        angles: tuple[Number, ...] = (_wrapped(f, 2.0 * half),)
        turned = (c, s * a0, s * a1, s * a2)
    else:
        b0, b1, b2 = axes[1]
        n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
        cosine = a0 * b0 + a1 * b1 + a2 * b2
        along_second = x * b0 + y * b1 + z * b2
        across = x * n0 + y * n1 + z * n2 - r0 * cosine
        # With half angles a and b, the inner product of the quaternion and that of the result is
        # (cos a, sin a) [[r0, along_second], [along, across]] (cos b, sin b)ᵀ: a term that depends on a + b plus one
        # that depends on a − b, which are maximised separately.
        total = f.atan2(along + along_second, r0 - across)
        difference = f.atan2(along - along_second, r0 + across)
        ha, hb = 0.5 * (total + difference), 0.5 * (total - difference)
        ca, sa, cb, sb = f.cos(ha), f.sin(ha), f.cos(hb), f.sin(hb)
        p, q, r = sa * cb, ca * sb, sa * sb
        angles = (_wrapped(f, total + difference), _wrapped(f, total - difference))
        turned = (ca * cb - r * cosine, p * a0 + q * b0 + r * n0, p * a1 + q * b1 + r * n1, p * a2 + q * b2 + r * n2)
    pairs = tuple(zip((r0, x, y, z), turned, strict=True))
    to_one = sum((u - v) * (u - v) for u, v in pairs)
    to_other = sum((u + v) * (u + v) for u, v in pairs)
    return *angles, 4.0 * f.atan2(f.sqrt(to_one), f.sqrt(to_other))


def _wrapped(f: Functions, angle: Number) -> Number:
    """Wrap an angle in [−2π, 2π] to [−π, π]."""
    return angle - f.where(angle > math.pi, 2.0 * math.pi, f.where(angle < -math.pi, -2.0 * math.pi, 0.0)) + 0.0
