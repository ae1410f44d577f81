"""Robots exported for MuJoCo, loaded, and compared frame by frame."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_kin as nk

mujoco = pytest.importorskip("mujoco")


def exported(robot: nk.RobotModel, folder: Path, **options: Any) -> Any:
    """The model that MuJoCo makes of the scene."""
    return mujoco.MjModel.from_xml_path(str(nk.export.mjcf(robot, folder, **options).path))


def all_values(robot: nk.RobotModel, q: np.ndarray) -> dict[str, float]:
    """Return the value of every joint, including mimic joints."""
    values = {name: float(value) for name, value in robot.angles(q).items()}
    return values | {name: m.multiplier * values[m.joint] + m.offset for name, m in robot.mimics.items()}


def set_joints(model: Any, data: Any, values: Mapping[str, float]) -> None:
    """Set the positions of hinges and slides."""
    for joint in range(model.njnt):
        name, kind = model.joint(joint).name, mujoco.mjtJoint(int(model.jnt_type[joint]))
        start = model.jnt_qposadr[joint]
        if kind in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            data.qpos[start] = values[name]


def place(data: Any, link: str) -> np.ndarray:
    """Pose of a link in the world: a body, or a site."""
    try:
        one = data.body(link)
    except KeyError:
        one = data.site(link)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = one.xmat.reshape(3, 3), one.xpos
    return T


def worst_pose(model: Any, robot: nk.RobotModel, q: np.ndarray, values: Mapping[str, float]) -> float:
    """Largest difference between MuJoCo's poses of all links and the robot's, seen from its root."""
    data = mujoco.MjData(model)
    set_joints(model, data, values)
    if model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE:
        data.qpos[:7] = 0.3, -0.2, 0.9, 0.5, -0.5, 0.1, 0.7
        data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
    mujoco.mj_kinematics(model, data)
    T_world_root = place(data, robot.tree.root)
    ours = T_world_root @ robot.fk(q, reference=robot.tree.root)
    return max(float(np.abs(place(data, link) - T).max()) for link, T in zip(robot.link_names, ours, strict=True))


def simulate(model: Any, key: str, seconds: float) -> tuple[Any, np.ndarray]:
    """The end of a simulation from a key frame, and the largest [tilt, sinking, drift] of the root on the way.

    The tilt is the angle between the root's vertical and what it was [rad], the others are lengths [m].
    """
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(key).id)
    mujoco.mj_kinematics(model, data)
    up, start = data.xmat[1].reshape(3, 3)[2].copy(), data.xpos[1].copy()
    worst = np.zeros(3)
    while data.time < seconds:
        mujoco.mj_step(model, data)
        tilt = np.arccos(np.clip(data.xmat[1].reshape(3, 3)[2] @ up, -1.0, 1.0))
        moved = data.xpos[1] - start
        worst = np.fmax(worst, [tilt, -moved[2], np.hypot(moved[0], moved[1])])
    return data, worst
