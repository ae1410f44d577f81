"""Names as NAOqi takes them: a joint, a chain, a group such as "Body" or "Legs", or a list of these."""

from __future__ import annotations

from collections.abc import Iterable
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, common_batch
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.robot import RobotModel, check_robot
from nao_kin.robot.nao import BODY_ORDER

# Body = Head + LArm + LLeg + RLeg + RArm (Aldebaran documentation 2.8, body parts of NAO6).
CHAINS: tuple[str, ...] = ("Head", "LArm", "LLeg", "RLeg", "RArm")
LIMB_PAIRS: dict[str, tuple[str, str]] = {"Arms": ("LArm", "RArm"), "Legs": ("LLeg", "RLeg")}
# What a robot answers to getBodyNames for each: all 26; the same; without the hands, 24; the hands, 2.
GROUPS: tuple[str, ...] = ("Body", "JointActuators", "Joints", "Actuators")
# The unit of a hand's opening.
_OPENING = "1"


def joint_names(robot: RobotModel, names: str | Iterable[str]) -> tuple[str, ...]:
    """The joints that NAOqi means, in its order.

    - A joint: itself; RHipYawPitch included, although one motor moves it with LHipYawPitch.
    - A chain: "Head", "LArm", "LLeg", "RLeg", "RArm", its joints from the trunk outwards, an arm's hand last.
    - "Arms" is LArm and RArm, "Legs" is LLeg and RLeg.
    - "Body" and "JointActuators" are all 26, "Joints" the 24 without the hands, "Actuators" the two hands.
    - Several of these one after the other, repeated where they are named twice.

    A robot that lacks some of NAO's joints has those that it has.

    Args:
        robot: a NAO of any version, or a robot with chains of these names.
        names: one name or several.

    Raises:
        UnknownName: no joint, chain or group.
        BadArgument: no names, or a robot without any of these chains.

    Examples:
        >>> nk.naoqi.joint_names(nk.load_nao(), "Head")
        ('HeadYaw', 'HeadPitch')
    """
    known = _known(robot)
    found: list[str] = []
    for name in as_names(names):
        if name not in known:
            raise UnknownName("joint, chain or group", name, tuple(known))
        found += known[name]
    return tuple(found)


def chain_names(robot: RobotModel) -> tuple[str, ...]:
    """The chains in the order of "Body", as getBodyNames("Chains") gives them.

    Raises:
        BadArgument: a robot without any of these chains.

    Examples:
        >>> nk.naoqi.chain_names(nk.load_nao())
        ('Head', 'LArm', 'LLeg', 'RLeg', 'RArm')
    """
    check_robot(robot)
    found = tuple(chain for chain in CHAINS if chain in robot.chains)
    if not found:
        raise BadArgument(f"robot {robot.name} has none of NAOqi's chains {', '.join(CHAINS)}")
    return found


def angles(robot: RobotModel, q: ArrayLike, names: str | Iterable[str] = "Body") -> Floats:
    """Joint values as getAngles gives them.

    Args:
        robot: a NAO of any version.
        q: configurations, shape (..., nq).
        names: as in `joint_names`.

    Returns:
        Shape (..., n) [rad; 0 to 1 for the hands].

    Raises:
        UnknownName, BadArgument: as `joint_names`.
        WrongShape, NotFinite: q is no configuration.

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.naoqi.angles(nao, nao.posture("Stand"), "Head").round(3).tolist()
        [0.0, -0.17]
    """
    joints = joint_names(robot, names)
    by_name = robot.angles(q)
    values = []
    for joint in joints:
        mimic = robot.mimics.get(joint)
        values.append(by_name[joint] if mimic is None else mimic.value(by_name[mimic.joint]))
    return np.stack(values, axis=-1) if values else np.empty((*np.shape(q)[:-1], 0))


def as_names(names: str | Iterable[str]) -> tuple[str, ...]:
    """One name or several as a tuple of texts.

    Raises:
        BadArgument: neither.
    """
    found = (names,) if isinstance(names, str) else tuple(names) if isinstance(names, Iterable) else (names,)
    for name in found:
        if not isinstance(name, str):
            raise BadArgument(f"names must be a name or several, got {type(name).__name__}")
    return found


def _known(robot: RobotModel) -> dict[str, tuple[str, ...]]:
    """Every name with the joints that it stands for."""
    chains = {chain: tuple(robot.chains[chain]) for chain in chain_names(robot)}
    body = tuple(joint for joints in chains.values() for joint in joints)
    hands = tuple(joint for joint in body if robot.unit(joint) == _OPENING)
    groups = dict(zip(GROUPS, (body, body, tuple(j for j in body if j not in hands), hands), strict=True))
    pairs = {
        name: tuple(joint for chain in pair for joint in chains.get(chain, ())) for name, pair in LIMB_PAIRS.items()
    }
    return {joint: (joint,) for joint in sorted(body, key=_place)} | chains | pairs | groups


def _place(joint: str) -> int:
    return BODY_ORDER.index(joint) if joint in BODY_ORDER else len(BODY_ORDER)


# --- The orders that joint values come in: NAOqi's Body, LoLA's frames, the DCM's table of joint actuators.

Hips = Literal["agree", "left", "right", "average"]
_HIPS = ("agree", "left", "right", "average")
_LEFT, _RIGHT = "LHipYawPitch", "RHipYawPitch"

_NOT_H21 = ("LWristYaw", "LHand", "RWristYaw", "RHand")
_HANDS = ("LHand", "RHand")
_LOLA = (*(joint for joint in BODY_ORDER if joint not in (_RIGHT, *_HANDS)), *_HANDS)

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
    """Joint values in one of `BODY_ORDERS`; RHipYawPitch, where the order has it, repeats LHipYawPitch.

    Args:
        robot: a NAO of any version.
        q: configurations, shape (..., nq).
        order: "H25", "H21", "LoLA" or "jointActuator".

    Returns:
        Shape (..., n) [rad; 0 to 1 for the hands].

    Raises:
        UnknownName: no such order.
        WrongShape, NotFinite: q is no configuration.

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.naoqi.to_order(nao, nao.posture("Stand"), "LoLA").shape
        (25,)
    """
    check_robot(robot)
    return angles(robot, q, _order(order))


def from_order(
    robot: RobotModel, values: ArrayLike, order: str, *, reference: ArrayLike | None = None, hips: Hips = "agree"
) -> Floats:
    """Configurations from joint values in one of `BODY_ORDERS`: the inverse of `to_order`.

    Args:
        robot: a NAO of any version.
        values: shape (..., n) [rad; 0 to 1 for the hands].
        order: "H25", "H21", "LoLA" or "jointActuator".
        reference: configurations that joints which the order lacks are taken from, shape (..., nq); None for zero.
        hips: one motor moves LHipYawPitch and RHipYawPitch. Where an order has both: "agree" refuses values more than
            1e-6 apart, "left" takes the left one, which has priority on the robot, "right" the other, "average" the
            mean.

    Returns:
        q, shape (..., nq); limits are not looked at.

    Raises:
        UnknownName: no such order, or no such rule for the hips.
        CouplingViolated: the hips disagree.
        WrongShape, NotFinite, BadArgument: not one finite number for each joint.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("Stand")
        >>> values = nk.naoqi.to_order(nao, q, "LoLA")
        >>> np.allclose(nk.naoqi.from_order(nao, values, "LoLA"), q)
        True
    """
    check_robot(robot)
    names = _order(order)
    if not isinstance(hips, str) or hips not in _HIPS:
        raise UnknownName("rule for the hips", hips, _HIPS)
    array = as_floats(values, (), "values")
    if array.ndim == 0 or array.shape[-1] != len(names):
        raise WrongShape("values", f"(..., {len(names)}), one for each joint", array.shape)
    by_name = dict(zip(names, np.moveaxis(array, -1, 0), strict=True))
    if hips != "agree" and _LEFT in by_name and _RIGHT in by_name:
        left, right = by_name[_LEFT], by_name.pop(_RIGHT)
        by_name[_LEFT] = {"left": left, "right": right, "average": 0.5 * (left + right)}[hips]
    found = robot.configuration(by_name, limits="ignore")
    if reference is None:
        return found
    start = as_floats(reference, (robot.nq,), "reference")
    batch = common_batch("values and reference", found.shape[:-1], start.shape[:-1])
    q = np.array(np.broadcast_to(start, (*batch, robot.nq)))
    base = robot.nq - len(robot.joint_names)
    columns = [base + column for column, joint in enumerate(robot.joint_names) if joint in by_name]
    q[..., columns] = found[..., columns]
    return q


def _order(order: object) -> tuple[str, ...]:
    if not isinstance(order, str):
        raise BadArgument(f"order must be one of {', '.join(BODY_ORDERS)}, got {type(order).__name__}")
    if order not in BODY_ORDERS:
        raise UnknownName("order of joints", order, tuple(BODY_ORDERS))
    return BODY_ORDERS[order]


# --- Joint limits as getLimits gives them.


def limits(robot: RobotModel, names: str | Iterable[str] = "Body") -> Floats:
    """[minAngle, maxAngle, maxVelocity, maxTorque] of joints, a row each, from the robot's own URDF.

    Ranges are the boxes; HeadPitch and the AnkleRolls are narrower where another joint's value makes them so, which
    getLimits does not say (`robot.coupled_limits` does). The published URDFs of the NAO hold the speeds at no load.

    Args:
        robot: a NAO of any version.
        names: as in `joint_names`.

    Returns:
        Shape (n, 4) [rad, rad, rad/s, N m; 0 to 1 and 1/s for the hands].

    Raises:
        UnknownName, BadArgument: as `joint_names`.

    Examples:
        >>> nk.naoqi.limits(nk.load_nao(), "HeadYaw").round(3).tolist()
        [[-2.086, 2.086, 8.268, 1.547]]
    """
    check_robot(robot)
    column = {name: index for index, name in enumerate(robot.joint_names)}
    rows = []
    for joint in joint_names(robot, names):
        mimic = robot.mimics.get(joint)
        own = column[joint if mimic is None else mimic.joint]
        box = float(robot.lower[own]), float(robot.upper[own])
        lower, upper = box if mimic is None else mimic.range(*box)
        ratio = 1.0 if mimic is None else abs(mimic.multiplier)
        rows.append((lower, upper, ratio * float(robot.velocity_limits[own]), float(robot.effort_limits[own])))
    return np.array(rows, dtype=np.float64).reshape(-1, 4)
