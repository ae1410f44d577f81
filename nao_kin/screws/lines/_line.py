"""Lines: construction, change of origin, rigid motions, and planes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    Floats,
    as_vectors,
    check_tolerance,
    common_batch,
    cross,
    dot,
    first_index,
    norm,
    split_poses,
    unit,
)
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument, DegeneratePoints, NotABatch, at_index
from nao_kin.rotations import check_rotation

_CENTRE = (0.0, 0.0, 0.0)
# A shorter difference of two points, relative to the larger coordinate, has no correct digit.
_COINCIDENT = 4.0 * float(np.finfo(np.float64).eps)
# Six numbers with a larger pitch are a screw, not a line with rounding errors [m].
_LARGEST_PITCH = 1e-9
# The largest component of arguments, so that squares do not overflow.
_LARGEST_MOMENT = 1e150


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
        >>> line = nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0])
        >>> line.direction, line.moment
        (array([0., 1., 0.]), array([0., 0., 1.]))
    """

    direction: Floats
    moment: Floats
    origin: Floats = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        direction, moment = as_vectors(self.direction, "direction"), as_vectors(self.moment, "moment")
        common_batch("direction and moment", direction.shape[:-1], moment.shape[:-1])
        # A power of two scales both, so that the division loses no digits even for a short direction.
        shift = -np.frexp(np.abs(direction).max(axis=-1, keepdims=True))[1]
        e, length = unit(np.ldexp(direction, shift), "direction")
        with np.errstate(over="ignore"):
            n = np.ldexp(moment, shift) / length[..., None]
        # These comparisons are written so that NaN fails them.
        too_large = ~(np.abs(n).max(axis=-1) <= _LARGEST_MOMENT)
        if too_large.any():
            index = first_index(too_large)
            got = f"{n[index].tolist()}{at_index(index)}"
            raise BadArgument(f"moment/‖direction‖ must not exceed {_LARGEST_MOMENT:.0e} in magnitude, got {got}")
        pitch = dot(e, n)
        not_a_line = ~(np.abs(pitch) <= _LARGEST_PITCH * np.maximum(1.0, norm(n)))
        if not_a_line.any():
            index = first_index(not_a_line)
            raise BadArgument(
                f"direction·moment must be zero for a line, got a screw of pitch {pitch[index]:.3g}{at_index(index)}"
            )
        self._freeze(e, n - pitch[..., None] * e, as_vectors(self.origin, "origin"))

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
            >>> nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).coordinates
            array([0., 1., 0., 0., 0., 1.])
        """
        p, q = as_vectors(p, "p"), as_vectors(q, "q")
        o = as_vectors(origin, "origin")
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
            >>> nk.lines.PluckerLine.from_point_direction([1, 0, 0], [0, 3, 0]).coordinates
            array([0., 1., 0., 0., 0., 1.])
        """
        p, d = as_vectors(point, "point"), as_vectors(direction, "direction")
        o = as_vectors(origin, "origin")
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
            >>> nk.lines.PluckerLine.from_coordinates([0, 2, 0, 0, 0, 2]).point
            array([1., 0., 0.])
        """
        k = as_vectors(coordinates, "coordinates", 6)
        return cls(k[..., :3], k[..., 3:], as_vectors(origin, "origin"))

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
            >>> nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).closest_point([5, 7, 0])
            array([1., 7., 0.])
        """
        return self.transfer_to(to).point

    def distance_to(self, point: ArrayLike) -> Floats:
        """Distance of a point from the line, the length of the moment about that point, shape (...) [m].

        Examples:
            >>> nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).distance_to([[5, 7, 0], [1, 1, 0]])
            array([4., 0.])
        """
        return norm(self.transfer_to(point).moment)

    def transfer_to(self, origin: ArrayLike) -> PluckerLine:
        """The same line about another origin: n' = n + (o − o') × e, as by `transfer_matrix(o, o')`.

        Args:
            origin: o', shape (..., 3) [m].

        Examples:
            >>> nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).transfer_to([3, 0, 0]).moment
            array([ 0.,  0., -2.])
        """
        o = as_vectors(origin, "origin")
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
            >>> nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0]).transformed(upwards).point
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


def check_line(value: object, what: str) -> PluckerLine:
    """Return `value`; raise `BadArgument` unless it is a line or a batch of lines."""
    if not isinstance(value, PluckerLine):
        raise BadArgument(f"{what} must be a PluckerLine, got {type(value).__name__}")
    return value


def as_poses(T: ArrayLike, what: str) -> tuple[Floats, Floats]:
    """Return the checked rotations and the translations of poses."""
    R, t = split_poses(T, what)
    check_rotation(R)
    return R, t


# --- Intersections with planes.


@one_line_repr
@dataclass(frozen=True, eq=False)
class PlaneMeeting:
    """The intersection of a line with a plane, and its angle.

    Attributes:
        point: the intersection, shape (..., 3) [m]; for a parallel line, the point of the line closest to its origin.
        offset: signed distance of `point` from the plane, positive on the side of the normal, shape (...) [m]: 0 for an
            intersection.
        angle: angle of the line with the plane, positive if the line points to the side of the normal, shape (...), in
            [−π/2, π/2] [rad].
        parallel: whether the line counts as parallel to the plane, shape (...).
    """

    point: Floats
    offset: Floats
    angle: Floats
    parallel: NDArray[np.bool_]


def meet_plane(
    line: PluckerLine, point: ArrayLike, normal: ArrayLike, *, parallel_below: float = 1e-13
) -> PlaneMeeting:
    """Intersect lines with planes: x = c + ((p − c)·n / e·n) e, with c the point of the line closest to p.

    (x − line.point)·e is the coordinate of x along the line, and may be negative. The error of x is that of line and
    plane, divided by the sine of the angle between them.

    Args:
        line: lines with directions e.
        point: p, a point of each plane, shape (..., 3) [m].
        normal: n, the normal of each plane, of any length but zero, shape (..., 3).
        parallel_below: lines at a smaller angle to the plane count as parallel to it [rad].

    Examples:
        >>> ray = nk.lines.PluckerLine.from_point_direction([0, 0, 1], [1, 0, -1])
        >>> nk.lines.meet_plane(ray, point=[0, 0, 0], normal=[0, 0, 1]).point
        array([1., 0., 0.])
    """
    check_line(line, "line")
    check_tolerance(parallel_below, "parallel_below")
    p, given = as_vectors(point, "point"), as_vectors(normal, "normal")
    common_batch("line, point and normal", line.batch_shape, p.shape[:-1], given.shape[:-1])
    n, _ = unit(given, "normal")
    e, closest = line.direction, line.closest_point(p)
    sine = dot(e, n)
    parallel = np.abs(sine) <= parallel_below
    height = dot(closest - p, n)
    way = np.where(parallel, 0.0, -height / np.where(parallel, 1.0, sine))
    level = np.asarray(parallel)[..., None]
    return PlaneMeeting(
        point=np.where(level, line.point, closest + way[..., None] * e),
        offset=np.where(parallel, dot(line.point - p, n), 0.0),
        angle=np.arctan2(sine, norm(cross(e, n))),
        parallel=np.asarray(parallel),
    )
