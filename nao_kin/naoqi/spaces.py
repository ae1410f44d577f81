"""The three spaces of NAOqi, its effectors, and their poses in each space.

FRAME_TORSO is the torso. FRAME_WORLD is fixed to the floor where the robot started. FRAME_ROBOT is between the feet:
"average of the two feet positions projected around a vertical z axis" (doc.aldebaran.com/2-8/glossary.html).

The model of FRAME_ROBOT: its origin is the mean of the origins of LLeg and RLeg, projected along the world's
vertical to the height of the lower foot; its z axis is the vertical, its yaw the mean of the yaws of the feet.
Recordings of ALMotion.getPosition (LennonNM/NaoMimic) agree on the yaw to rounding, but their origin is 4.5 mm in front
of the mean with both feet down, and stays with the standing foot while the other is lifted. These two effects are not
modelled.
"""

from __future__ import annotations

import operator
from enum import IntFlag
from typing import SupportsIndex, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_batch, as_floats, choice, join_poses, rigid_inverse
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.naoqi.names import CHAINS, LEGS
from nao_kin.robot import RobotModel
from nao_kin.rotations import matrix_from_rpy, nearest_rotation, rpy_from_matrix
from nao_kin.screws import refuse_not_rigid
from nao_kin.world import feet_frame

# --- Poses as NAOqi writes them: Position6D, six numbers, and transforms, sixteen numbers row by row.

# The tolerance for rotations typed with a few digits, or sent by NAOqi in single precision.
_TYPED = 1e-3


def position6d(T: ArrayLike) -> Floats:
    """Return Position6D (x, y, z, wx, wy, wz) of poses, with R = Rz(wz) Ry(wy) Rx(wx).

    wy is in [−π/2, π/2]. At wy = ±π/2 only wx ∓ wz is determined, and wz is 0: the pose is still exact.

    Args:
        T: homogeneous matrices, shape (..., 4, 4).

    Returns:
        Shape (..., 6) [m, rad].

    Raises:
        NotARotation, BadArgument: T is not a rigid transform.

    Examples:
        >>> nk.naoqi.position6d(nk.naoqi.pose([0.1, 0.0, 0.2, 0.0, 0.5, 0.0])).tolist()
        [0.1, 0.0, 0.2, 0.0, 0.5, 0.0]
    """
    poses = _rigid(as_batch(T, (4, 4), "T"), "T")
    return np.concatenate([poses[..., :3, 3], rpy_from_matrix(poses[..., :3, :3])], axis=-1)


def pose(position6d: ArrayLike) -> Floats:
    """Return homogeneous matrices, shape (..., 4, 4), of Position6D (x, y, z, wx, wy, wz), shape (..., 6) [m, rad].

    Examples:
        >>> nk.naoqi.pose([0.1, 0.0, 0.2, 0.0, 0.0, 0.0])[:3, 3].tolist()
        [0.1, 0.0, 0.2]
    """
    six = as_batch(position6d, (6,), "position6d")
    return join_poses(matrix_from_rpy(six[..., 3:]), six[..., :3])


def transform_list(T: ArrayLike) -> Floats:
    """Return the sixteen numbers of poses row by row, as getTransform does.

    Args:
        T: homogeneous matrices, shape (..., 4, 4).

    Returns:
        A copy, shape (..., 16).

    Raises:
        NotARotation, BadArgument: T is not a rigid transform.

    Examples:
        >>> nk.naoqi.transform_list(np.eye(4)).tolist()[:5]
        [1.0, 0.0, 0.0, 0.0, 0.0]
    """
    poses = _rigid(as_batch(T, (4, 4), "T"), "T")
    return np.array(poses.reshape(*poses.shape[:-2], 16))


def pose_from_list(transform: ArrayLike) -> Floats:
    """Return poses from sixteen numbers row by row, or from twelve without the last row, as for setTransforms.

    Rounding to single precision or to three digits is removed from the rotation: the nearest exact rotation is used.

    Args:
        transform: shape (..., 16) or (..., 12).

    Returns:
        Homogeneous matrices, shape (..., 4, 4).

    Raises:
        NotARotation: the rotation is wrong by more than 1e-3.
        BadArgument: the last row is not 0, 0, 0, 1.

    Examples:
        >>> nk.naoqi.pose_from_list(np.eye(4).ravel()).shape
        (4, 4)
    """
    numbers = as_floats(transform, (), "transform")
    rows = 3 if numbers.shape[-1:] == (12,) else 4
    numbers = as_batch(numbers, (4 * rows,), "transform")
    T = np.zeros((*numbers.shape[:-1], 4, 4))
    T[..., 3, 3] = 1.0
    T[..., :rows, :] = numbers.reshape(*numbers.shape[:-1], rows, 4)
    _rigid(T, "transform", _TYPED)
    return join_poses(nearest_rotation(T[..., :3, :3]), T[..., :3, 3])


def _rigid(T: Floats, what: str, *tolerance: float) -> Floats:
    """Return the poses after checking that they are rigid; `tolerance` is that of `check_rotation`."""
    refuse_not_rigid(T, what, *tolerance)
    return T


# --- The three spaces of NAOqi, its effectors, and their poses in each space.

FRAME_TORSO, FRAME_WORLD, FRAME_ROBOT = 0, 1, 2
SPACES: tuple[str, ...] = ("FRAME_TORSO", "FRAME_WORLD", "FRAME_ROBOT")
# The six frames that Cartesian control moves: the ends of the chains, and the torso.
TORSO = "Torso"
EFFECTORS: tuple[str, ...] = (*CHAINS, TORSO)


def space_number(space: SupportsIndex | str) -> int:
    """Return the number of a space: FRAME_TORSO 0, FRAME_WORLD 1 or FRAME_ROBOT 2, by number or by name."""
    if isinstance(space, str):
        return SPACES.index(choice(space, SPACES, "space"))
    number = _whole(space)
    if number not in range(len(SPACES)):
        numbers = ", ".join(f"{name} {index}" for index, name in enumerate(SPACES))
        raise BadArgument(f"space must be one of {numbers}, got {quoted(space)}")
    return number


def _whole(value: SupportsIndex | float) -> int:
    """Return a whole number, also from a float such as 2.0; -1 for anything else."""
    try:
        return int(value) if isinstance(value, float) and value.is_integer() else operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return -1


def frame_of(robot: RobotModel, name: str) -> str:
    """Return the robot's frame for its name or NAOqi's of an effector, joint, camera or sensor (getSensorNames)."""
    for candidate in (name, f"{name}_frame"):
        if isinstance(name, str) and candidate in robot.frame_names:
            return candidate
    known = dict.fromkeys((*EFFECTORS, *(frame.removesuffix("_frame") for frame in robot.frame_names)))
    raise UnknownName("effector, joint or sensor", name, tuple(known))


def robot_frame(robot: RobotModel, q: ArrayLike, *, torso_in_world: ArrayLike | None = None) -> Floats:
    """Return FRAME_ROBOT in the world, T_world_robot, shape (..., 4, 4), as the module's docstring defines it.

    The z axis of `torso_in_world`, T_world_torso, is the vertical. None means the floating base of q; with a fixed
    base, a level torso at the world's origin.
    """
    T_torso_feet = robot.fk(q, [frame_of(robot, foot) for foot in LEGS], reference=frame_of(robot, TORSO))
    return feet_frame(_torso_in_world(robot, q, torso_in_world)[..., None, :, :] @ T_torso_feet)


def pose_in(
    robot: RobotModel,
    q: ArrayLike,
    name: str,
    space: SupportsIndex | str = FRAME_TORSO,
    *,
    torso_in_world: ArrayLike | None = None,
) -> Floats:
    """Return T_space_name, the pose of getTransform; getPosition returns its `position6d`.

    Args:
        robot: a NAO of any version.
        q: configurations, shape (..., nq).
        name: an effector, joint, sensor, camera, or any frame of the robot. The frame of "CameraTop" looks along x.
        space: FRAME_TORSO, FRAME_WORLD or FRAME_ROBOT.
        torso_in_world: T_world_torso, shape (..., 4, 4), whose z axis is the vertical. None for the floating base of q;
            with a fixed base, for a level torso at the world's origin.

    Returns:
        Shape (..., 4, 4).

    Raises:
        NotARotation, BadArgument: the torso's pose is not rigid.
        UnknownName: the robot does not have the feet of a NAO.

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.naoqi.pose_in(nao, nao.posture("Stand"), "LArm", "FRAME_ROBOT").shape
        (4, 4)
    """
    number = space_number(space)
    T_torso_name = robot.fk(q, frame_of(robot, name), reference=frame_of(robot, TORSO))
    return np.asarray(torso_in(robot, q, number, torso_in_world=torso_in_world) @ T_torso_name)


def torso_in(
    robot: RobotModel, q: ArrayLike, space: SupportsIndex | str, *, torso_in_world: ArrayLike | None = None
) -> Floats:
    """Return T_space_torso, which maps poses from the torso to a space; arguments as in `pose_in`."""
    number = space_number(space)
    if number == FRAME_TORSO:
        return np.eye(4)
    T_world_torso = _torso_in_world(robot, q, torso_in_world)
    if number == FRAME_WORLD:
        return T_world_torso
    return np.asarray(rigid_inverse(robot_frame(robot, q, torso_in_world=T_world_torso)) @ T_world_torso)


def _torso_in_world(robot: RobotModel, q: ArrayLike, torso_in_world: ArrayLike | None) -> Floats:
    if torso_in_world is None:
        return np.eye(4) if robot.base == "fixed" else cast(Floats, robot.fk(q, frame_of(robot, TORSO)))
    return _rigid(as_batch(torso_in_world, (4, 4), "torso_in_world"), "torso_in_world")


# --- Axis masks: the axes that a Cartesian call controls.


class AxisMask(IntFlag):
    """The axes that a Cartesian call controls, one bit each, along the axes of its space.

    Source: aldebaran/libalmath, almath/types/alaxismask.h (BSD-3-Clause).

    Examples:
        >>> int(nk.naoqi.AxisMask.X | nk.naoqi.AxisMask.Z), int(nk.naoqi.AxisMask.VEL)
        (5, 7)
    """

    X = 1
    Y = 2
    Z = 4
    WX = 8
    WY = 16
    WZ = 32
    XY = X | Y
    VEL = X | Y | Z
    PLANEZ = Z | WX | WY
    WYWZ = WY | WZ
    ROT = WX | WY | WZ
    ALL = VEL | ROT
    NONE = 0


def axis_mask(mask: SupportsIndex | str) -> int:
    """Return a mask as a number from 0 to 63.

    Args:
        mask: a number, a member of `AxisMask`, or a name: "VEL" or "AXIS_MASK_VEL".

    Examples:
        >>> nk.naoqi.axis_mask("VEL"), nk.naoqi.axis_mask(63)
        (7, 63)
    """
    if isinstance(mask, str):
        return int(AxisMask[choice(mask.removeprefix("AXIS_MASK_"), AxisMask.__members__, "axis mask")])
    number = _whole(mask)
    if not 0 <= number <= AxisMask.ALL:
        raise BadArgument(
            f"axis mask must be a number from 0 to 63 (7 position, 56 rotation, 63 both), got {quoted(mask)}"
        )
    return number


def controlled_axes(mask: SupportsIndex | str) -> NDArray[np.bool_]:
    """Return which of x, y, z, wx, wy, wz a mask controls, shape (6,).

    Args:
        mask: as in `axis_mask`.

    Examples:
        >>> nk.naoqi.controlled_axes("VEL").tolist()
        [True, True, True, False, False, False]
    """
    return np.array([axis_mask(mask) >> bit & 1 for bit in range(6)], dtype=np.bool_)
