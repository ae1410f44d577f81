"""Words of a URDF that nobody reads are noted, and extensions of other programs are not."""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Callable
from pathlib import Path

import pytest

import nao_kin as nk
from nao_kin.errors import BadModel
from nao_kin.robot.urdf.reader import read_urdf

Read = Callable[..., nk.RobotModel]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """A robot of two links, with more in its joint, in its second link and beside both."""

    def read(joint: str = "", link: str = "", robot: str = "", kind: str = "fixed") -> nk.RobotModel:
        path = tmp_path / "r.urdf"
        path.write_text(
            f'<robot name="r" xmlns:a="of another"><link name="a"/><link name="b">{link}</link>'
            f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>{joint}</joint>{robot}</robot>'
        )
        return nk.RobotModel.from_file(path)

    return read


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ('<pose xyz=".3 0 .8"/>', ("<joint>", "<pose>", "<origin>")),
        ('<origin pos=".3 0 .8"/>', ("<origin>", "pos", "xyz")),
        ("<origin>.3 0 .8</origin>", ("<origin>", "text", ".3 0 .8")),
        ('<origin xyz=".3 0 .8"/><origin xyz="1 1 1"/>', ("<joint>", "second", "<origin>")),
        ('<origin rpy="90 0 0"/>', ("degrees", "90 0 0")),
        ('<limits lower="-1" upper="1"/>', ("<joint>", "<limits>", "<limit>")),
        ('<limit min="-1" max="1"/>', ("<limit>", "min", "lower", "max", "upper")),
        ('<dynamics damp="2"/>', ("<dynamics>", "damp", "damping")),
    ],
)
def test_words_of_a_joint_that_nobody_reads(read: Read, wrong: str, named: tuple[str, ...]) -> None:
    (note,) = read(wrong).load_notes
    assert all(word in note for word in named)
    assert "'j'" in note


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ('<Visual><geometry><sphere radius="1"/></geometry></Visual>', ("<link>", "<Visual>", "<visual>")),
        ('<origin xyz="0 0 1"/>', ("<link>", "<origin>", "<joint>", "<visual>")),
        ('<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" iyx="2"/></inertial>', ("<inertia>", "iyx")),
        ('<visual><geometry><box size="1 1 1"/><box size="2 2 2"/></geometry></visual>', ("<geometry>", "second")),
        ('<collision><pose>1 0 0</pose><geometry><box size="1 1 1"/></geometry></collision>', ("<pose>", "<origin>")),
        ('<collision><origin rpy="0 0 180"/><geometry><box size="1 1 1"/></geometry></collision>', ("0 0 180",)),
    ],
)
def test_words_of_a_link_that_nobody_reads(read: Read, wrong: str, named: tuple[str, ...]) -> None:
    (note,) = read("", wrong).load_notes
    assert all(word in note for word in named)
    assert "'b'" in note


def test_misspelt_and_misplaced_words_beside_links_and_joints_are_noted(read: Read) -> None:
    (note,) = read(
        robot='<Link name="c"/><limit lower="1"/><joints/><gazebo/><sensor/><group_state name="x"/>'
    ).load_notes
    assert all(word in note for word in ("<robot>", "<Link>", "<limit>", "<joints>"))
    assert all(word not in note for word in ("gazebo", "sensor", "group_state"))


def test_words_of_both_versions_and_of_other_programs_give_no_note(read: Read) -> None:
    robot = read(
        '<origin xyz="0 0 1" rpy="-6.2832 0 0"/><calibration rising="1"/><dynamics damping="1" a:more="1"/>'
        '<safety_controller k_velocity="1"/><limit lower="0" upper="1" velocity="1" effort="1" acceleration="2"/>'
        '<axis xyz="0 0 1"/><a:plugin what="1"/><gazebo><pose>1</pose></gazebo><sensor/>',
        '<contact><mu value="1"/></contact><visual name="v"><geometry><capsule radius="1" length="1"/></geometry>'
        '<material name="m"><color rgba="1 1 1 1"/><texture filename="t"/></material></visual><visual><geometry>'
        '<box size="1 1 1"/></geometry></visual><collision><geometry><box size="1 1 1"/></geometry>'
        '<verbose value="x"/></collision>',
        kind="prismatic",
    )
    assert robot.load_notes == ()


def test_a_word_is_noted_once_with_its_count(tmp_path: Path) -> None:
    joints = "".join(
        f'<joint name="j{k}" type="fixed"><parent link="l{k}"/><child link="l{k + 1}"/><origin pos="0 0 1"/></joint>'
        for k in range(12)
    )
    links = "".join(f'<link name="l{k}"/>' for k in range(13))
    path = tmp_path / "r.urdf"
    path.write_text(f'<robot name="r">{links}{joints}</robot>')
    (note,) = nk.RobotModel.from_file(path).load_notes
    assert "12 times" in note
    assert "'j0'" in note


def test_real_files_give_few_notes() -> None:
    try:
        files = [file for file in importlib.metadata.files("example-robot-data") or () if file.name.endswith(".urdf")]
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    # Currents and models of motors, and the place of a link that nobody moves there.
    odd = {"anymal", "panda", "so101"}
    found = set()
    for file in files:
        if file.stem in (*odd, "romeo", "ur5_robot", "talos_reduced", "solo12", "go2", "kinova"):
            notes = [note for note in read_urdf(Path(str(file.locate()))).notes if "not read in" in note]
            found |= {file.stem} if notes else set()
            assert len(notes) <= 1
    assert found == odd


# --- limits that are infinite


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize(
    ("limit", "lower", "upper"),
    [
        ('lower="-inf" upper="inf"', -math.inf, math.inf),
        ('lower=" -Infinity" upper="+INF "', -math.inf, math.inf),
        ('lower="-inf" upper="1.5"', -math.inf, 1.5),
        ('lower="-1.5" upper="inf"', -1.5, math.inf),
    ],
)
def test_an_infinite_limit_is_none(
    read: Read, tmp_path: Path, kind: str, limit: str, lower: float, upper: float
) -> None:
    robot = read(f'<limit {limit} velocity="1" effort="1"/>', kind=kind)
    assert (robot.lower[0], robot.upper[0]) == (lower, upper)
    (note,) = robot.load_notes
    assert ("lower" in note, "upper" in note) == (math.isinf(lower), math.isinf(upper))
    assert [len(robot.limit_violations([value])) for value in (-9.0, 9.0)] == [lower == -1.5, upper == 1.5]
    # The end that there is remains in the URDF that is written.
    nk.export.urdf(robot, tmp_path / "written.urdf", meshes="none")
    again = nk.RobotModel.from_file(tmp_path / "written.urdf")
    assert [bound for bound in (again.lower[0], again.upper[0]) if abs(bound) < 10.0] == [
        bound for bound in (lower, upper) if math.isfinite(bound)
    ]


@pytest.mark.parametrize("limit", ['lower="inf" upper="1"', 'lower="0" upper="-inf"', 'lower="nan" upper="1"'])
def test_a_range_that_begins_beyond_all_numbers_is_refused(read: Read, limit: str) -> None:
    with pytest.raises(BadModel, match="expected a number"):
        read(f"<limit {limit}/>", kind="revolute")
