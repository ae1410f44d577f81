"""The SRDF export follows MoveIt's rules, and Pinocchio and this package read it back unchanged."""

from __future__ import annotations

import importlib
import json
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

import coal
import numpy as np
import pinocchio as pin
import pytest
import trimesh
from loops import EACH_VERSION, full
from made_up_robots import J, made_up
from moveit_rules import violations

import nao_kin as nk
from nao_kin.export.srdf import Planning
from nao_kin.export.variants import Variant
from nao_kin.robot import LinkShapes, link_shapes
from nao_kin.robot.collision_pairs import adjacent_links
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf import Box, Cylinder, MeshFile, Sphere

DATA = Path(__file__).resolve().parents[1] / "data"
FEW = 60
srdf_module = importlib.import_module("nao_kin.export.srdf")  # a face gives the function of this name
COLLIDE = link_shapes._collide


class Document(NamedTuple):
    text: str
    changes: tuple[str, ...]


def srdf_document(robot: nk.RobotModel, *, samples: int, base: str | None = None, **chosen: Any) -> Document:
    return Document(*srdf_module.srdf_document(robot, Variant(**chosen), base=base, samples=samples))


@pytest.fixture(scope="module")
def nao() -> nk.NaoModel:
    return nk.load_nao("v6")


@pytest.fixture(scope="module")
def written(nao: nk.NaoModel, tmp_path_factory: pytest.TempPathFactory) -> nk.export.Exported:
    return nk.export.srdf(nao, tmp_path_factory.mktemp("srdf") / "nao.srdf", samples=500)


# --- MoveIt -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("names", ["ros", *full("naoqi")])
@pytest.mark.parametrize("frames", ["effectors", *full("all", "none")])
@pytest.mark.parametrize("version", EACH_VERSION)
def test_every_variant_of_every_nao_obeys_the_rules_of_moveit(version: str, frames: str, names: str) -> None:
    robot = nk.load_nao(version)
    document = srdf_document(robot, names=names, frames=frames, samples=FEW)
    assert violations(document.text, Variant(names=names, frames=frames).tree_of(robot)[0]) == []


@pytest.mark.full
@pytest.mark.parametrize("coupling", ["locked", "independent"])
@pytest.mark.parametrize("frames", ["all", "none"])
def test_other_couplings_obey_the_rules_of_moveit(nao: nk.NaoModel, frames: str, coupling: str) -> None:
    document = srdf_document(nao, frames=frames, coupling=coupling, samples=FEW)
    assert violations(document.text, Variant(frames=frames, coupling=coupling).tree_of(nao)[0]) == []
    names = {element.get("name") for element in ET.fromstring(document.text).iter("joint")}
    assert ("RHipYawPitch" in names) == (coupling == "independent")


@pytest.mark.parametrize(
    "name", ["panda", "ur5_robot", "double_pendulum_continuous", *full("romeo", "anymal", "solo12")]
)
def test_other_robots_obey_the_rules_of_moveit(name: str) -> None:
    robot = nk.load_robot(name)
    assert violations(srdf_document(robot, samples=FEW).text, robot.tree) == []


@pytest.mark.parametrize(
    ("old", "new", "rule"),
    [
        ('<robot name="nao_v6">', '<robot name="nao">', "of the robot that the URDF is of"),
        ('tip_link="LLeg"', 'tip_link="LFoo"', "both ends of a chain are links"),
        ('<chain base_link="torso" tip_link="LLeg"', '<chain base_link="l_wrist" tip_link="LLeg"', "are ends of"),
        ('<group name="Head">', '<group name="LLeg">', "a group of a name is there once"),
        ('<link name="l_sole" />', "", "group LLeg_effector has at least one joint"),
        ('<link name="l_sole" />', '<link name="LLeg" />', "its parent link is not in its own group"),
        ('parent_group="LArm_without_LHand"', 'parent_group="LArm_effector"', "its group is not its parent group"),
        ('parent_group="LArm_without_LHand"', 'parent_group="RArm"', "its parent group has its parent link"),
        ('type="fixed"', 'type="free"', "the virtual joint has a known type"),
        ('child_link="base_link"', 'child_link="torso"', "the virtual joint holds the root link"),
        ('<passive_joint name="RHipYawPitch"', '<passive_joint name="RHip"', "passive joint RHip is known"),
        ('reason="Never"', 'reason="Rarely"', "MoveIt knows the reason"),
        ('<joint name="LHand" />', '<joint name="LHandle" />', "group LArm_effector: LHandle is known"),
        ('<joint name="HeadYaw" value', '<joint name="LHand" value', "of whole_body: a joint is named once"),
    ],
)  # fmt: skip
def test_a_broken_srdf_breaks_a_rule(
    written: nk.export.Exported, nao: nk.NaoModel, old: str, new: str, rule: str
) -> None:
    text = written.path.read_text(encoding="utf-8")
    assert violations(text, nao.tree) == []
    assert old in text
    assert any(rule in found for found in violations(text.replace(old, new, 1), nao.tree))


def test_the_names_of_the_moveit_configuration_of_ros_naoqi_resolve() -> None:
    moveit = json.loads((DATA / "nao_moveit_names.json").read_text(encoding="utf-8"))
    robot = nk.load_nao("v4")
    tree, _ = Variant(names="ros").tree_of(robot)
    document = srdf_document(robot, names="ros", samples=1)
    assert ET.fromstring(document.text).get("name") == moveit["robot"] == tree.name
    assert set(moveit["links"]) <= set(tree.links)
    passive = {element.get("name") for element in ET.fromstring(document.text).findall("passive_joint")}
    # What that configuration calls passive, beside the virtual joint, is what follows here; its hands are driven.
    assert passive == set(moveit["joints"]) - {"LHand", "RHand"}


def test_a_planner_is_asked_for_the_frame_of_the_effector_and_not_for_the_opening_hand(nao: nk.NaoModel) -> None:
    plan = Planning(nao.tree, nao.semantics)
    groups = plan.groups
    assert groups["LLeg"].chain == ("torso", "LLeg")
    assert groups["LArm_without_LHand"].chain == ("torso", "LArm")
    assert groups["LArm_without_LHand"].own == nao.chains["LArm"][:-1]
    assert groups["LArm"].own == nao.chains["LArm"]
    assert groups["whole_body"].groups == tuple(nao.chains)
    assert set(groups["whole_body"].own) == set(nao.joint_names)
    assert groups["RArm_effector"].own == ("RHand",)
    assert len(groups["RArm_effector"].joints) == 9
    attached = {effector.name: effector.parent_group for effector in plan.end_effectors}
    assert attached == {
        "Head": "Head",
        "LArm": "LArm_without_LHand",
        "RArm": "RArm_without_RHand",
        "LLeg": "LLeg",
        "RLeg": "RLeg",
    }


def test_a_chain_that_another_one_continues_is_no_second_group() -> None:
    names = list(Planning(nk.load_robot("panda").tree, nk.load_robot("panda").semantics).groups)
    assert names == ["whole_body", "arm", "hand", "arm_and_hand", "panda_hand_tcp_effector"]


# --- read back --------------------------------------------------------------------------------------------------------


def test_the_package_reads_back_chains_effectors_and_postures(nao: nk.NaoModel, written: nk.export.Exported) -> None:
    again = nk.RobotModel.from_urdf(nao.urdf_path, semantics=written.path)
    assert {name: again.chains[name] for name in nao.chains} == nao.chains
    assert again.semantics.end_effectors == nao.semantics.end_effectors
    assert again.posture_names == nao.posture_names
    for name in nao.posture_names:
        np.testing.assert_array_equal(again.posture(name), nao.posture(name))


def test_pinocchio_reads_the_postures_of_the_whole_body(nao: nk.NaoModel, written: nk.export.Exported) -> None:
    model = pin.buildModelFromUrdf(str(nao.urdf_path), mimic=True)
    pin.loadReferenceConfigurations(model, str(written.path))
    assert len(model.referenceConfigurations) == len(nao.posture_names)
    for name in nao.posture_names:
        angles = nao.angles(nao.posture(name))
        q = model.referenceConfigurations[name]
        found = {joint: q[model.joints[model.getJointId(joint)].idx_q] for joint in nao.joint_names}
        assert found == angles


def test_pinocchio_removes_the_pairs_that_need_no_check(nao: nk.NaoModel, written: nk.export.Exported) -> None:
    model = pin.buildModelFromUrdf(str(nao.urdf_path), mimic=True)
    shapes = pin.buildGeomFromUrdf(model, str(nao.urdf_path), pin.GeometryType.COLLISION)
    shapes.addAllCollisionPairs()

    def pairs() -> set[frozenset[str]]:
        owners = [model.frames[shape.parentFrame].name for shape in shapes.geometryObjects]
        return {frozenset((owners[pair.first], owners[pair.second])) for pair in shapes.collisionPairs}

    before = pairs()
    pin.removeCollisionPairs(model, shapes, str(written.path))
    root = ET.parse(written.path).getroot()
    disabled = {frozenset((e.get("link1"), e.get("link2"))) for e in root.findall("disable_collisions")}
    assert before - pairs() == disabled
    assert len(disabled) > 20


def test_pinocchio_sees_no_contact_in_the_posture_the_robot_starts_in(
    nao: nk.NaoModel, written: nk.export.Exported
) -> None:
    model = pin.buildModelFromUrdf(str(nao.urdf_path), mimic=True)
    shapes = pin.buildGeomFromUrdf(model, str(nao.urdf_path), pin.GeometryType.COLLISION)
    shapes.addAllCollisionPairs()
    pin.removeCollisionPairs(model, shapes, str(written.path))
    pin.loadReferenceConfigurations(model, str(written.path))
    q = model.referenceConfigurations[nao.semantics.start]
    assert not pin.computeCollisions(model, model.createData(), shapes, shapes.createData(), q, False)


# --- contacts ---------------------------------------------------------------------------------------------------------


def test_contacts_are_those_that_pinocchio_finds(nao: nk.NaoModel) -> None:
    model = pin.buildModelFromUrdf(str(nao.urdf_path), mimic=True)
    shapes = pin.buildGeomFromUrdf(model, str(nao.urdf_path), pin.GeometryType.COLLISION)
    shapes.addAllCollisionPairs()
    owners = [model.frames[shape.parentFrame].name for shape in shapes.geometryObjects]
    data, shape_data = model.createData(), shapes.createData()
    contacts = LinkShapes.exact(nao)
    q, expected = nao.random(1, 40), Counter[tuple[str, str]]()
    columns = [model.joints[model.getJointId(name)].idx_q for name in nao.joint_names]
    for row in q:
        theirs = np.zeros(model.nq)
        theirs[columns] = row
        pin.computeCollisions(model, data, shapes, shape_data, theirs, False)
        touching = {
            tuple(sorted((owners[pair.first], owners[pair.second])))
            for pair, result in zip(shapes.collisionPairs, shape_data.collisionResults, strict=True)
            if result.isCollision()
        }
        expected.update(pair for pair in touching if pair[0] != pair[1])
    found = contacts.count(q, set(contacts.pairs))
    assert {pair: count for pair, count in found.items() if count} == dict(expected)


def test_contacts_of_hollow_meshes_are_those_of_their_triangles(tmp_path: Path) -> None:
    arms = [trimesh.creation.box((0.6, 0.05, 0.05)), trimesh.creation.box((0.05, 0.05, 0.6))]
    for arm, place in zip(arms, ((0.3, 0.0, 0.0), (0.6, 0.0, 0.3)), strict=True):
        arm.apply_translation(place)
    trimesh.util.concatenate(arms).export(tmp_path / "hook.obj")
    hook = '<geometry><mesh filename="hook.obj"/></geometry>'
    first, second = J("a", (0.0, 0.0, 1.0), xyz=(0.5, 0.0, 0.1)), J("b", (0.0, 1.0, 0.0), xyz=(0.3, 0.05, 0.2))
    robot = made_up(tmp_path, first, second)
    robot = _shaped(robot, tmp_path, base=hook, a_l=hook, b_l=hook)
    shape = coal.MeshLoader().load(str(tmp_path / "hook.obj"), np.ones(3))
    q, expected = robot.random(2, 400), Counter[tuple[str, str]]()
    for T in robot.fk(q, ["base", "a_l", "b_l"]):
        places = dict(zip(("base", "a_l", "b_l"), (coal.Transform3s(t[:3, :3], t[:3, 3]) for t in T), strict=True))
        for one, other in (("a_l", "base"), ("b_l", "base"), ("a_l", "b_l")):
            request, result = coal.CollisionRequest(), coal.CollisionResult()
            expected[one, other] += bool(coal.collide(shape, places[one], shape, places[other], request, result))
    assert all(10 < count < 390 for count in expected.values())
    contacts = LinkShapes.exact(robot)
    assert contacts.count(q, set(contacts.pairs)) == expected


def test_a_pair_whose_part_is_known_is_not_looked_at_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot, looks = _before_a_wall(tmp_path, 0.5), []
    monkeypatch.setattr(link_shapes, "_collide", lambda *shapes: looks.append(shapes) or COLLIDE(*shapes))
    assert ("base", "b_l") not in LinkShapes.exact(robot).found_disabled(10_000, 0)
    assert 0 < len(looks) < 200


@pytest.mark.full
def test_a_longer_proof_never_finds_fewer_pairs_that_never_touch(nao: nk.NaoModel, written: nk.export.Exported) -> None:
    few, many = (
        {
            (e.get("link1"), e.get("link2"))
            for e in ET.fromstring(text).findall("disable_collisions")
            if e.get("reason") == "Never"
        }
        for text in (srdf_document(nao, samples=FEW).text, written.path.read_text(encoding="utf-8"))
    )
    assert few < many


def _shaped(robot: nk.RobotModel, folder: Path, **shapes: str) -> nk.RobotModel:
    """The robot with a collision shape on some links, given as the text of its geometry and origin."""
    text = robot.urdf_path.read_text(encoding="utf-8")
    for link, shape in shapes.items():
        head = f'<link name="{link}">'
        assert head in text
        text = text.replace(head, f"{head}<collision>{shape}</collision>")
    path = folder / "shaped.urdf"
    path.write_text(text, encoding="utf-8")
    return nk.RobotModel.from_urdf(path)


def _ball(radius: float, x: float = 0.0) -> str:
    return f'<origin xyz="{x} 0 0"/><geometry><sphere radius="{radius}"/></geometry>'


def _reasons(robot: nk.RobotModel, samples: int = 200) -> dict[tuple[str | None, str | None], str | None]:
    root = ET.fromstring(srdf_document(robot, samples=samples).text)
    return {(e.get("link1"), e.get("link2")): e.get("reason") for e in root.findall("disable_collisions")}


def test_each_reason_is_found_on_a_robot_made_for_it(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a", xyz=(0.2, 0.0, 0.0), limits=(-0.1, 0.1)),  # adjacent to the base
        J("b", xyz=(0.2, 0.0, 0.0), limits=(-0.1, 0.1)),  # overlaps the base in every configuration but that at zero
        J("c", xyz=(1.0, 0.0, 0.0), limits=(-0.1, 0.1)),  # far from the base
        J("d", xyz=(-1.0, 0.0, 0.0), parent="base", limits=(-0.1, 0.1)),
    )
    robot = _shaped(robot, tmp_path, base=_ball(0.3), a_l=_ball(0.05), b_l=_ball(0.3), c_l=_ball(0.1), d_l=_ball(0.1))
    assert _reasons(robot) == {
        ("a_l", "b_l"): "Adjacent",
        ("a_l", "base"): "Adjacent",
        ("a_l", "c_l"): "Never",
        ("a_l", "d_l"): "Never",
        ("b_l", "base"): "Default",
        ("b_l", "c_l"): "Adjacent",
        ("b_l", "d_l"): "Never",
        ("base", "c_l"): "Never",
        ("base", "d_l"): "Adjacent",
        ("c_l", "d_l"): "Never",
    }


def test_a_pair_that_is_apart_in_the_first_posture_and_touches_elsewhere_is_always_in_contact(tmp_path: Path) -> None:
    slide = J("b", kind="prismatic", axis=(1.0, 0.0, 0.0), limits=(0.0, 1.0))
    robot = made_up(tmp_path, J("a", xyz=(0.1, 0.0, 0.0), limits=(-0.01, 0.01)), slide)
    # The wall on the base begins 0.02 before the ball of the last link, which slides 1 m into it; then 0.1 before it.
    for gap, reason in ((0.02, "Always"), (0.1, None)):
        wall = f'<origin xyz="{1.15 + gap} 0 0"/><geometry><box size="2 2 2"/></geometry>'
        shaped = _shaped(robot, tmp_path, base=wall, a_l=_ball(0.01), b_l=_ball(0.05, x=0.0))
        assert _reasons(shaped, samples=1000).get(("b_l", "base")) == reason


def _before_a_wall(tmp_path: Path, touching_from: float) -> nk.RobotModel:
    """A ball that slides by up to 1 m, and touches a wall on the base from a value on."""
    slide = J("b", kind="prismatic", axis=(1.0, 0.0, 0.0), limits=(0.0, 1.0))
    robot = made_up(tmp_path, J("a", xyz=(0.1, 0.0, 0.0), kind="fixed"), slide)
    wall = f'<origin xyz="{1.15 + touching_from} 0 0"/><geometry><box size="2 2 2"/></geometry>'
    return _shaped(robot, tmp_path, base=wall, a_l=_ball(0.01), b_l=_ball(0.05))


@pytest.mark.parametrize(("gap", "reason"), [(-1e-4, None), (-1e-12, None), (1e-4, "Never")])
def test_a_pair_that_touches_only_at_a_limit_is_checked(tmp_path: Path, gap: float, reason: str | None) -> None:
    slide = J("b", kind="prismatic", axis=(1.0, 0.0, 0.0), limits=(0.0, 1.0))
    robot = made_up(tmp_path, J("a", xyz=(0.1, 0.0, 0.0), kind="fixed"), slide)
    robot = _shaped(robot, tmp_path, base=_ball(0.3, x=1.45 + gap), a_l=_ball(0.01), b_l=_ball(0.05))
    assert robot.random(0, 1000)[:, 0].max() < 0.9999
    assert _reasons(robot, samples=1000).get(("b_l", "base")) == reason


def test_a_pair_that_touches_in_the_start_posture_touches_by_default(tmp_path: Path) -> None:
    robot = _before_a_wall(tmp_path, 0.9999)
    postures = {"in": nk.semantics.Posture({}), "out": nk.semantics.Posture({"b": 1.0})}
    assert ("b_l", "base") not in _reasons(nk.RobotModel(robot.tree, Semantics(postures=postures, start="in")))
    # What touches in the posture that the robot starts in touches by default.
    out = nk.RobotModel(robot.tree, Semantics(postures=postures, start="out"))
    assert _reasons(out)[("b_l", "base")] == "Default"


def test_a_pair_with_two_hinges_between_that_touches_in_a_posture_touches_by_default(
    written: nk.export.Exported,
) -> None:
    text = written.path.read_text(encoding="utf-8")
    assert not any("in posture 'Stand" in note for note in written.changes)
    assert '<disable_collisions link1="LHip" link2="LTibia" reason="Default" />' in text
    # Other pairs are still checked, though they touch in a posture.
    assert 'link1="l_ankle" link2="r_ankle"' not in text


def test_where_zero_is_outside_the_middle_of_the_range_is_the_default(tmp_path: Path) -> None:
    robot = _before_a_wall(tmp_path, 0.7)
    for limits, reason in (((0.5, 1.0), "Default"), ((0.5, 0.8), None)):
        joints = tuple(
            replace(joint, lower=limits[0], upper=limits[1]) if joint.name == "b" else joint
            for joint in robot.tree.joints
        )
        moved = nk.RobotModel(replace(robot.tree, joints=joints), Semantics())
        assert _reasons(moved).get(("b_l", "base")) == reason


def test_a_link_that_slides_stays_at_no_point(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", kind="prismatic"))
    assert ("b_l", "base") not in adjacent_links(robot.tree, ("base", "b_l"))


def test_links_without_shapes_join_their_neighbours_at_one_point_and_not_along_a_limb(tmp_path: Path) -> None:
    far, near = (0.3, 0.0, 0.0), (0.0, 0.0, 0.0)
    for at, joined in ((near, True), (far, False)):
        robot = made_up(tmp_path, J("a", xyz=far), J("b", xyz=at))
        assert (("b_l", "base") in adjacent_links(robot.tree, ("base", "b_l"))) is joined
        assert ("a_l", "base") in adjacent_links(robot.tree, ("base", "a_l", "b_l"))
        assert ("b_l", "base") not in adjacent_links(robot.tree, ("base", "a_l", "b_l"))
    beside = made_up(tmp_path, J("a"), J("b"), base="fixed", chain=False)
    assert adjacent_links(beside.tree, ("a_l", "b_l")) == {("a_l", "b_l")}
    held = made_up(tmp_path, J("a", xyz=far), J("b", xyz=far, kind="fixed"))
    assert adjacent_links(held.tree, ("base", "b_l")) == {("b_l", "base")}


def test_the_forearm_of_a_nao_is_checked_against_its_trunk_though_the_upper_arm_has_no_shape(
    written: nk.export.Exported,
) -> None:
    disabled = ET.parse(written.path).getroot().findall("disable_collisions")
    assert ("LForeArm", "torso") not in {(e.get("link1"), e.get("link2")) for e in disabled}


def test_shapes_of_every_kind_and_meshes_are_read(tmp_path: Path) -> None:
    (tmp_path / "cube.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", encoding="utf-8"
    )
    robot = made_up(tmp_path, J("a", xyz=(5.0, 0.0, 0.0)), J("b", xyz=(5.0, 0.0, 0.0)), J("c", xyz=(5.0, 0.0, 0.0)))
    robot = _shaped(
        robot,
        tmp_path,
        base='<geometry><mesh filename="cube.obj" scale="2 2 2"/></geometry>',
        a_l='<geometry><cylinder radius="0.1" length="1"/></geometry>',
        b_l='<geometry><box size="1 2 3"/></geometry>',
        c_l=_ball(0.1),
    )
    kinds = [type(collision.geometry) for collision in robot.tree.collisions]
    assert kinds == [MeshFile, Cylinder, Box, Sphere]
    contacts = LinkShapes.exact(robot)
    assert contacts.links == ("base", "a_l", "b_l", "c_l")
    assert contacts.notes == []


def test_a_mesh_is_as_large_as_its_scale_makes_it(tmp_path: Path) -> None:
    (tmp_path / "cube.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", encoding="utf-8"
    )
    robot = made_up(tmp_path, J("a", xyz=(1.5, 0.0, 0.0)))
    for scale, touching in (("1 1 1", 0), ("2 1 1", 1)):
        mesh = f'<geometry><mesh filename="cube.obj" scale="{scale}"/></geometry>'
        contacts = LinkShapes.exact(_shaped(robot, tmp_path, base=mesh, a_l=_ball(0.05)))
        assert contacts.count(np.zeros((1, 1)), {("a_l", "base")}) == {("a_l", "base"): touching}


def test_a_mesh_that_is_missing_or_broken_is_noted_and_left_out(tmp_path: Path) -> None:
    (tmp_path / "broken.stl").write_bytes(b"no mesh")
    robot = made_up(tmp_path, J("a"))
    mesh = '<geometry><mesh filename="{}"/></geometry>'
    robot = _shaped(robot, tmp_path, base=mesh.format("gone.stl"), a_l=mesh.format("broken.stl"))
    changes = srdf_document(robot, samples=1).changes
    assert "a collision shape of base is left out: its mesh 'gone.stl' is not there" in changes
    assert any(
        line.startswith("a collision shape of a_l is left out: its mesh 'broken.stl' cannot be") for line in changes
    )


# --- odd robots and bad input -----------------------------------------------------------------------------------------


def test_a_robot_that_means_nothing_has_the_group_of_all_its_joints(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", follows=("a", 2.0, 0.1)))
    document = srdf_document(robot, samples=1)
    assert violations(document.text, robot.tree) == []
    root = ET.fromstring(document.text)
    assert [group.get("name") for group in root.findall("group")] == ["whole_body"]
    assert [e.get("name") for e in root.findall("passive_joint")] == ["b"]
    assert document.changes == (
        "no two links have collision shapes: a planner finds no contacts of the robot with itself",
    )


def test_names_that_are_taken_already_are_not_taken_twice(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("virtual_joint"), J("b"))
    meaning = Semantics(chains={"whole_body": ("virtual_joint",), "b_l_effector": ("b",)}, end_effectors=("b_l",))
    robot = nk.RobotModel.from_urdf(robot.urdf_path, semantics=meaning)
    text = srdf_document(robot, samples=1).text
    assert violations(text, robot.tree) == []
    root = ET.fromstring(text)
    assert [group.get("name") for group in root.findall("group")] == ["whole_body_2", "whole_body", "b_l_effector"]
    assert root.find("virtual_joint").get("name") == "virtual_joint_2"


def test_chains_beside_each_other_are_groups_of_joints(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b"), J("c"))
    chains = {"gap": ("a", "c"), "on the way": ("b", "c")}
    robot = nk.RobotModel.from_urdf(robot.urdf_path, semantics=Semantics(chains=chains))
    document = srdf_document(robot, samples=1)
    assert violations(document.text, robot.tree) == []
    path = tmp_path / "back.srdf"
    path.write_text(document.text, encoding="utf-8")
    again = nk.RobotModel.from_urdf(robot.urdf_path, semantics=path)
    assert {name: again.chains[name] for name in chains} == chains
    assert any("'on the way' is not a valid name of a ROS parameter" in line for line in document.changes)


def test_an_effector_on_the_trunk_takes_no_arm_for_its_gripper(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("waist"), J("arm"), J("wrist"), J("finger"))
    meaning = Semantics(end_effectors=("base", "waist_l", "wrist_l"))
    plan = Planning(robot.tree, meaning)
    assert [(effector.name, effector.group) for effector in plan.end_effectors] == [("wrist_l", "wrist_l_effector")]
    assert plan.groups["wrist_l_effector"].joints == ("finger",)
    assert plan.notes == [
        "end effector base is left out: nothing is attached to that link",
        "end effector waist_l is left out: nothing is attached to that link",
    ]


def test_what_an_srdf_cannot_say_is_said(written: nk.export.Exported) -> None:
    changes = "\n".join(written.changes)
    assert "at most 500 configurations examined" in changes
    assert "coupled limits are left out, because a planner has one range for each joint: HeadPitch" in changes
    assert "in posture 'Sit' checked shapes touch" in changes


def test_joint_names_that_moveit_warns_of_are_noted(tmp_path: Path) -> None:
    changes = srdf_document(made_up(tmp_path, J("left-arm"), J("fine")), samples=1).changes
    assert "MoveIt warns of the characters in 1 names of joints, first 'left-arm'" in changes


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_the_virtual_joint_is_that_of_the_robot_or_as_asked_for(tmp_path: Path, base: str) -> None:
    robot = nk.RobotModel(made_up(tmp_path, J("a")).tree, base=base)
    joint = ET.fromstring(srdf_document(robot, samples=1).text).find("virtual_joint")
    assert joint is not None
    assert (joint.get("type"), joint.get("parent_frame"), joint.get("child_link")) == (base, "world", "base")
    joint = ET.fromstring(srdf_document(robot, samples=1, base="planar").text).find("virtual_joint")
    assert joint is not None
    assert joint.get("type") == "planar"
