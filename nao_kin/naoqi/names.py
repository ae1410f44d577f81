"""Names as NAOqi takes them: a joint, a chain, a group such as "Body" or "Legs", or a list of these."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.parameters import BODY_ORDER
from nao_kin.robot import RobotModel, check_robot

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


def one_value_each(values: ArrayLike, names: Sequence[str], what: str = "values") -> Floats:
    """Values of shape (..., n) for n names.

    Raises:
        WrongShape: not as many as names.
        BadArgument, NotFinite: no finite numbers.
    """
    array = as_floats(values, (), what)
    if array.ndim == 0 or array.shape[-1] != len(names):
        raise WrongShape(what, f"(..., {len(names)}), one for each joint", array.shape)
    return array


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
