"""Lines in space in Plücker coordinates: direction and moment, about any origin.

A line through the point p with unit direction e has the moment n = (p − o) × e about the origin o, which is the same
for all points p of the line. The six numbers (e; n), in this order, are its Plücker coordinates.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    Floats,
    as_floats,
    common_batch,
    cross,
    cross_matrix,
    dot,
    first_index,
    norm,
    unit,
)
from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin._core.text import one_line_repr, quoted
from nao_kin.errors import BadArgument, DegeneratePoints, NotABatch, WrongShape, at_index
from nao_kin.screws._poses import as_poses

__all__ = [
    "CommonNormal",
    "PluckerLine",
    "angle",
    "common_normal",
    "distance",
    "geometric_jacobian",
    "incident",
    "motion_matrix",
    "reciprocal_product",
    "transfer_matrix",
]

_CENTRE = (0.0, 0.0, 0.0)
# A shorter difference of two points, relative to the larger coordinate, has no correct digit.
_COINCIDENT = 4.0 * float(np.finfo(np.float64).eps)
# Six numbers with a larger pitch are a screw, not a line with rounding errors [m].
_LARGEST_PITCH = 1e-9


@one_line_repr
@dataclass(frozen=True, eq=False)
class PluckerLine:
    """A directed line, or a batch of them, in Plücker coordinates (direction; moment) about an origin.

    With e the unit direction, p any point of the line and o the origin: moment n = (p − o) × e, and e·n = 0. Immutable:
    the arrays are read-only copies. `lines[i]` indexes the batch axes, and iteration runs over the first of them.

    Attributes:
        direction: unit vectors e, shape (..., 3). Given with any length but zero; direction and moment are divided by
            it.
        moment: n about `origin`, shape (..., 3) [m].
        origin: o, shape (..., 3) [m], in the same frame as everything else.

    Raises:
        BadArgument: direction·moment is not zero, so that the six numbers are a screw with a pitch and not a line.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 3.2.2.

    Examples:
        >>> line = nk.screws.lines.PluckerLine.through([1, 0, 0], [1, 2, 0])
        >>> line.direction, line.moment
        (array([0., 1., 0.]), array([0., 0., 1.]))
    """

    direction: Floats
    moment: Floats
    origin: Floats = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        direction, moment = as_floats(self.direction, (3,), "direction"), as_floats(self.moment, (3,), "moment")
        common_batch("direction and moment", direction.shape[:-1], moment.shape[:-1])
        e, length = unit(direction, "direction")
        n = moment / length[..., None]
        pitch = dot(e, n)
        not_a_line = ~(np.abs(pitch) <= _LARGEST_PITCH * np.maximum(1.0, norm(n)))
        if not_a_line.any():
            index = first_index(not_a_line)
            raise BadArgument(
                f"direction·moment must be zero for a line, got a screw of pitch {pitch[index]:.3g}{at_index(index)}"
            )
        self._freeze(e, n - pitch[..., None] * e, as_floats(self.origin, (3,), "origin"))

    @classmethod
    def through(cls, p: ArrayLike, q: ArrayLike, *, origin: ArrayLike = _CENTRE) -> PluckerLine:
        """The line through the points p and q, directed from p to q: e = (q − p)/‖q − p‖.

        Args:
            p: points, shape (..., 3) [m].
            q: points, shape (..., 3) [m], different from p.
            origin: point about which the moment is taken, shape (..., 3) [m].

        Raises:
            DegeneratePoints: p and q differ by no more than the rounding of their coordinates.

        Examples:
            >>> nk.screws.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).coordinates
            array([0., 1., 0., 0., 0., 1.])
        """
        p, q = as_floats(p, (3,), "p"), as_floats(q, (3,), "q")
        o = as_floats(origin, (3,), "origin")
        common_batch("p, q and origin", p.shape[:-1], q.shape[:-1], o.shape[:-1])
        difference = q - p
        largest = np.maximum(np.abs(p).max(axis=-1), np.abs(q).max(axis=-1))
        coincident = np.abs(difference).max(axis=-1) <= _COINCIDENT * largest
        if coincident.any():
            index = first_index(coincident)
            raise DegeneratePoints(f"p and q coincide{at_index(index)}: they determine no line")
        e, _ = unit(difference, "q − p")
        p_near, q_near = p - o, q - o
        # The nearer point gives the moment the smaller rounding error.
        arm = np.where((norm(p_near) <= norm(q_near))[..., None], p_near, q_near)
        return cls._of(e, cross(arm, e), o)

    @classmethod
    def from_point_direction(
        cls, point: ArrayLike, direction: ArrayLike, *, origin: ArrayLike = _CENTRE
    ) -> PluckerLine:
        """The line through a point along a direction of any length.

        Args:
            point: shape (..., 3) [m].
            direction: shape (..., 3), not zero.
            origin: point about which the moment is taken, shape (..., 3) [m].

        Examples:
            >>> nk.screws.lines.PluckerLine.from_point_direction([1, 0, 0], [0, 3, 0]).coordinates
            array([0., 1., 0., 0., 0., 1.])
        """
        p, d = as_floats(point, (3,), "point"), as_floats(direction, (3,), "direction")
        o = as_floats(origin, (3,), "origin")
        common_batch("point, direction and origin", p.shape[:-1], d.shape[:-1], o.shape[:-1])
        e, _ = unit(d, "direction")
        return cls._of(e, cross(p - o, e), o)

    @classmethod
    def from_coordinates(cls, coordinates: ArrayLike, *, origin: ArrayLike = _CENTRE) -> PluckerLine:
        """The line with the Plücker coordinates (direction; moment) about `origin`, up to a positive factor.

        Args:
            coordinates: shape (..., 6), the direction of any length but zero.
            origin: point about which the moment is taken, shape (..., 3) [m].

        Raises:
            BadArgument: direction·moment is not zero.

        Examples:
            >>> nk.screws.lines.PluckerLine.from_coordinates([0, 2, 0, 0, 0, 2]).point
            array([1., 0., 0.])
        """
        k = as_floats(coordinates, (6,), "coordinates")
        return cls(k[..., :3], k[..., 3:], as_floats(origin, (3,), "origin"))

    @property
    def coordinates(self) -> Floats:
        """Plücker coordinates (direction; moment), shape (..., 6)."""
        return np.concatenate([self.direction, self.moment], axis=-1)

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Shape of the batch axes: () for one line."""
        return self.direction.shape[:-1]

    @property
    def point(self) -> Floats:
        """The point of the line closest to its origin, o + e × n, shape (..., 3) [m]."""
        return self.origin + cross(self.direction, self.moment)

    def closest_point(self, to: ArrayLike) -> Floats:
        """The point of the line closest to the point `to`, shape (..., 3) [m].

        Examples:
            >>> nk.screws.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).closest_point([5, 7, 0])
            array([1., 7., 0.])
        """
        return self.transfer_to(to).point

    def distance_to(self, point: ArrayLike) -> Floats:
        """Distance of a point from the line, the length of the moment about that point, shape (...) [m].

        Examples:
            >>> nk.screws.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).distance_to([[5, 7, 0], [1, 1, 0]])
            array([4., 0.])
        """
        return norm(self.transfer_to(point).moment)

    def transfer_to(self, origin: ArrayLike) -> PluckerLine:
        """The same line about another origin: n' = n + (o − o') × e, as by `transfer_matrix(o, o')`.

        Args:
            origin: o', shape (..., 3) [m].

        Examples:
            >>> nk.screws.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).transfer_to([3, 0, 0]).moment
            array([ 0.,  0., -2.])
        """
        o = as_floats(origin, (3,), "origin")
        common_batch("line and origin", self.batch_shape, o.shape[:-1])
        return self._of(self.direction, self.moment + cross(self.origin - o, self.direction), o)

    def transformed(self, T_ab: ArrayLike) -> PluckerLine:
        """The coordinates in frame a of a line given in frame b; also a line of frame a moved by T_ab.

        e' = R e and p' = R p + t for every point p; the coordinates of `origin` stay the same. For origin zero
        this is `motion_matrix(T_ab)` times the coordinates.

        Args:
            T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).

        Examples:
            >>> upwards = nk.screws.pose(np.eye(3), [0, 0, 0.5])
            >>> nk.screws.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).transformed(upwards).point
            array([1. , 0. , 0.5])
        """
        R, t = as_poses(T_ab, "T_ab")
        common_batch("line and T_ab", self.batch_shape, t.shape[:-1])
        # A pose may be rounded to float32; the direction stays a unit vector.
        e, _ = unit(np.einsum("...ij,...j->...i", R, self.direction), "direction")
        n = np.einsum("...ij,...j->...i", R, self.moment)
        moved_origin = np.einsum("...ij,...j->...i", R, self.origin) + t
        return self._of(e, n + cross(moved_origin - self.origin, e), self.origin)

    def __getitem__(self, index: Any) -> PluckerLine:
        """The lines at `index`, any NumPy index over the batch axes; IndexError outside them."""
        picked = np.arange(self.direction.size // 3).reshape(self.batch_shape)[index]
        return self._of(*(v.reshape(-1, 3)[picked] for v in (self.direction, self.moment, self.origin)))

    def __iter__(self) -> Iterator[PluckerLine]:
        """The lines along the first batch axis; a single line raises `NotABatch`, which is a TypeError too."""
        if not self.batch_shape:
            raise NotABatch("a single PluckerLine contains no lines to iterate over: its batch shape is ()")
        return (self[i] for i in range(self.batch_shape[0]))

    def __reduce__(self) -> tuple[Any, ...]:
        # Default pickling would give the copy writable arrays.
        return PluckerLine._of, (self.direction, self.moment, self.origin)

    @classmethod
    def _of(cls, direction: Floats, moment: Floats, origin: Floats) -> PluckerLine:
        # Not checked: for a line through its origin, rounding may make direction·moment large relative to the moment.
        line = object.__new__(cls)
        line._freeze(direction, moment, origin)
        return line

    def _freeze(self, direction: Floats, moment: Floats, origin: Floats) -> None:
        batch = common_batch("direction, moment and origin", direction.shape[:-1], moment.shape[:-1], origin.shape[:-1])
        for name, value in (("direction", direction), ("moment", moment), ("origin", origin)):
            own = np.array(np.broadcast_to(value, (*batch, 3)))
            own.setflags(write=False)
            object.__setattr__(self, name, own)


# --- Two lines: common normal, distance, angle, reciprocal product.

# The angle that rounding in a chain of a hundred rotations leaves between parallel lines [rad].
_PARALLEL = 1e-13
# Parallel lines at a smaller distance coincide [m], and lines at a smaller distance meet.
_SAME_LINE, _MEETING = 1e-12, 1e-9


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


def common_normal(a: PluckerLine, b: PluckerLine) -> CommonNormal:
    """The common normal of two lines, its feet, and the distance and angle between the lines.

    For skew lines that are nearly parallel the distance is still accurate to the rounding of the moments, without a
    division by the sine of the angle, as long as the angle itself is accurate.

    Args:
        a: first lines.
        b: second lines, of a batch shape that broadcasts with that of `a`; the origins may differ.

    Lines at an angle below 1e-13, the rounding of a chain of a hundred rotations, count as parallel, and parallel lines
    at a distance below 1e-12 m as coincident: they get no direction.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 3.2.2 and 4.2.

    Examples:
        >>> a = nk.screws.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> normal = nk.screws.lines.common_normal(a, nk.screws.lines.PluckerLine.through([3, 0, -2], [3, 1, -2]))
        >>> normal.direction + 0.0, normal.offset.tolist(), np.rad2deg(normal.angle).tolist()
        (array([0., 0., 1.]), -2.0, 90.0)
    """
    pair = _compare(a, b)
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
    coincident = distances <= _SAME_LINE
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
        >>> a = nk.screws.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> nk.screws.lines.distance(a, nk.screws.lines.PluckerLine.through([0, 0, 2], [0, 1, 2])).tolist()
        2.0
    """
    pair = _compare(a, b)
    distances = norm(_part_across(pair.a_to_b, pair.mean_direction))
    return np.asarray(np.where(pair.parallel, distances, np.abs(dot(pair.a_to_b, pair.normal))))


def angle(a: PluckerLine, b: PluckerLine) -> Floats:
    """Angle between two directed lines, shape (...), in [0, π] [rad], with the same result in either order.

    atan2(‖e_a × e_b‖, e_a·e_b) keeps all digits of small angles and of angles near π, where an arccos loses half. For
    undirected lines use min(angle, π − angle).

    Examples:
        >>> a = nk.screws.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> nk.screws.lines.angle(a, nk.screws.lines.PluckerLine.through([0, 0, 2], [1, 1e-9, 2])).tolist()
        1e-09
    """
    pair = _compare(a, b)
    return np.asarray(np.arctan2(pair.sine, pair.cosine))


def incident(a: PluckerLine, b: PluckerLine) -> NDArray[np.bool_]:
    """Return whether the `distance` between two lines is at most 1e-9 m, shape (...).

    Parallel lines share a point only if they coincide, though their reciprocal product is always zero.

    Examples:
        >>> a = nk.screws.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> others = nk.screws.lines.PluckerLine.through([[2, 0, 0], [0, 1, 0]], [[2, 1, 1], [1, 1, 0]])
        >>> nk.screws.lines.incident(a, others)
        array([ True, False])
    """
    return np.asarray(distance(a, b) <= _MEETING)


def reciprocal_product(a: PluckerLine, b: PluckerLine) -> Floats:
    """e_a·n_b + e_b·n_a, the moment of one line about the other, shape (...) [m].

    It is −offset · sin(angle) of the common normal, the same about every origin, and zero exactly when the lines meet
    or are parallel. It is the power of a unit force along one line and a unit angular velocity about the other.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 3.2.2; Ball, A Treatise on the Theory of Screws, ch. 1.

    Examples:
        >>> a = nk.screws.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> nk.screws.lines.reciprocal_product(a, nk.screws.lines.PluckerLine.through([0, 0, 2], [0, 1, 2])).tolist()
        -2.0
    """
    common_batch("a and b", a.batch_shape, b.batch_shape)
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


def _compare(a: PluckerLine, b: PluckerLine) -> _Pair:
    common_batch("a and b", a.batch_shape, b.batch_shape)
    e_a, e_b = a.direction, b.direction
    cosine = dot(e_a, e_b)
    same_way = np.copysign(1.0, cosine)[..., None] * e_a
    # e_a × e_b is computed from a difference, which is exact where the two are nearly equal or nearly opposite. Half
    # the sum in place of one of the two makes it symmetric to the last bit, except for the sign.
    mean = 0.5 * (e_b + same_way)
    crossed = np.copysign(1.0, cosine)[..., None] * cross(mean, e_b - same_way)
    sine = norm(crossed)
    parallel = sine <= _PARALLEL
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
        >>> line = nk.screws.lines.PluckerLine.through([1, 0, 0], [1, 2, 0])
        >>> nk.screws.lines.transfer_matrix([0, 0, 0], [3, 0, 0]) @ line.coordinates
        array([ 0.,  1.,  0.,  0.,  0., -2.])
    """
    a, b = as_floats(a, (3,), "a"), as_floats(b, (3,), "b")
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
        >>> line = nk.screws.lines.PluckerLine.through([1, 0, 0], [1, 2, 0])
        >>> nk.screws.lines.motion_matrix(nk.screws.pose(np.eye(3), [0, 0, 0.5])) @ line.coordinates
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
        >>> axes = nk.screws.lines.PluckerLine.from_point_direction([[0, 0, 0], [1, 0, 0]], [0, 0, 1])
        >>> nk.screws.lines.geometric_jacobian(axes, at=[2, 0, 0])[:2] + 0.0  # both turns about z move the hand along y
        array([[0., 0.],
               [2., 1.]])
    """
    if not axes.batch_shape:
        raise WrongShape("batch axes of axes", "(..., m)", ())
    point = as_floats(at, (3,), "at")
    common_batch("axes and at", axes.batch_shape[:-1], point.shape[:-1])
    seen = axes.transfer_to(point[..., None, :])
    count = axes.batch_shape[-1]
    slides = np.asarray(sliding)
    if slides.dtype != np.bool_:
        raise BadArgument(f"sliding must be true or false for each joint, got {quoted(sliding)}")
    if slides.shape not in ((), (count,)):
        raise WrongShape("sliding", f"({count},)", slides.shape)
    slides = np.broadcast_to(slides, (count,))[:, None]
    turning = np.concatenate([seen.moment, seen.direction], axis=-1)
    shifting = np.concatenate([seen.direction, np.zeros_like(seen.direction)], axis=-1)
    columns = np.swapaxes(np.where(slides, shifting, turning), -1, -2)
    if coupling is None:
        return columns
    C = as_floats(coupling, (), "coupling")
    if C.ndim != 2 or C.shape[0] != count:
        raise WrongShape("coupling", f"({count}, n)", C.shape)
    return columns @ C


globals().update(_public_attributes(__name__))
