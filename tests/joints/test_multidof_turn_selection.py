"""Which whole turns and which couplings decide between the angles of a ball, on readings made by hand."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest

from nao_kin.joints._readings import Angle, Motor, Reading, _Assignment, _Input, _TurnRange
from nao_kin.joints.grouping import JointNode
from nao_kin.robot.semantics import Mimic


def joint(
    name: str = "a", *, lower: float = -3.0, upper: float = 3.0, follows: tuple[str, float] | None = None
) -> JointNode:
    mimic, axis, here = Mimic(*follows) if follows else None, np.array([0.0, 0.0, 1.0]), pin.SE3.Identity()
    return JointNode(1, name, 0, (), "revolute", axis, here, mimic, lower, upper, "rad", True, 0, 0)


@pytest.mark.parametrize(
    ("lower", "upper", "middle"),
    [
        (-1.0, 3.0, 1.0),
        (-math.inf, math.inf, 0.0),
        (0.5, math.inf, 0.5 + math.pi),
        (-math.inf, 0.5, 0.5 - math.pi),
    ],
)
def test_a_joint_without_a_limit_has_its_middle_half_a_turn_inside_the_other(
    lower: float, upper: float, middle: float
) -> None:
    assert _TurnRange.of(joint(lower=lower, upper=upper)).middle == middle


@pytest.mark.parametrize("multiplier", [2.0, -2.0])
@pytest.mark.parametrize(("off", "broken"), [(0.15, 0), (0.25, 1)])
def test_a_follower_may_be_off_by_the_doubt_of_its_driver_whichever_way_it_turns(
    multiplier: float, off: float, broken: int
) -> None:
    """The driver is known to 0.1, so that the follower is known to 0.2; it is in no ball, and read off column 0."""
    follower = joint("b", follows=("a", multiplier))
    motor = Motor(joint(), Angle(0, 0), [(follower, Reading(0))])
    drivers = np.array([[0.3]])
    for sign in (1.0, -1.0):
        given = _Input(np.array([[multiplier * 0.3 + sign * off]]), None)
        found = _Assignment(given, (), np.zeros((1, 3, 1)), np.full((1, 1), 0.1), np.zeros((4, 1)))
        assert found.violated_couplings(motor, drivers).tolist() == [[broken]]
