"""What two lines have to do with one another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.scalars import check_tolerance
from nao_kin._common.vectors import common_batch, cross, dot, norm
from nao_kin.lines._line import PluckerLine, check_line


@dataclass(frozen=True, eq=False)
class CommonNormal:
    """The shortest connection of two lines: foot_b = foot_a + offset · direction, to the last digit.

    Attributes:
        foot_a: its point on the first line, to the rounding of its coordinates, shape (..., 3) [m]. Of parallel lines,
            which have a common normal everywhere, the one through the point of the first line closest to its origin.
        foot_b: its point on the second line, shape (..., 3) [m]; the same point as `foot_a` where the lines coincide.
        direction: unit vectors at right angles to both lines, shape (..., 3): e_a × e_b normalised, which lines that
            meet have too; from the first to the second when they are parallel; zero when they coincide, for then no
            normal is distinguished.
        offset: signed distance along `direction`, shape (...) [m].
        angle: angle from e_a to e_b, positive about `direction`, shape (...), in [0, π] [rad].
        parallel: where the lines count as parallel or antiparallel, shape (...).
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
    a: PluckerLine, b: PluckerLine, *, parallel_below: float = 1e-13, coincident_below: float = 1e-12
) -> CommonNormal:
    """The common normal of two lines, its feet, and the distance and angle it measures.

    Skew lines that are nearly parallel keep their accuracy: the distance is right to the rounding of the moments, with
    no division by the sine of the angle, as long as the angle itself is right.

    Args:
        a: first lines.
        b: second lines, of a batch shape that broadcasts with that of `a`; the origins may differ.
        parallel_below: lines under this angle count as parallel [rad]; the default is what the rounding of a chain of
            a hundred rotations leaves.
        coincident_below: parallel lines under this distance coincide and get no direction [m].

    Raises:
        WrongShape: the batch shapes do not fit together.
        BadArgument: `a` or `b` is no `PluckerLine`, or a threshold no number ≥ 0.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 3.2.2 and 4.2.
    """
    _check_pair(a, b)
    check_tolerance(parallel_below, "parallel_below")
    check_tolerance(coincident_below, "coincident_below")
    common_batch("a and b", a.batch_shape, b.batch_shape)
    e_a, e_b = a.direction, b.direction
    p_a, p_b = a.point, b.point
    cosine = dot(e_a, e_b)
    # e_a × e_b, taken from a difference that is exact where the two are nearly equal or nearly opposite.
    crossed = cross(e_a, e_b - np.copysign(1.0, cosine)[..., None] * e_a)
    sine = norm(crossed)
    parallel = sine <= parallel_below

    safe_sine = np.where(parallel, 1.0, sine)[..., None]
    normal = crossed / safe_sine
    a_to_b = p_b - p_a
    along_a = dot(a_to_b, cross(e_b, normal))[..., None] / safe_sine
    along_b = dot(a_to_b, cross(e_a, normal))[..., None] / safe_sine
    skew_offset = dot(a_to_b, normal)
    # Feet of nearly parallel lines lie far away; the line with the shorter way to its own tells where they are.
    from_a = p_a + along_a * e_a
    from_b = p_b + along_b * e_b - skew_offset[..., None] * normal
    skew_foot = np.where(np.abs(along_a) <= np.abs(along_b), from_a, from_b)

    across = a_to_b - dot(a_to_b, e_b)[..., None] * e_b
    # Once more: of lines much closer than their points, the first difference leaves a part along them by rounding.
    across = across - dot(across, e_b)[..., None] * e_b
    apart = norm(across)
    coincident = apart <= coincident_below
    towards_b = np.where(coincident[..., None], 0.0, across / np.where(coincident, 1.0, apart)[..., None])

    chosen = parallel[..., None]
    foot_a = np.where(chosen, p_a, skew_foot)
    direction = np.where(chosen, towards_b, normal)
    offset = np.where(parallel, apart, skew_offset)
    return CommonNormal(
        foot_a=foot_a,
        foot_b=foot_a + offset[..., None] * direction,
        direction=direction,
        offset=offset,
        angle=np.arctan2(sine, cosine),
        parallel=np.asarray(parallel),
    )


def distance(a: PluckerLine, b: PluckerLine) -> Floats:
    """Distance of two lines, shape (...) [m], as `common_normal` measures it; errors as there."""
    return common_normal(a, b).distance


def incident(a: PluckerLine, b: PluckerLine, *, within: float = 1e-9) -> NDArray[np.bool_]:
    """Whether two lines share a point, that is, come within `within` [m] of each other; shape (...).

    Parallel lines share one only when they coincide, though their reciprocal product is zero at any distance.

    Raises:
        WrongShape: the batch shapes do not fit together.
        BadArgument: `a` or `b` is no `PluckerLine`, or `within` no number ≥ 0.
    """
    check_tolerance(within, "within")
    return np.asarray(distance(a, b) <= within)


def reciprocal_product(a: PluckerLine, b: PluckerLine) -> Floats:
    """e_a·n_b + e_b·n_a, the moment of one line about the other, shape (...) [m].

    It is −offset · sin(angle) of the common normal, the same about every origin, and zero exactly when the lines meet
    or are parallel. As a product of a force along one line and a turn about the other it is their power.

    Raises:
        WrongShape: the batch shapes do not fit together.
        BadArgument: `a` or `b` is no `PluckerLine`.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 3.2.2; Ball, A Treatise on the Theory of Screws, ch. 1.
    """
    _check_pair(a, b)
    common_batch("a and b", a.batch_shape, b.batch_shape)
    seen_from_a = b.transfer_to(a.origin)
    return dot(a.direction, seen_from_a.moment) + dot(b.direction, a.moment)


def _check_pair(a: object, b: object) -> None:
    check_line(a, "a")
    check_line(b, "b")
