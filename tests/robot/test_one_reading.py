"""A URDF is parsed once; all that is made of it afterwards comes from the tree that the robot keeps."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.crosscheck.steps import steps_of
from nao_kin.joints import JointAxes, MultiDofModel, group_joints, joint_table
from nao_kin.robot import topology
from nao_kin.robot.urdf import document


def test_after_loading_nobody_reads_the_file_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parsed = []
    original = document._document
    monkeypatch.setattr(document, "_document", lambda *given: parsed.append(len(given[1])) or original(*given))
    path = made_up(tmp_path, J("a"), J("b", axis=(1.0, 0.0, 0.0)), J("c", follows=("a", 0.5, 0.0))).urdf_path
    parsed.clear()
    robot = nk.RobotModel.from_urdf(path)
    assert len(parsed) == 1
    path.unlink()
    nk.Viewer(robot).display([0.3, 0.2])
    topology(robot)
    group_joints(robot)
    joint_table(robot, typed=True)
    MultiDofModel(robot).fk(MultiDofModel(robot).neutral())
    steps_of(robot)
    q = robot.random(0)
    assert np.allclose(JointAxes(robot).jacobian(q, "c_l"), robot.jacobian(q, "c_l"), atol=1e-12)
    for other in (copy.deepcopy(robot), pickle.loads(pickle.dumps(robot))):
        assert np.array_equal(other.fk(q), robot.fk(q))
    assert len(parsed) == 1


def test_a_version_of_the_nao_is_read_once_in_a_process(monkeypatch: pytest.MonkeyPatch) -> None:
    nk.load_nao("v4")
    monkeypatch.setattr(document, "_document", lambda *given: pytest.fail("read again"))
    first, second = nk.load_nao("v4"), nk.load_nao("4", base="floating")
    assert first.tree is second.tree
    assert first.model is not second.model
