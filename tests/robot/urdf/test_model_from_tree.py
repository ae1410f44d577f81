"""The Pinocchio model made joint by joint, against the one Pinocchio's own parser makes of the same file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from made_up_robots import J, made_up

import nao_kin as nk

ROBOTS = ("ur5_robot", "talos_reduced", "anymal-kinova", "panda", "double_pendulum", "human", "romeo_small", "xarm7")


def _compare(robot: nk.RobotModel, parsed: pin.Model) -> None:
    model = robot.model

    def same(ours: pin.SE3, theirs: pin.SE3) -> bool:
        return np.allclose(ours.homogeneous, theirs.homogeneous, atol=1e-12)

    assert list(model.names) == list(parsed.names)
    assert list(model.parents) == list(parsed.parents)
    for index in range(1, parsed.njoints):
        ours, theirs = model.joints[index], parsed.joints[index]
        if theirs.nq == 1:  # an unlimited joint has one coordinate here, two there
            assert ours.shortname() == theirs.shortname()
            for name in ("upperVelocityLimit", "upperEffortLimit", "damping", "upperDryFrictionLimit"):
                limit = getattr(parsed, name)[theirs.idx_v]
                if name == "upperVelocityLimit" and limit == 0.0:
                    limit = np.inf  # not filled in, there
                assert getattr(model, name)[ours.idx_v] == limit, name
        assert same(model.jointPlacements[index], parsed.jointPlacements[index])
    for ours, theirs in zip(model.inertias, parsed.inertias, strict=True):
        assert np.allclose(ours.toDynamicParameters(), theirs.toDynamicParameters(), rtol=1e-12, atol=1e-12)
    assert len(model.frames) == len(parsed.frames)
    for ours, theirs in zip(model.frames, parsed.frames, strict=True):
        assert (ours.name, ours.type) == (theirs.name, theirs.type)
        assert (ours.parentJoint, ours.parentFrame) == (theirs.parentJoint, theirs.parentFrame)
        assert same(ours.placement, theirs.placement)
        assert ours.inertia.mass == pytest.approx(theirs.inertia.mass, abs=1e-12)


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_every_nao_is_the_model_pinocchio_reads(each_nao: nk.NaoModel, base: str) -> None:
    robot = nk.load_nao(each_nao.version, base=base)
    roots = (pin.JointModelFreeFlyer(),) if base == "floating" else ()
    parsed = pin.buildModelFromUrdf(str(robot.urdf_path), *roots, mimic=True)
    _compare(robot, parsed)
    for name in ("lowerPositionLimit", "upperPositionLimit", "rotorGearRatio", "rotorInertia", "armature"):
        assert np.array_equal(getattr(robot.model, name), getattr(parsed, name)), name
    assert robot.model.gravity == parsed.gravity


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("name", ROBOTS)
def test_other_robots_are_the_models_pinocchio_reads(name: str, base: str) -> None:
    robot = nk.load_robot(name, base=base)
    roots = (pin.JointModelFreeFlyer(),) if base == "floating" else ()
    _compare(robot, pin.buildModelFromUrdf(str(robot.urdf_path), *roots, mimic=True))


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_turned_and_full_tensors_keep_every_entry(tmp_path: Path, base: str) -> None:
    robot = made_up(tmp_path, J("a", axis=(1.0, 2.0, 3.0)), J("b", kind="prismatic", axis=(0.0, 1.0, 0.0)))
    text = robot.urdf_path.read_text(encoding="utf-8")
    # Three different products of inertia, in axes that are turned about all three.
    text = text.replace('ixy="0.001" ixz="-0.002" iyz="0.001"', 'ixy="0.001" ixz="-0.002" iyz="0.003"')
    text = text.replace('"/><mass', '" rpy="0.3 -0.5 0.7"/><mass')
    robot.urdf_path.write_text(text, encoding="utf-8")
    roots = (pin.JointModelFreeFlyer(),) if base == "floating" else ()
    robot = nk.RobotModel.from_urdf(robot.urdf_path, base=base)
    parsed = pin.buildModelFromXML(text, *roots)
    for ours, theirs in zip(robot.model.inertias, parsed.inertias, strict=True):
        assert np.allclose(ours.toDynamicParameters(), theirs.toDynamicParameters(), rtol=1e-12, atol=1e-14)
    turned = robot.model.inertias[1].inertia
    assert len({round(abs(turned[i, j]), 9) for i, j in ((0, 1), (0, 2), (1, 2))}) == 3


def test_a_joint_without_an_axis_turns_about_x(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    path.write_text(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="J" type="continuous">'
        '<parent link="a"/><child link="b"/></joint></robot>'
    )
    R = nk.RobotModel.from_urdf(path).rotation([0.5], "b")
    assert R[0].tolist() == [1.0, 0.0, 0.0]
    assert R[2, 1] == pytest.approx(np.sin(0.5))


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("name", ["universe", "root_joint", "world"])
def test_a_joint_may_have_any_name_that_pinocchio_uses_itself(tmp_path: Path, name: str, base: str) -> None:
    def robot(driver: str) -> nk.RobotModel:
        return made_up(
            tmp_path,
            J(driver, limits=(-0.5, 1.0)),
            J("b", axis=(1, 0, 0), xyz=(1, 0, 0), follows=(driver, -2, 0.1)),
            base=base,
        )

    plain, named = robot("a"), robot(name)
    assert named.joint_names == (name,)
    assert len(named.model.frames) == len(plain.model.frames)
    for limits in ("lowerPositionLimit", "upperPositionLimit", "upperVelocityLimit", "upperEffortLimit"):
        assert np.array_equal(getattr(named.model, limits), getattr(plain.model, limits)), limits
    for q in plain.random(0, 3):
        assert np.array_equal(named.fk(q), plain.fk(q))
        assert np.array_equal(named.fk(q, name), plain.fk(q, "a"))
        assert np.array_equal(named.jacobian(q, "b_l"), plain.jacobian(q, "b_l"))
