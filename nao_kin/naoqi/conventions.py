"""NAOqi's conventions: names and orders of joints, limits, poses, spaces and axis masks.

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
from collections.abc import Iterable
from enum import IntFlag
from types import MappingProxyType
from typing import SupportsIndex, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, choice, join_poses, rigid_inverse, texts
from nao_kin._core.sides import Hips
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.robot.nao import BODY_ORDER
from nao_kin.rotations import matrix_from_rpy, nearest_rotation, rpy_from_matrix
from nao_kin.screws import refuse_not_rigid
from nao_kin.world import feet_frame

# --- Names of joints, chains and groups.

# Body = Head + LArm + LLeg + RLeg + RArm (Aldebaran documentation 2.8, body parts of NAO6).
CHAINS: tuple[str, ...] = ("Head", "LArm", "LLeg", "RLeg", "RArm")
ARMS, LEGS, HANDS = ("LArm", "RArm"), ("LLeg", "RLeg"), ("LHand", "RHand")
LIMB_PAIRS: dict[str, tuple[str, str]] = {"Arms": ARMS, "Legs": LEGS}
# Two joints with one motor.
LEFT_HIP, RIGHT_HIP = "LHipYawPitch", "RHipYawPitch"
# getBodyNames returns for these, in order: all 26 joints; the same 26; the 24 without the hands; the 2 hands.
GROUPS: tuple[str, ...] = ("Body", "JointActuators", "Joints", "Actuators")
# The unit of a hand's opening.
_OPENING = "1"


def joint_names(robot: RobotModel, names: str | Iterable[str]) -> tuple[str, ...]:
    """Return the joints that NAOqi's names stand for, in NAOqi's order.

    - A joint's name stands for that joint. RHipYawPitch is included, although one motor moves it with LHipYawPitch.
    - A chain, "Head", "LArm", "LLeg", "RLeg" or "RArm", is its joints from the trunk outwards, an arm's hand last.
    - "Arms" is LArm and RArm, "Legs" is LLeg and RLeg.
    - "Body" and "JointActuators" are all 26, "Joints" the 24 without the hands, "Actuators" the two hands.

    Several names give their joints one after the other; a joint that is named twice is repeated. Joints of a NAO that
    the robot lacks are left out.

    Args:
        robot: a NAO of any version, or a robot with chains of these names.
        names: one name or several.

    Raises:
        BadArgument: the robot has none of these chains.

    Examples:
        >>> nk.naoqi.joint_names(nk.load_nao(), "Head")
        ('HeadYaw', 'HeadPitch')
    """
    known = _known(robot)
    return tuple(joint for name in as_names(names) for joint in known[choice(name, known, "joint, chain or group")])


def chain_names(robot: RobotModel) -> tuple[str, ...]:
    """Return the chains in the order of "Body", as getBodyNames("Chains") does.

    Raises:
        BadArgument: the robot has none of these chains.

    Examples:
        >>> nk.naoqi.chain_names(nk.load_nao())
        ('Head', 'LArm', 'LLeg', 'RLeg', 'RArm')
    """
    chains = tuple(chain for chain in CHAINS if chain in robot.chains)
    if not chains:
        raise BadArgument(f"robot {robot.name} has none of NAOqi's chains {', '.join(CHAINS)}")
    return chains


def angles(robot: RobotModel, q: ArrayLike, names: str | Iterable[str] = "Body") -> Floats:
    """Return joint values as getAngles does.

    Args:
        robot: a NAO of any version.
        q: configurations, shape (..., nq).
        names: as in `joint_names`.

    Returns:
        Shape (..., n) [rad; 0 to 1 for the hands].

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.naoqi.angles(nao, nao.posture("Stand"), "Head").round(3).tolist()
        [0.0, -0.17]
    """
    joints = joint_names(robot, names)
    by_name = robot.angles(q)
    by_name |= {name: mimic.value(by_name[mimic.joint]) for name, mimic in robot.mimics.items()}
    values = [by_name[joint] for joint in joints]
    return np.stack(values, axis=-1) if values else np.empty((*np.shape(q)[:-1], 0))


def as_names(names: str | Iterable[str]) -> tuple[str, ...]:
    """Return one name or several as a tuple of strings."""
    return (names,) if isinstance(names, str) else texts(names, "names")


def _known(robot: RobotModel) -> dict[str, tuple[str, ...]]:
    """Return every name with its joints."""
    chains = {chain: tuple(robot.chains[chain]) for chain in chain_names(robot)}
    body = tuple(joint for joints in chains.values() for joint in joints)
    hands = tuple(joint for joint in body if robot.unit(joint) == _OPENING)
    groups = dict(zip(GROUPS, (body, body, tuple(j for j in body if j not in hands), hands), strict=True))
    pairs = {name: (*chains.get(left, ()), *chains.get(right, ())) for name, (left, right) in LIMB_PAIRS.items()}
    ordered = dict.fromkeys((*(joint for joint in BODY_ORDER if joint in body), *body))
    return {joint: (joint,) for joint in ordered} | chains | pairs | groups


# --- The orders of joint values: NAOqi's Body, LoLA's frames, the DCM's table of joint actuators.

_NOT_H21 = ("LWristYaw", "LHand", "RWristYaw", "RHand")
_LOLA = (*(joint for joint in BODY_ORDER if joint not in (RIGHT_HIP, *HANDS)), *HANDS)

# "H25": getBodyNames("Body") of a NAO H25, 26 names (doc.aldebaran.com/2-8, bodyparts_naov6.html).
# "H21": the same without wrists and hands, 22 names (doc.aldebaran.com/2-0/family/robots/bodyparts.html, note 2).
# "LoLA": the 25 values of the RoboCup interface of the NAO6 (ros-sports/nao_lola, JointIndexes.msg).
# "jointActuator": the 25 actuators by name, as Aldebaran's example fastgetsetdcm lays out its DCM alias of that name.
BODY_ORDERS: MappingProxyType[str, tuple[str, ...]] = MappingProxyType(
    {
        "H25": BODY_ORDER,
        "H21": tuple(joint for joint in BODY_ORDER if joint not in _NOT_H21),
        "LoLA": _LOLA,
        "jointActuator": tuple(sorted(_LOLA)),
    }
)


def to_order(robot: RobotModel, q: ArrayLike, order: str) -> Floats:
    """Return joint values in one of `BODY_ORDERS`; RHipYawPitch repeats LHipYawPitch if the order has both.

    Args:
        robot: a NAO of any version.
        q: configurations, shape (..., nq).
        order: "H25", "H21", "LoLA" or "jointActuator".

    Returns:
        Shape (..., n) [rad; 0 to 1 for the hands].

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.naoqi.to_order(nao, nao.posture("Stand"), "LoLA").shape
        (25,)
    """
    return angles(robot, q, BODY_ORDERS[choice(order, BODY_ORDERS, "order of joints")])


def from_order(
    robot: RobotModel,
    values: ArrayLike,
    order: str,
    *,
    hips: Hips | None = None,
    missing: str | float | None = None,
) -> Floats:
    """Return configurations from joint values in one of `BODY_ORDERS`: the inverse of `to_order`.

    Args:
        robot: a NAO of any version.
        values: shape (..., n) [rad; 0 to 1 for the hands].
        order: "H25", "H21", "LoLA" or "jointActuator".
        hips: one motor moves LHipYawPitch and RHipYawPitch. If an order has both, None rejects values that differ by
            more than 1e-6, "left" uses the left one, as the robot does, "right" the right one, "average" the mean.
        missing: values of joints that are NaN, such as hands without a sensor, as in `RobotModel.configuration`.

    Returns:
        q, shape (..., nq), zero for joints that the order lacks; limits are not checked.

    Raises:
        CouplingViolated: the hips disagree.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("Stand")
        >>> values = nk.naoqi.to_order(nao, q, "LoLA")
        >>> np.allclose(nk.naoqi.from_order(nao, values, "LoLA"), q)
        True
    """
    names = BODY_ORDERS[choice(order, BODY_ORDERS, "order of joints")]
    array = as_floats(values, (), "values", gaps=True)
    if array.ndim == 0 or array.shape[-1] != len(names):
        raise WrongShape("values", f"(..., {len(names)}), one for each joint", array.shape)
    by_name = dict(zip(names, np.moveaxis(array, -1, 0), strict=True))
    return robot.configuration(by_name, limits="ignore", hips=hips, missing=missing)


# --- Joint limits as getLimits returns them.


def limits(robot: RobotModel, names: str | Iterable[str] = "Body") -> Floats:
    """Return [minAngle, maxAngle, maxVelocity, maxTorque] of joints, a row each, from the robot's own URDF.

    Each range is that of the joint alone. The value of another joint may narrow the range of HeadPitch or an AnkleRoll:
    `robot.coupled_limits` has these narrower ranges, getLimits does not. The speeds in the NAO's published URDFs are
    those at no load.

    Args:
        robot: a NAO of any version.
        names: as in `joint_names`.

    Returns:
        Shape (n, 4) [rad, rad, rad/s, N m; 0 to 1 and 1/s for the hands].

    Examples:
        >>> nk.naoqi.limits(nk.load_nao(), "HeadYaw").round(3).tolist()
        [[-2.086, 2.086, 8.268, 1.547]]
    """
    joints, mimics = joint_names(robot, names), robot.mimics
    columns = [robot.joint_names.index(mimics[joint].joint if joint in mimics else joint) for joint in joints]
    bounds = np.array([robot.joints.limits(joint) for joint in joints]).reshape(-1, 3)
    return np.column_stack([bounds, robot.effort_limits[columns]])


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
    poses = _rigid(as_floats(T, (4, 4), "T"), "T")
    return np.concatenate([poses[..., :3, 3], rpy_from_matrix(poses[..., :3, :3])], axis=-1)


def pose(position6d: ArrayLike) -> Floats:
    """Return homogeneous matrices, shape (..., 4, 4), of Position6D (x, y, z, wx, wy, wz), shape (..., 6) [m, rad].

    Examples:
        >>> nk.naoqi.pose([0.1, 0.0, 0.2, 0.0, 0.0, 0.0])[:3, 3].tolist()
        [0.1, 0.0, 0.2]
    """
    six = as_floats(position6d, (6,), "position6d")
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
    poses = _rigid(as_floats(T, (4, 4), "T"), "T")
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
    numbers = as_floats(numbers, (4 * rows,), "transform")
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
        if candidate in robot.frame_names:
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
    return _rigid(as_floats(torso_in_world, (4, 4), "torso_in_world"), "torso_in_world")


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
