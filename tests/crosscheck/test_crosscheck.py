from __future__ import annotations

import inspect
import json
import logging
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin import crosscheck, rotations
from nao_kin.cli.app import run as run_program
from nao_kin.crosscheck.report import _OTHERS, LEFT_OUT, Row, Tally, angle_difference
from nao_kin.crosscheck.samples import sample_configurations
from nao_kin.crosscheck.steps import Step, StepKinematics, steps_of
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot.nao import nao_parameters

SOMEWHERE = {"xyz": (0.1, -0.2, 0.3), "rpy": (0.3, -0.5, 0.7)}


def row_of(report: crosscheck.Report, convention: str, against: str = "") -> Row:
    return next(row for row in report.rows if row.convention == convention and against in row.against)


@pytest.fixture(scope="module")
def report(nao: nk.NaoModel) -> crosscheck.Report:
    return crosscheck.run(nao, 120)


def test_every_version_agrees_with_everyone(each_nao: nk.NaoModel) -> None:
    report = crosscheck.run(each_nao, 30, seed=3)
    assert report.ok, report.failures
    assert row_of(report, "poses from elementary rotations", "yourdfpy").pairs == 30 * len(each_nao.frame_names)


@pytest.mark.full
def test_romeo_agrees_with_everyone() -> None:
    romeo = nk.load_robot("romeo")
    report = crosscheck.run(romeo, 30)
    assert report.ok, report.failures
    assert row_of(report, "poses from elementary rotations", "Pinocchio").pairs == 30 * len(romeo.frame_names)
    assert row_of(report, "travel of a coupled joint").pairs == 30 * len(romeo.mimics)


def test_every_frame_of_the_nao_has_a_pose_by_hand(nao: nk.NaoModel) -> None:
    assert {step.name for step in steps_of(nao)} == set(nao.frame_names)


def test_the_report_has_a_row_for_every_conversion(report: crosscheck.Report) -> None:
    conventions = [row.convention for row in report.rows]
    for sequence in rotations.SEQUENCES:
        for axes in ("moving", "fixed"):
            assert f"matrix_from_euler {sequence} {axes}" in conventions
            assert f"euler_from_matrix {sequence} {axes}" in conventions
    assert set(report.worst) == set(conventions)
    assert report.worst["log"].worst == max(row_of(report, "log", oracle).worst for oracle in ("Angle", "log3"))


def test_all_limits_are_compared_with_another_reader_of_the_file(report: crosscheck.Report) -> None:
    compared = {row.convention for row in report.rows if row.against == "yourdfpy"}
    assert compared >= {f"{kind} limits" for kind in ("lower", "upper", "velocity", "effort")} | {"mimics"}


def test_every_public_function_of_rotations_has_a_row_or_a_reason(report: crosscheck.Report) -> None:
    compared = {row.convention.split()[0] for row in report.rows}
    assert vars(crosscheck.Conversions()).keys() - compared == {"joint_axes"}
    offered = {name for name in rotations.__all__ if inspect.isfunction(getattr(rotations, name))}
    assert offered - compared == _OTHERS


def test_a_function_that_is_not_compared_is_refused() -> None:
    with pytest.raises(UnknownName, match="nearest: log"):
        crosscheck.Conversions(logs=rotations.log)


def test_every_stratum_has_its_share(report: crosscheck.Report) -> None:
    assert sum(report.strata.values()) == report.samples == 120
    assert list(report.strata) == [
        "zero",
        "inside",
        "limits",
        "right angles",
        "near right angles",
        "half turns",
        "beyond",
    ]
    assert all(count > 0 for count in report.strata.values())


def test_rows_say_where_the_worst_case_was(nao: nk.NaoModel, report: crosscheck.Report) -> None:
    row = row_of(report, "poses from elementary rotations", "Pinocchio")
    place = row.place
    assert place is not None
    walk = StepKinematics(steps_of(nao), nao.joint_names, crosscheck.Conversions())
    by_hand = walk.poses(np.array([place.q]))
    names = [step.name for step in steps_of(nao)]
    found = np.abs(by_hand[0, names.index(place.frame)] - nao.fk(place.q, place.frame)).max()
    assert found == pytest.approx(row.worst, abs=1e-17)
    assert 0.0 < row.worst < 1e-14


def test_equal_seeds_give_equal_reports(nao: nk.NaoModel) -> None:
    first, again, other = (crosscheck.run(nao, 6, seed=seed).as_dict() for seed in (5, 5, 6))
    assert first == again
    assert first != other


def test_the_report_is_plain_json(report: crosscheck.Report) -> None:
    document = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    assert document["ok"] is True
    assert len(document["rows"]) == len(report.rows)
    assert len(document["rows"][0]["configuration"]["q"]) == len(document["joint_names"]) == 25
    assert "all within tolerance" in str(report)


# --- what the configurations reach ------------------------------------------------------------------------------------


def test_the_configurations_are_sample_configurations(nao: nk.NaoModel) -> None:
    found = sample_configurations(nao, 400, seed=1)
    strata = np.array(found.kinds)
    q = {name: found.q[strata == name] for name in found.counts}
    assert not q["zero"].any()
    assert not nao.limit_violations(q["inside"])
    assert ((q["limits"] == nao.lower) | (q["limits"] == nao.upper)).all()
    assert (q["limits"] == nao.lower).any(axis=0).all()
    assert (q["limits"] == nao.upper).any(axis=0).all()
    assert (np.abs(q["right angles"]) == math.pi).any(axis=0).all()
    assert (np.abs(q["beyond"]) > 6.0).any()


@pytest.mark.parametrize("axes", ["moving", "fixed"])
def test_the_configurations_lock_every_sequence_and_come_close(nao: nk.NaoModel, axes: str) -> None:
    found = sample_configurations(nao, 500, seed=0)
    R = nao.rotation(found.q, ["HeadPitch", "LWristYaw", "RAnkleRoll", "CameraTop_optical_frame"]).reshape(-1, 3, 3)
    turned = np.abs(R - np.eye(3)).max(axis=(1, 2)) > 0.1
    for sequence in rotations.SEQUENCES:
        euler = rotations.euler_from_matrix(R, sequence, axes=axes)
        free = (np.abs(euler.angles[:, [0, 2]]).max(axis=1) > 0.1) & turned
        middle = euler.angles[:, 1]
        if sequence[0] == sequence[2]:
            distances = [middle, math.pi - middle]
        else:
            distances = [math.pi / 2 - middle, math.pi / 2 + middle]
        for distance in distances:
            assert (euler.locked & free & (distance < 1e-15)).any(), sequence
            assert ((distance > 1e-15) & (distance < 1e-4)).any(), sequence


def test_the_configurations_turn_frames_by_half_a_turn_and_nearly(nao: nk.NaoModel) -> None:
    R = nao.rotation(sample_configurations(nao, 300, seed=0).q).reshape(-1, 3, 3)
    short = math.pi - rotations.natural_invariants(R)[1]
    for lower, upper in ((-1e-15, 1e-14), (1e-14, 1e-8), (1e-8, 1e-3)):
        assert np.count_nonzero((short >= lower) & (short < upper)) > 20


def test_some_half_turns_are_about_general_axes(nao: nk.NaoModel) -> None:
    R = nao.rotation(sample_configurations(nao, 300, seed=0).q).reshape(-1, 3, 3)
    axis, angle = rotations.natural_invariants(R)
    general = np.abs(axis).min(axis=1) > 0.1
    assert np.count_nonzero(general & (np.abs(angle - math.pi) < 1e-14)) > 10
    assert np.count_nonzero(general & (np.abs(angle - math.pi) > 1e-14) & (np.abs(angle - math.pi) < 1e-4)) > 10


# --- what is left out, and why ----------------------------------------------------------------------------------------


def test_what_is_left_out_is_little_and_said(report: crosscheck.Report) -> None:
    full = row_of(report, "log", "pin.AngleAxis").pairs
    assert full == row_of(report, "exp").pairs
    for convention, against in (("log", "pin.log3"), ("matrix_from_linear", ""), ("slerp", "")):
        row = row_of(report, convention, against)
        assert 0.8 * full < row.pairs < full
        assert "left out" in row.note
    assert all(row.tolerance == 1e-12 for row in report.rows)


# --- other people's robots --------------------------------------------------------------------------------------------


def test_robots_of_every_kind_of_joint_agree(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a", axis=(1.0, -2.0, 3.0), **SOMEWHERE),
        J("b", kind="prismatic", axis=(0.0, -1.0, 0.0), **SOMEWHERE),
        J("c", kind="continuous", axis=(0.0, -1.0, 0.0)),
        J("d", kind="prismatic", follows=("b", -2.0, 0.1)),
        J("e", kind="fixed", **SOMEWHERE),
        J("f", follows=("c", 0.5, 0.3)),
    )
    report = crosscheck.run(robot, 60)
    assert report.ok, report.failures


def test_a_single_link_agrees(tmp_path: Path) -> None:
    path = tmp_path / "brick.urdf"
    path.write_text('<robot name="brick"><link name="brick"/></robot>')
    for samples in (1, 3):
        report = crosscheck.run(nk.RobotModel.from_urdf(path), samples)
        assert report.ok, report.failures


def test_a_robot_without_joints_agrees(tmp_path: Path) -> None:
    report = crosscheck.run(made_up(tmp_path, J("a", kind="fixed", **SOMEWHERE)), 3)
    assert report.ok, report.failures
    assert not [row.convention for row in report.rows if "joint" in row.convention or row.convention.startswith("rot_")]


def test_frames_that_yourdfpy_reads_otherwise_are_left_out_without_a_word_on_stderr(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    robot = made_up(
        tmp_path,
        J("a"),
        J("b", follows=("a", 2.0, 0.1)),
        J("c", axis=(1.0, 0.0, 0.0), follows=("b", -1.0, 0.2)),
        J("d"),
    )
    with caplog.at_level(logging.WARNING):
        report = crosscheck.run(robot, 10)
    assert not caplog.records
    row = row_of(report, "poses by Pinocchio", "yourdfpy")
    assert report.ok
    assert row.pairs == 10 * (len(robot.frame_names) - 4)
    assert row.note.startswith("4 frames left out")


def test_a_link_with_the_name_of_a_joint_is_found(tmp_path: Path) -> None:
    parts = '<link name="base"/><link name="A"/><link name="B"/>'
    for parent, child in (("base", "A"), ("A", "B")):
        parts += (
            f'<joint name="{child}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
            '<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="0 1 0"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    path = tmp_path / "clash.urdf"
    path.write_text(f'<robot name="clash">{parts}</robot>')
    report = crosscheck.run(nk.RobotModel.from_urdf(path), 10)
    assert report.ok, report.failures
    for reader in ("yourdfpy", "pin.buildModelFromUrdf"):
        assert row_of(report, "poses by Pinocchio", reader).pairs == 10 * 5


@pytest.mark.filterwarnings("ignore::nao_kin.errors.RenamedFrameWarning")
def test_a_name_of_a_link_and_of_a_joint_elsewhere_is_compared_as_the_link(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", axis=(0.0, 1.0, 0.0)))
    robot.urdf_path.write_text(robot.urdf_path.read_text(encoding="utf-8").replace('"a_l"', '"b"'), encoding="utf-8")
    report = crosscheck.run(nk.RobotModel.from_urdf(robot.urdf_path), 10)
    assert report.ok, report.failures


@pytest.mark.full
@pytest.mark.filterwarnings("ignore::nao_kin.errors.RenamedFrameWarning")
@pytest.mark.parametrize("name", sorted({*nk.robot_names()} - {"alex_psyonic_hands", "ur3"}))  # which are broken
def test_pinocchio_reads_the_files_of_example_robot_data_as_this_library_does(name: str) -> None:
    report = crosscheck.run(nk.load_robot(name), 3)
    assert report.ok, report.failures
    assert row_of(report, "poses by Pinocchio", "pin.buildModelFromUrdf").pairs > 0


# --- bad input --------------------------------------------------------------------------------------------------------


def test_a_floating_base_is_refused() -> None:
    with pytest.raises(BadArgument, match="fixed base"):
        crosscheck.run(nk.load_nao(base="floating"), 3)


@pytest.mark.parametrize(("samples", "seed"), [(0, 0), (-1, 0), (1.5, 0), ("many", 0), (1, -1), (1, None)])
def test_bad_numbers_are_refused(nao: nk.NaoModel, samples: object, seed: object) -> None:
    with pytest.raises(BadArgument, match=r"samples|seed"):
        crosscheck.run(nao, samples, seed)


def test_a_step_that_hangs_nowhere_is_refused(nao: nk.NaoModel) -> None:
    steps = steps_of(nao)
    with pytest.raises(UnknownName, match="frame 'Waist'"):
        crosscheck.run(nao, 3, steps=[steps[0], replace(steps[1], parent="Waist")])


# --- the parts --------------------------------------------------------------------------------------------------------


def test_angles_differ_modulo_a_turn() -> None:
    ours = np.array([math.pi - 1e-3, -math.pi, 0.1, 0.1 + 4.0 * math.pi])
    theirs = np.array([-math.pi + 1e-3, math.pi, 0.3, 0.1])
    assert np.allclose(angle_difference(ours, theirs), [2e-3, 0.0, 0.2, 0.0], atol=1e-14)


def test_a_row_that_compared_nothing_is_not_ok(nao: nk.NaoModel) -> None:
    row = Tally("a", "b").row(sample_configurations(nao, 1, 0))
    assert (row.pairs, row.worst, row.place, row.ok) == (0, 0.0, None, False)
    nothing_left = Tally("a", "b")
    nothing_left.add(np.full((1, 2), LEFT_OUT), 0, ["x", "y"])
    assert not nothing_left.row(sample_configurations(nao, 1, 0)).ok


def test_a_report_in_which_a_row_compared_nothing_is_not_ok(nao: nk.NaoModel) -> None:
    steps = [replace(step, name=f"_{step.name}", parent=step.parent and f"_{step.parent}") for step in steps_of_v6()]
    report = crosscheck.run(nao, 2, steps=steps)
    row = row_of(report, "poses from elementary rotations", "Pinocchio")
    assert row.pairs == 0
    assert row in report.failures


def steps_of_v6() -> tuple[Step, ...]:
    return crosscheck.steps_of_nao(nao_parameters("v6"))


def test_exponentials_are_taken_of_vectors_within_and_out_of_half_a_turn(nao: nk.NaoModel) -> None:
    lengths: list[np.ndarray] = []

    def watched(v: np.ndarray) -> np.ndarray:
        lengths.append(np.linalg.norm(v, axis=-1).reshape(20, -1))
        return rotations.exp(v)

    assert crosscheck.run(nao, 20, conversions=crosscheck.Conversions(exp=watched)).ok
    length = np.concatenate(lengths)
    for frames in (length[:, ::2], length[:, 1::2]):
        assert (frames > 2.0 * math.pi).any()
        assert ((frames > 0.1) & (frames < math.pi)).any()


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command_prints_the_cells_of_the_report(capsys: pytest.CaptureFixture, tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", axis=(0.0, 1.0, 0.0)))
    assert run_program(["check", "--urdf", str(robot.urdf_path), "--samples", "3"]) == 0
    printed = [line.split() for line in capsys.readouterr().out.splitlines()]
    report = crosscheck.run(robot, 3)
    text = [line.split() for line in str(report).splitlines()]
    for cells in (report.columns, *(row.cells for row in report.rows)):
        assert " ".join(cells).split() in printed
        assert " ".join(cells).split() in text


def test_the_command_prints_json_of_any_robot(capsys: pytest.CaptureFixture, tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", axis=(0.0, 1.0, 0.0)))
    arguments = ["check", "--urdf", str(robot.urdf_path), "--samples", "8", "--seed", "4", "--json"]
    assert run_program(arguments) == 0
    document = json.loads(capsys.readouterr().out)
    assert document == crosscheck.run(robot, 8, seed=4).as_dict()


@pytest.mark.parametrize("json_too", [True, False])
def test_the_command_fails_when_a_row_does(
    capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, json_too: bool
) -> None:
    robot = made_up(tmp_path, J("a"), J("b", axis=(0.0, 1.0, 0.0)))
    wrong = crosscheck.Conversions(log=lambda R: -rotations.log(R))
    true_run = crosscheck.run
    monkeypatch.setattr(crosscheck, "run", lambda *given, **named: true_run(*given, **named, conversions=wrong))
    arguments = ["check", "--urdf", str(robot.urdf_path), "--samples", "8"]
    assert run_program([*arguments, "--json"] if json_too else arguments) == 1
    out = capsys.readouterr().out
    if json_too:
        assert {row["convention"] for row in json.loads(out)["rows"] if not row["ok"]} == {"log"}
    else:
        assert "FAILS: log against pin.log3: " in out
        assert "\n2 of " in out


def test_progress_is_reported(nao: nk.NaoModel) -> None:
    reported: list[tuple[int, int]] = []
    crosscheck.run(nao, 3, progress=lambda done, total: reported.append((done, total)))
    assert reported == [(3, 3)]
