"""A name that the URDF gives to both a link and a joint means the link, and its first use gives a warning."""

from __future__ import annotations

import copy
import math
import pickle
import warnings
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
import yourdfpy

import nao_kin as nk
from nao_kin.errors import RenamedFrameWarning
from nao_kin.joints import JointAxes
from nao_kin.robot import topology


def _like_the_official_v6(nao: nk.NaoModel, folder: Path) -> Path:
    """Our V6 with every moving joint about its own z axis, and a fixed link of the joint's name parallel to the torso.

    The official file of the V6 is built so: the joint `LElbowRoll` moves the link `LElbowRoll_link`, whose frame is
    turned, and the link `LElbowRoll` is fixed to it with the axes of the torso.
    """
    document = ET.parse(nao.urdf_path)
    robot = document.getroot()
    moved = {}
    for joint in robot.findall("joint"):
        axis, link = joint.find("axis"), joint.find("child").get("link")
        name = joint.get("name", "")
        if axis is None or "Finger" in name or "Thumb" in name or link == f"{name}_link":
            continue
        x, y, z = map(float, axis.get("xyz", "").split())
        # R z = axis
        rpy = (0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x)) if z != 1.0 else (0.0, 0.0, 0.5)
        axis.set("xyz", "0 0 1")
        joint.find("origin").set("rpy", " ".join(map(repr, rpy)))
        moved[link] = name, rpy
        joint.find("child").set("link", f"{name}_link")
    for link, (name, rpy) in moved.items():
        ET.SubElement(robot, "link", name=f"{name}_link")
        R = np.array(nk.rotations.matrix_from_rpy(rpy)).T
        back = nk.rotations.rpy_from_matrix(R)
        for end, turn in ((name, back), (link, back)):
            if end == name:
                ET.SubElement(robot, "link", name=name)
            held = ET.SubElement(robot, "joint", name=f"{end}_of_{name}_fixed", type="fixed")
            ET.SubElement(held, "parent", link=f"{name}_link")
            ET.SubElement(held, "child", link=end)
            ET.SubElement(held, "origin", xyz="0 0 0", rpy=" ".join(map(repr, np.asarray(turn).tolist())))
    path = folder / "official.urdf"
    document.write(path)
    return path


@pytest.fixture
def official(nao: nk.NaoModel, tmp_path: Path) -> nk.RobotModel:
    return nk.RobotModel.from_urdf(_like_the_official_v6(nao, tmp_path))


def test_joint_names_give_the_poses_that_load_nao_gives(nao: nk.NaoModel, official: nk.RobotModel) -> None:
    assert set(official.joint_names) == set(nao.joint_names)
    for q in nao.random(0, 10):
        theirs = official.configuration(nao.angles(q), limits="ignore")
        for name in nao.joint_names:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RenamedFrameWarning)
                assert np.allclose(official.fk(theirs, name), nao.fk(q, name), atol=1e-12), name


def test_every_link_of_the_file_answers_under_its_own_name(official: nk.RobotModel) -> None:
    oracle = yourdfpy.URDF.load(str(official.urdf_path), load_meshes=False, load_collision_meshes=False)
    q = official.random(1)
    angles = official.angles(q)
    oracle.update_cfg({name: angles[name] for name in oracle.actuated_joint_names})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RenamedFrameWarning)
        for link in oracle.link_map:
            assert np.allclose(official.fk(q, link), oracle.get_transform(link), atol=1e-12), link


def test_the_warning_names_both_frames_and_comes_once(official: nk.RobotModel) -> None:
    q = official.neutral()
    with pytest.warns(RenamedFrameWarning) as caught:
        official.fk(q, "LElbowRoll")
    (warning,) = caught
    assert str(warning.message) == (
        "frame 'LElbowRoll': the URDF has a link and a joint of this name. This is the link's frame "
        "('LElbowRoll_frame'); the joint's own frame is 'LElbowRoll_link'"
    )
    assert warning.filename == __file__
    official.fk(q, "LElbowRoll")
    official.fk(q, ["LElbowRoll", "LElbowRoll_frame", "LElbowRoll_link"])
    official.jacobian(q, "LElbowRoll")
    for ask in (
        lambda: official.jacobian(q, "LElbowYaw"),
        lambda: official.fk(q, "LElbowYaw_frame", reference="HeadYaw"),
        lambda: official.fk(q, ["LArm", "RElbowYaw"]),
        lambda: official.com(q, reference="RElbowRoll"),
        lambda: official.position(q, "LHipYawPitch"),
    ):
        with pytest.warns(RenamedFrameWarning):
            ask()
    assert "link 'LElbowRoll' renamed 'LElbowRoll_frame': a joint has the same name" in official.load_notes


def test_what_asks_by_itself_warns_nobody(official: nk.RobotModel) -> None:
    axes = JointAxes(official)
    q = official.random(0)
    assert np.allclose(axes.jacobian(q, "LArm"), official.jacobian(q, "LArm"), atol=1e-12)
    official.fk(q)
    topology(official)
    nk.joints.group_joints(official)
    pickle.loads(pickle.dumps(official)).fk(q)
    copy.deepcopy(official).com(q)


def test_jacobian_and_pose_speak_of_the_same_frame(official: nk.RobotModel) -> None:
    q = official.random(2)
    with pytest.warns(RenamedFrameWarning):
        J = official.jacobian(q, "RElbowRoll", "frame")
    assert np.allclose(J, official.jacobian(q, "RElbowRoll_frame", "frame"))
    assert not np.allclose(J, official.jacobian(q, "RElbowRoll_link", "frame"))
    assert np.allclose(JointAxes(official).jacobian(q, "RElbowRoll", "frame"), J, atol=1e-12)


def test_where_both_frames_are_one_nobody_is_warned(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    path.write_text(
        '<robot name="r"><link name="base"/><link name="J"/><link name="F"/>'
        '<joint name="J" type="continuous"><parent link="base"/><child link="J"/><axis xyz="0 0 1"/></joint>'
        '<joint name="F" type="fixed"><parent link="J"/><child link="F"/><origin xyz="1 0 0"/></joint></robot>'
    )
    robot = nk.RobotModel.from_urdf(path)
    assert robot.link_names == ("base", "J_link", "F_link")
    assert np.array_equal(robot.fk([0.3], "J"), robot.fk([0.3], "J_link"))
    assert np.array_equal(robot.fk([0.3], "F"), robot.fk([0.3], "F_link"))
