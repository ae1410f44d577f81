"""Motion files: made-up ones with every trait of their formats, read, compared with numbers, written, read again."""

from __future__ import annotations

import io
import json
import math
import re
import sys
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nao_kin._core.csv_numbers import quick_numbers
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.motion import Motion, MotionFileWarning, read_motion
from nao_kin.motion.files import is_motion_file
from nao_kin.motion.files.choregraphe import automatic_handles
from nao_kin.robot.nao import BODY_ORDER

DATA = Path(__file__).parents[1] / "data" / "motions"
LOSSLESS = ["csv", "json", "npz", "python", "naoqi"]


def _motion(tmp_path: Path, text: str | bytes, name: str, **options: Any) -> Motion:
    path = tmp_path / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_motion(path, **options)


def _refused(tmp_path: Path, text: str | bytes, name: str, **options: Any) -> BadInputFile:
    with pytest.raises(BadInputFile) as error:
        _motion(tmp_path, text, name, **options)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(str(tmp_path / name))
    return error.value


def _column(motion: Motion, joint: str) -> tuple[list[float], list[float]]:
    index = motion.joint_names.index(joint)
    return motion.times[index].tolist(), motion.keys[index].tolist()


def _degrees(*values: float) -> list[float]:
    return [math.radians(value) for value in values]


# Reading, format by format.


def test_csv_names_its_units_and_leaves_cells_empty_where_a_joint_has_no_key() -> None:
    motion = read_motion(DATA / "wave.csv")
    assert motion.joint_names == ("HeadYaw", "LHand", "RHipYawPitch", "LAnklePitch")
    assert motion.interpolation == "linear"
    assert _column(motion, "HeadYaw") == ([0.0, 0.5, 1.25], pytest.approx(_degrees(0, 30, -45)))
    assert _column(motion, "LHand") == ([0.0, 1.25], pytest.approx([0.4, 1.0]))
    assert _column(motion, "RHipYawPitch") == ([0.0, 1.25], [0.25, 0.1])
    assert _column(motion, "LAnklePitch") == ([0.5, 1.25], pytest.approx(_degrees(-10, 0.5)))


def test_csv_with_tabs_a_byte_order_mark_and_windows_line_ends() -> None:
    assert _column(read_motion(DATA / "tabs.tsv"), "HeadPitch") == ([0.5, 1.0], [0.125, -0.25])


def test_degrees_are_for_turning_joints_that_name_no_unit(tmp_path: Path) -> None:
    motion = _motion(tmp_path, "t,HeadYaw,HeadPitch [rad],LHand\n0,90,1,0.5\n", "a.csv", degrees=True)
    assert [float(keys[0]) for keys in motion.keys] == pytest.approx([math.pi / 2, 1.0, 0.5])


def test_json_holds_units_and_handles() -> None:
    motion = read_motion(DATA / "bezier.json")
    assert motion.interpolation == "bezier"
    assert _column(motion, "HeadYaw") == ([0.0, 0.6], pytest.approx(_degrees(0, 90)))
    assert _column(motion, "RHand") == ([0.3], [0.75])
    assert motion.handles is not None
    yaw, hand = motion.handles
    assert np.allclose(yaw, [[[0, 0], [0.2, math.pi / 10]], [[-0.3, -math.pi / 20], [0, 0]]])
    assert np.allclose(hand, [[[-0.1, -0.25], [0.1, 0.25]]])


@pytest.mark.parametrize(("unit", "size"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
@pytest.mark.parametrize("start", [0.0, 1.7e9])
@pytest.mark.parametrize("suffix", ["csv", "json"])
def test_times_in_another_unit_are_read_with_a_warning_unless_it_is_stated(
    tmp_path: Path, unit: str, size: float, start: float, suffix: str
) -> None:
    seconds = start + 0.02 * np.arange(40)
    times, keys = np.rint(size * seconds), 0.01 * np.sin(np.arange(40.0))

    def read(stated: bool) -> Motion:
        path = tmp_path / f"m.{suffix}"
        if suffix == "csv":
            rows = "".join(f"{time:.0f},{key}\n" for time, key in zip(times, keys, strict=True))
            path.write_text(f"time{f' [{unit}]' if stated else ''},HeadYaw\n{rows}")
        else:
            document = {"joint_names": ["HeadYaw"], "times": times.tolist(), "keys": keys[:, None].tolist()}
            path.write_text(json.dumps({**document, **({"units": {"time": unit}} if stated else {})}))
        return read_motion(path)

    with pytest.warns(MotionFileWarning, match=f"taken as {unit} "):
        guessed = read(stated=False)
    assert guessed == read(stated=True)  # without a warning, which would be an error here
    assert np.allclose(guessed.key_times, seconds, rtol=1e-12)


def test_json_with_one_list_of_times_has_a_row_of_keys_for_each() -> None:
    motion = read_motion(DATA / "rows.json")
    assert motion == Motion([0.0, 0.5, 2.0], ["HeadYaw", "HeadPitch"], [[0.0, 0.1], [0.25, -0.5], [1.0, 0.3]], "smooth")


def test_webots_holds_what_a_star_does_not_command() -> None:
    motion = read_motion(DATA / "holds.motion")
    assert _column(motion, "HeadYaw") == ([0.0, 0.08, 60.12, 61.0], [0.5, 0.5, 0.1, -0.25])
    assert _column(motion, "LShoulderPitch") == ([0.0, 0.04, 0.08], [1.4, 1.4, 1.3])
    assert _column(motion, "RHipYawPitch") == ([0.08, 60.12, 61.0], [-0.1, -0.1, -0.2])
    assert _column(motion, "RHand") == ([0.0, 0.04, 0.08, 60.12], [0.25, 0.5, 0.75, 1.0])


def test_webots_last_pose_of_stars_says_how_long_the_motion_is(tmp_path: Path) -> None:
    text = "#WEBOTS_MOTION,V1.0,HeadYaw,HeadPitch\n0,a,1,*\n500,b,*,2\n2:000,c,*,*\n"
    motion = _motion(tmp_path, text, "a.motion")
    assert _column(motion, "HeadYaw") == ([0.0, 2.0], [1.0, 1.0])
    assert _column(motion, "HeadPitch") == ([0.5, 2.0], [2.0, 2.0])


def test_webots_joint_that_is_never_commanded_is_left_out_with_a_word(tmp_path: Path) -> None:
    with pytest.warns(MotionFileWarning, match="HeadPitch has no value in any pose"):
        motion = _motion(tmp_path, "#WEBOTS_MOTION,V1.0,HeadYaw,HeadPitch\n0,a,1,*\n", "a.motion")
    assert motion.joint_names == ("HeadYaw",)


def test_runswift_adds_up_durations_and_takes_degrees() -> None:
    motion = read_motion(DATA / "poses.pos")
    assert set(motion.joint_names) == set(BODY_ORDER) - {"RHipYawPitch"}
    assert _column(motion, "HeadYaw") == ([0.2, 1.7, 1.75], pytest.approx(_degrees(0, -45, 10)))
    assert _column(motion, "HeadPitch") == ([0.2, 1.7, 1.75], pytest.approx(_degrees(30, 0.5, 20)))
    assert _column(motion, "LShoulderPitch")[1] == pytest.approx(_degrees(90.5, 58, 90.5))
    assert _column(motion, "LHipYawPitch")[1] == pytest.approx(_degrees(-5, 0, -5))
    assert _column(motion, "RAnkleRoll")[1] == pytest.approx(_degrees(0, 0, 0))
    assert _column(motion, "RWristYaw")[1] == pytest.approx(_degrees(90, -97, 90))
    assert _column(motion, "LHand")[1] == pytest.approx([1.0, 0.0, 1.0])
    assert _column(motion, "RHand")[1] == pytest.approx(_degrees(0, 10, 0))


# The order of rUNSWift's files before 2019, in which nothing marks a pose: the hands come after the wrists.
OLD_POS = """\
# HY HP LSP LSR LEY LER LWY LH LHYP LHR LHP LKP LAP LAR RHR RHP RKP RAP RAR RSP RSR REY RER RWY RH DUR
  0  -5  72  20  -33 -47 55 1  -10 2 -25 40 -20 3  -2 -26 41 -21 -3  72 -20  33  47  -55  0  1500 # arms out
$ 0.3 1 -1 -1 -1 -1 0 0 1 1 1 1 1 1 1 1 1 1 1 -1 -1 -1 -1 0 0
#  9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9  9

  0   5  90  10    0   0  0 0    0 0 -28 50 -25 0   0 -28 50 -25  0  90 -10   0   0    0  0.5  500
"""


@pytest.mark.parametrize("text", [(DATA / "poses.pos").read_text(), OLD_POS], ids=["marked", "old"])
@pytest.mark.parametrize("name", ["a.pos", "a.dat"])
def test_runswift_numbers_may_touch_where_a_sign_parts_them(tmp_path: Path, text: str, name: str) -> None:
    closer = re.sub(r"(?<=\d)[ \t]+(?=-\d)", "", text)
    assert closer != text
    whole, read = _motion(tmp_path, text, name), _motion(tmp_path, closer, name)
    assert [_column(read, joint) for joint in read.joint_names] == [
        _column(whole, joint) for joint in whole.joint_names
    ]
    _refused(tmp_path, closer.replace("-21", "--21", 1), name)


@pytest.mark.parametrize("name", ["a.pos", "a.dat"])
@pytest.mark.parametrize("header", [True, False])
def test_runswift_before_2019_has_rows_without_a_mark(tmp_path: Path, name: str, header: bool) -> None:
    text = OLD_POS if header else OLD_POS.partition("\n")[2]
    if not header and name == "a.dat":
        _refused(tmp_path, text, name)
        return
    motion = _motion(tmp_path, text, name)
    assert set(motion.joint_names) == set(BODY_ORDER) - {"RHipYawPitch"}
    assert _column(motion, "HeadPitch") == ([1.5, 2.0], pytest.approx(_degrees(-5, 5)))
    assert _column(motion, "LHand")[1] == pytest.approx(_degrees(1, 0))
    assert _column(motion, "LHipYawPitch")[1] == pytest.approx(_degrees(-10, 0))
    assert _column(motion, "RHipPitch")[1] == pytest.approx(_degrees(-26, -28))
    assert _column(motion, "RWristYaw")[1] == pytest.approx(_degrees(-55, 0))
    assert _column(motion, "RHand")[1] == pytest.approx(_degrees(0, 0.5))


def test_hulks_key_frames_begin_at_the_initial_positions() -> None:
    with pytest.warns(MotionFileWarning, match="left out: exit_condition, interrupt_conditions"):
        motion = read_motion(DATA / "keyframes.json")
    assert set(motion.joint_names) == set(BODY_ORDER)
    assert _column(motion, "HeadYaw") == ([0.0, 0.5, 0.75, 1.75], [0.0, 0.25, -0.5, 0.0])
    assert _column(motion, "RHand")[1] == [0.0, 0.5, 1.0, 0.0]
    assert _column(motion, "LShoulderRoll")[1] == [0.2] * 4
    assert _column(motion, "RElbowYaw")[1] == [0.9] * 4
    assert _column(motion, "RHipYawPitch")[1] == [-0.1] * 4
    assert _column(motion, "RAnkleRoll")[1] == [0.05] * 4
    assert motion.interpolation == "linear"


def test_hulks_older_frames_with_conditions_between() -> None:
    with pytest.warns(MotionFileWarning, match="left out: StabilizedCondition"):
        motion = read_motion(DATA / "frames.json")
    assert _column(motion, "HeadYaw") == ([0.0, 0.5, 0.75], [0.0, 0.25, -0.5])


def test_hulks_cosine_steps_are_cubic_ones_within_a_thousandth() -> None:
    with pytest.warns(MotionFileWarning, match=r"up to 0\.02 % of a step"):
        motion = read_motion(DATA / "cosine.json")
    t = np.linspace(0.0, 2.0, 1001)
    off = np.abs(motion.sample(t)[:, 0] - 0.5 * (1.0 - np.cos(math.pi * t / 2.0)))
    assert off.max() < 0.0002


WEBOTS_HANDS = """#WEBOTS_MOTION,V1.0,LPhalanx1,HeadYaw,LPhalanx2,RPhalanx3
00:00:000,Pose1,0.0,0.1,0.0,%s
00:00:500,Pose2,*,0.2,*,0.5
00:01:000,Pose3,1.0,0.3,1.0,0.5
"""


def test_the_motors_of_webots_hands_are_one_joint(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    path = tmp_path / "TaiChi.motion"
    path.write_text(WEBOTS_HANDS % "0.25", encoding="utf-8")
    motion = read_motion(path)
    assert motion.joint_names == ("HeadYaw", "LHand", "RHand")
    # * commands nothing: the hand stays until the last one, as any joint does.
    assert _column(motion, "LHand") == ([0.0, 0.5, 1.0], [0.0, 0.0, 1.0])
    assert _column(motion, "RHand") == ([0.0, 0.5, 1.0], [0.25, 0.5, 0.5])
    assert not recwarn.list
    path.write_text(path.read_text(encoding="utf-8").replace("1.0,0.3,1.0", "1.0,0.3,0.5"), encoding="utf-8")
    with pytest.warns(MotionFileWarning, match="LHand is the mean of its 2 motors, which differ from it by up to 0.25"):
        assert _column(read_motion(path), "LHand")[1][-1] == 0.75
    # A robot with fingers of its own, or a file that names the hand too, is not folded.
    path.write_text(WEBOTS_HANDS.replace("HeadYaw", "LHand") % "0", encoding="utf-8")
    with pytest.raises(BadInputFile, match="unknown joint 'LPhalanx1'"):
        read_motion(path)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "time,HeadYaw,Battery [V],State,HeadPitch\n0,0.1,12.5,walking,0\n1,0.2,12.4,,0.5\n"),
        ("a.motion", "#WEBOTS_MOTION,V1.0,HeadYaw,Battery,HeadPitch\n0,P,0.1,12,0\n1000,P,0.2,12,0.5\n"),
        (
            "a.json",
            '{"joint_names": ["HeadYaw", "Wheel", "HeadPitch"], "times": [0, 1], "keys": [[0.1, 1, 0], [0.2, 1, 0.5]]}',
        ),
        ("a.json", '[["HeadYaw", "Wheel", "HeadPitch"], [[0.1, 0.2], [1, 1], [0, 0.5]], [[0, 1], [0, 1], [0, 1]], 1]'),
        (
            "a.py",
            "names = ['HeadYaw', 'Wheel', 'HeadPitch']\ntimes = [[0, 1], [0, 1], [0, 1]]\n"
            "keys = [[0.1, 0.2], [1, 1], [0, 0.5]]\n",
        ),
    ],
)
def test_what_names_no_joint_is_left_out_when_asked(tmp_path: Path, name: str, text: str) -> None:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    with pytest.raises(
        BadInputFile, match="ignore_other=True, or --ignore-other of nao-kin motion, fk and view, leaves it out"
    ):
        read_motion(path)
    with pytest.warns(MotionFileWarning, match="left out names that are not joints: (Battery|Wheel)"):
        motion = read_motion(path, ignore_other=True)
    assert motion == Motion([0.0, 1.0], ["HeadYaw", "HeadPitch"], [[0.1, 0.0], [0.2, 0.5]])
    path.write_text(text.replace("HeadYaw", "A").replace("HeadPitch", "B"), encoding="utf-8")
    with pytest.warns(MotionFileWarning), pytest.raises(BadInputFile, match="no joint with keys"):
        read_motion(path, ignore_other=True)


@pytest.mark.parametrize("joint", ["KneePitch", "HipRoll", "WheelFL"])
def test_a_file_of_a_pepper_is_told_by_its_joints(tmp_path: Path, joint: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"time,HeadYaw,{joint}\n0,0.1,0.2\n", encoding="utf-8")
    with pytest.raises(BadInputFile, match=rf"unknown joint '{joint}' \(a joint of Pepper\)"):
        read_motion(path)


def test_naodevils_frames_move_what_they_command_and_hold_the_rest() -> None:
    motion = read_motion(DATA / "nod.kfm")
    assert set(motion.joint_names) == set(BODY_ORDER)
    # Reached from wherever the robot is: the first key is at the first duration.
    assert _column(motion, "HeadPitch") == ([0.4, 0.9, 1.5], np.radians([20.0, -10.0, 10.0]).tolist())
    # 20000: held until the frame that commands it again begins.
    assert _column(motion, "HeadYaw") == ([0.4, 0.9, 1.5], [0.1, 0.1, 0.3])
    assert _column(motion, "RShoulderPitch") == ([1.5], [math.radians(90.0)])
    assert _column(motion, "LElbowRoll")[1] == np.radians([-40.0, -40.0, -40.0]).tolist()
    assert _column(motion, "RAnklePitch")[1][0] == math.radians(-27.5)
    assert _column(motion, "LHand")[1] == [math.radians(30.0), 0.0, 0.0]
    t = np.linspace(0.0, 1.0, 101)
    pitch = np.degrees(motion.sample(0.4 + 0.5 * t)[:, motion.joint_names.index("HeadPitch")])
    assert np.abs(pitch - (20.0 - 30.0 * (0.5 - 0.5 * np.cos(math.pi * t)))).max() < 30 * 0.0002
    pitch = np.degrees(motion.sample(0.9 + 0.6 * t)[:, motion.joint_names.index("HeadPitch")])
    assert np.abs(pitch - (-10.0 + 20.0 * t)).max() < 1e-9


KFM_FRAME = """{{
  headAngles = [{head}];
  armsAngles = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]; armsAngles = [{arm}, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
  legsAngles = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]; duration = {ms}; intType = linear;
}}"""


def test_of_a_part_that_naodevils_give_twice_the_last_counts(tmp_path: Path) -> None:
    text = f"keyFrames = [{KFM_FRAME.format(head='0.1, 0.2', arm=0.5, ms=200)}];"
    assert _column(_motion(tmp_path, text, "a.kfm"), "LShoulderPitch") == ([0.2], [0.5])


def test_of_frames_at_0_s_the_last_that_commands_a_joint_counts(tmp_path: Path) -> None:
    frames = (("0.1, 0.2", 0.5, 0), ("20000, 0.3", 20000, 0), ("20000, 0.4", 0.6, 0), ("0.7, 0.8", 0.9, 100))
    text = ",".join(KFM_FRAME.format(head=head, arm=arm, ms=ms) for head, arm, ms in frames)
    motion = _motion(tmp_path, f"keyFrames = [{text}];", "a.kfm")
    assert _column(motion, "HeadYaw") == ([0.0, 0.1], [0.1, 0.7])
    assert _column(motion, "HeadPitch") == ([0.0, 0.1], [0.4, 0.8])
    assert _column(motion, "LShoulderPitch") == ([0.0, 0.1], [0.6, 0.9])


def test_bhuman_motions_are_blocks_one_after_another() -> None:
    with pytest.warns(MotionFileWarning, match="sensors are left out: keyframeBranches"):
        motion = read_motion(DATA / "blocks.cfg", timeline="wave")
    assert _column(motion, "HeadYaw") == ([0.5, 1.5, 2.3], [0.0, math.radians(20.0), 0.0])
    assert _column(motion, "RElbowRoll") == ([1.5, 2.3], np.radians([3.0, 3.0]).tolist())
    assert _column(motion, "LHand")[1] == pytest.approx([0.0, 1.0, 0.0])
    t = np.linspace(0.0, 1.0, 101)
    column = motion.joint_names.index("LShoulderPitch")
    up, down = (np.degrees(motion.sample(start + span * t)[:, column]) for start, span in ((0.5, 1.0), (1.5, 0.8)))
    assert np.abs(up - (41.0 - 101.0 * (0.5 - 0.5 * np.cos(math.pi * t)))).max() < 101 * 0.0002
    assert np.abs(down - (-60.0 + 101.0 * np.sin(0.5 * math.pi * t))).max() < 101 * 0.0004
    lower = read_motion(DATA / "blocks.cfg", timeline="lower")
    assert lower == read_motion(DATA / "blocks.cfg", timeline="keyframeBlock/lower")
    assert _column(lower, "HeadYaw") == ([0.8], [0.0])
    with pytest.raises(BadInputFile, match="3 motions; choose one .* 1: wave, 2: keyframeBlock/raise"):
        read_motion(DATA / "blocks.cfg")


@pytest.mark.parametrize("robot", ["K1", "T1"])
def test_bhumans_key_frames_of_another_robot_are_refused(tmp_path: Path, robot: str) -> None:
    text = (DATA / "blocks.cfg").read_text(encoding="utf-8")
    (tmp_path / robot).mkdir()
    (tmp_path / robot / "keyframeMotionEngine.cfg").write_text(text, encoding="utf-8")
    with pytest.raises(BadInputFile, match=f"key frames of Booster's {robot}, expected those of a NAO"):
        read_motion(tmp_path / robot / "keyframeMotionEngine.cfg", timeline="lower")
    # A copy elsewhere is known by arms that hang down at a roll of -80°, also in another block than the one to read.
    block = "keyframeBlock = {rest = {keyframes = [\n{angles = {positions = {leftArm = [3deg, -83deg, 90deg]}}}]};"
    error = _refused(tmp_path, text.replace("keyframeBlock = {", block, 1), "a.cfg")
    assert "the left shoulder rolls to -83°, which no NAO's does; key frames of another robot" in str(error)


@pytest.mark.parametrize("older", ["mofs = {up = {%s};};", "mofs = [{name = up; %s}];"])
def test_older_bhuman_files_are_in_degrees_and_lines_with_conditions_are_left_out(tmp_path: Path, older: str) -> None:
    limbs = "".join(f"{limb} = [1, 2, 3, 4, 5, 0];" for limb in ("leftArm", "rightArm", "leftLeg", "rightLeg"))
    line = f"{{duration = %d; conditions = [%s]; head = [%d, 20000]; {limbs}}}"
    lines = ", ".join((line % (250, "", 9), line % (250, "{variable = BrokenLeftArm;}", 50), line % (750, "", 18)))
    path = tmp_path / "getUpEngine.cfg"
    path.write_text(older % f"lines = [{lines}];", encoding="utf-8")
    with pytest.warns(MotionFileWarning, match="lines with conditions"):
        motion = read_motion(path)
    assert "HeadPitch" not in motion.joint_names
    assert motion.interpolation == "linear"
    assert _column(motion, "HeadYaw") == ([0.25, 1.0], np.radians([9.0, 18.0]).tolist())
    assert _column(motion, "RKneePitch")[1] == np.radians([4.0, 4.0]).tolist()


def test_motion2_times_are_shares_of_the_header_time() -> None:
    motion = read_motion(DATA / "nod.motion2")
    assert motion.joint_names == ("HeadYaw", "HeadPitch", "RHand", "RHipYawPitch")
    assert _column(motion, "HeadYaw") == ([0.125, 0.5, 1.0], [0.5, 0.0, -0.5])
    assert _column(motion, "RHand")[1] == [0.125, 1.0, 0.0]
    assert _column(motion, "RHipYawPitch")[1] == [-0.1, -0.2, 0.0]


def test_simplified_export_of_python_2_is_read_and_not_run() -> None:
    motion = read_motion(DATA / "simplified_export.txt", format="python")
    assert motion.joint_names == ("HeadPitch", "RHand", "LHipYawPitch")
    assert _column(motion, "HeadPitch") == ([0.52, 0.8, 1.04], [-0.39, 0.64, 0.0])
    assert _column(motion, "RHand") == ([0.5, 1.0], [1.0, 0.5])
    assert _column(motion, "LHipYawPitch") == ([2.0], pytest.approx(_degrees(9)))
    assert motion.interpolation == "linear"


def test_bezier_export_has_handles_and_straight_ones_too() -> None:
    motion = read_motion(DATA / "bezier_export.txt", timeline="up")
    assert motion.interpolation == "bezier"
    assert _column(motion, "HeadYaw") == ([0.0, 0.6, 1.2], [0.5, -0.25, 0.5])
    assert motion.handles is not None
    expected = [[[-0.0133333, 0], [0.2, 0.1]], [[-0.2, 0], [0.2, 0.25]], [[-0.2, 0.05], [0, 0]]]
    assert np.allclose(motion.handles[0], expected)
    assert np.allclose(motion.handles[1], [[[-0.4, 0], [0, 0]]])


def test_export_with_several_motions_lists_them_and_lets_choose(tmp_path: Path) -> None:
    path = DATA / "bezier_export.txt"
    with pytest.raises(BadInputFile, match=r"2 motions; choose one with timeline=.*1: up, 2: down"):
        read_motion(path)
    assert read_motion(path, timeline=2) == read_motion(path, timeline="down")
    assert _column(read_motion(path, timeline="down"), "HeadYaw") == ([0.25], [0.3])
    with pytest.raises(BadInputFile, match=r"no timeline 'dwon' among 2 motions \(nearest: down\)"):
        read_motion(path, timeline="dwon")


@pytest.mark.parametrize(
    "expression", ["open('x', 'w')", "__import__('os')", "[0]*9**9", "speed", "(lambda: 0)()", "-'a'", "True", "f'{1}'"]
)
def test_an_export_is_never_run(tmp_path: Path, expression: str) -> None:
    text = f"names = ['HeadYaw']\ntimes = [[1]]\nkeys = [[0 +\n   {expression}]]\n"
    error = _refused(tmp_path, text, "a.py")
    assert error.line in (3, 4)
    assert not (tmp_path / "x").exists()


def test_exports_may_empty_their_lists_at_once(tmp_path: Path) -> None:
    one = "  names, times, keys = [], list(), []\n  names.append('HeadYaw'); times.append([1]); keys.append([0.5])\n"
    motion = _motion(tmp_path, f"def up():\n{one}\ndef down():\n{one}", "a.py", timeline="down")
    assert motion == Motion([1.0], ["HeadYaw"], [[0.5]])


def test_what_is_computed_in_one_function_does_no_harm_to_another(tmp_path: Path) -> None:
    good = "def good():\n  names = ['HeadYaw']\n  times = [[1]]\n  keys = [[0.5]]\n"
    text = f"{good}def bad(speed):\n  names = ['HeadYaw']\n  times = [[speed]]\n  keys = [[0.5]]\n"
    assert _motion(tmp_path, text, "a.py", timeline="good") == Motion([1.0], ["HeadYaw"], [[0.5]])
    assert "'speed' is not a number" in str(_refused(tmp_path, text, "a.py", timeline="bad"))


def test_what_an_export_computes_is_named_with_its_place(tmp_path: Path) -> None:
    text = "names = list()\ntimes = list()\nif 1:\n  names.append('HeadYaw')\n  times.append([0.5, speed])\n"
    error = _refused(tmp_path, text, "a.py")
    assert (error.line, error.column) == (5, 22)
    assert "'speed' is not a number written out" in str(error)


def test_xar_timeline_has_degrees_ratios_and_tangents() -> None:
    motion = read_motion(DATA / "timelines.xar", timeline="Dance/wave")
    assert motion.joint_names == ("HeadYaw", "LHand", "RHand", "RHipYawPitch")
    times, keys = _column(motion, "HeadYaw")
    assert times == pytest.approx([0.0, 0.3, 1.2, 1.5, 2.1])
    assert keys == pytest.approx(_degrees(0, 9, 18, -90, 0))
    assert _column(motion, "LHand") == ([1.0], [0.75])
    assert _column(motion, "RHand") == ([0.5], [0.5])
    assert _column(motion, "RHipYawPitch") == ([0.5], pytest.approx(_degrees(-18)))
    assert motion.handles is not None
    # Frames and degrees: automatic (slope 18 / 12), automatic at an extremum, given and linear, automatic at the end.
    expected = [[[0, 0], [1, 0]], [[-1, -1.5], [3, 4.5]], [[-3, 0], [1, 0]], [[-1.5, 4.5], [2, 30]], [[-2, 0], [0, 0]]]
    assert np.allclose(motion.handles[0], np.array(expected) * [0.1, math.pi / 180.0])


def test_xar_counts_frames_from_its_start_and_says_what_is_not_played() -> None:
    with pytest.warns(MotionFileWarning, match="outside of frames 5 to 30"):
        motion = read_motion(DATA / "timelines.xar", timeline="bow")
    assert motion.interpolation == "linear"
    assert _column(motion, "LHipPitch") == ([0.0, 1.0], pytest.approx(_degrees(-9, -45)))


def test_xar_says_once_that_keys_of_several_joints_are_not_played(tmp_path: Path) -> None:
    keys = '<Key frame="5" value="1"/><Key frame="9" value="2"/>'
    curves = "".join(f'<ActuatorCurve actuator="{joint}">{keys}</ActuatorCurve>' for joint in ("HeadYaw", "HeadPitch"))
    xml = f'<Box name="root"><Timeline fps="25" start_frame="1" end_frame="8">{curves}</Timeline></Box>'
    (tmp_path / "a.xar").write_text(xml)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        motion = read_motion(tmp_path / "a.xar")
    assert [len(keys) for keys in motion.keys] == [1, 1]
    assert len(said) == 1


def test_automatic_handles_end_at_most_at_the_value_of_the_neighbour() -> None:
    handles = automatic_handles(np.array([0.0, 1.0, 31.0]), np.array([0.0, 10.0, 11.0]))
    # β = 11 / 31 would rise by 3.5 over the third of 30 frames; the neighbour is 1 away.
    assert np.allclose(handles[1], [[-1 / 3, -1 / 30], [10.0, 1.0]])
    assert automatic_handles(np.array([3.0]), np.array([1.0])).tolist() == [[[0.0, 0.0], [0.0, 0.0]]]


@pytest.mark.parametrize(
    "xml",
    [
        '<!DOCTYPE a [<!ENTITY x "&y;"><!ENTITY y "lol">]>',
        '<!DOCTYPE ChoregrapheProject [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
    ],
)
def test_xar_with_a_document_type_is_refused_before_anything_else(tmp_path: Path, xml: str) -> None:
    text = f'<?xml version="1.0"?>\n{xml}\n<ChoregrapheProject><Box name="&x;"/></ChoregrapheProject>'
    error = _refused(tmp_path, text, "a.xar")
    assert "refused" in str(error)
    assert error.line == 2


def test_naoqi_arguments_mix_numbers_and_lists() -> None:
    motion = read_motion(DATA / "arguments.json")
    assert _column(motion, "HeadYaw") == ([1.0, 2.0], [0.5, 0.0])
    assert _column(motion, "HeadPitch") == ([1.5], [0.25])
    assert _column(motion, "RHand") == ([1.0, 2.0, 3.0], [0.1, 0.2, 1.0])


def test_naoqi_control_points() -> None:
    motion = read_motion(DATA / "bezier_arguments.json")
    assert motion == Motion(
        [[1.0, 2.5]], ["HeadYaw"], [[0.3, 0.0]], "bezier", [[[[-0.25, 0.0], [0.5, 0.125]], [[-0.5, 0.0], [0.0, 0.0]]]]
    )


def test_naoqi_chain_by_name() -> None:
    assert read_motion(DATA / "chain.json") == Motion([2.0], ["HeadYaw", "HeadPitch"], [[0.5, -0.25]])


@pytest.mark.parametrize(
    ("arguments", "times", "keys"),
    [
        (["HeadYaw", 0.5, 1.0, True], [1.0], [0.5]),
        (["HeadYaw", [0.5, 0.1], [1.0, 2.0], True], [1.0, 2.0], [0.5, 0.1]),
        (["HeadYaw", [[0.5, 0.1]], [[1, 2]], True], [1.0, 2.0], [0.5, 0.1]),
        ([["HeadYaw"], [0.5, 0.1], [1, 2], True], [1.0, 2.0], [0.5, 0.1]),
        ([["HeadYaw"], 0.5, [1], 1], [1.0], [0.5]),
    ],
)
def test_naoqi_forms_of_one_joint(tmp_path: Path, arguments: Any, times: list[float], keys: list[float]) -> None:
    assert _column(_motion(tmp_path, json.dumps(arguments), "a.json"), "HeadYaw") == (times, keys)


def test_naoqi_whole_body_in_one_time(tmp_path: Path) -> None:
    angles = [index / 100 for index in range(26)]
    motion = _motion(tmp_path, json.dumps(["Body", angles, 2.5, True]), "a.json")
    assert motion == Motion([2.5], BODY_ORDER, [angles])


# Choregraphe's poses and packages.


def test_a_pose_of_choregraphe_is_one_key_in_degrees_or_since_version_2_in_radians() -> None:
    wave = read_motion(DATA / "library.xap", timeline="Greetings/Wave & smile")
    assert wave.joint_names == ("HeadYaw", "LHand", "RElbowRoll")
    assert _column(wave, "HeadYaw") == ([0.0], pytest.approx(_degrees(-20.5)))
    assert _column(wave, "RElbowRoll") == ([0.0], pytest.approx(_degrees(60)))
    assert _column(wave, "LHand") == ([0.0], [0.25])
    look = read_motion(DATA / "library.xap", timeline="Look")
    assert (_column(look, "HeadYaw"), _column(look, "LHand")) == (([0.0], [0.5]), ([0.0], [0.75]))
    assert _column(read_motion(DATA / "library.xap", timeline="3"), "HeadPitch") == ([0.0], [-0.1])
    with pytest.raises(BadInputFile, match="3 poses; .* 1: Greetings/Wave & smile, 2: Greetings/Look, 3: Nod"):
        read_motion(DATA / "library.xap")


def test_the_project_and_the_packages_of_choregraphe_say_where_the_motions_are(tmp_path: Path) -> None:
    rows = "".join(f'<BehaviorDescription name="behavior" src="{src}" xar="behavior.xar" />' for src in ("wave", "sit"))
    project = f'<?xml version="1.0"?><Package name="a"><BehaviorDescriptions>{rows}</BehaviorDescriptions></Package>'
    error = _refused(tmp_path, project, "a.pml")
    assert "a project of Choregraphe, with its motions in other files: wave/behavior.xar and 1 more" in str(error)
    with zipfile.ZipFile(tmp_path / "packed.pkg", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("manifest.xml", "<package/>")
        archive.writestr("wave/behavior.xar", "<Timeline/>")
    for content, name in ((b"!<arch>\ndebian-binary", "a.crg"), ((tmp_path / "packed.pkg").read_bytes(), "a.pkg")):
        assert "a package of Choregraphe; unpack it" in str(_refused(tmp_path, content, name))
        assert is_motion_file(tmp_path / name)


@pytest.mark.parametrize("first", [b"", b"#!/usr/bin/python\n"])
def test_an_export_in_another_encoding_is_read_if_it_declares_it(tmp_path: Path, first: bytes) -> None:
    export = "# 挥手\nnames = ['HeadYaw']\ntimes = [[1.0]]\nkeys = [[0.5]]\n".encode("gbk")
    motion = _motion(tmp_path, first + b"# -*- coding: gbk -*-\n" + export, "a.py")
    assert _column(motion, "HeadYaw") == ([1.0], [0.5])
    for declared in (b"", b"# coding: utf-8\n", b"# coding: nonsense\n", b"# coding: hex\n", b"\n\n# coding: gbk\n"):
        assert "not UTF-8 text" in str(_refused(tmp_path, first + declared + export, "a.py"))


def test_relative_angles_are_refused(tmp_path: Path) -> None:
    error = _refused(tmp_path, '["HeadYaw", 0.5, 1.0,\n false]', "a.json")
    assert "[3]: relative angles" in str(error)


# Which format it is.


@pytest.mark.parametrize("file", sorted(path.name for path in DATA.iterdir()))
def test_the_content_says_which_format_it_is_whatever_the_suffix(tmp_path: Path, file: str) -> None:
    timeline = 1 if file in ("timelines.xar", "bezier_export.txt", "blocks.cfg", "library.xap") else None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        expected = read_motion(DATA / file, timeline=timeline)
        for name in ("a", "a.dat", "a.csv", "a.json", "a.npz", "a.motion", "a.pos", "a.py", "a.xar", "a.motion2"):
            assert _motion(tmp_path, (DATA / file).read_bytes(), name, timeline=timeline) == expected


def test_where_the_content_says_two_things_the_suffix_decides(tmp_path: Path) -> None:
    text = f"time,HeadYaw\n! {'0 ' * 25}500\n"
    assert len(_motion(tmp_path, text, "a.pos").joint_names) == 25
    assert "may be csv, runswift; choose one with format=" in str(_refused(tmp_path, text, "a.dat"))
    assert len(_motion(tmp_path, text, "a.dat", format="runswift").joint_names) == 25


def test_standard_input_is_recognised_by_its_content(monkeypatch: pytest.MonkeyPatch) -> None:
    for file in ("wave.csv", "rows.json", "holds.motion", "poses.pos", "nod.motion2"):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO((DATA / file).read_bytes())))
        assert read_motion("-") == read_motion(DATA / file)
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(BadInputFile, match="standard input: closed"):
        read_motion("-")


@pytest.mark.parametrize("content", [b"", b" \n\t\n"])
def test_an_empty_file_lists_the_formats(tmp_path: Path, content: bytes) -> None:
    assert "empty; expected a motion: csv (.csv" in str(_refused(tmp_path, content, "a.csv"))


@pytest.mark.parametrize("content", [b"hello\nworld\n", b"\x00\xff\xfe" * 99, b"HeadYaw,HeadPitch\n0,1\n", b"[1, 2]"])
def test_unknown_content_lists_the_formats(tmp_path: Path, content: bytes) -> None:
    assert "expected csv (.csv .tsv .txt), json" in str(_refused(tmp_path, content, "a.dat"))


def test_a_missing_file_and_a_folder_are_one_line(tmp_path: Path) -> None:
    for path in (tmp_path / "none.csv", tmp_path):
        with pytest.raises(BadInputFile, match="cannot be read"):
            read_motion(path)
    with pytest.raises(BadArgument, match="no file name"):
        read_motion("")
    with pytest.raises(BadInputFile, match="cannot be read"):
        read_motion("a\0b")


def test_a_robot_says_whose_joints_may_occur(tmp_path: Path, nao: Any) -> None:
    assert _motion(tmp_path, "time,LHipYawPitch\n0,0\n", "a.csv", robot=nao).joint_names == ("LHipYawPitch",)
    assert "unknown joint 'Tail'" in str(_refused(tmp_path, "time,Tail\n0,0\n", "a.csv", robot=nao))


@pytest.mark.parametrize(
    "text",
    [
        "timestamp,HeadYaw [deg],LHand [%]\n0,10,40\n0.5,20,\n",
        "# by a recorder\n\nt [ms];HeadYaw (deg);LHand\n0;10,0;0,4\n500;20,0;\n",
        ",stamp [us],Device/SubDeviceList/HeadYaw/Position/Sensor/Value [deg],LHand [%]\n0,0,10,40\n1,500000,20,\n",
        "# time [s],HeadYaw [deg],LHand\n0,10,0.4\n0.5,20,\n",
    ],
)
def test_headings_of_motions_are_those_of_logs(tmp_path: Path, text: str) -> None:
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    motion = read_motion(tmp_path / "log.csv")
    assert motion.joint_names == ("HeadYaw", "LHand")
    assert [times.tolist() for times in motion.times] == [[0.0, 0.5], [0.0]]
    np.testing.assert_allclose(motion.keys[0], np.radians([10.0, 20.0]), rtol=1e-15)
    assert motion.keys[1].tolist() == [0.4]


@pytest.mark.parametrize("mark", [".", ","])
def test_a_large_table_is_the_same_motion_however_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mark: str
) -> None:
    pytest.importorskip("pyarrow")
    values = np.random.default_rng(0).normal(size=(50, 2))
    rows = ";".join(["HeadYaw", "time", "LHand"]) + "\n"
    rows += "".join(f"{a!r};{0.1 * row!r};{b!r}\n" for row, (a, b) in enumerate(values.tolist())).replace(".", mark)
    (tmp_path / "a.csv").write_text(rows)
    motion = read_motion(tmp_path / "a.csv")
    read_at_once = []
    monkeypatch.setattr("nao_kin._core.csv_numbers._LARGE", 0)
    monkeypatch.setattr(
        "nao_kin._core.csv_numbers.quick_numbers",
        lambda *given: read_at_once.append(quick_numbers(*given)) or read_at_once[-1],
    )
    assert read_motion(tmp_path / "a.csv") == motion == Motion(0.1 * np.arange(50), ["HeadYaw", "LHand"], values)
    assert read_at_once[0] is not None
    for row, words in (
        ("0;0;0", "line 52, column 2: time 0 s is before"),
        ("0;9;x", "line 52, column 3: LHand is 'x'"),
    ):
        assert words in str(_refused(tmp_path, f"{rows}{row}\n", "b.csv"))


def test_webots_joints_may_be_named_on_a_second_line(tmp_path: Path) -> None:
    # As the files of TucAgent3D have them.
    path = tmp_path / "turn.motion"
    rows = "00:00:000,Pose1,0,-0.012\n00:00:040,Pose2,-0.478,-0.011\n"
    path.write_text(f"#WEBOTS_MOTION,V1.0\nLHipYawPitch,LHipRoll\n{rows}")
    motion = read_motion(path)
    assert motion.joint_names == ("LHipYawPitch", "LHipRoll")
    assert [keys.tolist() for keys in motion.keys] == [[0.0, -0.478], [-0.012, -0.011]]
    assert motion.times[0].tolist() == [0.0, 0.04]
    for wrong, line in (("LHipRoll", 2), ("-0.011", 4), ("00:00:040", 4)):
        path.write_text(f"#WEBOTS_MOTION,V1.0\nLHipYawPitch,LHipRoll\n{rows}".replace(wrong, "wrong"))
        with pytest.raises(BadInputFile) as refused:
            read_motion(path)
        assert refused.value.line == line
    path.write_text(f"#WEBOTS_MOTION,V1.0\n{rows}")
    with pytest.raises(BadInputFile, match="names no joints"):
        read_motion(path)
