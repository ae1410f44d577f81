from __future__ import annotations

import csv
import dataclasses
import io
import json
import math
import os
import re
import signal
import struct
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from command_line import Capture, refused_line as _refused
from loops import for_all

import nao_kin as nk
from nao_kin.cli import options
from nao_kin.cli.app import run
from nao_kin.cli.options import RobotOptions
from nao_kin.cli.output import fixed, print_note
from nao_kin.cli.parsing import options_of
from nao_kin.cli.slips import mended
from nao_kin.errors import NaoKinWarning


def _json(capsys: Capture, *arguments: str) -> dict:
    assert run(arguments) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return json.loads(out)


def test_all_commands_name_a_robot_by_the_same_options() -> None:
    of_robots = tuple(field.name for field in dataclasses.fields(RobotOptions))
    fewer = dict.fromkeys(("doctor", "sample", "warmup"), ()) | dict.fromkeys(
        ("serve", "run", "live"), ("nao", "offsets")
    )
    fewer["export"] = tuple(name for name in of_robots if name != "package_dir")
    for name in options.COMMANDS:
        taken = [option for option in options_of(name)[0] if option in of_robots]
        assert tuple(taken) == fewer.get(name, of_robots), name


def test_the_forms_of_poses_are_those_of_the_library() -> None:
    assert options_of("fk")[0]["as_"].choices == get_args(nk.robot.PoseForm)


@pytest.mark.parametrize("command", options.COMMANDS)
def test_every_command_has_help_with_an_example(capsys: Capture, command: str) -> None:
    assert run([*command.split(), "--help"]) == 0
    out = capsys.readouterr().out
    assert f"Example: nao-kin {command}" in " ".join(out.split())
    assert "--json" in out or command == "run"


def test_help_groups_commands_and_the_options_of_a_robot(capsys: Capture) -> None:
    assert run(["--help"]) == 0
    _, *jobs = re.split(r"^(?=\S.*:$)", capsys.readouterr().out, flags=re.M)
    assert [job.partition(":")[0] for job in jobs][:3] == [
        "Options",
        "A robot",
        "A robot on the floor, its cameras and logs",
    ]
    listed = [line.split()[0] for job in jobs[1:] for line in job.splitlines() if re.match(r"  \w", line)]
    assert sorted({name.split()[0] for name in options.COMMANDS}) == sorted(set(listed) - {"Example:"})
    assert run(["info", "--help"]) == 0
    own, robots = capsys.readouterr().out.split("\nRobot:\n")
    flags = [f"--{field.name.replace('_', '-')} " for field in dataclasses.fields(RobotOptions)]
    assert all(flag in robots and flag not in own for flag in flags)
    assert "--json" in own


def test_the_program_prints_its_version_and_its_commands(capsys: Capture) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.strip() == nk.__version__
    assert run(["--help"]) == 0
    assert all(command in capsys.readouterr().out for command in ("fk",))


def test_fk_gives_the_poses_of_the_library(capsys: Capture, nao: nk.NaoModel) -> None:
    document = _json(
        capsys, "fk", "--posture", "StandInit", "--frame", "LArm", "--frame", "CameraTop", "--json", "--as", "matrix"
    )
    q = nao.posture("StandInit")
    assert document["robot"] == "nao_v6"
    assert np.array_equal(document["poses"]["LArm"], nao.fk(q, "LArm"))
    assert np.array_equal(document["poses"]["CameraTop"], nao.fk(q, "CameraTop"))


def test_fk_by_default_answers_where_hands_feet_and_cameras_are(capsys: Capture) -> None:
    poses = _json(capsys, "fk", "--json")["poses"]
    assert list(poses) == ["Head", "LArm", "RArm", "LLeg", "RLeg", "CameraTop", "CameraBottom"]
    assert poses["LArm"]["x"] == pytest.approx(0.2187)


def test_numbers_have_five_decimals_and_zero_no_sign() -> None:
    assert [fixed(value) for value in (-4e-6, -0.0, 0.123456, -1.0)] == ["0.00000", "0.00000", "0.12346", "-1.00000"]


def test_joints_are_set_on_top_of_a_posture(capsys: Capture, nao: nk.NaoModel) -> None:
    arguments = (
        "fk",
        "--posture",
        "Sit",
        "--joint",
        "RHipYawPitch=-0.3",
        "--joint",
        "HeadYaw=0.2",
        "--json",
        "--as",
        "matrix",
    )
    poses = _json(capsys, *arguments)["poses"]
    q = nao.configuration({**nao.angles(nao.posture("Sit")), "LHipYawPitch": -0.3, "HeadYaw": 0.2})
    assert np.array_equal(poses["LLeg"], nao.fk(q, "LLeg"))
    assert np.array_equal(poses["CameraTop"], nao.fk(q, "CameraTop"))


def test_degrees_go_in_and_come_out(capsys: Capture) -> None:
    arguments = ("--joint", "HeadYaw=20", "--joint", "LHand=0.5", "--frame", "Head", "--json")
    pose = _json(capsys, "fk", "--deg", *arguments)["poses"]["Head"]
    assert pose["yaw_deg"] == pytest.approx(20.0)
    assert "yaw" not in pose


@pytest.mark.parametrize(
    ("style", "names"),
    [
        ("rpy", ["x", "y", "z", "roll", "pitch", "yaw"]),
        ("quaternion", ["x", "y", "z", "r0", "r1", "r2", "r3"]),
    ],
)
def test_every_style_of_a_pose_describes_the_same_pose(
    capsys: Capture, nao: nk.NaoModel, style: str, names: list[str]
) -> None:
    pose = _json(capsys, "fk", "--posture", "Crouch", "--frame", "RLeg", "--as", style, "--json")["poses"]["RLeg"]
    assert list(pose) == names
    T = nao.fk(nao.posture("Crouch"), "RLeg")
    numbers = list(pose.values())
    assert np.array_equal(numbers[:3], T[:3, 3])
    if style == "quaternion":
        R = nk.rotations.matrix_from_quat(numbers[3:])
    else:
        R = nk.rotations.matrix_from_rpy(numbers[3:])
    assert np.allclose(R, T[:3, :3], atol=1e-15)


def test_a_reference_frame_can_be_named(capsys: Capture, nao: nk.NaoModel) -> None:
    arguments = ("fk", "--posture", "Stand", "--frame", "Head", "--reference", "LLeg", "--as", "matrix", "--json")
    document = _json(capsys, *arguments)
    assert document["reference"] == "LLeg"
    assert np.array_equal(document["poses"]["Head"], nao.fk(nao.posture("Stand"), "Head", reference="LLeg"))


@pytest.mark.full
@pytest.mark.parametrize("width", [40, 60, 80])
def test_a_narrow_terminal_cuts_nothing(width: int) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _IN_A_TERMINAL, str(width)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert "…" not in done.stdout.replace(" … ", "")  # ranges are written a … b
    poses, quaternions, joints, info = done.stdout.split("ENDED")[:-1]
    for printed in (poses, quaternions):
        assert "CameraTop" in printed
        assert "CameraBottom" in printed
    assert "HeadYaw" in joints
    assert "nao_v6" in info


_IN_A_TERMINAL = """
import fcntl, os, pty, struct, sys, termios
child, terminal = pty.fork()
if child == 0:
    fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 24, int(sys.argv[1]), 0, 0))
    from nao_kin.cli.app import run
    for words in (["fk"], ["fk", "--as", "quaternion"], ["joints"], ["info"]):
        assert run(words) == 0
        print("ENDED", flush=True)
    sys.exit()
try:
    while data := os.read(terminal, 65536):
        os.write(1, data)
except OSError:
    pass
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--joint", "LHipYawPitch=5", "--joint", "RHipYawPitch=10"), "LHipYawPitch = 5° drives RHipYawPitch"),
        (("--joint", "HeadYaw=200"), "HeadYaw = 200 not in [-119.5, 119.5]°"),
        (("--joint", "HeadYaw=62.45", "--joint", "HeadPitch=25"), "not in [-24.64, 17.19]° at HeadYaw = 62.45"),
    ],
)
def test_errors_speak_degrees_to_those_who_do(capsys: Capture, arguments: tuple[str, ...], message: str) -> None:
    assert message in _refused(capsys, "fk", "--deg", *arguments)


def test_a_joint_that_follows_one_of_another_kind_keeps_its_own_unit(capsys: Capture, tmp_path: Path) -> None:
    joint = (
        '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/>{4}</joint>'
    )
    slide = joint.format("slide", "prismatic", "a", "b", "")
    turn = joint.format("turn", "revolute", "b", "c", '<mimic joint="slide" multiplier="2"/>')
    path = tmp_path / "r.urdf"
    path.write_text(f'<robot name="r"><link name="a"/><link name="b"/><link name="c"/>{slide}{turn}</robot>')
    pose = _json(capsys, "fk", "--urdf", str(path), "--deg", "--joint", "turn=10", "--frame", "c", "--json")["poses"][
        "c"
    ]
    assert pose["yaw_deg"] == pytest.approx(10.0)
    assert pose["z"] == pytest.approx(math.radians(10.0) / 2)


@pytest.fixture
def trajectory(nao: nk.NaoModel, tmp_path: Path) -> Path:
    path = tmp_path / "walk.csv"
    q = nao.random(0, 5)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(nao.joint_names)
        writer.writerows(q.tolist())
    return path


def test_a_file_gives_one_result_per_row(capsys: Capture, nao: nk.NaoModel, trajectory: Path) -> None:
    document = _json(capsys, "fk", str(trajectory), "--frame", "LArm", "--as", "matrix", "--json")
    got = [configuration["LArm"] for configuration in document["configurations"]]
    assert np.array_equal(got, nao.fk(nao.random(0, 5), "LArm"))


def _printed_csv(capsys: Capture, trajectory: Path) -> np.ndarray:
    assert run(["fk", str(trajectory), "--frame", "LArm", "--frame", "RLeg", "--as", "matrix", "--csv"]) == 0
    rows = list(csv.reader(io.StringIO(capsys.readouterr().out)))
    assert rows[0][:4] == ["row", "frame", "t11", "t12"]
    assert [row[:2] for row in rows[1:5]] == [["0", "LArm"], ["0", "RLeg"], ["1", "LArm"], ["1", "RLeg"]]
    return np.array([row[2:] for row in rows[1:]], dtype=float).reshape(5, 2, 4, 4)


def test_csv_output_reads_back(capsys: Capture, nao: nk.NaoModel, trajectory: Path) -> None:
    assert np.array_equal(_printed_csv(capsys, trajectory), nao.fk(nao.random(0, 5), ["LArm", "RLeg"]))


@pytest.mark.parametrize(("chunk", "threads"), [(5, None), (2, 1)], ids=["by Pinocchio", "by the kernels"])
def test_long_files_are_worked_through_in_pieces(
    capsys: Capture,
    nao: nk.NaoModel,
    trajectory: Path,
    monkeypatch: pytest.MonkeyPatch,
    chunk: int,
    threads: int | None,
) -> None:
    monkeypatch.setattr("nao_kin.cli.fk._CHUNK", chunk)
    poses = nao.fk(nao.random(0, 5), ["LArm", "RLeg"], threads=threads)
    assert np.array_equal(_printed_csv(capsys, trajectory), poses)


def test_the_table_shows_units_and_no_negative_zero(capsys: Capture) -> None:
    assert run(["fk", "--frame", "RArm", "--deg"]) == 0
    out = capsys.readouterr().out
    assert out.count("[m]") == out.count("[°]") == 3
    assert "-0.00000" not in out
    assert run(["fk", "--frame", "RArm", "--as", "matrix"]) == 0
    assert "origin" in capsys.readouterr().out


def test_limits_can_be_clamped_or_ignored(capsys: Capture, nao: nk.NaoModel) -> None:
    wrong = ("fk", "--joint", "HeadYaw=3", "--frame", "Head", "--json")
    assert "HeadYaw = 3 not in [-2.08567, 2.08567] rad" in _refused(capsys, *wrong)
    assert _json(capsys, *wrong, "--limits", "clamp")["poses"]["Head"]["yaw"] == pytest.approx(nao.upper[0])
    assert _json(capsys, *wrong, "--limits", "ignore")["poses"]["Head"]["yaw"] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("fk", "--joint", "HeadYew=1"), "unknown joint 'HeadYew' (nearest: HeadYaw"),
        (
            ("info", "--robot", "robots/nao.urdf"),
            "a file is read with RobotModel.from_file, and on the command line with --urdf",
        ),
        (("fk", "--joint", "HeadYaw=a"), "expected NAME=VALUE with a number"),
        (("fk", "--joint", "HeadYaw=1", "--joint", "HeadYaw=2"), "--joint names HeadYaw twice"),
        (("fk", "--csv", "--json"), "--csv and --json exclude each other"),
        (("fk", "--as", "rpy", "--as", "matrix", "--as=rpy"), "--as is given 3 times; give it once"),
        (("fk", "--urdf", "a", "--nao", "v6"), "--nao and --urdf exclude each other"),
        (("fk", "--joint", "HeadYaw=1e400", "--limits", "ignore"), "expected NAME=VALUE with a number"),
        (("fk", ""), "no file name"),
        (("info", "--urdf", ""), "--urdf is empty"),
        (("info", "--urdf", "-"), "--urdf does not read standard input as -; give /dev/stdin, or the path"),
        (("info", "--urdf", "a", "--robot", "b"), "give one"),
        (("fk", "--robot", "ur10_robot", "--posture", "Stand"), "unknown posture 'Stand' (there are none)"),
        (("fk", "--as", "euler"), "--as 'euler': expected one of matrix, "),
        (("fk", "--bogus"), "no such option: --bogus (see nao-kin fk --help)"),
        (("fk", "--fram", "LArm"), "no such option: --fram (nearest: --frame"),
        (("motion", "convert", "a.csv", "b.csv", "--mirrored"), "no such option: --mirrored (nearest: --mirror)"),
        (("export",), "give one file or folder to write, as OUT or with --output"),
        (("motion", "plot", "a.csv", "b.png", "-o", "c.png"), "give one file or folder to write, as OUT or with"),
        (("view", "--camera", "CameraTop", "--html", "nao.html"), "a page shows it with Camera view"),
        (("view", "-o", "nao.jpg"), "--output nao.jpg: expected one .html, .png, .webm or .zip file"),
        (("view", "-o", "a.html", "--html", "b.html"), "--output a.html: expected one .html, .png, .webm or .zip file"),
        (("ik", "LArm", "--target", "1 2 3", "--limits", "clamp"), "--limits 'clamp': expected one of enforce, ignore"),
        (("bogus",), "no such command 'bogus' (see nao-kin --help)"),
        (("FK",), "no such command 'FK' (nearest: fk"),
        (("fk", "--posture"), "Option '--posture' requires an argument"),
        (("joints", "x" * 300), "(xxx"),
        (("dh", "LArm"), "no such command 'dh' (that is nao-kin joints --dh FRAME)"),
        (("joints", "--dh", "LArm", "--typed"), "--dh and --typed exclude each other"),
        (("joints", "--latex"), "--latex needs --dh"),
        (("fk", "--frame", ""), "--frame is empty"),
        (("calibrate", "photos/"), "'photos' is no file; the option is --photos"),
        (("view", "walk.csv", "--fps", "0"), "--fps 0: expected a number above zero"),
        (("info", "--compare", "v7"), "unknown NAO version 'v7'"),
        (("camera", "--resolution", "640by480"), "unknown resolution of CameraTop '640by480'"),
        (("reach", "LArm", "--by", "mean"), "--by needs --html or --output"),
        (("ik", "LLeg", "a.csv", "b.csv"), "nexpected extra argument"),
        (("fk", "LArm", "0", "0"), "'0' is a number, expected a file; --joint NAME=VALUE sets a joint"),
        (("ik", "LArm", "0.1", "0.2"), "--target '0.1 0.2': 2 numbers"),
        (("limits",), "no such command 'limits' (that is nao-kin joints)"),
        (("sta",), "no such command 'sta' (nearest: state)"),
        (("motion", __file__), "(a command comes before a file"),
        (("--nao", "v5", "fk"), "no such option: --nao (the options of a command stand after it)"),
        (("fk", "--quaternion"), "no such option: --quaternion (nearest: --as quaternion)"),
        (("fk", "--ref", "Head"), "no such option: --ref (nearest: --reference)"),
        (("ik", "LArm", "--xyz", "0.1", "0.2", "0.3"), "no such option: --xyz"),
        (("fk", "--format", "json"), "'json' is no file; the option is --json"),
        (("fk", "larm"), "unknown frame 'larm' (nearest: LArm"),
        (("fk", __file__, "out.csv"), "2 files; several files need --output, which names the file to write"),
        (("fk", "--robot", "v5"), "load_nao loads a NAO, and on the command line --nao"),
        (("ik", "LArm", "--target", "15 12 5 cm"), "'cm' is not a finite number; units are not written"),
        (("reach", "LArm", "--html", "r.html", "--by", "manipulability"), "best and mean manipulability"),
        (("reach", "LArm", "--voxel", "10"), "voxel = 10 m is wider than the whole reach of LArm, 0.442 m"),
        (("info", "LArm"), "nexpected extra argument"),
    ],
)
def test_bad_input_is_one_line_on_standard_error(capsys: Capture, arguments: tuple[str, ...], message: str) -> None:
    assert message in _refused(capsys, *arguments)


def test_versions_are_compared_number_by_number(capsys: Capture) -> None:
    document = _json(capsys, "info", "--nao", "v3.2", "--compare", "v6", "--json", "--deg")
    one, other = nk.load_nao("v3.2"), nk.load_nao("v6")
    assert document["robots"] == [one.name, other.name]
    found = document["differences"]
    assert found["mass [kg]"] == [[one.mass], [other.mass]]
    assert found["place of LElbowYaw [mm]"] == [[90.0, 0.0, 0.0], [105.0, 15.0, 0.0]]
    k = one.joint_names.index("LElbowRoll")
    ranges = [[np.degrees(robot.lower[k]), np.degrees(robot.upper[k])] for robot in (one, other)]
    assert np.allclose(found["range of LElbowRoll [°]"], ranges)
    assert np.allclose(found["roll, pitch, yaw of CameraBottom [°]"], [[0.0, 40.0, 0.0], [0.0, 39.7, 0.0]], atol=0.01)
    assert "place of LHipRoll [mm]" not in found  # it is the same
    assert run(["info", "--nao", "v3.2", "--compare", "v6"]) == 0
    table = capsys.readouterr().out
    assert "90 0 0" in table


@for_all(
    ("slip", "meant"),
    [
        ("ik LArm --target 0.15 -0.12 0.05", "ik|LArm|--target|0.15 -0.12 0.05"),
        ("camera CameraTop --pixel 320 240", "camera|CameraTop|--pixel|320 240"),
        ("balance --gravity 0 0 -1", "balance|--gravity|0 0 -1"),
        ("fk --joint HeadYaw 0.3 --joint HeadPitch=-0.1", "fk|--joint|HeadYaw=0.3|--joint|HeadPitch=-0.1"),
        ("fk --frame LArm RArm --deg", "fk|--frame|LArm,RArm|--deg"),
        ("fk LArm RArm", "fk|--frame|LArm|--frame|RArm"),
        ("info V5", "info|--nao|v5"),
        ("info v5 v6", "info|--nao|v5|--compare|v6"),
        ("fk HeadYaw=0.3 HeadPitch=0.1", "fk|--joint|HeadYaw=0.3|--joint|HeadPitch=0.1"),
        ("fk --joint HeadYaw=0.3,HeadPitch=0.1", "fk|--joint|HeadYaw=0.3|--joint|HeadPitch=0.1"),
        ("fk Stand larm", "fk|--posture|Stand|--frame|larm"),
        ("balance Sit", "balance|--posture|Sit"),
        ("fk missing.csv", "fk|missing.csv"),
        ("ik LArm 0.15 0.12 0.05", "ik|LArm|--target|0.15 0.12 0.05"),
        ("ik --frame LArm --target 0.15 0.12 0.05", "ik|LArm|--target|0.15 0.12 0.05"),
        ("ik LArm —target “0.15 0.12 0.05”", "ik|LArm|--target|0.15 0.12 0.05"),
        ("fk -deg -–frame=LArm", "fk|--deg|--frame=LArm"),
        (f"info {nk.load_nao().urdf_path}", f"info|--urdf|{nk.load_nao().urdf_path}"),
        ("ik LArm --xyz 0.15 0.12", "ik|LArm|--xyz|0.15|0.12"),
        ("ik LArm -0.15 0.12 0.05", "ik|LArm|--target|-0.15 0.12 0.05"),
        ("ik LArm --target=0.15 0.12 0.05", "ik|LArm|--target|0.15 0.12 0.05"),
    ],
)
def test_numbers_without_quotes_and_names_without_options_are_what_they_can_only_be(slip: str, meant: str) -> None:
    command, *words = slip.split()
    assert [command, *mended(words, options_of(command)[0])] == meant.split("|")


def test_a_file_may_be_called_like_a_frame(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.chdir(tmp_path)
    Path("LArm").write_text("HeadYaw\n0.1\n")
    assert run(["fk", "LArm", "--missing", "Stand", "--frame", "Head", "--json"]) == 0
    assert '"configurations"' in capsys.readouterr().out


def test_h_is_help_everywhere(capsys: Capture) -> None:
    for words in ((), ("fk",), ("motion",), ("motion", "check")):
        assert run([*words, "--help"]) == 0
        expected = capsys.readouterr().out
        assert run([*words, "-h"]) == 0
        assert capsys.readouterr().out == expected
        assert "-h, --help" in expected


def test_the_nao_is_a_robot_by_name_too(capsys: Capture) -> None:
    assert _json(capsys, "info", "--robot", "nao", "--json") == _json(capsys, "info", "--json")


@pytest.mark.parametrize(
    "arguments",
    [
        ("fk", "--joint", "HeadYaw=" + "1" * 5000),
        ("fk", "--joint", f"{'x' * 5000}=1", "--joint", f"{'x' * 5000}=1"),
        ("fk", "--frame", "x y " * 5000),
        ("fk", "--" + "x" * 5000),
        ("x" * 5000,),
        ("view", "--html", "x" * 5000),
    ],
    ids=lambda arguments: arguments[1][:9] if arguments[1:] else "command",
)
def test_messages_repeat_little_of_what_was_given(capsys: Capture, arguments: tuple[str, ...]) -> None:
    message = _refused(capsys, *arguments)
    assert max(message.count("x"), message.count("1")) <= 210
    assert len(message) < 500


def _warned(*arguments: object, **options: object) -> nk.NaoModel:
    for _ in range(2):
        warnings.warn("careful:\ntwo lines", NaoKinWarning, stacklevel=2)
    return nk.NaoModel()


@pytest.mark.parametrize("command", [("info",), ("view", "--html", "x")])
def test_a_warning_is_printed_once_as_one_line(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("nao_kin.robot.load_nao", _warned)
    assert run([*command, "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == "nao-kin: careful: two lines\n"
    assert json.loads(out)


def test_warnings_of_others_are_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nao_kin.robot.load_nao", lambda version: warnings.warn("not ours", UserWarning, stacklevel=1))
    with pytest.raises(UserWarning, match="not ours"):
        run(["info"])


@pytest.mark.parametrize("limits", [(), ("--limits", "clamp"), ("--limits", "ignore")])
def test_joints_on_a_posture_face_limits_as_a_whole(capsys: Capture, nao: nk.NaoModel, limits: tuple[str, ...]) -> None:
    # Inside its own range, but not with the head pitched as the posture has it.
    arguments = ("fk", "--posture", "Sit", "--joint", "HeadYaw=1.1", "--joint", "HeadPitch=0.4", "--frame", "Head")
    q = nao.configuration({**nao.angles(nao.posture("Sit")), "HeadYaw": 1.1, "HeadPitch": 0.4}, limits="ignore")
    if limits:
        poses = _json(capsys, *arguments, *limits, "--as", "matrix", "--json")["poses"]
        assert np.array_equal(poses["Head"], nao.fk(nao.clamp(q) if limits == ("--limits", "clamp") else q, "Head"))
    else:
        assert "HeadPitch = 0.4 not in" in _refused(capsys, *arguments)


def test_a_bad_row_prints_nothing_of_the_good_ones(capsys: Capture, trajectory: Path) -> None:
    trajectory.write_text(trajectory.read_text().rstrip() + ",1\n")
    for output in ("--json", "--csv"):
        assert "line 6: 26 values" in _refused(capsys, "fk", str(trajectory), output)


def test_info_describes_nao_and_others(capsys: Capture) -> None:
    nao = _json(capsys, "info", "--nao", "v5", "--json")
    assert (nao["degrees_of_freedom"], nao["version"], len(nao["postures"])) == (25, "v5", 8)
    romeo = _json(capsys, "info", "--robot", "romeo", "--json")
    assert romeo["degrees_of_freedom"] == 33
    assert len(romeo["load_notes"]) > 0
    assert run(["info"]) == 0
    assert "StandInit" in capsys.readouterr().out


def test_joints_lists_every_joint_with_its_line_and_its_limits(capsys: Capture, nao: nk.NaoModel) -> None:
    document = _json(capsys, "joints", "--deg", "--json")
    rows = {row["joint"]: row for row in document["rows"]}
    assert list(rows) == [name for chain in nao.chains.values() for name in chain]
    assert document["summary"] == "25 DOF = 26×1 − 1"
    assert rows["HeadYaw"]["upper"] == pytest.approx([119.5])
    assert (rows["LHand"]["lower"], rows["LHand"]["upper"], rows["LHand"]["units"]) == ([0.0], [1.0], ["1"])
    assert rows["LHipYawPitch"]["followed_by"] == ["RHipYawPitch"]
    assert rows["RHipYawPitch"]["velocity"] == rows["LHipYawPitch"]["velocity"]
    assert rows["HeadPitch"]["screws"] == [[0.0, 1.0, 0.0, -0.1265, 0.0, 0.0]]
    assert rows["RKneePitch"]["velocity"] == pytest.approx([math.degrees(6.40239)])
    assert run(["joints"]) == 0
    out = capsys.readouterr().out
    assert "RHipYawPitch (with LHipYawPitch)" in out
    assert out.rstrip().endswith("25 DOF = 26×1 − 1")


def test_joints_can_be_merged_into_lower_pairs(capsys: Capture) -> None:
    document = _json(capsys, "joints", "--typed", "--json")
    assert len(document["rows"]) == 15
    assert document["summary"] == "25 DOF = 2×3 + 7×2 + 6×1 − 1"
    concurrent = _json(capsys, "joints", "--typed", "--rule", "concurrent", "--json")
    elbow = next(row for row in concurrent["rows"] if row["parts"][0] == "LElbowYaw")
    assert (elbow["pair"], elbow["parts"]) == ("spherical", ["LElbowYaw", "LElbowRoll", "LWristYaw"])
    assert run(["joints", "--typed", "--nao", "v3.2", "--rule", "concurrent"]) == 0
    assert "ball and socket" in capsys.readouterr().out
    assert _json(capsys, "joints", "--rule", "concurrent", "--json") == concurrent
    for typed in ((), ("--typed",)):
        assert "unknown rule 'any'" in _refused(capsys, "joints", *typed, "--rule", "any")
        assert "tolerance must be in" in _refused(capsys, "joints", *typed, "--tolerance", "-1")


def test_names_from_a_file_are_no_markup(capsys: Capture, tmp_path: Path) -> None:
    path = tmp_path / "odd.urdf"
    path.write_text('<robot name="r"><link name="[red]base[/red]"/></robot>')
    assert run(["fk", "--urdf", str(path)]) == 0
    assert "[red]base[/red]" in capsys.readouterr().out


# --- as a program -----------------------------------------------------------------------------------------------------


def _program(*arguments: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-m", "nao_kin", *arguments], capture_output=True, text=True, **options)


def test_the_program_runs_from_any_folder_and_reads_standard_input(nao: nk.NaoModel, tmp_path: Path) -> None:
    text = json.dumps(nao.angles(nao.posture("Stand")))
    done = _program("fk", "-", "--frame", "LArm", "--json", input=text, cwd=tmp_path)
    assert done.returncode == 0
    assert json.loads(done.stdout)["poses"]["LArm"]["x"] == nao.position(nao.posture("Stand"), "LArm")[0]


@pytest.mark.full
@pytest.mark.skipif(os.name != "posix", reason="needs a POSIX shell")
@pytest.mark.parametrize(
    ("redirection", "arguments", "said"),
    [
        ("<&-", "fk -", "nao-kin: standard input: closed"),
        ("0> output", "fk -", "nao-kin: standard input: cannot be read: "),
        (">&-", "fk", "nao-kin: standard output is closed"),
        ("2>&-", "fk --joint HeadYaw=9", ""),
    ],
)
def test_closed_streams_are_named_or_done_without(tmp_path: Path, redirection: str, arguments: str, said: str) -> None:
    command = f'exec "{sys.executable}" -m nao_kin {arguments} {redirection}'
    options = {"capture_output": True, "text": True, "stdin": subprocess.DEVNULL, "cwd": tmp_path}
    done = subprocess.run(["bash", "-c", command], **options)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", said != "")
    assert done.stderr.startswith(said)


@pytest.mark.full
@pytest.mark.parametrize("arguments", ["fk {} --csv", "fk {}", "fk {} --json", "joints"])
def test_a_reader_that_stops_early_is_no_error(nao: nk.NaoModel, tmp_path: Path, arguments: str) -> None:
    path, rows = tmp_path / "walk.csv", nao.random(0, 500).tolist()  # more than a pipe holds
    path.write_text("\n".join(",".join(map(str, row)) for row in [nao.joint_names, *rows]))
    code = f"{sys.executable} -m nao_kin {arguments.format(path)} | head -c 10"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert len(done.stdout) == 10
    if "--csv" in arguments:
        assert done.stdout == "row,frame,"


def _wait_until_read(pipe: io.TextIOWrapper) -> None:
    """Wait until everything written into a pipe has been read."""
    import fcntl
    import termios

    end = time.monotonic() + 30.0
    while struct.unpack("i", fcntl.ioctl(pipe, termios.FIONREAD, bytes(4)))[0] > 0:
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.full
@pytest.mark.skipif(os.name != "posix", reason="needs signals and pipes")
def test_an_interrupt_ends_without_a_traceback() -> None:
    child = subprocess.Popen(
        [sys.executable, "-m", "nao_kin", "fk", "-"], stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        child.stdin.write("HeadYaw")
        child.stdin.flush()
        _wait_until_read(child.stdin)  # from then on it waits for the rest of its input
        os.kill(child.pid, signal.SIGINT)
        _, err = child.communicate(timeout=20)
    finally:
        child.kill()
    assert child.returncode == 130
    assert "Traceback" not in err


def test_notes_of_two_threads_do_not_share_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    class Recorder(io.StringIO):
        def write(self, text: str, /) -> int:
            written.append(text)
            return len(text)

    written: list[str] = []
    monkeypatch.setattr(sys, "stderr", Recorder())
    print_note("the first\nof two", "the second")
    assert [text for text in written if text] == ["nao-kin: the first of two\n", "nao-kin: the second\n"]


def test_degrees_have_two_options_with_one_text_each() -> None:
    texts: dict[str, set[str]] = {"deg": set(), "file_deg": set()}
    for name in options.COMMANDS:
        for option in options_of(name)[0].values():
            if option.name in texts:
                texts[option.name].add(option.field.metadata["help"])
    assert {len(of_one) for of_one in texts.values()} == {1}
