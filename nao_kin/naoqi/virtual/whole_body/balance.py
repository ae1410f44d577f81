"""What whole-body control keeps, and joint values that keep it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from nao_kin import NaoModel, ik
from nao_kin._common.arrays import Floats
from nao_kin.naoqi.virtual.cartesian.descent import RADIAN, Solution
from nao_kin.naoqi.virtual.cartesian.effectors import LEGS, TORSO

FOOT_STATES: tuple[str, ...] = ("Fixed", "Plane", "Free")
SUPPORTS: tuple[str, ...] = ("Legs", "LLeg", "RLeg")
_SENSORS = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
# A foot that is held by its leg, and not stood on, counts so much more than what else is asked for.
_HELD = 100.0
# How far inside the support polygon the centre of mass is kept [m].
_MARGIN = 0.005


@dataclass
class Balance:
    """What is kept while whole-body control is on.

    Attributes:
        enabled: whether it is on.
        feet: foot → "Fixed", "Plane" or "Free".
        support: what the centre of mass is kept above: "Legs", "LLeg" or "RLeg"; None for nothing.
    """

    enabled: bool = False
    feet: dict[str, str] = field(default_factory=lambda: dict.fromkeys(LEGS, "Fixed"))
    support: str | None = None


def above(robot: NaoModel, q: Floats, T_world_torso: Floats, support: str) -> Floats:
    """The middle of the pressure sensors of a foot, or of both for "Legs", seen from above, shape (2,) [m]."""
    feet = LEGS if support == "Legs" else (support,)
    frames = [f"{foot[0]}Foot/FSR/{sensor}" for foot in feet for sensor in _SENSORS]
    places = robot.fk(q, frames)[:, :, 3] @ T_world_torso.T
    return np.asarray(places[:, :2].mean(axis=0))


def com_above(robot: NaoModel, q: Floats, T_world_torso: Floats) -> Floats:
    """The centre of mass seen from above, shape (2,) [m]."""
    return np.asarray((T_world_torso[:3, :3] @ robot.com(q) + T_world_torso[:3, 3])[:2])


def solve(
    robot: NaoModel,
    balance: Balance,
    T_world_feet: Floats,
    targets: Mapping[str, tuple[Floats, tuple[float, float]]],
    q: Floats,
    posture: Floats,
    *,
    com: Floats | None = None,
) -> Solution | None:
    """Joint values of the whole robot, with the feet in place and the centre of mass above what supports it.

    Args:
        robot: a NAO.
        balance: what is kept.
        T_world_feet: where the feet are kept, left and right, shape (2, 4, 4).
        targets: effector → pose (4, 4) or place (3,) in the world, and its weights of metres and of radians. A foot
            that has one is not kept.
        q: where the search begins, shape (nq,).
        posture: what the joints stay near to, shape (nq,).
        com: where the centre of mass is to be above, shape (2,); None for anywhere above the support.

    Returns:
        What is missing of all targets together, radians times 0.1; None where no foot stands.
    """
    kept = {foot: T for foot, T in zip(LEGS, T_world_feet, strict=True) if foot not in targets}
    kept = {foot: T for foot, T in kept.items() if balance.feet[foot] != "Free"}
    standing = {balance.support: kept[balance.support]} if com is None and balance.support in kept else kept
    if not standing:
        return None
    asked = dict(targets) | {foot: (T, (_HELD, RADIAN * _HELD)) for foot, T in kept.items() if foot not in standing}
    torso = asked.pop(TORSO, None)
    weights = {name: weight for name, (_, weight) in asked.items()}
    if torso is not None:
        weights["torso"] = torso[1]
    found = ik.whole_body(
        robot,
        {name: T for name, (T, _) in asked.items()},
        feet={foot[0]: T for foot, T in standing.items()},
        com="support" if com is None and balance.support is not None else com,
        margin=_MARGIN if com is None and balance.support is not None else 0.0,
        torso=None if torso is None else torso[0],
        weights=weights,
        reference=q,
        posture=posture,
        restarts=0,
    )
    if not np.isfinite(found.q).all():
        return Solution(np.array(q), np.inf)
    off = [np.hypot(away, RADIAN * turn) for away, turn in found.residuals.values()]
    return Solution(found.q, float(np.linalg.norm(off)))
