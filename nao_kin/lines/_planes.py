"""Where a line meets a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.scalars import check_tolerance
from nao_kin._common.vectors import as_vectors, common_batch, cross, dot, norm, unit
from nao_kin.lines._line import PluckerLine, check_line


@dataclass(frozen=True, eq=False)
class PlaneMeeting:
    """Where a line meets a plane, and how steeply.

    Attributes:
        point: the point of the line nearest to the plane, shape (..., 3) [m]: the one in which they meet. Of a line
            parallel to the plane, all of whose points are equally near, the one closest to its origin.
        offset: signed distance of `point` from the plane, positive on the side of the normal, shape (...) [m]: 0 where
            they meet, for a parallel line its distance.
        angle: angle of the line with the plane, positive where it leaves on the side of the normal, shape (...), in
            [−π/2, π/2] [rad].
        parallel: where the line counts as parallel to the plane, shape (...).

    Examples:
        >>> ray = nk.lines.PluckerLine.from_point_direction([0, 0, 1], [1, 0, -1])
        >>> meeting = nk.lines.meet_plane(ray, [0, 0, 0], [0, 0, 1])
        >>> np.rad2deg(meeting.angle).round(9).tolist()
        -45.0
    """

    point: Floats
    offset: Floats
    angle: Floats
    parallel: NDArray[np.bool_]


def meet_plane(
    line: PluckerLine, point: ArrayLike, normal: ArrayLike, *, parallel_below: float = 1e-13
) -> PlaneMeeting:
    """Where lines meet planes: x = c + ((p − c)·n / e·n) e, with c the point of the line closest to p.

    It is the point of the line, forwards or backwards; (x − line.point)·e tells how far along it lies. Its error is
    that of the line and plane, divided by the sine of the angle between them.

    Args:
        line: lines with directions e.
        point: p, some point of each plane, shape (..., 3) [m].
        normal: n, the normal of each plane, of any length but zero, shape (..., 3).
        parallel_below: lines under this angle count as parallel to the plane [rad].

    Raises:
        ZeroNorm: a normal is zero.
        BadArgument: `line` is no `PluckerLine`, or the threshold no number ≥ 0.
        WrongShape, NotFinite: in `point` or `normal`, or batch shapes that do not fit together.

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
