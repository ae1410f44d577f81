"""Random robots with balls, locks, limits of several turns and followers: the typed model is the robot."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import NaoKinError
from nao_kin.joints import MultiDofModel
from nao_kin.joints.grouping import RULES

pytestmark = pytest.mark.full

PI = float(np.pi)
TRIADS = [np.eye(3), np.array([[1.0, 2.0, -2.0], [2.0, 1.0, 2.0], [2.0, -2.0, -1.0]]) / 3.0]
OFFSETS = [(0.0, 0.0, 0.0), (0.2, 0.0, 0.0), (0.0, 0.1, 0.3)]
LIMITS = [(-1.4, 1.4), (-3.0, 3.0), (-PI, PI), (-6.28, 6.28), (-20.0, 20.0), (0.5, 7.0), (-2 * PI, 0.0), None]
MULTIPLIERS = [0.5, 2.0, -1.0, 0.3, 1.0, -2.5]


@st.composite
def chains(draw: st.DrawFn) -> list[J]:
    """One to three groups of one to three joints, those of a group perpendicular through one point; some follow."""
    joints: list[J] = []
    for group in range(draw(st.integers(1, 3))):
        triad = draw(st.sampled_from(TRIADS))[draw(st.permutations(range(3)))]
        for place in range(draw(st.sampled_from([3, 3, 2, 1]))):
            begins = place == 0 and group > 0
            limits = draw(st.sampled_from(LIMITS))
            others = [joint.name for joint in joints if joint.follows is None]
            follows = None
            if others and draw(st.integers(0, 3)) == 0:
                multiplier, offset = draw(st.sampled_from(MULTIPLIERS)), draw(st.sampled_from([0.0, 0.3]))
                follows, limits = (draw(st.sampled_from(others)), multiplier, offset), (-99.0, 99.0)
            joints.append(
                J(
                    f"j{len(joints)}",
                    tuple(draw(st.sampled_from([1.0, -1.0])) * triad[place]),
                    draw(st.sampled_from(OFFSETS)) if begins else (0.0, 0.0, 0.0),
                    kind="continuous"
                    if limits is None
                    else "prismatic"
                    if draw(st.integers(0, 14)) == 0
                    else "revolute",
                    parent=draw(st.sampled_from(["", "", "base", "j0", "j1"])) if begins and len(joints) > 1 else "",
                    follows=follows,
                    limits=limits or (0.0, 0.0),
                )
            )
    return joints


@st.composite
def robots(draw: st.DrawFn) -> nk.RobotModel:
    try:
        with tempfile.TemporaryDirectory() as folder:
            return made_up(Path(folder), *draw(chains()), base=draw(st.sampled_from(["fixed", "fixed", "floating"])))
    except NaoKinError:
        assume(False)
        raise


def configurations(typed: MultiDofModel, seed: int) -> np.ndarray:
    """Inside the limits: at random, at and beside every lock, at the ends of the limits."""
    robot, rng = typed.robot, np.random.default_rng(seed)
    q = robot.random(seed, (40,))
    first = robot.nq_base
    lower, upper = np.maximum(robot.lower, -30.0), np.minimum(robot.upper, 30.0)
    unlimited = np.isinf(robot.upper)
    q[:, first:][:, unlimited] = rng.uniform(-30.0, 30.0, (40, int(unlimited.sum())))
    ends = np.where(rng.random((10, len(lower))) < 0.5, lower, upper)
    q[30:, first:] = np.where(rng.random(ends.shape) < 0.3, ends, q[30:, first:])
    for joint in typed.pairs:
        if joint.singularity is None or joint.singularity.joint not in robot.joint_names:
            continue
        column = robot.joint_names.index(joint.singularity.joint)
        for row in range(10, 30):
            beside = rng.choice([0.0, *10.0 ** rng.uniform(-17, -2, 3)]) * rng.choice([-1, 1])
            value = rng.choice(joint.singularity.at) + 2 * PI * rng.integers(-3, 4) + beside
            if lower[column] <= value <= upper[column]:
                q[row, first + column] = value
    return q


def known(typed: MultiDofModel) -> list[int]:
    """Return the columns of q whose whole turns a typed configuration keeps.

    These are all but the last angles of balls whose range allows more turns.
    """
    robot = typed.robot
    last = {joint.joints[-1] for joint in typed.pairs if joint.pair.name == "spherical"}
    shift = robot.nq_base
    return [
        shift + i
        for i, name in enumerate(robot.joint_names)
        if name not in last or robot.upper[i] - robot.lower[i] < 2 * PI - 1e-6
    ]


@settings(max_examples=150)
@given(robots(), st.sampled_from(RULES), st.integers(0, 2**32 - 1))
def test_inside_the_limits_nothing_is_lost_and_nothing_violated(robot, rule, seed) -> None:
    typed = MultiDofModel(robot, rule=rule)
    q = configurations(typed, seed)
    q_typed = typed.from_q(q)
    names = robot.frame_names
    expected = robot.fk(q, names)
    assert np.allclose(typed.fk(q_typed, names), expected, rtol=0, atol=1e-12)
    assert typed.violations(q_typed) == ()
    back = typed.to_q(q_typed)
    assert np.allclose(robot.fk(back, names), expected, rtol=0, atol=1e-11)
    assert np.allclose(back[:, known(typed)], q[:, known(typed)], rtol=0, atol=1e-11)
    assert np.allclose(typed.to_q(q_typed, near=q), q, rtol=0, atol=1e-9)
