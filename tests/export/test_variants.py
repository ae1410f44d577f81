"""Variants of a robot's tree: what changes is said, and everything else stays."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from loops import EACH_VERSION
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument
from nao_kin.export.inertia import make_physical
from nao_kin.export.variants import Variant, align_axes, keep_frames, name_frames
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf import UrdfJoint, read_urdf


@pytest.mark.parametrize("frames", ["all", "none"])
def test_a_ball_stands_where_the_three_joints_were_at_zero(frames: str) -> None:
    nao = nk.load_nao("v6")
    tree, changes = Variant(coupling="independent", typed=True, frames=frames).tree_of(nao)
    balls = [joint for joint in tree.joints if joint.kind == "spherical"]
    assert [(ball.parent, ball.child) for ball in balls] == [("torso", "LThigh"), ("torso", "RThigh")]
    assert sum("are one spherical joint" in line for line in changes) == 2
    for ball in balls:
        expected = nao.fk(nao.configuration({}, limits="ignore"), ball.child, reference="torso")
        np.testing.assert_allclose(ball.origin.matrix, expected, atol=1e-15)
    still = nk.RobotModel(replace(tree, joints=tuple(_held(joint) for joint in tree.joints)))
    assert still.mass == pytest.approx(nao.mass, abs=1e-14)
    q = nao.configuration({"HeadYaw": 0.5, "LKneePitch": 1.0}, limits="ignore")
    values = {name: value for name, value in nao.angles(q).items() if name in still.joint_names}
    links = [link for link in tree.links if link in nao.link_names]
    np.testing.assert_allclose(
        still.fk(still.configuration(values, limits="ignore"), links), nao.fk(q, links), atol=1e-14
    )


def _held(joint: UrdfJoint) -> UrdfJoint:
    """The joint, or the ball held at its rest."""
    return replace(joint, kind="fixed") if joint.kind == "spherical" else joint


def test_joints_of_one_motor_make_no_ball() -> None:
    nao = nk.load_nao("v6")
    tree, changes = Variant(typed=True).tree_of(nao)
    assert tree.joints == nao.tree.joints
    assert changes[0].startswith("LHipYawPitch, LHipRoll, LHipPitch are not merged, because LHipYawPitch is coupled")
    assert Variant(typed=True, coupling="locked").tree_of(nao)[1][-1].startswith("no three joints have one centre")


def test_merged_links_leave_their_mass_and_shapes_where_they_were() -> None:
    nao = nk.load_nao("v5")
    tree, _ = keep_frames(nao.tree, "none", nao.semantics)
    sensors = sum(nao.tree.inertials[f"LFsr{place}_frame"].mass for place in ("FL", "FR", "RL", "RR"))
    assert tree.inertials["l_ankle"].mass == pytest.approx(nao.tree.inertials["l_ankle"].mass + sensors, abs=1e-18)
    assert len(tree.visuals) == len(nao.tree.visuals)
    assert len(tree.collisions) == len(nao.tree.collisions)
    assert {visual.link for visual in tree.visuals} <= set(tree.links)


def test_a_turned_link_is_merged_as_it_stands(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a", axis=(0.0, 0.6, 0.8)),
        J("b", xyz=(0.1, 0.2, 0.3), rpy=(0.4, 0.5, 0.6), kind="fixed"),
        J("c", xyz=(0.3, 0.0, 0.1), rpy=(1.0, -1.0, 2.0), kind="fixed"),
        J("d", xyz=(0.0, 0.1, 0.0)),
    )
    tree, changes = keep_frames(robot.tree, "none", robot.semantics)
    one, q = nk.RobotModel(tree), np.array([0.7, -0.4])
    assert changes == ("2 links on fixed joints are merged into the links that carry them: b_l, c_l",)
    np.testing.assert_allclose(one.fk(q, "d_l"), robot.fk(q, "d_l"), atol=1e-14)
    np.testing.assert_allclose(one.com(q), robot.com(q), atol=1e-14)
    for name in ("crba", "nle"):
        found = [_dynamics(model, q, name) for model in (one.model, robot.model)]
        np.testing.assert_allclose(*found, atol=1e-12)


def _dynamics(model: pin.Model, q: np.ndarray, name: str) -> np.ndarray:
    data = model.createData()
    if name == "crba":
        return np.triu(pin.crba(model, data, q))
    return pin.nonLinearEffects(model, data, q, np.array([0.3, 0.9])).copy()


def test_a_link_that_stands_askew_gives_mass_where_it_stands(tmp_path: Path) -> None:
    body = '<inertial><origin xyz="0.1 0 0"/><mass value="2"/><inertia ixx="1" iyy="2" izz="2"/>'
    path = tmp_path / "askew.urdf"
    path.write_text(
        f'<robot name="askew"><link name="a"/><link name="b">{body}</inertial></link><link name="c"/>'
        '<joint name="ab" type="fixed"><parent link="a"/><child link="b"/><origin xyz="1 2 3" rpy="1 2 3"/></joint>'
        '<joint name="ac" type="continuous"><parent link="a"/><child link="c"/><origin xyz="-1 0 1"/></joint></robot>'
    )
    robot = nk.RobotModel.from_urdf(path, base="floating")
    tree, changes = make_physical(robot.tree)
    mended = nk.RobotModel(tree, base="floating")
    assert changes[-1] == "b: mass 2 → 1.98 kg, the rest given to links on it"
    for q in (robot.neutral(), mended.random(np.random.default_rng(4))):
        np.testing.assert_allclose(mended.com(q), robot.com(q), atol=1e-14)
        M = [pin.crba(one.model, one.model.createData(), q)[:6, :6] for one in (robot, mended)]
        np.testing.assert_allclose(np.triu(M[1]), np.triu(M[0]), atol=1e-12)


def test_two_places_cannot_have_one_ros_name(tmp_path: Path) -> None:
    tree = made_up(tmp_path, J("a"), J("b", kind="fixed", xyz=(0.0, 0.0, 0.1)), J("c", kind="fixed")).tree
    named, _ = name_frames(tree, Semantics(ros_names={"b_l": "hand", "c_l": "hand"}))
    assert named.links == ("base", "a_l", "hand")
    for other in ("a_l", "base"):
        with pytest.raises(BadArgument, match="made_up: two links would be named hand in ROS"):
            name_frames(tree, Semantics(ros_names={"b_l": "hand", other: "hand"}))


def test_a_ball_stands_right_where_the_axes_are_askew(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a", axis=(0.0, 0.0, 1.0), xyz=(0.1, 0.2, 0.3), rpy=(0.4, 0.5, 0.6)),
        J("b", axis=(1.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.3)),
        J("between", kind="fixed", rpy=(0.7, 0.0, 0.0)),
        J("c", axis=(0.0, 1.0, 0.0), rpy=(0.2, 0.0, 0.0)),
    )
    tree, changes = Variant(typed=True).tree_of(robot)
    (ball,) = (joint for joint in tree.joints if joint.kind == "spherical")
    assert (ball.parent, ball.child, len(changes)) == ("base", "c_l", 1)
    np.testing.assert_allclose(ball.origin.matrix, robot.fk(robot.configuration({}), "c_l"), atol=1e-15)


@pytest.mark.parametrize("version", EACH_VERSION)
def test_aligned_axes_leave_every_link_where_it_was(version: str) -> None:
    nao = nk.load_nao(version)
    tree, changes = Variant(axes="aligned").tree_of(nao)
    robot, q = nk.RobotModel(tree), nao.random(np.random.default_rng(3), 20)
    assert [line.split(":")[0] for line in changes] == ["LHipYawPitch", "RHipYawPitch"]
    assert all(sorted(map(abs, joint.axis)) == [0.0, 0.0, 1.0] for joint in tree.moving_joints)
    assert robot.joint_names == nao.joint_names
    assert (robot.lower.tolist(), robot.upper.tolist()) == (nao.lower.tolist(), nao.upper.tolist())
    np.testing.assert_allclose(robot.fk(q, nao.link_names), nao.fk(q, nao.link_names), atol=1e-14)
    np.testing.assert_allclose(robot.com(q), nao.com(q), atol=1e-14)


@pytest.mark.parametrize("axis", [(0.0, 0.0, -1.0), (1e-9, 0.0, -1.0), (1e-9, 1e-9, 1.0), (0.6, 0.0, -0.8)])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_an_axis_almost_aligned_is_turned_as_exactly(
    axis: tuple[float, float, float], kind: str, tmp_path: Path
) -> None:
    robot = made_up(tmp_path, J("a", axis=axis, rpy=(0.3, 0.2, 0.1), kind=kind), J("a_axis", xyz=(0.1, 0.2, 0.3)))
    tree, changes = align_axes(robot.tree)
    other, q = nk.RobotModel(tree), np.array([[0.7, -0.4], [-2.0, 1.0]])
    assert len(changes) == (0 if axis == (0.0, 0.0, -1.0) else 1)
    assert len({*tree.links, *(joint.name for joint in tree.joints)}) == len(tree.links) + len(tree.joints)
    np.testing.assert_allclose(other.fk(q, ["a_l", "a_axis_l"]), robot.fk(q, ["a_l", "a_axis_l"]), atol=1e-14)


def test_exports_take_the_variant_that_is_asked_for(nao: nk.NaoModel, tmp_path: Path) -> None:
    aligned = nk.RobotModel.from_urdf(nk.export.urdf(nao, tmp_path / "a.urdf", axes="aligned", meshes="none").path)
    assert all(sorted(map(abs, joint.axis)) == [0.0, 0.0, 1.0] for joint in aligned.tree.moving_joints)
    package = nk.export.ros2(nao, tmp_path / "nao_description", inertia="physical", meshes="none", samples=1)
    (urdf,) = (package.path / "urdf").iterdir()
    own = nk.export.urdf(nao, tmp_path / "b.urdf", names="ros", inertia="physical", meshes="none").path
    written, expected = (
        {link: row for link, row in read_urdf(path).inertials.items() if row.mass} for path in (urdf, own)
    )
    assert written == expected
    path = tmp_path / "a.srdf"
    nk.export.srdf(nao, path, base="planar", names="ros", frames="effectors", coupling="independent", samples=1)
    text = path.read_text(encoding="utf-8")
    assert '<passive_joint name="RHipYawPitch"' not in text
    assert 'type="planar"' in text
    assert '<robot name="NaoH25V60">' in text
    done = nk.export.urdf(nao, tmp_path / "c.urdf", typed=True, coupling="independent", meshes="none")
    assert done.path.read_text().count('type="spherical"') == 2
    assert "mimic" not in nk.export.sdf(nao, tmp_path / "nao", coupling="independent", meshes="none").path.read_text()
