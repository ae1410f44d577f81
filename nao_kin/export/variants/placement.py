"""Poses as a URDF writes them, put one after the other."""

from __future__ import annotations

import numpy as np

from nao_kin._common.arrays import Floats, Vector
from nao_kin.rotations import exp, matrix_from_rpy, rpy_from_matrix
from nao_kin.urdf import Origin

HERE = Origin()


def transform(origin: Origin) -> Floats:
    """The pose as a matrix, shape (4, 4)."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = matrix_from_rpy(origin.rpy), origin.xyz
    return T


def composed(first: Origin, second: Origin) -> Origin:
    """The pose `second` in the frame at `first`; exactly the other one where one of them is the identity."""
    if not any(first.xyz) and not any(first.rpy):
        return second
    if not any(second.xyz) and not any(second.rpy):
        return first
    T = transform(first) @ transform(second)
    if not any(second.rpy):
        return Origin(_vector(T[:3, 3]), first.rpy)
    if not any(first.rpy):
        return Origin(_vector(T[:3, 3]), second.rpy)
    return Origin(_vector(T[:3, 3]), rpy_of(T[:3, :3]))


def moved(origin: Origin, kind: str, axis: Vector, value: float) -> Origin:
    """The pose of a joint at a value: turned about its axis, or moved along it."""
    if value == 0.0:
        return origin
    if kind == "prismatic":
        return composed(origin, Origin(_vector(value * np.array(axis))))
    return composed(origin, Origin(rpy=rpy_of(exp(value * np.array(axis)))))


def rpy_of(R: Floats) -> Vector:
    """Roll, pitch and yaw of a rotation, none of them −0."""
    return _vector(rpy_from_matrix(R))


def _vector(values: Floats) -> Vector:
    x, y, z = (values + 0.0).tolist()  # no −0
    return x, y, z
