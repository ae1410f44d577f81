"""The joints of MuJoCo's bodies as joints of one coordinate each, one behind the other.

A body of MuJoCo stands at its place in the body that carries it, moved by its joints in their order: about an axis
through an anchor (hinge), along one (slide), or freely about the anchor (ball). A joint's value counts from `ref`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats, Vector
from nao_kin.rotations import exp, matrix_from_quat, rpy_from_matrix
from nao_kin.urdf.visuals import Origin

FREE, BALL, SLIDE, HINGE = range(4)
"""The kinds of joints, as `mujoco.mjtJoint` numbers them."""

_AXES = (("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0)), ("z", (0.0, 0.0, 1.0)))
# The kinds of actuators that act on a joint, as `mujoco.mjtTrn` numbers them.
_ON_JOINTS = (0, 1)


@dataclass(frozen=True, eq=False)
class Motion:
    """One coordinate of a MuJoCo joint.

    Attributes:
        id: the joint in MuJoCo.
        part: 0, 1, 2 for the three turns of a ball joint about x, y, z; 0 else.
        name: "" where the file gives none.
        kind: "revolute" or "prismatic".
        T_before: pose of its frame, at zero, in the frame that the motion before it leaves; shape (4, 4).
        axis: unit vector.
        lower: smallest value [rad or m].
        upper: largest value [rad or m].
    """

    id: int
    part: int
    name: str
    kind: str
    T_before: Floats
    axis: Vector
    lower: float = -math.inf
    upper: float = math.inf


def motions(model: Any, body: int) -> tuple[list[Motion], Floats]:
    """The coordinates that move a body, in order, and the pose (4, 4) of its frame in the last one's.

    A free joint is none of them: it is the base's.
    """
    T = pose(model.body_pos[body], model.body_quat[body])
    found: list[Motion] = []
    first = int(model.body_jntadr[body])
    for joint in range(first, first + int(model.body_jntnum[body])):
        kind = int(model.jnt_type[joint])
        if kind == FREE:
            continue
        name, anchor = str(model.joint(joint).name), np.array(model.jnt_pos[joint])
        if kind == BALL:
            T = T @ translation(anchor)
            limits = _ball_limits(model, joint)
            for part, ((letter, axis), limit) in enumerate(zip(_AXES, limits, strict=True)):
                label = f"{name}_{letter}" if name else ""
                found.append(Motion(joint, part, label, "revolute", T, axis, -limit, limit))
                T = np.eye(4)
            T = translation(-anchor)
            continue
        ref = float(model.qpos0[model.jnt_qposadr[joint]])
        x, y, z = (float(value) for value in model.jnt_axis[joint])
        limited = bool(model.jnt_limited[joint])
        lower, upper = (float(value) for value in model.jnt_range[joint]) if limited else (-math.inf, math.inf)
        if math.isfinite(lower) and math.isfinite(upper) and math.isinf(upper - lower):
            lower, upper = -math.inf, math.inf  # a range beyond all measure
        slides = kind == SLIDE
        if not slides:
            T = T @ translation(anchor)
        T = T @ moved(slides, (x, y, z), -ref)
        found.append(Motion(joint, 0, name, "prismatic" if slides else "revolute", T, (x, y, z), lower, upper))
        T = np.eye(4) if slides else translation(-anchor)
    return found, T


def _ball_limits(model: Any, joint: int) -> tuple[float, float, float]:
    """The largest turns about x, y and z: the box that holds every turn of at most the joint's largest angle."""
    if not model.jnt_limited[joint]:
        return math.inf, math.inf, math.inf
    most = float(model.jnt_range[joint, 1])
    # Up to a right angle, each of the three turns is at most the whole turn.
    return (most, most, most) if most <= math.pi / 2 else (math.inf, math.pi / 2, math.inf)


def efforts(model: Any) -> dict[int, float]:
    """Joint → the largest torque or force that its actuators exert; joints without such a bound are left out."""
    strongest: dict[int, float] = {}
    for actuator in range(len(model.actuator_trntype)):
        if int(model.actuator_trntype[actuator]) in _ON_JOINTS:
            joint = int(model.actuator_trnid[actuator, 0])
            strongest[joint] = strongest.get(joint, 0.0) + _strongest(model, actuator)
    for joint in range(int(model.njnt)):
        if model.jnt_actfrclimited[joint]:
            bound = float(np.abs(model.jnt_actfrcrange[joint]).max())
            strongest[joint] = min(bound, strongest.get(joint, math.inf))
    return {joint: effort for joint, effort in strongest.items() if math.isfinite(effort)}


def _strongest(model: Any, actuator: int) -> float:
    """The largest force of one actuator at its joint; infinite where the file bounds none."""
    gear = abs(float(model.actuator_gear[actuator, 0]))
    if model.actuator_forcelimited[actuator]:
        return gear * float(np.abs(model.actuator_forcerange[actuator]).max())
    # Since MuJoCo 4 an actuator may have several controls, or none.
    control = int(model.actuator_ctrladr[actuator]) if hasattr(model, "actuator_ctrladr") else actuator
    is_motor = not model.actuator_gaintype[actuator] and not model.actuator_biastype[actuator] and control >= 0
    if is_motor and model.actuator_ctrllimited[control]:
        gain = abs(float(model.actuator_gainprm[actuator, 0]))
        return gear * gain * float(np.abs(model.actuator_ctrlrange[control]).max())
    return math.inf


def pose(position: Any, quaternion: Any) -> Floats:
    """A pose, shape (4, 4), from MuJoCo's position and quaternion (scalar first)."""
    T = np.eye(4)
    unit = np.array(quaternion, dtype=np.float64)
    T[:3, :3] = matrix_from_quat(unit / np.linalg.norm(unit))
    T[:3, 3] = position
    return T


def translation(by: Floats) -> Floats:
    """A pose, shape (4, 4), that moves and does not turn."""
    T = np.eye(4)
    T[:3, 3] = by
    return T


def moved(slides: bool, axis: Vector, value: float) -> Floats:
    """What a joint value does, shape (4, 4)."""
    T = np.eye(4)
    if slides:
        T[:3, 3] = value * np.array(axis)
    elif value:
        T[:3, :3] = exp(value * np.array(axis))
    return T


def origin(T: Floats) -> Origin:
    """A pose as the tree keeps it."""
    x, y, z = _numbers(T[:3, 3])
    if np.array_equal(T[:3, :3], np.eye(3)):
        return Origin((x, y, z))
    roll, pitch, yaw = _numbers(rpy_from_matrix(T[:3, :3]))
    return Origin((x, y, z), (roll, pitch, yaw))


def _numbers(values: Any) -> Iterator[float]:
    return (float(value) + 0.0 for value in values)  # no −0
