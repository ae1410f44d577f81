"""The centre of mass and the angular momentum of a robot: in a motion, and how the joints change them.

The second moments J = Σ m p pᵀ of the points p = (x, y, z, 1) of a body are T J Tᵀ at its pose T. If it moves with
Ṫ = V T, then V T J Tᵀ has the sums Σ m v_i p_j over these points: their differences are the angular momentum about the
origin, and the last column is the momentum.
"""

from __future__ import annotations

import numpy as np

from nao_kin._core.arrays import Floats, cross_matrix
from nao_kin.robot import RobotModel


def momenta(robot: RobotModel, q: Floats, T_world_base: Floats, step: float) -> tuple[Floats, Floats]:
    """Return the centre of mass, and the angular momentum about the origin, in rows (n, nq) a step apart, (n, 3)."""
    T, J = _bodies(robot, q, T_world_base)
    T = T[..., :3, :]
    moments = T @ J
    second = _across(np.gradient(T, step, axis=0)) @ _across(moments).swapaxes(1, 2)
    return moments[..., 3].sum(axis=1) / J[:, 3, 3].sum(), _angular(second)


def momentum_jacobians(robot: RobotModel, q: Floats, T_world_base: Floats, sole: str) -> tuple[Floats, Floats]:
    """Return the Jacobians of the centre of mass and of the angular momentum about it, with a sole in place.

    Both are in the world, for rows (n, nq), shape (n, 3, nv) [m; kg m²]; a floating base has zeros.
    """
    joints = robot.joints
    T, J = _bodies(robot, q, T_world_base)
    moved = T @ J @ T.swapaxes(2, 3)
    for k in reversed(range(len(joints.names))):  # of all that a joint carries
        moved[:, joints.parents[k] + 1] += moved[:, k + 1]
    body = robot.model.names[robot.model.frames[robot.frame_ids([sole])[0]].parentJoint]
    to_sole = joints.path(joints.row(body)) if body in joints.names else []
    mass, centre = moved[0, 0, 3, 3], moved[:, 0, :3, 3] / moved[0, 0, 3, 3]
    of_centre, of_momentum = np.zeros((2, len(q), 3, robot.nv))
    for k, column in enumerate(joints.columns.tolist()):
        axis = joints.multipliers[k] * T[:, k + 1, :3, :3] @ joints.axes[k]
        V = np.zeros((len(q), 3, 4))
        if joints.slides[k]:
            V[..., 3] = axis
        else:
            V[..., :3] = cross_matrix(axis)
            V[..., 3] = -np.cross(axis, T[:, k + 1, :3, 3])
        # A joint between the root and the sole moves all that it does not carry, the other way.
        second = V @ (moved[:, k + 1] - moved[:, 0] if k in to_sole else moved[:, k + 1])
        of_centre[..., column] += second[..., 3] / mass
        of_momentum[..., column] += _angular(second) - np.cross(centre, second[..., 3])
    return of_centre, of_momentum


def _bodies(robot: RobotModel, q: Floats, T_world_base: Floats) -> tuple[Floats, Floats]:
    """Return the poses of all bodies in rows (n, nq), shape (n, l, 4, 4), and their second moments, shape (l, 4, 4)."""
    joints = robot.joints
    T_base_links = np.asarray(robot.fk(q, (robot.tree.root, *joints.links), reference=robot.tree.root))
    masses = np.append(joints.root_mass, joints.masses)
    levers = np.vstack([joints.root_centre_of_mass, joints.centres_of_mass])
    inertias = np.concatenate([joints.root_inertia[None], joints.inertias])
    J = np.zeros((len(masses), 4, 4))
    J[:, :3, :3] = 0.5 * np.trace(inertias, axis1=1, axis2=2)[:, None, None] * np.eye(3) - inertias
    J += masses[:, None, None] * np.einsum("li,lj->lij", *[np.column_stack([levers, np.ones(len(levers))])] * 2)
    return T_world_base[:, None] @ T_base_links, J


def _across(array: Floats) -> Floats:
    """Return the columns of all bodies beside each other, shape (n, 3, 4 l)."""
    return array.swapaxes(1, 2).reshape(len(array), 3, -1)


def _angular(second: Floats) -> Floats:
    """Return the sums Σ m p × v of the sums Σ m v_i p_j, shape (n, 3)."""
    return np.asarray(second[:, (2, 0, 1), (1, 2, 0)] - second[:, (1, 2, 0), (2, 0, 1)])
