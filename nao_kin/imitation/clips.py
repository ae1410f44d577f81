"""Motions of a floating base as arrays of joints and bodies, for programs of reinforcement learning."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.robot import RobotModel
from nao_kin.rotations import log, power, quat_from_matrix

# Frames per second: BeyondMimic and mjlab play one frame in each step of their controller, which has this rate.
FPS = 50.0


def clip_of(
    robot: RobotModel, times: Floats, q: Floats, T_world_base: Floats, contacts: NDArray[np.bool_]
) -> dict[str, NDArray[Any]]:
    """Return the arrays of `Imitation.clip` from configurations (n, nq) and poses of the base (n, 4, 4)."""
    at = times[0] + np.arange(int((times[-1] - times[0]) * FPS + 1e-6) + 1) / FPS
    before = np.clip(np.searchsorted(times, at, side="right") - 1, 0, max(len(times) - 2, 0))
    after = np.minimum(before + 1, len(times) - 1)
    share = np.where(after > before, (at - times[before]) / np.maximum(times[after] - times[before], 1e-12), 0.0)
    q = q[before] + share[:, None] * (q[after] - q[before])
    T = T_world_base[before]
    T[:, :3, 3] += share[:, None] * (T_world_base[after, :3, 3] - T[:, :3, 3])
    T[:, :3, :3] = T[:, :3, :3] @ power(T[:, :3, :3].swapaxes(1, 2) @ T_world_base[after, :3, :3], share)
    moving = robot.tree.moving_joints  # depth first, as in MuJoCo
    joints = [joint.name for joint in moving]
    bodies = [robot.semantics.root or robot.tree.root, *(joint.child for joint in moving)]
    values = dict(zip(robot.joint_names, q[:, robot.nq_base :].T, strict=True))
    values |= {name: mimic.value(values[mimic.joint]) for name, mimic in robot.mimics.items()}
    positions = np.stack([values[name] for name in joints], axis=1)
    local = robot.fk(q, bodies, reference=robot.tree.root)
    poses = T[:, None] @ local
    R, places = poses[..., :3, :3], poses[..., :3, 3]
    quaternions = quat_from_matrix(R)
    return {
        "fps": np.array([FPS]),
        "joint_pos": positions,
        "joint_vel": _rate(positions),
        "body_pos_w": places,
        "body_quat_w": quaternions,
        "body_lin_vel_w": _rate(places),
        "body_ang_vel_w": _turning(R),
        "root_pos": places[:, 0],
        "root_rot": quaternions[:, 0, [1, 2, 3, 0]],
        "dof_pos": positions,
        "local_body_pos": local[..., :3, 3],
        "link_body_list": np.array(bodies),
        "dof_names": np.array(joints),
        "body_names": np.array(bodies),
        "contacts": contacts[before] & contacts[after],
    }


def _rate(rows: Floats) -> Floats:
    """Return the derivatives of rows, by central differences."""
    return np.gradient(rows, 1.0 / FPS, axis=0) if len(rows) > 1 else np.zeros(rows.shape)


def _turning(R: Floats) -> Floats:
    """Return angular velocities in the world, shape (n, bodies, 3), by central differences; the ends repeat."""
    count = len(R)
    first, last = np.maximum(np.arange(count) - 1, 0), np.minimum(np.arange(count) + 1, count - 1)
    seconds = np.maximum(last - first, 1)[:, None, None] / FPS
    return np.asarray(log(R[last] @ R[first].swapaxes(-1, -2)) / seconds)
