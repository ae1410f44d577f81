"""Denavit–Hartenberg tables beside forward kinematics and SymPy."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.joints import DHConvention, dh_table
from nao_kin.robot.nao import VERSIONS

FRAMES = ("LArm", "RArm", "LLeg", "RLeg", "Head", "CameraTop", "CameraBottom", "RFinger13_link")
CONVENTIONS = get_args(DHConvention)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_product_of_the_table_is_the_pose_of_every_version_and_when_calibrated(
    convention: DHConvention,
) -> None:
    robots = [nk.load_nao(version) for version in VERSIONS]
    offsets = np.random.default_rng(1).normal(0.0, 0.01, robots[0].nq)
    robots.append(robots[0].with_offsets(dict(zip(robots[0].joint_names[:20], offsets[:20].tolist(), strict=True))))
    for nao in robots:
        q = np.vstack((nao.random(3, 40), nao.neutral(), nao.posture("Crouch", limits="ignore")))
        for frame in FRAMES:
            if frame in nao.frame_names:
                assert np.abs(dh_table(nao, frame, convention).fk(q) - nao.fk(q, frame)).max() < 1e-12


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("name", ["panda", "tiago", "ur5_robot"])
def test_other_robots_and_sliding_joints_have_tables_too(name: str, convention: DHConvention) -> None:
    robot = nk.load_robot(name)
    q = robot.random(1, 10)
    kinds = set()
    for frame in robot.frame_names[::3]:
        if robot.frame_placement(frame)[0] >= 0:
            table = dh_table(robot, frame, convention)
            kinds |= set(table.kinds)
            assert np.abs(table.fk(q) - robot.fk(q, frame)).max() < 1e-8
    assert "prismatic" in kinds or name == "ur5_robot"


def test_a_table_has_the_links_of_the_robot_and_few_numbers_that_are_not_zero() -> None:
    nao = nk.load_nao()
    leg = dh_table(nao, "LLeg")
    assert leg.a == pytest.approx([0, 0, 0.1, 0.1029, 0, 0], abs=1e-12)
    assert leg.alpha == pytest.approx([np.pi / 2, np.pi / 2, 0, 0, np.pi / 2, 0], abs=1e-12)
    assert leg.d == pytest.approx(np.zeros(6), abs=1e-12)
    craig = dh_table(nao, "LLeg", "modified")
    assert craig.a == pytest.approx(np.roll(leg.a, 1), abs=1e-12)
    assert craig.alpha == pytest.approx(np.roll(leg.alpha, 1), abs=1e-12)
    assert (leg.a >= 0.0).all()
    right = dh_table(nao, "RLeg")
    assert right.joints[0] == "RHipYawPitch"
    assert nao.joint_names[right.coordinates[0]] == "LHipYawPitch"


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_formula_gives_the_numbers(convention: DHConvention) -> None:
    sympy = pytest.importorskip("sympy")
    nao = nk.load_nao()
    q = nao.random(2)
    for frame in ("LArm", "CameraTop"):
        table = dh_table(nao, frame, convention)
        T = table.symbolic()
        assert {symbol.name for symbol in T.free_symbols} == set(table.joints)
        values = {symbol: nao.angles(q)[symbol.name] for symbol in T.free_symbols}
        assert np.abs(np.array(T.evalf(20, subs=values).tolist(), dtype=float) - nao.fk(q, frame)).max() < 1e-12
    head = dh_table(nao, "Head", convention).symbolic()
    yaw, pitch = sympy.symbols("HeadYaw HeadPitch", real=True)
    assert sympy.simplify(head[0, 0] - sympy.cos(yaw) * sympy.cos(pitch)) == 0
    assert head[2, 1] == 0


def test_what_has_no_table_is_refused() -> None:
    nao = nk.load_nao()
    with pytest.raises(BadArgument, match="no joint moves torso"):
        dh_table(nao, "torso")
    with pytest.raises(UnknownName, match="convention"):
        dh_table(nao, "LArm", "craig")  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="LArn"):
        dh_table(nao, "LArn")
    with pytest.raises(WrongShape):
        dh_table(nao, "LArm").fk([0.0] * 3)
