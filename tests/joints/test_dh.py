"""Denavit–Hartenberg tables beside forward kinematics and SymPy."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.joints import DHConvention, dh_table
from nao_kin.robot.nao import VERSIONS

FRAMES = ("LArm", "RArm", "LLeg", "RLeg", "Head", "CameraTop", "CameraBottom", "RFinger13_link")
CONVENTIONS = get_args(DHConvention)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_product_of_the_table_is_the_pose_of_every_version_and_when_calibrated(convention: DHConvention) -> None:
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
    for frame in ("LElbow", "CameraTop"):
        table = dh_table(nao, frame, convention)
        T = table.symbolic()
        assert {symbol.name for symbol in T.free_symbols} == set(table.joints)
        values = {symbol: nao.angles(q)[symbol.name] for symbol in T.free_symbols}
        assert np.abs(np.array(T.evalf(20, subs=values).tolist(), dtype=float) - nao.fk(q, frame)).max() < 1e-12
    head = dh_table(nao, "Head", convention).symbolic()
    yaw, pitch = sympy.symbols("HeadYaw HeadPitch", real=True)
    assert sympy.simplify(head[0, 0] - sympy.cos(yaw) * sympy.cos(pitch)) == 0
    assert head[2, 1] == 0


# π/2 and π as files write them.
ROUNDINGS = ("1.57", "1.5708", "1.570796", "1.57079633", "1.570796327", "1.5707963267948966", "3.14159", "3.14159265")


def arm(path: Path, joints: list[tuple[str, str, str]]) -> nk.RobotModel:
    """An arm of revolutes with these xyz, rpy and axes."""
    links = "".join(f'<link name="l{i}"/>' for i in range(len(joints) + 1))
    rest = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
        '<limit lower="-6" upper="6" effort="1" velocity="1"/></joint>'
        for i, (xyz, rpy, axis) in enumerate(joints)
    )
    path.write_text(f'<robot name="r">{links}{rest}</robot>')
    return nk.RobotModel.from_file(path)


def product(rows: list[dict[str, Any]], convention: DHConvention, q: np.ndarray) -> np.ndarray:
    """The product of a table of turning joints, by the names of its columns and screws about z and x."""
    T = np.eye(4)
    for row, value in zip(rows, q, strict=True):
        about_z = nk.screws.exp([0, 0, row["d"], 0, 0, row["theta"] + value])
        about_x = nk.screws.exp([row["a"], 0, 0, row["alpha"], 0, 0])
        T = T @ (about_z @ about_x if convention == "classic" else about_x @ about_z)
    return T


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("one", ["1.57079633 0 0", "1.5707963 0 0", "1.5708 0 0"])
def test_axes_that_a_file_leaves_almost_parallel_are_parallel(
    one: str, convention: DHConvention, tmp_path: Path
) -> None:
    joints = [("0 0 0", "0 0 0", "0 0 1"), ("0.3 0.2 0", one, "0 1 0"), ("0.3 0 0.2", "-1.570796327 0 0", "0 0 1")]
    robot = arm(tmp_path / "r.urdf", joints)
    table = dh_table(robot, "l3", convention)
    q = np.array([0.3, -0.7, 1.1])
    apart = np.abs(table.base @ product(table.as_dict()["rows"], convention, q) @ table.tool - robot.fk(q, "l3"))
    assert apart[:3, 3].max() < 2.0 * table.residual[0] < 1e-5
    assert apart.max() < 2.0 * table.residual.max() + 1e-12 < 2e-5
    assert np.abs(table.d).max() < 1.0
    assert "j1" in table.notes[0]
    assert table.as_dict()["notes"] == list(table.notes)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_no_table_differs_from_the_robot_by_more_than_it_says(convention: DHConvention, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for _ in range(30):
        signs, zero = ["", "-"], rng.random((6, 2, 3)) < 0.5
        xyz = np.where(zero[:, 0], 0.0, rng.uniform(-0.3, 0.3, (6, 3)).round(2)).astype(str)
        rpy = np.where(zero[:, 1], "0", np.char.add(rng.choice(signs, (6, 3)), rng.choice(ROUNDINGS, (6, 3))))
        axes = rng.choice(["0 0 1", "0 1 0", "1 0 0"], 6)
        rows = [(" ".join(p), " ".join(angles), axis) for p, angles, axis in zip(xyz, rpy, axes, strict=True)]
        robot = arm(tmp_path / "r.urdf", rows)
        table = dh_table(robot, "l6", convention)
        q = robot.random(1, 20)
        apart = np.abs(table.fk(q) - robot.fk(q, "l6")).max()
        assert apart < (3.0 * table.residual.max() if table.notes else 1e-11)
        assert table.residual.max() < 1e-4
        assert np.abs(table.d).max() < 1e3  # 1.57 and 1.5708 are 8e-4 rad apart, and not taken for the same


def test_axes_that_meet_near_the_robot_are_exact_however_small_the_angle(tmp_path: Path) -> None:
    rows = [("0 0 0", "0 0 0", "0 1 0"), ("0.3 0.2 0", "0.000004 0 0", "0 1 0"), ("0.1 0 0", "0 0 0", "1 0 0")]
    table = dh_table(arm(tmp_path / "r.urdf", rows), "l3")
    assert table.alpha[0] == pytest.approx(4e-6, rel=1e-6)
    assert np.abs(table.d).max() < 1.0
    assert table.residual.max() < 1e-14
    assert table.notes == ()


def test_offsets_of_joints_change_no_length_and_no_angle_between_axes() -> None:
    nao = nk.load_nao()
    table = dh_table(nao, "LArm")
    offsets = dict(zip(table.joints, (0.03, -0.02, 0.01, 0.035, -0.03), strict=True))
    calibrated = dh_table(nao.with_offsets(joints=offsets), "LArm")
    for one, other in ((table.a, calibrated.a), (table.alpha, calibrated.alpha), (table.d, calibrated.d)):
        assert one == pytest.approx(other, abs=1e-15)
    turned = np.angle(np.exp(1j * (calibrated.theta - table.theta)))
    # Those of the ends are in the constants there.
    assert np.abs(turned) == pytest.approx([0.0, 0.02, 0.01, 0.035, 0.0], abs=1e-12)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_columns_of_the_document_mean_what_their_names_say(convention: DHConvention) -> None:
    robot = nk.load_nao()
    document = dh_table(robot, "LLeg", convention).as_dict()
    q = robot.posture("Crouch")
    values = np.array([robot.angles(q)[row["joint"]] for row in document["rows"]])
    T = np.array(document["base"]) @ product(document["rows"], convention, values) @ np.array(document["tool"])
    assert pytest.approx(robot.fk(q, "LLeg"), abs=1e-12) == T
    assert {row["kind"] for row in document["rows"]} == {"revolute"}
    assert max(document["residual"].values()) < 1e-12


def test_the_command_says_which_axes_count_as_parallel(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    joints = [("0 0 0", "1.5708 0 0", "0 0 1"), ("0 0.1 0.2", "0.000004 0 0", "0 0 1")]
    arm(tmp_path / "r.urdf", joints)
    assert run(["joints", "--dh", "l2", "--urdf", str(tmp_path / "r.urdf"), "--json", "--deg"]) == 0
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert document["notes"][0] in err
    assert np.degrees(4e-6) < document["residual"]["rotation"] < np.degrees(1e-5)


def test_the_table_of_latex_and_of_csv_has_the_same_numbers(nao: nk.NaoModel, capsys: pytest.CaptureFixture) -> None:
    table = dh_table(nao, "LLeg", "modified")
    assert run(["joints", "--dh", "LLeg", "--modified", "--csv", "--deg"]) == 0
    head, *rows = csv.reader(io.StringIO(capsys.readouterr().out))
    assert head == ["joint", "a [m]", "alpha [deg]", "d [m]", "theta [deg]"]
    numbers = np.array([row[1:] for row in rows], dtype=float)
    assert tuple(row[0] for row in rows) == table.joints
    assert np.allclose(np.radians(numbers[:, [1, 3]]), np.stack([table.alpha, table.theta], axis=-1))
    assert np.array_equal(numbers[:, [0, 2]], np.stack([table.a, table.d], axis=-1))
    assert run(["joints", "--dh", "LLeg", "--modified", "--latex"]) == 0
    latex = capsys.readouterr().out
    assert latex == table.as_latex() + "\n"
    assert r"LHipRoll & $0$ & $\pi/2$ & $0$ & $-3\pi/4$ \\" in latex
    assert r"LKneePitch & $0.1$ & $0$ & $0$ & $0$ \\" in latex
    assert r"E = \begin{bmatrix} 0 & 0 & -1 & 0.04511 \\" in latex


def test_a_table_cannot_be_changed() -> None:
    table = dh_table(nk.load_nao(), "LArm")
    for array in (table.a, table.alpha, table.d, table.theta, table.base, table.tool, table.coordinates):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_a_floating_base_moves_no_table() -> None:
    fixed, floating = nk.load_nao(), nk.load_nao(base="floating")
    assert np.array_equal(dh_table(fixed, "RArm").theta, dh_table(floating, "RArm").theta)
    assert dh_table(floating, "RArm").residual.max() < 1e-12


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
