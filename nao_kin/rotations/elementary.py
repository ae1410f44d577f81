"""Turns about one coordinate axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._arrays import Floats
from nao_kin._vectors import as_batch
from nao_kin.rotations._kernels import Functions, Kernel, Number, evaluate


def rot_x(angle: ArrayLike) -> Floats:
    """Rotation about x, [[1, 0, 0], [0, c, −s], [0, s, c]] with c = cos(angle), s = sin(angle).

    Args:
        angle: shape (...) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Raises:
        BadArgument, NotFinite: not numbers, NaN or infinity.
    """
    return _turn(_about_x, angle)


def rot_y(angle: ArrayLike) -> Floats:
    """Rotation about y, [[c, 0, s], [0, 1, 0], [−s, 0, c]] with c = cos(angle), s = sin(angle).

    Args:
        angle: shape (...) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Raises:
        BadArgument, NotFinite: not numbers, NaN or infinity.
    """
    return _turn(_about_y, angle)


def rot_z(angle: ArrayLike) -> Floats:
    """Rotation about z, [[c, −s, 0], [s, c, 0], [0, 0, 1]] with c = cos(angle), s = sin(angle).

    Args:
        angle: shape (...) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Raises:
        BadArgument, NotFinite: not numbers, NaN or infinity.
    """
    return _turn(_about_z, angle)


def _turn(kernel: Kernel, angle: ArrayLike) -> Floats:
    angles = as_batch(angle, (), "angle")
    return evaluate(kernel, [angles[..., np.newaxis]], (3, 3))[0]


def _about_x(f: Functions, angle: Number) -> tuple[Number, ...]:
    c, s = f.cos(angle), f.sin(angle)
    return 1.0, 0.0, 0.0, 0.0, c, 0.0 - s, 0.0, s, c


def _about_y(f: Functions, angle: Number) -> tuple[Number, ...]:
    c, s = f.cos(angle), f.sin(angle)
    return c, 0.0, s, 0.0, 1.0, 0.0, 0.0 - s, 0.0, c


def _about_z(f: Functions, angle: Number) -> tuple[Number, ...]:
    c, s = f.cos(angle), f.sin(angle)
    return c, 0.0 - s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0
