"""Two lines: common normal, distance, angle, reciprocal product; and matrices that transform lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    Floats,
    as_floats,
    as_vectors,
    check_tolerance,
    common_batch,
    cross,
    cross_matrix,
    dot,
    norm,
)
from nao_kin._core.text import one_line_repr, quoted
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.screws.lines._line import PluckerLine, as_poses, check_line

# The angle that rounding in a chain of a hundred rotations leaves between parallel lines [rad].
_PARALLEL = 1e-13


@one_line_repr
@dataclass(frozen=True, eq=False)
class CommonNormal:
    """The shortest connection of two lines, with foot_b = foot_a + offset · direction to the last digit.

    Attributes:
        foot_a: its point on the first line, to the rounding of its coordinates, shape (..., 3) [m]. For parallel lines,
            the point of the first line closest to its origin.
        foot_b: its point on the second line, shape (..., 3) [m]; equal to `foot_a` where the lines coincide.
        direction: unit vectors normal to both lines, shape (..., 3): e_a × e_b normalised, also for lines that meet;
            from the first to the second line if they are parallel; zero if they coincide.
        offset: signed distance along `direction`, shape (...) [m].
        angle: angle from e_a to e_b, positive about `direction`, shape (...), in [0, π] [rad].
        parallel: whether the lines count as parallel or antiparallel, shape (...).
    """

    foot_a: Floats
    foot_b: Floats
    direction: Floats
    offset: Floats
    angle: Floats
    parallel: NDArray[np.bool_]

    @property
    def distance(self) -> Floats:
        """Distance of the two lines, shape (...) [m]."""
        return np.asarray(np.abs(self.offset))


def common_normal(
    a: PluckerLine, b: PluckerLine, *, parallel_below: float = _PARALLEL, coincident_below: float = 1e-12
) -> CommonNormal:
    """The common normal of two lines, its feet, and the distance and angle between the lines.

    For skew lines that are nearly parallel the distance is still accurate to the rounding of the moments, without a
    division by the sine of the angle, as long as the angle itself is accurate.

    Args:
        a: first lines.
        b: second lines, of a batch shape that broadcasts with that of `a`; the origins may differ.
        parallel_below: lines at a smaller angle count as parallel [rad]; the default is the rounding of a chain of a
            hundred rotations.
        coincident_below: parallel lines at a smaller distance count as coincident and get no direction [m].

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 3.2.2 and 4.2.

    Examples:
        >>> a = nk.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> normal = nk.lines.common_normal(a, nk.lines.PluckerLine.through([3, 0, -2], [3, 1, -2]))
        >>> normal.direction + 0.0, normal.offset.tolist(), np.rad2deg(normal.angle).tolist()
        (array([0., 0., 1.]), -2.0, 90.0)
    """
    check_tolerance(coincident_below, "coincident_below")
    pair = _compare(a, b, parallel_below)
    e_a, e_b, p_a = a.direction, b.direction, a.point
    a_to_b, normal, parallel = pair.a_to_b, pair.normal, pair.parallel
    safe_sine = np.where(parallel, 1.0, pair.sine)[..., None]
    along_a = dot(a_to_b, cross(e_b, normal))[..., None] / safe_sine
    along_b = dot(a_to_b, cross(e_a, normal))[..., None] / safe_sine
    skew_offset = dot(a_to_b, normal)
    # The feet of nearly parallel lines are far away; the foot that is nearer determines both.
    from_a = p_a + along_a * e_a
    from_b = b.point + along_b * e_b - skew_offset[..., None] * normal
    skew_foot = np.where(np.abs(along_a) <= np.abs(along_b), from_a, from_b)

    across = _part_across(a_to_b, e_b)
    distances = norm(across)
    coincident = distances <= coincident_below
    towards_b = np.where(coincident[..., None], 0.0, across / np.where(coincident, 1.0, distances)[..., None])

    chosen = parallel[..., None]
    foot_a = np.where(chosen, p_a, skew_foot)
    direction = np.where(chosen, towards_b, normal)
    offset = np.where(parallel, distances, skew_offset)
    return CommonNormal(
        foot_a=foot_a,
        foot_b=foot_a + offset[..., None] * direction,
        direction=direction,
        offset=offset,
        angle=np.arctan2(pair.sine, pair.cosine),
        parallel=np.asarray(parallel),
    )


def distance(a: PluckerLine, b: PluckerLine) -> Floats:
    """Distance between two lines, shape (...) [m], with the same result in either order.

    It equals the `distance` of `common_normal`, except for lines that count as parallel there but are not exactly
    parallel. For these it is the distance of the points closest to the origins of both, normal to the mean of the two
    directions.

    Examples:
        >>> a = nk.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> nk.lines.distance(a, nk.lines.PluckerLine.through([0, 0, 2], [0, 1, 2])).tolist()
        2.0
    """
    pair = _compare(a, b, _PARALLEL)
    distances = norm(_part_across(pair.a_to_b, pair.mean_direction))
    return np.asarray(np.where(pair.parallel, distances, np.abs(dot(pair.a_to_b, pair.normal))))


def angle(a: PluckerLine, b: PluckerLine) -> Floats:
    """Angle between two directed lines, shape (...), in [0, π] [rad], with the same result in either order.

    atan2(‖e_a × e_b‖, e_a·e_b) keeps all digits of small angles and of angles near π, where an arccos loses half. For
    undirected lines use min(angle, π − angle).

    Examples:
        >>> a = nk.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> nk.lines.angle(a, nk.lines.PluckerLine.through([0, 0, 2], [1, 1e-9, 2])).tolist()
        1e-09
    """
    pair = _compare(a, b, _PARALLEL)
    return np.asarray(np.arctan2(pair.sine, pair.cosine))


def incident(a: PluckerLine, b: PluckerLine, *, within: float = 1e-9) -> NDArray[np.bool_]:
    """Return whether the `distance` between two lines is at most `within` [m], shape (...).

    Parallel lines share a point only if they coincide, though their reciprocal product is always zero.

    Examples:
        >>> a = nk.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> nk.lines.incident(a, nk.lines.PluckerLine.through([[2, 0, 0], [0, 1, 0]], [[2, 1, 1], [1, 1, 0]]))
        array([ True, False])
    """
    check_tolerance(within, "within")
    return np.asarray(distance(a, b) <= within)


def reciprocal_product(a: PluckerLine, b: PluckerLine) -> Floats:
    """e_a·n_b + e_b·n_a, the moment of one line about the other, shape (...) [m].

    It is −offset · sin(angle) of the common normal, the same about every origin, and zero exactly when the lines meet
    or are parallel. It is the power of a unit force along one line and a unit angular velocity about the other.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 3.2.2; Ball, A Treatise on the Theory of Screws, ch. 1.

    Examples:
        >>> a = nk.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> nk.lines.reciprocal_product(a, nk.lines.PluckerLine.through([0, 0, 2], [0, 1, 2])).tolist()
        -2.0
    """
    _check_pair(a, b)
    seen_from_a = b.transfer_to(a.origin)
    return dot(a.direction, seen_from_a.moment) + dot(b.direction, a.moment)


class _Pair(NamedTuple):
    """Two lines. Exchanging them reverses `a_to_b`, `normal` and perhaps `mean_direction`, and changes nothing else."""

    a_to_b: Floats
    mean_direction: Floats
    normal: Floats
    sine: Floats
    cosine: Floats
    parallel: NDArray[np.bool_]


def _compare(a: PluckerLine, b: PluckerLine, parallel_below: float) -> _Pair:
    _check_pair(a, b)
    check_tolerance(parallel_below, "parallel_below")
    e_a, e_b = a.direction, b.direction
    cosine = dot(e_a, e_b)
    same_way = np.copysign(1.0, cosine)[..., None] * e_a
    # e_a × e_b is computed from a difference, which is exact where the two are nearly equal or nearly opposite. Half
    # the sum in place of one of the two makes it symmetric to the last bit, except for the sign.
    mean = 0.5 * (e_b + same_way)
    crossed = np.copysign(1.0, cosine)[..., None] * cross(mean, e_b - same_way)
    sine = norm(crossed)
    parallel = sine <= parallel_below
    return _Pair(
        a_to_b=b.point - a.point,
        mean_direction=mean,
        normal=crossed / np.where(parallel, 1.0, sine)[..., None],
        sine=sine,
        cosine=cosine,
        parallel=np.asarray(parallel),
    )


def _part_across(v: Floats, e: Floats) -> Floats:
    """The part of v at right angles to the unit vector e."""
    across = v - dot(v, e)[..., None] * e
    # Repeated, because rounding leaves a part along e if the difference is short relative to v.
    return np.asarray(across - dot(across, e)[..., None] * e)


def _check_pair(a: object, b: object) -> None:
    first, second = check_line(a, "a"), check_line(b, "b")
    common_batch("a and b", first.batch_shape, second.batch_shape)


# --- Matrices that transform Plücker coordinates, and the geometric Jacobian.


def transfer_matrix(a: ArrayLike, b: ArrayLike) -> Floats:
    """The matrix U with k_b = U k_a for the coordinates (direction; moment) of every line about the origins a and b.

    U = [[1, 0], [A − B, 1]], where A and B are the cross-product matrices of a and b: n_b = n_a + (a − b) × e.

    Args:
        a: the old origin, shape (..., 3) [m].
        b: the new origin, shape (..., 3) [m].

    Returns:
        U, shape (..., 6, 6), of determinant 1.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 3.2.2.

    Examples:
        >>> line = nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0])
        >>> nk.lines.transfer_matrix([0, 0, 0], [3, 0, 0]) @ line.coordinates
        array([ 0.,  1.,  0.,  0.,  0., -2.])
    """
    a, b = as_vectors(a, "a"), as_vectors(b, "b")
    batch = common_batch("a and b", a.shape[:-1], b.shape[:-1])
    U = np.zeros((*batch, 6, 6))
    U[...] = np.eye(6)
    U[..., 3:, :3] = cross_matrix(a - b)
    return U


def motion_matrix(T_ab: ArrayLike) -> Floats:
    """The matrix X with k_a = X k_b for the coordinates (direction; moment) of every line about the origins of a and b.

    X = [[R, 0], [t× R, R]] for the pose T_ab = [[R, t], [0, 1]], where t× is the cross-product matrix of t. With
    P = [[0, 1], [1, 0]], the adjoint of SE(3) in Pinocchio's order (linear; angular) is Ad = P X P, because a unit
    rotation about a line is the velocity (moment; direction). X is also Pinocchio's `SE3.toDualActionMatrix`, because a
    unit force along a line is (direction; moment).

    Args:
        T_ab: pose of frame b in frame a, shape (..., 4, 4).

    Returns:
        X, shape (..., 6, 6), of determinant 1.

    Examples:
        >>> line = nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0])
        >>> nk.lines.motion_matrix(nk.screws.pose(np.eye(3), [0, 0, 0.5])) @ line.coordinates
        array([ 0. ,  1. ,  0. , -0.5,  0. ,  1. ])
    """
    R, t = as_poses(T_ab, "T_ab")
    X = np.zeros((*t.shape[:-1], 6, 6))
    X[..., :3, :3] = X[..., 3:, 3:] = R
    X[..., 3:, :3] = cross_matrix(t) @ R
    return X


def geometric_jacobian(
    axes: PluckerLine,
    *,
    at: ArrayLike = (0.0, 0.0, 0.0),
    coupling: ArrayLike | None = None,
    sliding: ArrayLike = False,
) -> Floats:
    """The Jacobian of a body moved by joints: its columns are the Plücker coordinates of the joint axes.

    Column j is (moment; direction) of axis j about the point `at`: at unit speed about that line the body has the
    angular velocity e_j, and its point `at` the velocity e_j × (at − p_j) = n_j. The order (linear; angular) is
    Pinocchio's; the result is in the frame of the axes. A prismatic joint has the column (direction; 0).

    Args:
        axes: the m axes, batch shape (..., m).
        at: the point of the body whose velocity is computed, shape (..., 3) [m]: the frame's origin, or the root's.
        coupling: ∂(angle of axis)/∂(coordinate of the robot), shape (m, n). A mimic joint has its multiplier in the
            column of its driver; an axis that does not move the body has a row of zeros. By default the identity.
        sliding: which joints are prismatic, shape (m,), or one boolean for all.

    Returns:
        J, shape (..., 6, n), with n = m when no coupling is given.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 5.2.

    Examples:
        >>> axes = nk.lines.PluckerLine.from_point_direction([[0, 0, 0], [1, 0, 0]], [0, 0, 1])
        >>> nk.lines.geometric_jacobian(axes, at=[2, 0, 0])[:2] + 0.0  # both rotations about z move the hand along y
        array([[0., 0.],
               [2., 1.]])
    """
    check_line(axes, "axes")
    if not axes.batch_shape:
        raise WrongShape("batch axes of axes", "(..., m)", ())
    point = as_vectors(at, "at")
    common_batch("axes and at", axes.batch_shape[:-1], point.shape[:-1])
    seen = axes.transfer_to(point[..., None, :])
    count = axes.batch_shape[-1]
    slides = np.asarray(sliding, dtype=object)
    if slides.shape not in ((), (count,)):
        raise WrongShape("sliding", f"({count},)", slides.shape)
    if not all(isinstance(answer, (bool, np.bool_)) for answer in slides.flat):
        raise BadArgument(f"sliding must be true or false for each joint, got {quoted(sliding)}")
    slides = np.broadcast_to(slides.astype(np.bool_), (count,))[:, None]
    turning = np.concatenate([seen.moment, seen.direction], axis=-1)
    shifting = np.concatenate([seen.direction, np.zeros_like(seen.direction)], axis=-1)
    columns = np.swapaxes(np.where(slides, shifting, turning), -1, -2)
    if coupling is None:
        return columns
    C = as_floats(coupling, (), "coupling")
    if C.ndim != 2 or C.shape[0] != count:
        raise WrongShape("coupling", f"({count}, n)", C.shape)
    return columns @ C
