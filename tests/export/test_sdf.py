"""The SDFormat model has the robot's poses, masses and couplings, in Drake and according to the specification."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from loops import EACH_VERSION
from made_up_robots import J, made_up
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.errors import BadArgument
from nao_kin.export.inertia import realizable
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf import Inertial, Origin

VERSIONS = ("v3.2", "v3.3", "v4", "v5", "v6")
DRAKE = "{http://drake.mit.edu}"


def _values(robot: nk.RobotModel, q: np.ndarray[Any, Any]) -> dict[str, float]:
    own = {name: float(value) for name, value in robot.angles(q).items()}
    return own | {name: float(mimic.value(own[mimic.joint])) for name, mimic in robot.mimics.items()}


def _pose(element: ET.Element) -> tuple[np.ndarray[Any, Any], str]:
    """A pose, and what it is relative to."""
    pose = element.find("pose")
    numbers = [float(word) for word in ((pose.text or "") if pose is not None else "0 0 0 0 0 0").split()]
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = numbers[:3], Rotation.from_euler("xyz", numbers[3:]).as_matrix()
    return T, (pose.get("relative_to", "") if pose is not None else "")


def _poses(model: ET.Element, values: dict[str, float]) -> dict[str, np.ndarray[Any, Any]]:
    """Return the poses of all links and frames in the root link, according to the specification."""
    joints = {joint.findtext("child", ""): joint for joint in model.findall("joint")}
    found = {str(model.get("canonical_link")): np.eye(4)}
    for link in model.findall("link"):
        name = str(link.get("name"))
        if name in found:
            continue
        joint = joints[name]
        T_parent_joint, parent = _pose(joint)
        T_joint_link, to = _pose(link)
        assert (parent, to) == (joint.findtext("parent"), joint.get("name"))
        axis = np.array([float(word) for word in joint.findtext("axis/xyz", "0 0 0").split()])
        T = np.eye(4)
        if joint.get("type") == "prismatic":
            T[:3, 3] = values[to] * axis
        elif joint.get("type") in ("revolute", "continuous"):
            T[:3, :3] = Rotation.from_rotvec(values[to] * axis).as_matrix()
        found[name] = found[parent] @ T_parent_joint @ T @ T_joint_link
    for frame in model.findall("frame"):
        found[str(frame.get("name"))] = found[str(frame.get("attached_to"))] @ _pose(frame)[0]
    return found


def _model(done: nk.export.Exported) -> ET.Element:
    root = ET.parse(done.path).getroot()
    assert (root.tag, root.get("version")) == ("sdf", "1.11")
    model = root.find("model")
    assert model is not None
    return model


@pytest.mark.parametrize("version", EACH_VERSION)
@pytest.mark.parametrize("frames", ["all", "effectors", "none"])
def test_every_link_and_frame_is_where_the_robot_has_it(version: str, frames: str, tmp_path: Path) -> None:
    robot = nk.load_nao(version)
    model = _model(nk.export.sdf(robot, tmp_path / "nao", frames=frames, meshes="none"))
    for q in robot.random(2, 3):
        poses = _poses(model, _values(robot, q))
        assert set(poses) <= set(robot.link_names)
        if frames == "all":
            assert set(poses) == set(robot.link_names)
        for name, T in poses.items():
            np.testing.assert_allclose(T, robot.fk(q, name), atol=1e-12, err_msg=name)


@pytest.mark.parametrize("version", EACH_VERSION)
def test_mass_and_centre_of_mass_stay_and_every_inertia_is_one_that_a_body_can_have(
    version: str, tmp_path: Path
) -> None:
    robot = nk.load_nao(version)
    model = _model(nk.export.sdf(robot, tmp_path / "nao", meshes="none"))
    q = robot.posture("StandInit")
    poses, mass, moment = _poses(model, _values(robot, q)), 0.0, np.zeros(3)
    for link in model.findall("link"):
        inertial = link.find("inertial")
        assert inertial is not None, link.get("name")
        xx, xy, xz, yy, yz, zz = (float(row.text or "") for row in inertial.findall("inertia/*"))
        body, T = float(inertial.findtext("mass", "")), poses[str(link.get("name"))] @ _pose(inertial)[0]
        assert realizable(Inertial(body, Origin(), (xx, xy, xz, yy, yz, zz)))
        mass, moment = mass + body, moment + body * T[:3, 3]
    assert math.isclose(mass, robot.mass, rel_tol=1e-12)
    np.testing.assert_allclose(moment / mass, robot.com(q), atol=1e-9)


@pytest.mark.parametrize("which", ["v6", "made up"])
def test_couplings_stand_in_the_words_of_gazebo_and_of_drake(which: str, tmp_path: Path) -> None:
    robot = nk.load_nao("v6")
    if which == "made up":
        robot = made_up(tmp_path, J("a"), J("b", follows=("a", -2.0, 0.5)))
    model = _model(nk.export.sdf(robot, tmp_path / "nao", meshes="none"))
    for joint in model.findall("joint"):
        name, mimic, drake = str(joint.get("name")), joint.find("axis/mimic"), joint.find(f"{DRAKE}mimic")
        assert (mimic is not None) == (drake is not None) == (name in robot.mimics)
        if mimic is not None and drake is not None:
            row = robot.mimics[name]
            said = (mimic.get("joint"), float(mimic.findtext("multiplier", "")), float(mimic.findtext("offset", "")))
            assert said == (row.joint, row.multiplier, row.offset)
            assert float(mimic.findtext("reference", "")) == 0.0
            assert (drake.get("joint"), float(drake.get("multiplier", "")), float(drake.get("offset", ""))) == said


def test_limits_and_losses_are_those_of_the_robot(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("hinge", limits=(-0.5, 0.75)),
        J("free", kind="continuous"),
        J("slide", kind="prismatic", limits=(0.0, 0.2)),
    )
    text = robot.urdf_path.read_text(encoding="utf-8").replace(
        '<axis xyz="0.0 0.0 1.0"/>', '<axis xyz="0.0 0.0 1.0"/><dynamics damping="0.1" friction="0.2"/>', 1
    )
    robot.urdf_path.write_text(text, encoding="utf-8")
    model = _model(nk.export.sdf(nk.RobotModel.from_urdf(robot.urdf_path), tmp_path / "m"))
    joints = {joint.get("name"): joint for joint in model.findall("joint")}
    kinds = {name: joint.get("type") for name, joint in joints.items()}
    assert kinds == {"hinge": "revolute", "free": "continuous", "slide": "prismatic"}
    words = ("lower", "upper", "effort", "velocity")
    assert [joints["hinge"].findtext(f"axis/limit/{word}") for word in words] == ["-0.5", "0.75", "5", "2"]
    assert [joints["free"].findtext(f"axis/limit/{word}") for word in words[:2]] == [None, None]
    losses = [joints["hinge"].findtext(f"axis/dynamics/{word}") for word in ("damping", "friction")]
    assert losses == ["0.1", "0.2"]
    assert joints["free"].find("axis/dynamics") is None


def test_shapes_have_names_of_their_own_colours_and_files_that_are_there(tmp_path: Path) -> None:
    robot = nk.load_nao("v6")
    done = nk.export.sdf(robot, tmp_path / "nao")
    model = _model(done)
    uris = set()
    for link in model.findall("link"):
        for tag in ("visual", "collision"):
            names = [shape.get("name") for shape in link.findall(tag)]
            assert len(set(names)) == len(names)
            assert all(names)
        uris |= {uri.text for uri in link.iter("uri")}
    assert {done.path.parent / str(uri) for uri in uris} < set(done.files)
    assert len(list(model.iter("visual"))) == len(robot.tree.visuals)
    assert len(list(model.iter("collision"))) == len(robot.tree.collisions) == 72
    led = next(visual for visual in model.iter("visual") if visual.get("name") == "torso_led")
    assert led.findtext("material/diffuse") == "0.7 0.89 1 1"
    assert {tag: sum(1 for _ in model.iter(tag)) for tag in ("sphere", "cylinder", "box")} == {
        "sphere": 45,
        "cylinder": 21,
        "box": 6,
    }


def test_gazebo_finds_the_model_in_its_folder(tmp_path: Path) -> None:
    done = nk.export.sdf(nk.load_nao("v6"), tmp_path / "nao", meshes="none")
    config = ET.parse(tmp_path / "nao" / "model.config").getroot()
    assert config.findtext("name") == "nao_v6"
    assert tmp_path / "nao" / config.findtext("sdf", "") == done.path


@pytest.mark.parametrize(("base", "held"), [("floating", False), ("fixed", True)])
def test_the_trunk_floats_or_is_held(tmp_path: Path, base: str, held: bool) -> None:
    model = _model(nk.export.sdf(nk.load_nao("v6"), tmp_path / "nao", meshes="none", base=base))
    world = [joint for joint in model.findall("joint") if joint.findtext("parent") == "world"]
    assert [(joint.get("type"), joint.findtext("child")) for joint in world] == [("fixed", "torso")] * held
    assert model.get("canonical_link") == "torso"


# --- Drake ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("version", "options"),
    [*((version, {}) for version in VERSIONS), ("v6", {"names": "ros"}), ("v6", {"base": "fixed"})],
)
def test_drake_reads_the_same_robot(version: str, options: dict[str, str], tmp_path: Path) -> None:
    pytest.importorskip("pydrake")
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, DiscreteContactApproximation
    from pydrake.systems.framework import DiagramBuilder

    robot = nk.load_nao(version)
    done = nk.export.sdf(robot, tmp_path / "nao", **options)
    plant, scene = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.001)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    (model,) = Parser(plant, scene).AddModels(str(done.path))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    new = robot.semantics.ros_names if options.get("names") == "ros" else {}
    names = {link: new.get(link, link) for link in robot.link_names}
    names = {link: name for link, name in names.items() if plant.HasFrameNamed(name, model)}
    assert len(names) == (122 if new else len(robot.link_names))
    for q in robot.random(4, 5):
        for joint, value in _values(robot, q).items():
            plant.GetJointByName(new.get(joint, joint), model).set_angle(context, value)
        root = plant.GetFrameByName("torso", model)
        for link, name in names.items():
            T = plant.GetFrameByName(name, model).CalcPose(context, root).GetAsMatrix4()
            np.testing.assert_allclose(T, robot.fk(q, link), atol=1e-9, err_msg=link)
    assert math.isclose(plant.CalcTotalMass(context), robot.mass, rel_tol=1e-12)
    assert plant.num_constraints() == len(robot.mimics) == 17
    assert plant.num_positions(model) == 42 + (0 if options.get("base") == "fixed" else 7)
    bodies = [plant.get_body(index) for index in plant.GetBodyIndices(model)]
    assert all(body.default_spatial_inertia().IsPhysicallyValid() for body in bodies)


# --- odd robots and bad input -----------------------------------------------------------------------------------------


def test_a_link_whose_name_a_joint_has_gets_another_one(tmp_path: Path) -> None:
    done = nk.export.sdf(nk.load_nao("v6"), tmp_path / "nao", names="ros", meshes="none")
    model = _model(done)
    names = [element.get("name") for tag in ("link", "joint", "frame") for element in model.findall(tag)]
    assert len(set(names)) == len(names)
    assert done.changes[-1].startswith("link RAnklePitch is called RAnklePitch_link")


@pytest.mark.parametrize("name", ["a::b", "world", "__root__", "__mine__"])
def test_names_that_sdformat_keeps_for_itself_are_refused(tmp_path: Path, name: str) -> None:
    robot = made_up(tmp_path, J("a"), J(name))
    with pytest.raises(BadArgument, match=f"SDFormat reserves the name '{name}\\w*'"):
        nk.export.sdf(robot, tmp_path / "m")
    assert not (tmp_path / "m").exists()


def test_the_joint_that_holds_the_trunk_has_a_name_of_its_own(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("world_joint"), J("a"))
    model = _model(nk.export.sdf(robot, tmp_path / "m", base="fixed"))
    assert [joint.get("name") for joint in model.findall("joint")] == ["world_joint_", "world_joint", "a"]


@pytest.mark.parametrize("name", ["base", "a_l", "b_l"])
def test_a_link_or_frame_called_world_gets_another_name(tmp_path: Path, name: str) -> None:
    robot = made_up(tmp_path, J("a"), J("b", kind="fixed", xyz=(0.1, 0.2, 0.3)))
    text = robot.urdf_path.read_text(encoding="utf-8").replace(f'"{name}"', '"world"')
    robot.urdf_path.write_text(text, encoding="utf-8")
    robot = nk.RobotModel.from_urdf(robot.urdf_path)
    done = nk.export.sdf(robot, tmp_path / "m")
    poses = _poses(_model(done), {"a": 0.3})
    assert set(poses) == set(robot.link_names) - {"world"} | {"world_link"}
    np.testing.assert_allclose(poses["world_link"], robot.fk([0.3], "world"), atol=1e-12)
    assert "link world is called world_link: SDFormat reserves that name" in done.changes


def test_a_frame_and_a_joint_of_one_name_are_refused(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", kind="fixed"))
    text = robot.urdf_path.read_text(encoding="utf-8").replace('"b_l"', '"twin"').replace('name="a"', 'name="twin"')
    robot.urdf_path.write_text(text, encoding="utf-8")
    robot = nk.RobotModel.from_urdf(robot.urdf_path)
    assert robot.tree.shared_names == {"twin": "twin_link"}  # told apart on reading
    nk.export.sdf(robot, tmp_path / "m")


def test_links_without_mass_are_refused_unless_they_are_given_one(tmp_path: Path) -> None:
    robot = nk.load_nao("v6")
    with pytest.raises(BadArgument, match="link LHand_link has no mass, .*; inertia='physical' gives"):
        nk.export.sdf(robot, tmp_path / "m", inertia="published")
    assert list(tmp_path.iterdir()) == []


def test_a_root_without_mass_weighs_a_gram_and_not_a_kilogram(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b"))
    tree = robot.tree
    light = replace(tree, inertials={link: body for link, body in tree.inertials.items() if link != "base"})
    done = nk.export.sdf(nk.RobotModel(light, Semantics()), tmp_path / "m")
    assert "base has no mass: written as 0.001 kg" in done.changes
    assert _model(done).findtext("link/inertial/mass") == "0.001"
