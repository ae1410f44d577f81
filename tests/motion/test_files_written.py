"""Motion files that are written: read again they are as they were, and what a format cannot hold is said."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from test_motion_files import DATA, LOSSLESS, _column

from nao_kin import load_nao
from nao_kin.errors import BadArgument, NotFinite, UnknownName
from nao_kin.motion import FORMATS, Motion, MotionFileWarning, read_motion, resample, time_warp, write_motion
from nao_kin.robot.nao import BODY_ORDER


def _same(one: Motion, two: Motion, tolerance: float = 1e-12) -> bool:
    """Whether two motions have the same joints, times, keys and handles, in any order of joints."""
    if set(one.joint_names) != set(two.joint_names) or one.interpolation != two.interpolation:
        return False
    for index, joint in enumerate(one.joint_names):
        other = two.joint_names.index(joint)
        pairs = [(one.times[index], two.times[other]), (one.keys[index], two.keys[other])]
        if one.handles is not None and two.handles is not None:
            pairs.append((one.handles[index], two.handles[other]))
        if any(a.shape != b.shape or not np.allclose(a, b, rtol=0.0, atol=tolerance) for a, b in pairs):
            return False
    return True


WRITTEN = [name for name, known in FORMATS.items() if known.write is not None]


@pytest.fixture
def whole_body() -> Motion:
    """All 26 joints at four shared times in whole milliseconds, both hips equal."""
    rng = np.random.default_rng(0)
    keys = rng.uniform(-0.5, 0.5, (4, 26))
    keys[:, BODY_ORDER.index("RHipYawPitch")] = keys[:, BODY_ORDER.index("LHipYawPitch")]
    return Motion([0.0, 0.25, 1.5, 2.004], BODY_ORDER, keys)


@pytest.mark.parametrize("name", ["python", "naoqi"])
@pytest.mark.parametrize("interpolation", ["linear", "bezier"])
def test_keys_that_naoqi_refuses_are_warned_of(tmp_path: Path, name: str, interpolation: Any) -> None:
    path = tmp_path / f"a{FORMATS[name].suffixes[0]}"
    motion = Motion([[0.5, 1.0], [0.0, 1.0]], ["HeadYaw", "HeadPitch"], [[0.1, 0.2]] * 2, interpolation)
    with pytest.warns(MotionFileWarning, match="refuses keys at 0 s; nk.motion.time_warp"):
        write_motion(motion, path, format=name)
    write_motion(time_warp(motion, lambda t: t + 1.0), path, format=name, overwrite=True)
    assert read_motion(path).times[1].tolist() == [1.0, 2.0]


@pytest.mark.filterwarnings("ignore:NAOqi refuses keys at 0 s")
@pytest.mark.parametrize("name", WRITTEN)
def test_a_linear_motion_comes_back(whole_body: Motion, tmp_path: Path, name: str) -> None:
    path = tmp_path / f"a{FORMATS[name].suffixes[0]}"
    write_motion(whole_body, path, format=name)
    again = read_motion(path)
    if name == "runswift":
        kept = [joint for joint in BODY_ORDER if joint != "RHipYawPitch"]
        columns = [BODY_ORDER.index(joint) for joint in kept]
        whole_body = Motion(whole_body.times[0], kept, np.stack(whole_body.keys, axis=-1)[:, columns])
    assert _same(again, whole_body)
    if name in LOSSLESS:
        assert again == whole_body


@pytest.mark.filterwarnings("ignore:NAOqi refuses keys at 0 s")
@pytest.mark.parametrize(
    ("file", "name", "options"),
    [
        ("wave.csv", "csv", {}),
        ("holds.motion", "webots", {}),
        ("poses.pos", "runswift", {}),
        ("keyframes.json", "hulks", {}),
        ("frames.json", "hulks", {}),
        ("nod.motion2", "motion2", {}),
        ("simplified_export.txt", "python", {}),
        ("bezier_export.txt", "python", {"timeline": "up"}),
        ("timelines.xar", "xar", {"timeline": "wave"}),
        ("timelines.xar", "xar", {"timeline": "bow"}),
        ("arguments.json", "naoqi", {}),
        ("bezier_arguments.json", "naoqi", {}),
    ],
)
def test_a_file_is_written_and_read_again_as_it_was(
    tmp_path: Path, file: str, name: str, options: dict[str, Any]
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motion = read_motion(DATA / file, **options)
    path = tmp_path / f"a{FORMATS[name].suffixes[0]}"
    write_motion(motion, path, format=name)
    again = read_motion(path)
    if name != "webots":
        assert _same(again, motion)
    else:  # a number where the line between two keys of the joint passes the time of a key of another one
        t = np.linspace(0.0, 61.0, 611)
        assert np.allclose(again.sample(t), motion.sample(t), atol=1e-12)


_names = st.lists(st.sampled_from(BODY_ORDER), min_size=1, max_size=4, unique=True)
_finite = st.floats(-1e6, 1e6, allow_subnormal=False)


@st.composite
def _motions(draw: Callable[..., Any]) -> Motion:
    names = draw(_names)
    steps = st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=5)
    times = [np.cumsum(draw(steps)) - draw(st.floats(-10.0, 1e-3)) for _ in names]
    keys = [draw(st.lists(_finite, min_size=len(row), max_size=len(row))) for row in times]
    interpolation = draw(st.sampled_from(["linear", "smooth", "bezier"]))
    handles = None
    if interpolation == "bezier" and draw(st.booleans()):
        handles = []
        for row in times:
            own = np.array(draw(st.lists(_finite, min_size=4 * len(row), max_size=4 * len(row)))).reshape(-1, 2, 2)
            widths = np.diff(row, prepend=row[0] - 1.0, append=row[-1] + 1.0)
            own[..., 0] = np.abs(own[..., 0]) / 1e6 * np.stack([-widths[:-1], widths[1:]], axis=-1)
            handles.append(own)
    return Motion(times, names, keys, interpolation, handles)


@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")
@settings(max_examples=20, deadline=None)
@given(_motions())
def test_json_and_npz_lose_nothing(tmp_path_factory: pytest.TempPathFactory, motion: Motion) -> None:
    folder = tmp_path_factory.mktemp("lossless")
    for name in ("json", "npz"):
        write_motion(motion, folder / "a", format=name, overwrite=True)
        assert read_motion(folder / "a") == motion


@pytest.mark.filterwarnings("ignore:NAOqi refuses keys at 0 s")
@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")
@settings(max_examples=20, deadline=None)
@given(_motions())
def test_curves_are_the_same_in_python_and_naoqi(tmp_path_factory: pytest.TempPathFactory, motion: Motion) -> None:
    folder = tmp_path_factory.mktemp("curves")
    if motion.start < 0.0:
        motion = Motion([row - motion.start for row in motion.times], motion.joint_names, motion.keys)
    for name in ("python", "naoqi"):
        write_motion(motion, folder / f"a{FORMATS[name].suffixes[0]}", format=name, overwrite=True)
        again = read_motion(folder / f"a{FORMATS[name].suffixes[0]}")
        expected = motion if motion.interpolation == "linear" else motion.as_bezier()
        assert _same(again, expected, 1e-9)


def test_a_smooth_motion_keeps_its_curve_in_a_timeline(tmp_path: Path) -> None:
    motion = Motion([[0.0, 0.4, 2.0], [0.2]], ["HeadYaw", "LHand"], [[0.0, 0.5, 0.75], [0.5]], "smooth")
    write_motion(motion, tmp_path / "a.xar")
    t = np.linspace(-0.5, 2.5, 301)
    assert np.allclose(read_motion(tmp_path / "a.xar").sample(t), motion.sample(t), atol=1e-12)


@pytest.mark.parametrize(("step", "fps"), [(0.04, 25), (0.02, 50), (0.01, 100), (0.003, 1000)])
def test_timelines_have_as_many_frames_as_the_keys_need(tmp_path: Path, step: float, fps: int) -> None:
    motion = Motion([0.0, step, 3 * step], ["HeadYaw"], [0.0, 0.5, 0.75])
    write_motion(motion, tmp_path / "a.xar")
    assert f'fps="{fps}"' in (tmp_path / "a.xar").read_text()
    assert _same(read_motion(tmp_path / "a.xar"), motion)


@pytest.mark.parametrize("name", ["csv", "webots", "runswift", "hulks", "motion2"])
def test_curves_in_formats_of_straight_lines_are_lost_with_a_word_or_sampled(
    whole_body: Motion, tmp_path: Path, name: str
) -> None:
    curved = Motion(whole_body.times, whole_body.joint_names, whole_body.keys, "smooth")
    path = tmp_path / f"a{FORMATS[name].suffixes[0]}"
    with pytest.warns(MotionFileWarning, match="smooth curves between the keys are lost"):
        write_motion(curved, path, format=name)
    write_motion(curved, path, format=name, rate=250.0, overwrite=True)
    sampled = read_motion(path)
    t = np.linspace(0.0, 2.0, 501)
    column, other = sampled.joint_names.index("HeadYaw"), curved.joint_names.index("HeadYaw")
    assert np.abs(sampled.sample(t)[:, column] - curved.sample(t)[:, other]).max() < 1e-4
    assert len(sampled.times[0]) == 502


def test_webots_writes_stars_before_the_first_and_after_the_last_key(tmp_path: Path) -> None:
    motion = Motion([[0.0, 1.0], [0.5], [0.25, 2.0]], ["HeadYaw", "HeadPitch", "LHand"], [[0, 1], [0.5], [0, 1]])
    write_motion(motion, tmp_path / "a.motion")
    assert (tmp_path / "a.motion").read_text().splitlines()[:3] == [
        "#WEBOTS_MOTION,V1.0,HeadYaw,HeadPitch,LHand",
        "00:00:000,Pose1,0.0,*,*",
        "00:00:250,Pose2,0.25,*,0.0",
    ]


@pytest.mark.parametrize("name", ["webots", "runswift", "motion2"])
def test_times_are_rounded_to_milliseconds_with_a_word(whole_body: Motion, tmp_path: Path, name: str) -> None:
    finer = Motion([0.0, 0.2504, 1.5, 2.0], BODY_ORDER, np.stack(whole_body.keys, axis=-1))
    with pytest.warns(MotionFileWarning, match=r"rounded, by up to 0\.4 ms"):
        write_motion(finer, tmp_path / "a", format=name)
    too_fine = Motion([0.0, 0.0002], BODY_ORDER, np.zeros((2, 26)))
    with pytest.raises(BadArgument, match="become the same"):
        write_motion(too_fine, tmp_path / "b", format=name)
    assert not (tmp_path / "b").exists()


def test_rounded_frames_keep_handles_within_their_segments(tmp_path: Path) -> None:
    handles = [[[[0.0, 0.0], [1.0004, 0.1]], [[-1.0004, 0.0], [0.0, 0.0]]]]
    motion = Motion([0.0, 1.0004], ["HeadYaw"], [[0.0], [0.5]], "bezier", handles)
    with pytest.warns(MotionFileWarning, match="rounded"):
        write_motion(motion, tmp_path / "a.xar")
    assert _same(read_motion(tmp_path / "a.xar"), motion, 5e-4)


@pytest.mark.parametrize("name", ["webots", "runswift", "motion2", "hulks", "xar"])
def test_formats_that_begin_at_zero_refuse_earlier_keys(tmp_path: Path, name: str) -> None:
    with pytest.raises(BadArgument, match="begin at 0 s"):
        write_motion(Motion([-1.0, 1.0], BODY_ORDER, np.zeros((2, 26))), tmp_path / "a", format=name)


def test_formats_of_all_joints_name_what_is_missing(tmp_path: Path) -> None:
    few = Motion([0.0], ["HeadYaw", "RHipYawPitch"], [[0.0, 0.1]])
    with pytest.raises(BadArgument, match="all 25 joints, the motion lacks HeadPitch, .* and 18 more"):
        write_motion(few, tmp_path / "a.pos")
    with pytest.raises(BadArgument, match="all 26 joints, the motion lacks HeadPitch"):
        write_motion(few, tmp_path / "a.json", format="hulks")
    foreign = Motion([0.0], ["HeadYaw", "Tail"], [[0.0, 0.1]])
    for name in ("runswift", "hulks", "motion2"):
        with pytest.raises(BadArgument, match="no place for Tail"):
            write_motion(foreign, tmp_path / "a", format=name)


def test_runswift_has_one_hip(whole_body: Motion, tmp_path: Path) -> None:
    keys = np.stack(whole_body.keys, axis=-1)
    keys[2, BODY_ORDER.index("RHipYawPitch")] += 0.125
    with pytest.warns(MotionFileWarning, match=r"RHipYawPitch differs from it by up to 0\.125 rad"):
        write_motion(Motion(whole_body.times[0], BODY_ORDER, keys), tmp_path / "a.pos")
    right_only = [joint for joint in BODY_ORDER if joint != "LHipYawPitch"]
    columns = [BODY_ORDER.index(joint) for joint in right_only]
    write_motion(Motion(whole_body.times[0], right_only, keys[:, columns]), tmp_path / "b.pos")
    assert _column(read_motion(tmp_path / "b.pos"), "LHipYawPitch")[1] == pytest.approx(keys[:, columns[13]].tolist())


def test_a_motion_that_a_format_cannot_hold_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.pos"
    path.write_text("precious")
    with pytest.raises(BadArgument):
        write_motion(Motion([0.0], ["HeadYaw"], [[0.0]]), path, overwrite=True)
    assert path.read_text() == "precious"


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, math.inf, "fast", 1e12])
def test_a_rate_is_a_sensible_number(whole_body: Motion, tmp_path: Path, rate: Any) -> None:
    with pytest.raises((BadArgument, NotFinite), match="rate|samples a second"):
        write_motion(whole_body, tmp_path / "a.csv", rate=rate)


def test_a_name_without_a_known_suffix_needs_a_format(whole_body: Motion, tmp_path: Path) -> None:
    with pytest.raises(
        BadArgument, match=r"no motion format for .*a\.dat; name one with .* end it in one of: csv \(\.csv"
    ):
        write_motion(whole_body, tmp_path / "a.dat")
    with pytest.raises(UnknownName, match="nearest: webots"):
        write_motion(whole_body, tmp_path / "a.dat", format="webot")
    with pytest.raises(UnknownName, match="nearest: webots"):
        read_motion(tmp_path / "a.dat", format="webot") if (tmp_path / "a.dat").write_text("x") else None


@pytest.mark.parametrize("rate", [0.3, 7.0, 33.3, 99.9999995, 100.0, 100.0000005, 100.01])
def test_a_file_has_a_row_for_each_configuration(tmp_path: Path, rate: float) -> None:
    motion = Motion([0.5, 1.5], ["HeadYaw"], [[0.0], [1.0]])
    trajectory = motion.configurations(load_nao(), rate=rate)
    write_motion(motion, tmp_path / "a.csv", rate=rate)
    assert np.array_equal(read_motion(tmp_path / "a.csv").times[0], trajectory.times)
    assert np.array_equal(resample(motion, rate).times[0], trajectory.times)
    assert (trajectory.times[0], trajectory.times[-1]) == (0.5, 1.5)
    assert np.diff(trajectory.times).min() > 1e-6 / rate


def test_a_format_that_is_only_read_is_not_written(whole_body: Motion, tmp_path: Path) -> None:
    assert sorted(set(FORMATS) - set(WRITTEN)) == ["bhuman", "naodevils", "xap"]
    for name, options in (("a.kfm", {}), ("a.cfg", {}), ("a.xap", {}), ("a.json", {"format": "bhuman"})):
        with pytest.raises(BadArgument, match="files are only read; write one of: csv"):
            write_motion(whole_body, tmp_path / name, **options)
        assert not (tmp_path / name).exists()


def test_a_joint_of_webots_is_free_outside_its_own_keys_when_sampled_too(tmp_path: Path) -> None:
    wave = Motion([[0.0, 1.0], [0.5, 0.75]], ["LShoulderRoll", "LHand"], [[0.2, 1.0], [0.0, 1.0]])
    write_motion(wave, tmp_path / "a.motion", rate=4.0)
    lines = (tmp_path / "a.motion").read_text().splitlines()
    assert [line.split(",")[-1] for line in lines[1:]] == ["*", "*", "0.0", "1.0", "*"]


def test_a_table_may_be_written_in_degrees(tmp_path: Path) -> None:
    nod = Motion([0.0, 0.5], ["HeadPitch", "LHand"], [[0.0, 1.0], [math.pi / 6.0, 0.5]])
    write_motion(nod, tmp_path / "nod.csv", degrees=True)
    assert float((tmp_path / "nod.csv").read_text().splitlines()[2].split(",")[1]) == pytest.approx(30.0)
    found = read_motion(tmp_path / "nod.csv")  # the headings say so
    assert np.allclose([*found.keys], [*nod.keys], atol=1e-12)
