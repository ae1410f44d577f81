"""Limits at the ends of tables, and configurations of a floating base, on the fast path and on that for arrays."""

from __future__ import annotations

import itertools
import math
import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import DegreesWarning, OutsideLimits
from nao_kin.robot.semantics import CoupledLimit, Semantics

# No bound of one end is the bound of another, and b = 0 is outside at both ends.
TABLE = CoupledLimit("b", "a", (-1.0, 0.0, 1.0), (0.25, -1.5, -1.0), (0.5, 1.0, -0.5))


@pytest.fixture
def robot(tmp_path: Path) -> nk.RobotModel:
    path = made_up(tmp_path, J("a"), J("b"), J("c")).urdf_path
    return nk.RobotModel.from_urdf(path, semantics=Semantics(coupled_limits=(TABLE,)))


# The corners of the table, between them, and on both sides of it.
A = (-2.5, -1.0, -0.75, -0.5, 0.0, 0.25, 0.5, 1.0, 2.5)


@pytest.mark.parametrize("a", A)
@pytest.mark.parametrize("nudge", [-2e-6, -1e-12, 1e-12, 2e-6])
def test_one_configuration_is_inside_a_table_where_a_batch_is(robot: nk.RobotModel, a: float, nudge: float) -> None:
    lower, upper = (float(np.interp(a, TABLE.at, bounds)) for bounds in (TABLE.lower, TABLE.upper))
    # At the bounds for this a, and at those for others.
    for b in (lower + nudge, upper + nudge, *(bound + nudge for bound in (*TABLE.lower, *TABLE.upper))):
        inside = lower - 1e-6 <= b <= upper + 1e-6
        assert robot.within_limits([[a, b, 0.0]]).tolist() == [inside]
        for check in (
            lambda b=b: robot.check_limits(np.array([a, b, 0.0])),
            lambda b=b: robot.configuration({"a": a, "b": b}),
            lambda b=b: robot.fk([a, b, 0.0], "c", limits="enforce"),
        ):
            if inside:
                check()
            else:
                with pytest.raises(OutsideLimits):
                    check()


def test_where_a_table_reaches_out_of_the_box_the_box_holds(tmp_path: Path) -> None:
    table = CoupledLimit("b", "a", (-1.0, 0.0, 1.0), (-9.0, -0.25, 0.75), (0.25, 9.0, 9.0))
    path = made_up(tmp_path, J("a", limits=(-1.0, 0.0)), J("b", limits=(-0.5, 0.5))).urdf_path
    robot = nk.RobotModel.from_urdf(path, semantics=Semantics(coupled_limits=(table,)))
    q = robot.random(0, 2000)
    assert robot.within_limits(q).all()
    assert q[:, 1].min() < -0.45
    assert q[:, 1].max() > 0.45
    # Where box and table have no value in common, the box is what stops the joint.
    path = made_up(tmp_path, J("a", limits=(-1.0, 1.0)), J("b", limits=(-0.5, 0.5))).urdf_path
    for sign, bounds in ((1.0, (0.75, 9.0)), (-1.0, (-9.0, -0.75))):
        apart = CoupledLimit("b", "a", (0.0,), bounds[:1], bounds[1:])
        robot = nk.RobotModel.from_urdf(path, semantics=Semantics(coupled_limits=(apart,)))
        for b in (-9.0, 0.0, 9.0):
            assert robot.clamp([0.0, b]).tolist() == [0.0, 0.5 * sign]
        assert (robot.random(0, 5)[:, 1] == 0.5 * sign).all()


@pytest.mark.parametrize("a", A)
def test_a_joint_at_zero_may_be_outside_by_the_joint_it_depends_on(robot: nk.RobotModel, a: float) -> None:
    lower, upper = TABLE.range(np.array(a))
    if lower <= 0.0 <= upper:
        assert robot.configuration({"a": a}).tolist() == [a, 0.0, 0.0]
    else:
        with pytest.raises(OutsideLimits, match=f"b = 0 not in .* at a = {a:g}"):
            robot.configuration({"a": a})
    assert robot.configuration({"c": 1.0}).tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_value_is_on_its_limit_to_a_millionth(robot: nk.RobotModel, side: float) -> None:
    for miss, inside in ((1e-9, True), (0.9e-6, True), (1.1e-6, False), (1e-4, False)):
        q = np.array([0.0, 0.0, side * (3.0 + miss)])
        assert robot.within_limits(q) == inside
        assert (robot.limit_violations(q) == ()) == inside
        if inside:
            assert robot.check_limits(q).tolist() == q.tolist()
            assert robot.configuration({"c": q[2]}).tolist() == q.tolist()


@pytest.mark.parametrize("rounded", [lambda q: q.astype(np.float32).astype(np.float64), lambda q: np.round(q, 6)])
@pytest.mark.parametrize("version", ["v3.2", "v6"])
def test_limits_and_postures_may_be_rounded_as_files_round_them(
    version: str, rounded: Callable[[np.ndarray], np.ndarray]
) -> None:
    nao = nk.load_nao(version)
    ends = np.stack([nao.clamp(np.where(np.eye(nao.nq) > 0, end, nao.posture("Stand"))) for end in (-9.0, 9.0)])
    postures = np.stack([nao.posture(name) for name in nao.posture_names])
    q = np.concatenate([ends.reshape(-1, nao.nq), postures])
    for row in rounded(q)[nao.within_limits(q)]:
        assert nao.check_limits(row).tolist() == row.tolist()
        assert nao.configuration(nao.angles(row)).tolist() == row.tolist()


def test_the_unit_of_a_violation_is_that_of_the_joint_that_is_limited(tmp_path: Path) -> None:
    path = made_up(tmp_path, J("slide", kind="prismatic"), J("turn")).urdf_path
    table = CoupledLimit("turn", "slide", (-1.0, 1.0), (-0.5, -0.5), (0.5, 0.5))
    robot = nk.RobotModel.from_urdf(path, semantics=Semantics(coupled_limits=(table,)))
    (violation,) = robot.limit_violations([0.25, 1.0])
    assert (violation.unit, violation.of, violation.of_value) == ("rad", "slide", 0.25)
    assert str(violation) == "turn = 1 not in [-0.5, 0.5] rad at slide = 0.25"


def test_violations_are_listed_by_configuration_and_then_by_excess(nao: nk.NaoModel) -> None:
    angles = {"HeadYaw": nao.upper[0] + 0.02, "HeadPitch": 0.4, "LHand": -0.3, "RHand": 1.01, "LKneePitch": -1.0}
    q = nao.configuration(angles, limits="ignore")
    found = nao.limit_violations(np.stack([nao.neutral(), q, nao.posture("Stand"), q]))
    rows = [(row.index, row.joint) for row in found if row.index in ((1,), (3,))]
    assert [row.index for row in found] == sorted(row.index for row in found)
    for index in ((1,), (3,)):
        excesses = [row.excess for row in found if row.index == index]
        assert excesses == sorted(excesses, reverse=True)
    own = [joint for index, joint in rows if index == (1,) and joint in angles]
    assert own == ["LKneePitch", "LHand", "HeadPitch", "HeadYaw", "RHand"]
    assert next(row.of for row in found if row.joint == "HeadPitch") == "HeadYaw"


@pytest.mark.parametrize("degrees", [False, True])
def test_a_violation_is_told_with_as_many_digits_as_show_it(nao: nk.NaoModel, degrees: bool) -> None:
    for end, miss in itertools.product((nao.lower[0], nao.upper[0]), (2e-6, 1e-4, 0.3)):
        q = nao.configuration({"HeadYaw": end + math.copysign(miss, end)}, limits="ignore")
        words = nao.limit_violations(q)[0].describe(degrees=degrees)
        value, lower, upper = map(float, re.findall(r"-?\d+\.?\d*", words))
        assert not lower <= value <= upper, words
        assert miss < 1e-4 or len(words) < 60


def test_joints_with_one_limit_and_sliding_ones_may_go_far_without_a_warning(tmp_path: Path) -> None:
    tree = made_up(tmp_path, J("below"), J("above"), J("slide", kind="prismatic"), J("bound")).tree
    below, above, slide, bound = tree.joints
    joints = (replace(below, upper=math.inf), replace(above, lower=-math.inf), slide, bound)
    robot = nk.RobotModel(replace(tree, joints=joints))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for far in (-7.0, 7.0):
            robot.fk([far, far, far, 0.0], "bound_l")
    with pytest.warns(DegreesWarning, match=r"^bound = 7 rad"):
        robot.fk([-7.0, 7.0, 50.0, 7.0], "bound_l")


def test_a_joint_within_a_turn_is_not_the_one_in_degrees(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b"))
    with pytest.warns(DegreesWarning, match=r"^b = -45 rad"):
        robot.fk([4.0, -45.0], "b_l")  # 4 is outside as well
    with pytest.warns(DegreesWarning, match=r"^b = 7 rad"):
        robot.fk([[4.0, 0.0], [0.0, 7.0]], "b_l")


# --- floating base ----------------------------------------------------------------------------------------------------


@pytest.fixture
def free(tmp_path: Path) -> nk.RobotModel:
    return made_up(tmp_path, J("a", limits=(-1.0, 1.0)), J("b", limits=(-2.0, 2.0)), base="floating")


def test_values_by_name_leave_the_base_where_it_is(free: nk.RobotModel) -> None:
    for limits in ("enforce", "clamp", "ignore"):
        for values in ({"b": 0.5, "a": -0.25}, {"b": np.array(0.5), "a": np.array(-0.25)}):
            q = free.configuration(values, limits=limits)  # type: ignore[arg-type]
            assert q.tolist() == [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -0.25, 0.5]


def test_only_joints_that_were_named_are_clamped_and_the_base_is_not(free: nk.RobotModel) -> None:
    assert free.configuration({"a": 9.0}, limits="clamp").tolist() == [0.0] * 6 + [1.0, 1.0, 0.0]
    assert free.configuration({"b": -9.0}, limits="clamp").tolist() == [0.0] * 6 + [1.0, 0.0, -2.0]
    q = np.array([5.0, 6.0, 7.0, 0.0, 0.0, 0.0, 1.0, 9.0, -9.0])
    assert free.clamp(q).tolist() == [5.0, 6.0, 7.0, 0.0, 0.0, 0.0, 1.0, 1.0, -2.0]


def test_joints_that_were_not_named_are_left_outside(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a", limits=(0.5, 1.0)), J("b", limits=(-2.0, 2.0)))
    assert robot.configuration({"b": 9.0}, limits="clamp").tolist() == [0.0, 2.0]
    assert robot.configuration({"b": [9.0, 0.0]}, limits="clamp").tolist() == [[0.0, 2.0], [0.0, 0.0]]
