"""Targets of inverse kinematics from files and from rows of numbers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument, BadInputFile, UnknownName


@pytest.mark.parametrize("style", ["matrix", "quaternion", "rpy"])
@pytest.mark.parametrize("degrees", [False, True])
def test_poses_written_by_fk_are_read_back(nao: nk.NaoModel, tmp_path: Path, style: str, degrees: bool) -> None:
    q, path = nao.random(1, 6), tmp_path / "feet.csv"
    nk.stream.fk(nao, nk.stream.Configurations(q), path, frame=["LLeg", "RLeg"], as_=style, degrees=degrees)
    one = nk.stream.read_targets(nao, path, "RLeg")
    assert (one.kind, one.many, one.notes) == ("pose", True, ())
    np.testing.assert_allclose(one.values, nao.fk(q, "RLeg"), atol=1e-12)
    both = nk.stream.read_targets(nao, path, ["RLeg", "LLeg"])
    np.testing.assert_allclose(both.values, nao.fk(q, ["RLeg", "LLeg"]), atol=1e-12)


def test_numbers_of_several_frames_stand_one_after_another(nao: nk.NaoModel, tmp_path: Path) -> None:
    T = nao.fk(nao.random(2, 3), ["LLeg", "RLeg", "LArm"])
    np.save(tmp_path / "three.npy", T)
    found = nk.stream.read_targets(nao, tmp_path / "three.npy", ["LLeg", "RLeg", "LArm"])
    assert np.array_equal(found.values, T)
    with pytest.raises(BadArgument, match="9 numbers; expected 18, 21 or 48 for the poses of 3 frames"):
        nk.stream.Targets.of(np.zeros((2, 9)), frames=3)


def test_a_table_may_have_comments_semicolons_and_decimal_commas(nao: nk.NaoModel, tmp_path: Path) -> None:
    path = tmp_path / "hands.csv"
    path.write_text("# from a spreadsheet\nframe;x;y;z\nLArm;0,15;0,12;0,05\nRArm;0,1;-0,1;0\nLArm;0,2;0,1;0\n")
    found = nk.stream.read_targets(nao, path, "LArm")
    assert found.kind == "position"
    assert found.values.tolist() == [[0.15, 0.12, 0.05], [0.2, 0.1, 0.0]]


def test_a_wrong_target_is_named_with_its_line(nao: nk.NaoModel, tmp_path: Path) -> None:
    path = tmp_path / "hands.csv"
    path.write_text("frame,r0,r1,r2,r3\nRArm,2,0,0,0\nLArm,1,0,0,0\nLArm,0,0,0,0\n")
    with pytest.raises(BadInputFile, match="line 4: 4 numbers are an orientation as a quaternion"):
        nk.stream.read_targets(nao, path, "LArm")
    with pytest.raises(BadInputFile, match="2 targets for LArm, 1 for RArm"):
        nk.stream.read_targets(nao, path, ["RArm", "LArm"])
    with pytest.raises(UnknownName, match="nearest: LArm"):
        nk.stream.read_targets(nao, path, "LArn")
    (tmp_path / "away.json").write_text(json.dumps({"reference": "Head", "poses": {"LArm": [0, 0, 0]}}))
    with pytest.raises(BadInputFile, match='poses in "Head"'):
        nk.stream.read_targets(nao, tmp_path / "away.json", "LArm")


def test_angles_of_targets_are_in_degrees_if_asked(nao: nk.NaoModel, tmp_path: Path) -> None:
    rows = np.array([[0.1, 0.0, 0.2, 10.0, 20.0, 30.0], [0.1, 0.0, 0.2, -10.0, 0.0, 90.0]])
    turned = rows * [1.0, 1.0, 1.0, *np.radians([1.0] * 3)]
    expected = nk.stream.Targets.of(turned).values
    np.testing.assert_allclose(nk.stream.Targets.of(rows, degrees=True).values, expected, atol=1e-15)
    np.save(tmp_path / "rows.npy", rows)
    np.testing.assert_allclose(
        nk.stream.read_targets(nao, tmp_path / "rows.npy", "LArm", degrees=True).values, expected, atol=1e-15
    )
