"""NAOqi's names and orders of joints, and their limits."""

from __future__ import annotations

from collections.abc import Iterable
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, choice, common_batch, texts
from nao_kin._core.sides import Hips, check_hips
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.robot.nao import BODY_ORDER

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
    near: ArrayLike | None = None,
    hips: Hips | None = None,
    missing: str | float | None = None,
) -> Floats:
    """Return configurations from joint values in one of `BODY_ORDERS`: the inverse of `to_order`.

    Args:
        robot: a NAO of any version.
        values: shape (..., n) [rad; 0 to 1 for the hands].
        order: "H25", "H21", "LoLA" or "jointActuator".
        near: configurations with the values of the joints that the order lacks, shape (..., nq); None for zero.
        hips: one motor moves LHipYawPitch and RHipYawPitch. If an order has both, None rejects values that differ by
            more than 1e-6, "left" uses the left one, as the robot does, "right" the right one, "average" the mean.
        missing: values of joints that are NaN, such as hands without a sensor, as in `RobotModel.configuration`.

    Returns:
        q, shape (..., nq); limits are not checked.

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
    if hips is not None:
        check_hips(hips)
    array = as_floats(values, (), "values", gaps=True)
    if array.ndim == 0 or array.shape[-1] != len(names):
        raise WrongShape("values", f"(..., {len(names)}), one for each joint", array.shape)
    by_name = dict(zip(names, np.moveaxis(array, -1, 0), strict=True))
    result = robot.configuration(by_name, limits="ignore", hips=hips, missing=missing)
    if near is None:
        return result
    start = as_floats(near, (robot.nq,), "near")
    batch = common_batch("values and near", result.shape[:-1], start.shape[:-1])
    q = np.array(np.broadcast_to(start, (*batch, robot.nq)))
    columns = [column for column, joint in enumerate(robot.joint_names, robot.nq_base) if joint in by_name]
    q[..., columns] = result[..., columns]
    return q


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
