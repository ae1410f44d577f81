"""Which whole turns and which couplings decide between the angles of a ball, on readings made by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nao_kin.joints._readings import JointReading, Motor, Source
from nao_kin.joints._turn_selection import _Assignment, _broken, _Given, _Range
from nao_kin.robot.semantics import Mimic


def reading(
    name: str = "a", *, lower: float = -3.0, upper: float = 3.0, follows: tuple[str, float] | None = None
) -> JointReading:
    return JointReading(name, Mimic(*(follows or (name, 1.0))), 0, 0, lower, upper, revolute=True)


@pytest.mark.parametrize(
    ("lower", "upper", "middle"),
    [
        (-1.0, 3.0, 1.0),
        (-math.inf, math.inf, 0.0),
        (-1e300, 1e300, 0.0),
        (0.5, math.inf, 0.5 + math.pi),
        (-math.inf, 0.5, 0.5 - math.pi),
        (-2e3, -1.0, -1.0 - math.pi),
    ],
)
def test_a_joint_without_a_limit_has_its_middle_half_a_turn_inside_the_other(
    lower: float, upper: float, middle: float
) -> None:
    assert _Range.of(reading(lower=lower, upper=upper)).middle == middle


@pytest.mark.parametrize("multiplier", [2.0, -2.0])
@pytest.mark.parametrize(("off", "broken"), [(0.15, 0), (0.25, 1)])
def test_a_follower_may_be_off_by_the_doubt_of_its_driver_whichever_way_it_turns(
    multiplier: float, off: float, broken: int
) -> None:
    """The driver is known to 0.1, so that the follower is known to 0.2; it is in no ball, and read off column 0."""
    follower = reading("b", follows=("a", multiplier))
    motor = Motor(reading(), ball=0, place=0, written=[(follower, Source(0))])
    found = _Assignment(np.zeros((1, 3, 1)), np.full((1, 1), 0.1), np.zeros((4, 1)))
    drivers = np.array([[0.3]])
    for sign in (1.0, -1.0):
        given = _Given(np.array([[multiplier * 0.3 + sign * off]]), None)
        assert _broken(motor, drivers, found, given).tolist() == [[broken]]
