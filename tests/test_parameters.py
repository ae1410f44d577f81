from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import UnknownName
from nao_kin.parameters import (
    ACTUATORS,
    BODY_ORDER,
    CHAINS,
    COLLISION_SHAPES,
    COUPLED_LIMITS,
    FINGERS,
    FRAMES,
    INERTIALS,
    JOINTS,
    LIMITS,
    OFFSETS,
    POSTURES,
    SOURCES,
    VERSIONS,
    nao_parameters,
    version_named,
)

# Aldebaran's totals [kg]; V3.2's printed total rounds away 0.2 g.
MASSES = {"v6": 5.35975, "v5": 5.30535, "v4": 5.19535, "v3.3": 5.00591, "v3.2": 4.83592}

# Tensors that no body can have (the largest moment exceeds the sum of the others); kept as published.
PUBLISHED_MISPRINTS = {
    ("LHipRoll", ("v3.2", "v3.3")),
    ("RHipRoll", ("v3.2", "v3.3")),
    ("RAnkleRoll", ("v3.2",)),
}


@pytest.mark.parametrize("version", VERSIONS)
def test_the_masses_add_up_to_the_published_total(version: str) -> None:
    assert nao_parameters(version).mass == pytest.approx(MASSES[version], abs=2e-4 if version == "v3.2" else 1e-9)


@pytest.mark.parametrize(
    ("rows", "key"),
    [(OFFSETS, "name"), (LIMITS, "joint"), (ACTUATORS, "joint"), (INERTIALS, "link"), (FRAMES, "name")],
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
        COLLISION_SHAPES,
        POSTURES,
    )
    assert {row.source for table in tables for row in table} <= SOURCES.keys()


@pytest.mark.parametrize("version", VERSIONS)
def test_every_version_is_complete(version: str) -> None:
    parameters = nao_parameters(version)
    assert tuple(joint.name for joint in parameters.joints) == BODY_ORDER
    assert len(BODY_ORDER) == 26
    assert parameters.inertials.keys() == {"torso", *BODY_ORDER} - {"LHand", "RHand"}
    assert {"LArm", "RArm", "LLeg", "RLeg", "CameraTop", "CameraBottom"} <= {frame.name for frame in parameters.frames}
    assert all(joint.lower < joint.upper for joint in parameters.joints)


def test_the_chains_hold_every_joint_once() -> None:
    assert [name for chain in CHAINS.values() for name in chain] == list(BODY_ORDER)


@pytest.mark.parametrize("version", VERSIONS)
def test_axes_are_unit_vectors_at_full_precision(version: str) -> None:
    for joint in nao_parameters(version).joints:
        assert np.linalg.norm(joint.axis) == pytest.approx(1.0, abs=3e-16)


@pytest.mark.parametrize("row", INERTIALS, ids=lambda row: f"{row.link}-{row.versions[0]}")
def test_inertia_tensors_belong_to_real_bodies(row) -> None:
    ixx, ixy, ixz, iyy, iyz, izz = row.inertia
    moments = np.linalg.eigvalsh([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    assert moments[0] > 0
    if (row.link, row.versions) not in PUBLISHED_MISPRINTS:
        assert moments[0] + moments[1] >= moments[2]


@pytest.mark.parametrize("row", COUPLED_LIMITS, ids=lambda row: row.joint)
def test_coupled_tables_ascend_and_have_room(row) -> None:
    at, lower, upper = np.array(row.table_deg).T
    assert np.all(np.diff(at) > 0)
    assert np.all(lower < upper)


def test_left_and_right_ankle_tables_mirror_each_other() -> None:
    tables = {row.joint: np.array(row.table_deg) for row in COUPLED_LIMITS}
    assert np.array_equal(tables["LAnkleRoll"] * [1, -1, -1], tables["RAnkleRoll"][:, [0, 2, 1]])


@pytest.mark.parametrize("name", ["v6", "V6", "6", " v6 ", "v6.0"])
def test_a_version_is_found_however_it_is_written(name: str) -> None:
    assert version_named(name) == "v6"


def test_an_unknown_version_is_answered_with_the_valid_ones() -> None:
    with pytest.raises(UnknownName, match=r"unknown NAO version 'v7' \(nearest: v6"):
        nao_parameters("v7")


def test_the_leg_effector_and_the_documented_foot_height_are_two_numbers() -> None:
    offsets = nao_parameters("v6").offsets
    assert offsets["LegEffectorHeight"] == 0.04511
    assert offsets["FootHeight"] == 0.04519
    nao = nk.load_nao()
    q = nao.neutral()
    assert nao.position(q, "LLeg")[2] == pytest.approx(-0.33301, abs=1e-12)
    assert nao.position(q, "LFoot/Sole")[2] == pytest.approx(-0.33309, abs=1e-12)
