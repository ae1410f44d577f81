"""Postures as key frames: the robot set down on its soles, or as it rests."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.export.mujoco.bodies import Bodies, BodyJoint, link_of
from nao_kin.export.variants import joint_values
from nao_kin.robot import RobotModel
from nao_kin.rotations import log, matrix_from_natural, quat_from_matrix

# --- How far down the shapes of a robot reach that can touch the floor.


def lowest_point(model: Any, data: Any) -> float:
    """Least height of all geoms that can touch something; without any, of the bodies' frames [m]."""
    heights = [_lowest(model, data, geom) for geom in range(model.ngeom) if model.geom_contype[geom]]
    return min(heights) if heights else float(data.xpos[1:, 2].min())


def _lowest(model: Any, data: Any, geom: int) -> float:
    import mujoco

    kinds = mujoco.mjtGeom
    kind, size = kinds(int(model.geom_type[geom])), model.geom_size[geom]
    height, down = data.geom_xpos[geom, 2], data.geom_xmat[geom].reshape(3, 3)[2]
    if kind == kinds.mjGEOM_SPHERE:
        reach = size[0]
    elif kind == kinds.mjGEOM_CYLINDER:
        reach = abs(down[2]) * size[1] + math.hypot(down[0], down[1]) * size[0]
    elif kind == kinds.mjGEOM_BOX:
        reach = np.abs(down) @ size
    else:
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
        reach = -(vertices @ down).min()
    return float(height - reach)


# --- Postures as key frames: the robot set down on its soles, or as it rests.

# Name of the key frame with all joints at zero, or at the limit nearest to it, of a robot without postures.
ZERO = "zero"


def add_keyframes(spec: Any, robot: RobotModel, bodies: Bodies, *, floating: bool) -> None:
    """A key frame for each posture, the one that the robot starts in first.

    Args:
        spec: the specification, with all bodies and actuators.
        robot: the robot.
        bodies: of it.
        floating: whether the root moves freely, and is to be set down on the floor z = 0.
    """
    import mujoco

    model = spec.compile()
    data = mujoco.MjData(model)
    start = robot.semantics.start
    names = sorted(robot.posture_names, key=lambda name: name != start)
    for name in names or [ZERO]:
        q = robot.posture(name) if names else robot.clamp(robot.neutral())
        values = joint_values(robot, q)
        data.qpos[:], data.ctrl[:] = model.qpos0, 0.0
        for joint in bodies.joints():
            _set(model, data, joint, values)
        if floating:
            data.qpos[:7] = model.qpos0[:7]
            mujoco.mj_kinematics(model, data)
            rest = robot.semantics.postures[name].up if names else None
            up = _across_the_soles(data, robot, bodies) if rest is None else np.array(rest)
            data.qpos[:7] = 0.0, 0.0, 0.0, *quat_from_matrix(upright(up))
            mujoco.mj_kinematics(model, data)
            data.qpos[2] = -lowest_point(model, data)
        spec.add_key(name=name, qpos=data.qpos.tolist(), ctrl=data.ctrl.tolist())


def _set(model: Any, data: Any, joint: BodyJoint, values: Mapping[str, Floats]) -> None:
    """Coordinates of a joint, and controls that hold it."""
    place = int(model.joint(joint.name).qposadr[0])
    if joint.kind == "ball":
        R = ball_rotation(joint, values)
        data.qpos[place : place + 4] = quat_from_matrix(R)
        for letter, value in zip("xyz", log(R), strict=True):
            data.actuator(f"{joint.name}_{letter}").ctrl = value
        return
    value = data.qpos[place] = values[joint.name]
    if joint.rows[0].mimic is None:
        data.actuator(joint.name).ctrl = value


def ball_rotation(joint: BodyJoint, values: Mapping[str, Floats]) -> Floats:
    """The rotation of a ball, as the product of its three turns."""
    R = np.eye(3)
    for row, axis in zip(joint.rows, joint.axes, strict=True):
        R = R @ matrix_from_natural(axis, values[row.name])
    return R


def upright(up: Floats) -> Floats:
    """The smallest rotation that makes the direction `up` the z axis, shape (3, 3); about y where it points down."""
    up = up / np.linalg.norm(up)
    axis = np.cross(up, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        return np.diag([1.0, 1.0, 1.0]) if up[2] > 0.0 else np.diag([-1.0, 1.0, -1.0])
    return np.asarray(matrix_from_natural(axis / sine, np.arctan2(sine, up[2])))


def _across_the_soles(data: Any, robot: RobotModel, bodies: Bodies) -> Floats:
    """The mean of the soles' normals, in the world of `data`; along z for a robot without soles."""
    normals = [np.array([0.0, 0.0, 1e-9])]
    for sole in robot.semantics.soles:
        body, T_sole = bodies.place(link_of(robot.tree, sole))
        normals.append(data.body(body.name).xmat.reshape(3, 3) @ T_sole.rotation[:, 2])
    return np.asarray(np.sum(normals, axis=0))
