"""The orders that joint values come in: NAOqi's Body, LoLA's frames, the DCM's table of joint actuators."""

from __future__ import annotations

from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._common.vectors import common_batch
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.naoqi.names import angles, one_value_each
from nao_kin.parameters import BODY_ORDER
from nao_kin.robot import RobotModel, check_robot

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
    by_name = dict(zip(names, np.moveaxis(one_value_each(values, names), -1, 0), strict=True))
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
