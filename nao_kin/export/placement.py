"""Poses as a URDF writes them, put one after the other."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nao_kin._core.arrays import Floats, Vector
from nao_kin.robot.urdf import Inertial, Origin
from nao_kin.rotations import exp, rpy_from_matrix

HERE = Origin()


def composed(first: Origin, second: Origin) -> Origin:
    """The pose `second` in the frame at `first`; exactly the other one where one of them is the identity."""
    if not any(first.xyz) and not any(first.rpy):
        return second
    if not any(second.xyz) and not any(second.rpy):
        return first
    T = first.matrix @ second.matrix
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


# --- How the mass of a body is spread, as a matrix that adds up.
#
# The pseudo-inertia of a body about a frame is P = ∫ x xᵀ dm with x = (position, 1): second moments, first moments and
# the mass in one symmetric 4×4 matrix. Those of two bodies held together add, and in another frame it is T P Tᵀ. A body
# of nowhere negative density has P ⪰ 0, and every such P belongs to one.
#
# Source: Wensing, Kim and Slotine, Linear Matrix Inequalities for Physically Consistent Inertial Parameter
# Identification, IEEE Robotics and Automation Letters 3(1), 2018.


def second_moments(inertia: Floats) -> Floats:
    """∫ x xᵀ dm of a tensor about the same point: Σ = ½ tr(I) 1 − I, shape (3, 3)."""
    return np.asarray(0.5 * np.trace(inertia) * np.eye(3) - inertia)


def tensor(moments: Floats) -> Floats:
    """The tensor of second moments about the same point: I = tr(Σ) 1 − Σ, shape (3, 3)."""
    return np.asarray(np.trace(moments) * np.eye(3) - moments)


def central_tensor(body: Inertial) -> Floats:
    """The tensor about the centre of mass along the axes of the link's frame, shape (3, 3) [kg m²]."""
    xx, xy, xz, yy, yz, zz = body.inertia
    found = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if any(body.origin.rpy):
        R = body.origin.matrix[:3, :3]
        found = R @ found @ R.T
    return found


def pseudo_inertia(body: Inertial, place: Origin | None = None) -> Floats:
    """P of a body, shape (4, 4): about its link's frame, or about the one in which that frame stands at `place`."""
    centre = np.array(body.origin.xyz)
    P = np.empty((4, 4))
    P[:3, :3] = second_moments(central_tensor(body)) + body.mass * np.outer(centre, centre)
    P[:3, 3] = P[3, :3] = body.mass * centre
    P[3, 3] = body.mass
    if place is None:
        return P
    T = place.matrix
    return np.asarray(T @ P @ T.T)


def body_of(P: Floats) -> Inertial:
    """The body of a pseudo-inertia, its tensor about the centre of mass along the axes of the frame."""
    mass = float(P[3, 3])
    centre = P[:3, 3] / mass if mass else np.zeros(3)
    return with_moments(mass, centre, P[:3, :3] - mass * np.outer(centre, centre))


def with_moments(mass: float, centre: Floats, moments: Floats) -> Inertial:
    """The body with these second moments about its centre of mass."""
    x, y, z = (np.asarray(centre) + 0.0).tolist()
    values = (tensor(moments) + 0.0)[np.triu_indices(3)].tolist()
    return Inertial(mass, Origin((x, y, z)), tuple(values))


# --- What an export has written.


@dataclass(frozen=True)
class Exported:
    """An export that is done.

    Attributes:
        path: the file to load, or the folder of the package.
        files: every file that was written.
        changes: what in them differs from the robot, one line each.

    Examples:
        >>> done = nk.export.urdf(nk.load_nao("v5"), "nao.urdf", coupling="locked", meshes="none")
        >>> [str(file) for file in done.files], done.changes[1]
        (['nao.urdf'], 'LHipYawPitch is fixed at 0, and with it what follows it: RHipYawPitch')
    """

    path: Path
    files: tuple[Path, ...]
    changes: tuple[str, ...] = ()
