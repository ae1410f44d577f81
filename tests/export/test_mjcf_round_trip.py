"""The NAO written for MuJoCo and read back: the same robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk

pytest.importorskip("mujoco", reason="MuJoCo reads MJCF")


@pytest.mark.parametrize("version", ["v6", "v3.2"])
def test_the_nao_comes_back_from_mujoco_as_it_went(tmp_path: Path, version: str) -> None:
    nao = nk.load_nao(version)
    nk.export.mjcf(nao, tmp_path / "nao", inertia="physical")
    robot = nk.RobotModel.from_mjcf(tmp_path / "nao" / "scene.xml")
    assert set(robot.joint_names) == set(nao.joint_names)
    assert set(robot.mimics) == set(nao.mimics)
    assert set(nao.link_names) <= set(robot.link_names)
    assert robot.semantics.cameras == nao.semantics.cameras
    assert set(robot.semantics.force_sensors) == set(nao.semantics.force_sensors)
    assert set(robot.posture_names) == set(nao.posture_names)
    columns = [nao.joint_names.index(name) for name in robot.joint_names]
    for ours in ("lower", "upper"):
        assert np.allclose(getattr(robot, ours), getattr(nao, ours)[columns], rtol=0.0, atol=1e-12), ours
    stall = [nao.semantics.stall_torques[name] for name in robot.joint_names]
    np.testing.assert_allclose(robot.effort_limits, stall)
    assert (robot.effort_limits > nao.effort_limits[columns]).all()
    q = nao.random(0, 20)
    assert np.allclose(robot.fk(q[:, columns], nao.link_names), nao.fk(q), rtol=0.0, atol=1e-12)
    for name in nao.posture_names:
        assert robot.angles(robot.posture(name)) == pytest.approx(nao.angles(nao.posture(name)))
