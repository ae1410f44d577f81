from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pytest
from loops import for_all

import nao_kin as nk
from nao_kin._core.files import read_toml
from nao_kin.errors import UnknownName
from nao_kin.robot.nao import (
    COUPLED_LIMITS,
    INERTIALS,
    LIMITS,
    OFFSETS,
    SOURCES,
    VERSIONS,
    Version,
    nao_parameters,
)
from nao_kin.robot.nao.model import nao_urdf_path
from nao_kin.robot.nao.parameters import ACTUATORS, CAMERA_ROWS, FRAMES, PLACEHOLDER, VISUALS, version_named
from nao_kin.robot.nao.rows import FrameRow, LimitRow, OffsetRow, VersionPage, VersionTables, overlaid
from nao_kin.robot.nao.tables import (
    FINGERS,
    FITTED_SHAPES,
    JOINTS,
    NAOQI_SHAPES,
    PAGES,
    POSTURES,
    RESOLUTIONS,
    SOLE_OUTLINES,
    TABLES,
    V6,
    tables_of,
)
from nao_kin.robot.semantics import Mimic
from nao_kin.robot.urdf.reader import read_urdf

ROOT = Path(__file__).resolve().parents[3]

# Aldebaran's totals [kg]; V3.2's printed total rounds away 0.2 g.
MASSES = {"v6": 5.35975, "v5": 5.30535, "v4": 5.19535, "v3.3": 5.00591, "v3.2": 4.83592}


@for_all("version", VERSIONS)
def test_the_masses_add_up_to_the_published_total(version: str) -> None:
    assert nao_parameters(version).mass == pytest.approx(MASSES[version], abs=2e-4 if version == "v3.2" else 1e-9)


@for_all(
    ("rows", "key"),
    [
        (OFFSETS, "name"),
        (LIMITS, "joint"),
        (ACTUATORS, "joint"),
        (INERTIALS, "link"),
        (FRAMES, "name"),
        (VISUALS, "key"),
    ],
)
def test_a_number_stands_once_for_each_version(rows: tuple, key: str) -> None:
    found = Counter((getattr(row, key), version) for row in rows for version in row.versions)
    assert [pair for pair, count in found.items() if count > 1] == []


def test_every_row_names_a_known_source() -> None:
    tables = (
        OFFSETS,
        JOINTS,
        FINGERS,
        LIMITS,
        ACTUATORS,
        COUPLED_LIMITS,
        INERTIALS,
        FRAMES,
        CAMERA_ROWS,
        RESOLUTIONS,
        NAOQI_SHAPES,
        SOLE_OUTLINES,
        FITTED_SHAPES,
        VISUALS,
        (PLACEHOLDER,),
        POSTURES,
    )
    assert {row.source for table in tables for row in table} <= SOURCES.keys()


VERSION_NAMES = {
    "v6": ["v6", "V6", "6", " v6 ", "v6.0", "V6.0", "6.0", "\tV6\n"],
    "v5": ["v5", "5", "v5.0", "5.0"],
    "v4": ["v4", "4", "v4.0", "4.0"],
    "v3.3": ["v3.3", "V3.3", "3.3", " 3.3"],
    "v3.2": ["v3.2", "V3.2", "3.2", "3.2 "],
}


@for_all(("version", "name"), [(v, name) for v, names in VERSION_NAMES.items() for name in names])
def test_a_version_is_found_however_it_is_written(version: str, name: str) -> None:
    assert version_named(name) == version
    assert nao_parameters(name) is nao_parameters(version)


@for_all(
    "name",
    [
        *"3.2.0 v3.2.0 3.3.0 6.0.0 v6.0.0 6. 6.00 6.1 06 60 vv6 v v. 3 v3 3.20 3.02 32 v32 3,2 .6 6v six V6H25".split(),
        *("", " ", "v 6", "3. 2", "v6 v5"),
    ],
)
def test_a_version_is_not_found_when_it_is_written_otherwise(name: str) -> None:
    with pytest.raises(UnknownName, match="unknown NAO version"):
        version_named(name)


def test_the_leg_effector_and_the_documented_foot_height_are_two_numbers() -> None:
    offsets = nao_parameters("v6").offsets
    assert offsets["LegEffectorHeight"] == 0.04511
    assert offsets["FootHeight"] == 0.04519
    nao = nk.load_nao()
    q = nao.neutral()
    assert nao.position(q, "LLeg")[2] == pytest.approx(-0.33301, abs=1e-12)
    assert nao.position(q, "LFoot/Sole")[2] == pytest.approx(-0.33309, abs=1e-12)


# --- versions as pages ------------------------------------------------------------------------------------------------


def test_v6_is_complete_and_every_other_version_has_one_page() -> None:
    assert get_args(Version) == VERSIONS
    assert sorted(["v6", *(page.version for page in PAGES)]) == sorted(VERSIONS)
    assert TABLES["v6"] is V6
    assert TABLES.keys() == set(VERSIONS)


def test_the_version_of_the_recipe_can_be_added_as_its_page_says(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "model.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^```toml\n(# nao_kin/robot/nao/tables\.toml\n.*?)^```", text, re.MULTILINE | re.DOTALL)
    (tmp_path / "page.toml").write_text(code, encoding="utf-8")
    ((version, given),) = read_toml(tmp_path / "page.toml")["versions"].items()
    page = VersionPage(version=version, **tables_of(given))
    tables = page.over(V6)
    changed = {name: set(getattr(tables, name)) - set(getattr(V6, name)) for name in ("offsets", "frames", "inertials")}
    assert changed == {name: set(getattr(page, name)) for name in changed}
    assert {row.key for row in tables.inertials} == {row.key for row in V6.inertials}
    assert [row.value_mm for row in tables.offsets if row.name == "TibiaLength"] == [104.0]
    assert (tables.limits, tables.colours, len(tables.visuals)) == (V6.limits, V6.colours, len(V6.visuals))
    assert _links_of_the_old_length(page) == []


def _links_of_the_old_length(page: VersionPage) -> list[str]:
    """The links whose length the page changes, and whose meshes or inertia it leaves as they are in the base."""
    base, changed = TABLES[page.base], {row.name for row in page.offsets}
    tables = page.over(base)
    shaped = {row.parent for row in tables.visuals}
    links = {
        joint.parent
        for joint in JOINTS
        if joint.name in shaped and changed & {at.lstrip("-") for at in joint.origin if isinstance(at, str)}
    }

    def bodies(of: VersionTables, link: str) -> tuple[list, list]:
        return [row for row in of.visuals if row.parent == link], [row for row in of.inertials if row.link == link]

    return sorted(
        link
        for link in links
        if any(new == old for new, old in zip(bodies(tables, link), bodies(base, link), strict=True))
    )


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.version)
def test_a_link_of_another_length_has_meshes_and_an_inertia_of_its_own(page: VersionPage) -> None:
    assert _links_of_the_old_length(page) == []


def test_a_longer_thigh_with_the_shapes_of_the_short_one_is_found() -> None:
    page = VersionPage(version="v5", base="v6", offsets=(OffsetRow("ThighLength", 110.0, "L6"),))
    assert _links_of_the_old_length(page) == ["LHipPitch", "RHipPitch"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.version)
def test_a_page_says_only_what_differs(page: VersionPage) -> None:
    base = TABLES[page.base]
    for name in ("offsets", "limits", "actuators", "inertials", "frames", "visuals"):
        assert not set(getattr(page, name)) & set(getattr(base, name)), name
        keys = [row.key for row in getattr(page, name)]
        assert len(set(keys)) == len(keys), name
        assert not set(keys) & {*page.without_frames, *page.without_visuals}, name


def test_the_versions_of_a_row_are_those_whose_tables_hold_it() -> None:
    for name, table in {"offsets": OFFSETS, "limits": LIMITS, "frames": FRAMES, "inertials": INERTIALS}.items():
        for version in VERSIONS:
            held = {replace(row, versions=()) for row in table if version in row.versions}
            assert held == set(getattr(TABLES[version], name)), (name, version)
    assert PLACEHOLDER.versions == ("v3.2", "v3.3", "v4", "v5")
    newer, older = (row.versions for row in OFFSETS if row.name == "ElbowOffsetY")
    assert (newer[:4], older) == (("v3.3", "v4", "v5", "v6"), ("v3.2",))


def _frame(name: str, parent: str, x: float = 0.0) -> FrameRow:
    return FrameRow(name, None, parent, (x, 0.0, 0.0), (0.0, 0.0, 0.0), "U6")


BASE = (_frame("a", "torso"), _frame("b", "head"), _frame("c", "head"), _frame("d", "torso"))


@for_all(
    ("changes", "without", "names"),
    [
        ([], [], "abcd"),
        ([_frame("b", "head", 1.0)], [], "abcd"),
        ([], ["b", "d"], "ac"),
        ([_frame("x", "head")], [], "abcxd"),
        ([_frame("x", "torso")], [], "abcdx"),
        ([_frame("x", "head"), _frame("y", "head")], ["b"], "axycd"),
        ([_frame("x", "torso"), _frame("y", "head")], ["b", "a"], "xycd"),
    ],
)
def test_rows_are_changed_left_out_and_added_in_their_places(
    changes: list[FrameRow], without: list[str], names: str
) -> None:
    rows = overlaid("frame", BASE, changes, without)
    assert "".join(row.name for row in rows) == names
    assert all(row in rows for row in changes)


def test_a_page_that_speaks_of_what_its_base_does_not_have_is_refused() -> None:
    with pytest.raises(UnknownName, match=r"unknown frame of v6, which v5 is laid over 'Gase' \(nearest: Gaze"):
        VersionPage(version="v5", base="v6", without_frames=("Gase",)).over(V6)
    with pytest.raises(UnknownName, match=r"unknown limit of v6, which v5 is laid over 'HeadYow'"):
        VersionPage(version="v5", base="v6", limits=(LimitRow("HeadYow", 0.0, 1.0, "deg", "J6"),)).over(V6)
    with pytest.raises(UnknownName, match="unknown frame"):
        VersionPage(version="v5", base="v6", frames=(_frame("x", "Tail"),)).over(V6)


def test_every_coordinate_is_a_number_or_names_an_offset() -> None:
    coordinates = {at for row in (*JOINTS, *FRAMES) for at in (row.origin if row in JOINTS else row.xyz)}
    named = {at.removeprefix("-") for at in coordinates if isinstance(at, str)}
    assert named == {row.name for row in OFFSETS}
    assert "-ThighLength" in coordinates
    assert nao_parameters("v6").joint("LKneePitch").xyz == (0.0, 0.0, -nao_parameters("v6").offsets["ThighLength"])


# --- the resolved parameters ------------------------------------------------------------------------------------------


@for_all("version", VERSIONS)
def test_the_phalanges_are_those_of_the_urdf_read_back(version: str) -> None:
    joints = {joint.name: joint for joint in read_urdf(nao_urdf_path(version)).joints}
    fingers = nao_parameters(version).fingers
    assert [finger.name for finger in fingers] == [name for name in joints if "Finger" in name or "Thumb" in name]
    assert len(fingers) == 16
    for finger in fingers:
        joint = joints[finger.name]
        assert (finger.parent_link, finger.link) == (joint.parent, joint.child)
        assert joint.mimic == Mimic(finger.driver, finger.multiplier)
        assert joint.child == f"{finger.driver[0]}{finger.phalanx}_link"
        assert finger.name == f"{finger.driver}{finger.phalanx}"
        hand = nao_parameters(version).joint(finger.driver)
        assert (finger.lower, finger.upper) == (0.0, finger.multiplier * hand.upper)
        assert (finger.velocity, finger.effort) == (finger.multiplier * hand.velocity, hand.effort)


@for_all("version", VERSIONS)
def test_a_phalanx_is_carried_by_the_joint_that_moves_its_parent_link(version: str) -> None:
    parameters = nao_parameters(version)
    links = {row.name: row.link for row in (*parameters.joints, *parameters.fingers)}
    assert all(links[finger.parent] == finger.parent_link for finger in parameters.fingers)


def test_a_joint_without_a_motor_of_its_own_is_a_mimic_and_no_other() -> None:
    parameters = nao_parameters()
    hip = replace(parameters.joint("RHipYawPitch"), mimic=None)
    freed = replace(parameters, joints=tuple(hip if row.name == hip.name else row for row in parameters.joints))
    assert parameters.mimics.keys() - freed.mimics.keys() == {"RHipYawPitch"}


def test_joints_and_frames_are_found_by_name() -> None:
    parameters = nao_parameters()
    assert all(parameters.joint(row.name) is row for row in parameters.joints)
    assert all(parameters.frame(row.name) is row for row in parameters.frames)
    with pytest.raises(UnknownName, match=r"unknown joint 'HeadYow' \(nearest: HeadYaw"):
        parameters.joint("HeadYow")
    with pytest.raises(UnknownName, match=r"unknown frame 'CameraTopp' \(nearest: CameraTop"):
        parameters.frame("CameraTopp")


def test_the_parameters_cannot_be_changed() -> None:
    parameters = nao_parameters()
    for mapping in (parameters.offsets, parameters.inertials, parameters.mimics):
        with pytest.raises(TypeError):
            mapping["NeckOffsetZ"] = 0.0  # type: ignore[index]
