"""The three spaces of NAOqi, its effectors, and poses of them in each other.

FRAME_TORSO is the torso. FRAME_WORLD is where the robot once was, fixed to the floor. FRAME_ROBOT is between the feet:
"average of the two feet positions projected around a vertical z axis" (doc.aldebaran.com/2-8/glossary.html).

What is modelled of FRAME_ROBOT: its origin is the mean of the origins of LLeg and RLeg, projected along the world's
vertical to the height of the lower of the two; its z axis is the vertical, its yaw the mean of the yaws of the feet.
What is not: recordings of ALMotion.getPosition (LennonNM/NaoMimic) agree on the yaw to rounding, but their origin lies
4.5 mm in front of the mean with both feet down, and stays with the standing foot while the other is lifted.
"""

from __future__ import annotations

import operator
from typing import SupportsIndex, cast

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import as_batch, rigid_inverse
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.naoqi.names import CHAINS
from nao_kin.naoqi.poses import position6d
from nao_kin.robot import RobotModel, check_robot
from nao_kin.rotations import rot_z

FRAME_TORSO, FRAME_WORLD, FRAME_ROBOT = 0, 1, 2
SPACES: tuple[str, ...] = ("FRAME_TORSO", "FRAME_WORLD", "FRAME_ROBOT")
# The six points that Cartesian control moves: the ends of the chains, and the torso.
EFFECTORS: tuple[str, ...] = (*CHAINS, "Torso")
_TORSO, _FEET = "Torso", ("LLeg", "RLeg")


def space_number(space: SupportsIndex | str) -> int:
    """FRAME_TORSO 0, FRAME_WORLD 1 or FRAME_ROBOT 2, by number or by name.

    Raises:
        UnknownName: no such name.
        BadArgument: no such number.

    Examples:
        >>> nk.naoqi.space_number("FRAME_ROBOT")
        2
    """
    if isinstance(space, str):
        if space not in SPACES:
            raise UnknownName("space", space, SPACES)
        return SPACES.index(space)
    try:
        number = int(space) if isinstance(space, float) and space.is_integer() else operator.index(space)
    except TypeError:
        number = -1
    if number not in range(len(SPACES)):
        numbers = ", ".join(f"{name} {index}" for index, name in enumerate(SPACES))
        raise BadArgument(f"space must be one of {numbers}, got {quoted(space)}")
    return number


def frame_of(robot: RobotModel, name: str) -> str:
    """The robot's name of what NAOqi calls `name`: an effector, a joint, a sensor or a camera.

    Sensors go by the names of getSensorNames: "CameraTop", "LFsrFL", "HeadTouchFront", "Accelerometer". Every frame of
    the robot is taken, too.

    Raises:
        UnknownName: there is none.

    Examples:
        >>> nk.naoqi.frame_of(nk.load_nao(), "CameraTop")
        'CameraTop'
    """
    check_robot(robot)
    for candidate in (name, f"{name}_frame"):
        if isinstance(name, str) and candidate in robot.frame_names:
            return candidate
    known = dict.fromkeys((*EFFECTORS, *(frame.removesuffix("_frame") for frame in robot.frame_names)))
    raise UnknownName("effector, joint or sensor", name, tuple(known))


def robot_frame(robot: RobotModel, q: ArrayLike, *, torso_in_world: ArrayLike | None = None) -> Floats:
    """FRAME_ROBOT in the world, T_world_robot, as the head of this module has it.

    Args:
        robot: a NAO of any version.
        q: configurations, shape (..., nq).
        torso_in_world: T_world_torso, shape (..., 4, 4); its z axis is the vertical. None for the floating base of q,
            or with a fixed base for a level torso at the world's origin.

    Returns:
        Shape (..., 4, 4).

    Raises:
        WrongShape, NotFinite, NotARotation, BadArgument: q is no configuration, or the torso's pose is not rigid.
        UnknownName: a robot without the feet of a NAO.

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.naoqi.robot_frame(nao, nao.posture("Stand"))[:2, 3].round(3).tolist()
        [0.005, 0.0]
    """
    check_robot(robot)
    T_torso_feet = robot.fk(q, [frame_of(robot, foot) for foot in _FEET], reference=frame_of(robot, _TORSO))
    return _between(_torso_in_world(robot, q, torso_in_world)[..., None, :, :] @ T_torso_feet)


def pose_in(
    robot: RobotModel,
    q: ArrayLike,
    name: str,
    space: SupportsIndex | str = FRAME_TORSO,
    *,
    torso_in_world: ArrayLike | None = None,
) -> Floats:
    """T_space_name: what getTransform gives; `position6d` of it is what getPosition gives.

    Args:
        robot: a NAO of any version.
        q: configurations, shape (..., nq).
        name: an effector, joint, sensor or camera, as `frame_of` takes it. The frame of "CameraTop" looks along x.
        space: FRAME_TORSO, FRAME_WORLD or FRAME_ROBOT.
        torso_in_world: as in `robot_frame`.

    Returns:
        Shape (..., 4, 4).

    Raises:
        UnknownName, BadArgument: no such name or space.
        WrongShape, NotFinite, NotARotation: as in `robot_frame`.

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.naoqi.pose_in(nao, nao.posture("Stand"), "LArm", "FRAME_ROBOT").shape
        (4, 4)
    """
    check_robot(robot)
    number = space_number(space)
    T_torso_name = robot.fk(q, frame_of(robot, name), reference=frame_of(robot, _TORSO))
    return np.asarray(torso_in(robot, q, number, torso_in_world=torso_in_world) @ T_torso_name)


def torso_in(
    robot: RobotModel, q: ArrayLike, space: SupportsIndex | str, *, torso_in_world: ArrayLike | None = None
) -> Floats:
    """T_space_torso, which takes what is known in the torso to a space; arguments and errors as in `pose_in`.

    Examples:
        >>> nao = nk.load_nao()
        >>> np.allclose(nk.naoqi.torso_in(nao, nao.posture("Stand"), "FRAME_TORSO"), np.eye(4))
        True
    """
    number = space_number(space)
    if number == FRAME_TORSO:
        return np.eye(4)
    T_world_torso = _torso_in_world(robot, q, torso_in_world)
    if number == FRAME_WORLD:
        return T_world_torso
    return np.asarray(rigid_inverse(robot_frame(robot, q, torso_in_world=T_world_torso)) @ T_world_torso)


def _torso_in_world(robot: RobotModel, q: ArrayLike, torso_in_world: ArrayLike | None) -> Floats:
    check_robot(robot)
    if torso_in_world is None:
        return np.eye(4) if robot.base == "fixed" else cast(Floats, robot.fk(q, frame_of(robot, _TORSO)))
    T = as_batch(torso_in_world, (4, 4), "torso_in_world")
    position6d(T)  # refuses what is not rigid
    return T


def _between(T_world_feet: Floats) -> Floats:
    """The frame between two feet, from poses of shape (..., 2, 4, 4)."""
    yaw = position6d(T_world_feet)[..., 5]
    # Halfway along the shorter arc, also where the yaws are on both sides of ±π.
    apart = yaw[..., 1] - yaw[..., 0]
    apart = apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi))
    T = np.zeros((*yaw.shape[:-1], 4, 4))
    T[..., :3, :3] = rot_z(yaw[..., 0] + 0.5 * apart)
    T[..., :2, 3] = T_world_feet[..., :2, 3].mean(axis=-2)
    T[..., 2, 3] = T_world_feet[..., 2, 3].min(axis=-1)
    T[..., 3, 3] = 1.0
    return T
