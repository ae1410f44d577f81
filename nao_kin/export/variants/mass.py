"""How the mass of a body is spread, as a matrix that adds up.

The pseudo-inertia of a body about a frame is P = ∫ x xᵀ dm with x = (position, 1): second moments, first moments and
the mass in one symmetric 4×4 matrix. Those of two bodies held together add, and in another frame it is T P Tᵀ. A body
of nowhere negative density has P ⪰ 0, and every such P belongs to one.

Source: Wensing, Kim and Slotine, Linear Matrix Inequalities for Physically Consistent Inertial Parameter
Identification, IEEE Robotics and Automation Letters 3(1), 2018.
"""

from __future__ import annotations

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.export.variants.placement import transform
from nao_kin.rotations import matrix_from_rpy
from nao_kin.urdf import Inertial, Origin


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
        R = matrix_from_rpy(body.origin.rpy)
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
    T = transform(place)
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
