"""The limbs that the closed forms solve, as plain data."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import nao_kin as nk


def test_limbs_are_plain_and_those_of_the_robot(nao: nk.NaoModel) -> None:
    limbs = nk.ik.limbs(nao)
    assert json.loads(json.dumps(limbs, allow_nan=False)) == limbs
    assert [(limb["kind"], limb["side"], limb["frame"]) for limb in limbs] == [
        ("arm", "L", "LArm"),
        ("arm", "R", "RArm"),
        ("leg", "L", "LLeg"),
        ("leg", "R", "RLeg"),
        ("head", "", "Head"),
        ("gaze", "", "CameraTop"),
        ("gaze", "", "CameraBottom"),
    ]
    for limb in limbs:
        rows = [nao.joint_names.index(name.replace("RHipYaw", "LHipYaw")) for name in limb["joints"]]
        assert limb["columns"] == rows
        np.testing.assert_array_equal(limb["lower"], nao.lower[rows])
        np.testing.assert_array_equal(limb["upper"], nao.upper[rows])
        tables = [table for table in nao.coupled_limits if table.joint in limb["joints"]]
        assert (limb["table"] is not None) == bool(tables)
        for table in tables:
            described = limb["table"]
            assert limb["joints"][described["joint"]] == table.joint
            assert limb["joints"][described["of"]] == table.of
            assert [described[key] for key in ("at", "lower", "upper")] == [
                list(column) for column in (table.at, table.lower, table.upper)
            ]
    moved = nk.load_nao()
    hip = int(moved.model.getJointId("LHipYawPitch"))
    moved.model.jointPlacements[hip].translation += np.array([0.001, 0.0, 0.0])
    hips = [nk.ik.limbs(robot)[2]["geometry"]["hip"][0] for robot in (moved, nao)]
    assert hips[0] == hips[1] + 0.001


def test_a_robot_without_such_limbs_has_none(tmp_path: Path) -> None:
    path = tmp_path / "bare.urdf"
    path.write_text('<robot name="bare"><link name="only"/></robot>', encoding="utf-8")
    assert nk.ik.limbs(nk.RobotModel.from_urdf(path)) == []


def test_the_limb_of_one_frame_is_described_alone(nao: nk.NaoModel) -> None:
    by_frame = {limb["frame"]: limb for limb in nk.ik.limbs(nao)}
    for frame in ("LArm", "RLeg", "Head"):
        assert nk.ik.limbs(nao, frame=frame) == [by_frame[frame]]
    (leg,) = nk.ik.limbs(nao, "LFoot")
    assert (leg["kind"], leg["side"], leg["frame"]) == ("leg", "L", "LFoot")
    assert nk.ik.limbs(nao, "torso") == []
