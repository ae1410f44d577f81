"""Joint axes as lines, and the Jacobian they make."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._arrays import Floats, as_floats
from nao_kin._vectors import as_vectors, common_batch
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.lines._line import PluckerLine, check_line


def geometric_jacobian(
    axes: PluckerLine,
    *,
    at: ArrayLike = (0.0, 0.0, 0.0),
    coupling: ArrayLike | None = None,
    sliding: ArrayLike = False,
) -> Floats:
    """The Jacobian of a body behind joints: its columns are the Plücker coordinates of the joint axes.

    Column j is (moment; direction) of axis j about the point `at`: turning at unit speed about that line, the body has
    the angular velocity e_j, and its point `at` the velocity e_j × (at − p_j) = n_j. The order (linear; angular) is
    Pinocchio's; the axes' frame is the frame of the result. A sliding joint has the column (direction; 0), the line at
    infinity about which it turns.

    Args:
        axes: the m axes, batch shape (..., m).
        at: the point of the body whose velocity is asked for, shape (..., 3) [m]: the frame's origin, or the root's.
        coupling: ∂(angle of axis)/∂(coordinate of the robot), shape (m, n). A mimic joint has its multiplier in the
            column of its primary; an axis that does not carry the body has a row of zeros. Left out: the axes are the
            coordinates.
        sliding: which joints are prismatic, shape (m,) or one answer for all.

    Returns:
        J, shape (..., 6, n), with n = m when no coupling is given.

    Raises:
        WrongShape: `axes` is a single line without a joint axis, or the arguments do not fit together.
        BadArgument: `axes` is no `PluckerLine`, or `sliding` holds anything but booleans.
        NotFinite: in `at` or `coupling`.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 5.2.
    """
    check_line(axes, "axes")
    if not axes.batch_shape:
        raise WrongShape("batch axes of axes", "(..., m)", ())
    point = as_vectors(at, "at")
    common_batch("axes and at", axes.batch_shape[:-1], point.shape[:-1])
    seen = axes.transfer_to(point[..., None, :])
    count = axes.batch_shape[-1]
    slides = np.asarray(sliding, dtype=object)
    if not all(isinstance(answer, (bool, np.bool_)) for answer in slides.flat):
        raise BadArgument(f"sliding must be true or false for each joint, got {sliding!r}")
    if slides.shape not in ((), (count,)):
        raise WrongShape("sliding", f"({count},)", slides.shape)
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
