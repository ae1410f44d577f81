"""Robots as MuJoCo has them: bodies, joints, limits, cameras, sensors and key frames."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument, BadModel, MissingExtra
from nao_kin.robot.geometry import shapes_of
from nao_kin.robot.semantics import Posture, Semantics
from nao_kin.robot.urdf import Box, Collision, Cylinder, Inertial, MeshFile, Origin, Sphere, UrdfTree, Visual

mujoco = pytest.importorskip("mujoco")
from mujoco_models import all_values, exported, place, set_joints, worst_pose  # noqa: E402


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("mjcf")


@pytest.fixture(scope="module")
def model(nao: nk.NaoModel, folder: Path) -> Any:
    return exported(nao, folder / "nao")


def test_every_link_is_where_the_robot_has_it(each_nao: nk.NaoModel, tmp_path: Path) -> None:
    model = exported(each_nao, tmp_path / "nao")
    for q in each_nao.random(1, 3):
        assert worst_pose(model, each_nao, q, all_values(each_nao, q)) < 1e-12
    assert float(model.body_mass.sum()) == pytest.approx(each_nao.mass, abs=1e-12)


def test_the_centre_of_mass_is_the_robots(nao: nk.NaoModel, model: Any) -> None:
    data = mujoco.MjData(model)
    q = nao.random(2)
    set_joints(model, data, all_values(nao, q))
    data.qpos[:7] = 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.subtree_com[1], nao.com(q), atol=1e-12)


def test_one_actuator_drives_each_joint_of_its_own_within_its_limits(nao: nk.NaoModel, model: Any) -> None:
    assert {model.actuator(i).name for i in range(model.nu)} == set(nao.joint_names)
    # Published: 59.5 mN m behind 130.85; the URDF has what a motor can give for long.
    assert nao.semantics.stall_torques["LKneePitch"] == pytest.approx(7.786, abs=1e-3)
    for name, lower, upper in zip(nao.joint_names, nao.lower, nao.upper, strict=True):
        actuator = model.actuator(name)
        assert model.joint(int(actuator.trnid[0])).name == name
        np.testing.assert_allclose(actuator.ctrlrange, (lower, upper), rtol=1e-15)
        np.testing.assert_allclose(actuator.forcerange[1], nao.semantics.stall_torques[name], rtol=1e-15)
        assert actuator.forcerange[0] == -actuator.forcerange[1]
        np.testing.assert_allclose(model.joint(name).range, (lower, upper), rtol=1e-15)
        assert actuator.gainprm[0] == -actuator.biasprm[1] > 0.0
    assert not model.jnt_limited[[model.joint(name).id for name in nao.mimics]].any()


# The elements and attributes that the export may use, all in the schema of MuJoCo 3.3.6 (`mujoco.mj_printSchema`).
_SCHEMA_OF_MUJOCO_3 = {
    "mujoco": "model",
    "compiler": "angle inertiafromgeom meshdir",
    "option": "cone impratio integrator",
    "size": "nkey",
    "material": "name rgba",
    "mesh": "content_type file inertia name scale",
    "default": "class",
    "body": "name pos quat",
    "inertial": "fullinertia mass pos",
    "joint": "armature axis damping frictionloss joint1 joint2 name polycoef pos range solimp solref type",
    "geom": "class conaffinity contype group material mesh name pos quat size type",
    "site": "group name pos quat size type",
    "camera": "fovy name pos quat resolution",
    "exclude": "body1 body2",
    "position": "ctrlrange forcerange gear joint kp kv name",
    "key": "ctrl name qpos",
    "framequat": "name objname objtype",
    **dict.fromkeys(("accelerometer", "gyro", "touch"), "name site"),
    **dict.fromkeys(("ballangvel", "ballquat", "jointpos", "jointvel"), "joint name"),
    **dict.fromkeys(("actuator", "asset", "contact", "equality", "keyframe", "sensor", "worldbody"), ""),
}


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"base": "fixed"},
        {"typed": True, "coupling": "independent"},
        {"coupling": "locked", "frames": "none", "meshes": "none"},
    ],
    ids=str,
)
def test_mujoco_3_can_read_what_a_later_version_has_written(
    nao: nk.NaoModel, tmp_path: Path, options: dict[str, Any]
) -> None:
    nk.export.mjcf(nao, tmp_path / "nao", **options)
    for element in ET.parse(tmp_path / "nao" / "nao_v6.xml").iter():
        assert element.tag in _SCHEMA_OF_MUJOCO_3
        assert set(element.keys()) <= set(_SCHEMA_OF_MUJOCO_3[element.tag].split()), element.tag


def test_couplings_are_equalities(nao: nk.NaoModel, model: Any) -> None:
    assert model.neq == len(nao.mimics)
    for number in range(model.neq):
        follower, driver = (
            model.joint(int(model.eq_obj1id[number])).name,
            model.joint(int(model.eq_obj2id[number])).name,
        )
        mimic = nao.mimics[follower]
        assert mimic.joint == driver
        np.testing.assert_allclose(model.eq_data[number, :5], [mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0])


def test_key_frames_are_the_postures_set_down(nao: nk.NaoModel, model: Any) -> None:
    assert {model.key(i).name for i in range(model.nkey)} == set(nao.posture_names)
    assert model.key(0).name == "StandInit"
    data = mujoco.MjData(model)
    for name in nao.posture_names:
        mujoco.mj_resetDataKeyframe(model, data, model.key(name).id)
        mujoco.mj_forward(model, data)
        for joint, value in all_values(nao, nao.posture(name)).items():
            assert data.joint(joint).qpos[0] == value, (name, joint)
        for joint, value in nao.angles(nao.posture(name)).items():
            assert data.actuator(joint).ctrl[0] == value, (name, joint)
        # Half a micrometre lower it just touches the floor, and nothing of it touches anything else.
        data.qpos[2] -= 5e-7
        mujoco.mj_forward(model, data)
        assert {int(geom) for geom in data.contact.geom1} == {model.geom("floor").id}, name
        assert data.contact.dist.min() == pytest.approx(-5e-7, abs=1e-9), name
        up = nao.semantics.postures[name].up
        if up is None:
            soles = [data.site(sole) for sole in nao.semantics.soles]
            # The published values of Stand and Crouch set the feet down on their edges.
            flat = name in ("StandInit", "StandZero")
            assert max(abs(sole.xpos[2]) for sole in soles) < (1e-6 if flat else 2e-3), name
            assert min(sole.xmat[8] for sole in soles) > np.cos(1e-6 if flat else 0.05), name
        else:
            vertical = place(data, "base_link")[2, :3]
            np.testing.assert_allclose(vertical, np.array(up) / np.linalg.norm(up), atol=1e-12)


def test_a_standing_robot_stands_on_four_corners_of_each_foot(nao: nk.NaoModel, model: Any) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("StandInit").id)
    mujoco.mj_forward(model, data)
    # NAO's two feet miss one plane by some nanometres, and a contact begins where there is no gap.
    data.qpos[2] -= 1e-6
    mujoco.mj_forward(model, data)
    assert data.ncon == 8


def test_cameras_look_along_x_with_the_published_fields_of_view(nao: nk.NaoModel, model: Any) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    for name, (horizontal, vertical) in nao.semantics.fields_of_view.items():
        right, above, back = data.camera(name).xmat.reshape(3, 3).T
        forward, left, up = place(data, name)[:3, :3].T
        np.testing.assert_allclose([-back, -right, above], [forward, left, up], atol=1e-12)
        np.testing.assert_allclose(data.camera(name).xpos, place(data, name)[:3, 3], atol=1e-12)
        fovy = np.radians(float(model.camera(name).fovy[0]))
        assert fovy == pytest.approx(vertical, abs=1e-12)
        width, height = model.cam_resolution[model.camera(name).id]
        assert 2.0 * np.arctan(np.tan(0.5 * fovy) * width / height) == pytest.approx(horizontal, abs=2e-3)


def test_shapes_to_see_and_shapes_to_touch_are_two_groups(nao: nk.NaoModel, model: Any) -> None:
    own = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom]]
    seen = [geom for geom in own if model.geom_group[geom] == 2]
    touching = [geom for geom in own if model.geom_group[geom] == 3]
    assert len(seen) == len(nao.tree.visuals)
    # A cylinder and two spheres of the URDF are one capsule here.
    kinds = Counter(mujoco.mjtGeom(kind).name for kind in model.geom_type[touching])
    assert kinds == {"mjGEOM_CAPSULE": 21, "mjGEOM_SPHERE": 3, "mjGEOM_BOX": 6}
    assert len(touching) == len(list(shapes_of(nao.tree)))
    assert len(own) == len(seen) + len(touching)
    assert not model.geom_contype[seen].any()
    assert not model.geom_conaffinity[seen].any()
    assert model.geom_contype[touching].all()
    white = model.geom("torso_white")
    np.testing.assert_allclose(model.mat_rgba[int(white.matid[0])], (0.93, 0.93, 0.94, 1.0), rtol=1e-6)


def test_meshes_are_where_the_robot_has_them(nao: nk.NaoModel, model: Any) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for name in ("l_foot_white", "r_forearm_white"):
        geom = data.geom(name)
        mesh = int(model.geom(name).dataid[0])
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        points = model.mesh_vert[first : first + count] @ geom.xmat.reshape(3, 3).T + geom.xpos
        visual = next(one for one in nao.tree.visuals if one.name == name)
        T = place(data, visual.link)
        text = (nao.urdf_path.parent / visual.geometry.filename).read_text()
        vertices = np.array([line.split()[1:4] for line in text.splitlines() if line.startswith("v ")], dtype=float)
        theirs = vertices @ T[:3, :3].T + T[:3, 3]
        np.testing.assert_allclose([points.min(0), points.max(0)], [theirs.min(0), theirs.max(0)], atol=1e-6)


@pytest.mark.parametrize(
    ("kind", "most", "written"), [("stl", 12, "stl"), ("stl", 11, "obj"), ("stl_ascii", 12, "stl")]
)
def test_meshes_are_written_as_mujoco_reads_them_and_scaled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, most: int, written: str
) -> None:
    import trimesh

    monkeypatch.setattr("nao_kin.export.meshes._MOST_IN_STL", most)
    box = trimesh.creation.box(extents=(0.2, 0.3, 0.4)).apply_translation((0.5, 0.6, 0.7))
    robot = made_up(tmp_path, J("a"))
    content = box.export(file_type=kind)
    (tmp_path / "box.stl").write_bytes(content.encode() if isinstance(content, str) else content)
    places = [Origin((0.0, 0.0, 1.0)), Origin((0.0, 0.0, 0.0), (0.0, 0.0, np.pi / 2.0))]
    shapes = [MeshFile("box.stl"), MeshFile("box.stl", (1.0, -1.0, 2.0))]
    visuals = tuple(Visual("base", place, shape) for place, shape in zip(places, shapes, strict=True))
    model = exported(nk.RobotModel(replace(robot.tree, visuals=visuals)), tmp_path / "model", base="fixed")
    assert [file.name for file in (tmp_path / "model" / "assets").iterdir()] == [f"box.{written}"]
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for geom, centre in (("base_visual", (0.5, 0.6, 1.7)), ("base_visual_2", (0.6, 0.5, 1.4))):
        mesh = int(model.geom(geom).dataid[0])
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        vertices = model.mesh_vert[first : first + count]
        points = vertices @ data.geom(geom).xmat.reshape(3, 3).T + data.geom(geom).xpos
        np.testing.assert_allclose(0.5 * (points.min(0) + points.max(0)), centre, atol=1e-6)


def test_a_robot_with_a_fixed_base_does_not_stand_in_the_floor(nao: nk.NaoModel, tmp_path: Path) -> None:
    model = exported(nao, tmp_path / "nao", base="fixed")
    data, floor = mujoco.MjData(model), model.geom("floor")
    touching = set()
    for higher in (0.0, 1e-3):  # a millimetre higher one posture reaches it
        floor.pos[2] += higher
        for key in range(model.nkey):
            mujoco.mj_resetDataKeyframe(model, data, key)
            mujoco.mj_forward(model, data)
            if np.any(data.contact.geom == floor.id):
                touching.add(higher)
    assert touching == {1e-3}


def test_with_a_fixed_base_the_root_does_not_move(nao: nk.NaoModel, tmp_path: Path) -> None:
    model = exported(nao, tmp_path / "nao", base="fixed", meshes="none")
    assert model.nq == len(nao.joint_names) + len(nao.mimics)
    assert not (model.jnt_type == mujoco.mjtJoint.mjJNT_FREE).any()


def test_a_robot_with_a_floating_base_gives_the_same_file(nao: nk.NaoModel, tmp_path: Path) -> None:
    for base in ("fixed", "floating"):
        nk.export.mjcf(nk.load_nao("v6", base=base), tmp_path / base, meshes="none")
    assert (tmp_path / "fixed/nao_v6.xml").read_bytes() == (tmp_path / "floating/nao_v6.xml").read_bytes()


@pytest.mark.parametrize(("frames", "wanted"), [("effectors", True), ("none", False)])
def test_fewer_frames_leave_the_sensors(nao: nk.NaoModel, tmp_path: Path, frames: str, wanted: bool) -> None:
    model = exported(nao, tmp_path / "nao", frames=frames, meshes="none")
    sites = {model.site(i).name for i in range(model.nsite)}
    assert {*nao.semantics.force_sensors, *nao.semantics.accelerometers, *nao.semantics.gyrometers} <= sites
    assert (set(nao.semantics.soles) <= sites) == wanted
    assert "HeadTouchFront_frame" not in sites
    assert model.ncam == 2


# --- several axes in one body -------------------------------------------------------------------------------------


def test_typed_axes_share_a_body_and_move_it_as_the_robot_does(nao: nk.NaoModel, tmp_path: Path) -> None:
    model = exported(nao, tmp_path / "nao", typed=True, meshes="none")
    hinges = [int(model.body(body).jntnum[0]) for body in ("Head", "LThigh", "RThigh", "l_ankle", "LTibia")]
    assert hinges == [2, 3, 3, 2, 1]
    assert float(model.body_mass.sum()) == pytest.approx(nao.mass, abs=1e-12)
    data, q = mujoco.MjData(model), nao.random(3)
    set_joints(model, data, all_values(nao, q))
    data.qpos[:7] = 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0
    mujoco.mj_kinematics(model, data)
    for frame in ("Head", "LThigh", "LLeg", "RLeg", "RArm", "CameraTop", "LFinger13_link"):
        np.testing.assert_allclose(place(data, frame), nao.fk(q, frame), atol=1e-12)


def test_why_three_axes_make_no_ball_is_said(nao: nk.NaoModel, tmp_path: Path) -> None:
    done = nk.export.mjcf(nao, tmp_path / "nao", typed=True, meshes="none")
    notes = [change for change in done.changes if "stay three hinges" in change]
    assert [note.split(" stay")[0] for note in notes] == [
        f"{side}HipYawPitch, {side}HipRoll, {side}HipPitch" for side in "LR"
    ]
    assert all(note.endswith("coupling='independent' (--coupling independent) makes a ball of them") for note in notes)
    robot = made_up(tmp_path, J("a", xyz=(0.5, 0.0, 0.0)), J("b", xyz=(0.5, 0.0, 0.0)))
    done = nk.export.mjcf(robot, tmp_path / "m", typed=True)
    assert "no joints have one centre: there is nothing to merge" in done.changes


def test_without_couplings_the_hips_are_balls(nao: nk.NaoModel, tmp_path: Path) -> None:
    model = exported(nao, tmp_path / "nao", typed=True, coupling="independent", meshes="none")
    balls = [i for i in range(model.njnt) if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_BALL]
    name = "LHipYawPitch+LHipRoll+LHipPitch"
    assert [model.joint(i).name for i in balls] == [name, name.replace("L", "R")]
    assert model.neq == 0
    data = mujoco.MjData(model)
    for posture in nao.posture_names:
        mujoco.mj_resetDataKeyframe(model, data, model.key(posture).id)
        mujoco.mj_kinematics(model, data)
        T_torso_world = np.linalg.inv(place(data, "torso"))
        for frame in ("LLeg", "RLeg", "LThigh"):
            expected = nao.fk(nao.posture(posture), frame)
            np.testing.assert_allclose(T_torso_world @ place(data, frame), expected, atol=1e-12)
        # The controls are where the actuators measure the ball.
        mujoco.mj_forward(model, data)
        ids = [model.actuator(f"{name}_{letter}").id for letter in "xyz"]
        np.testing.assert_allclose(data.actuator_length[ids], data.ctrl[ids], atol=1e-9)


def test_locked_joints_are_gone(nao: nk.NaoModel, tmp_path: Path) -> None:
    model = exported(nao, tmp_path / "nao", coupling="locked", meshes="none")
    assert model.nu == 22
    assert model.neq == 0
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("Crouch").id)
    mujoco.mj_kinematics(model, data)
    # With the hips at zero the soles are parallel to each other as they are then, and stand so.
    assert abs(data.site("LLeg").xpos[2] - data.site("RLeg").xpos[2]) < 2e-3


def test_independent_joints_have_actuators_of_their_own(nao: nk.NaoModel, tmp_path: Path) -> None:
    model = exported(nao, tmp_path / "nao", coupling="independent", meshes="none")
    assert model.nu == len(nao.joint_names) + len(nao.mimics)
    assert model.neq == 0


# --- other robots -------------------------------------------------------------------------------------------------


def test_any_joints_move_as_the_robots_do(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("turn", (0.0, 0.6, 0.8), (0.1, 0.0, 0.2), (0.3, -0.4, 0.5), limits=(-1.0, 2.0)),
        J("wheel", (1.0, 0.0, 0.0), (0.0, 0.1, 0.0), kind="continuous"),
        J("rail", (0.0, 0.8, -0.6), (0.2, 0.0, 0.0), (1.0, 0.0, 0.0), "prismatic", limits=(-0.1, 0.3)),
        J("back", (0.0, 1.0, 0.0), (0.0, 0.0, 0.1), follows=("turn", -1.5, 0.25)),
        J("slide", (0.0, 0.0, 1.0), kind="prismatic", follows=("turn", 0.1, -0.05), parent="turn"),
        J("still", (0.0, 0.0, 1.0), (0.1, 0.0, 0.0), follows=("turn", 0.0, 0.4)),
    )
    model = exported(robot, tmp_path / "model")
    for q in robot.random(0, 5):
        assert worst_pose(model, robot, q, all_values(robot, q)) < 1e-12
    assert [model.key(i).name for i in range(model.nkey)] == ["zero"]
    assert not model.jnt_limited[model.joint("wheel").id]
    assert not model.actuator_ctrllimited[model.actuator("wheel").id]
    assert model.jnt_type[model.joint("rail").id] == mujoco.mjtJoint.mjJNT_SLIDE
    np.testing.assert_allclose(model.joint("rail").range, (-0.1, 0.3))
    # Offsets of followers stand in the key frame too.
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    assert data.joint("back").qpos[0] == 0.25
    # At zero, a follower is at its offset; the world's z axis is the root's.
    np.testing.assert_allclose(data.qpos[3:7], (1.0, 0.0, 0.0, 0.0))


def test_three_free_axes_are_a_ball_as_the_product_of_their_turns(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a", (0.0, 0.0, 1.0), (0.1, 0.0, 0.2), (0.3, -0.4, 0.5)),
        J("b", (0.0, 1.0, 0.0)),
        J("c", (1.0, 0.0, 0.0)),
        J("d", (0.0, 1.0, 0.0), (0.3, 0.0, 0.0)),
    )
    angles = {"a": 0.4, "b": -0.7, "c": 1.1, "d": 0.2}
    posed = nk.RobotModel(robot.tree, Semantics(postures={"one": Posture(angles)}))
    model = exported(posed, tmp_path / "model", typed=True)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_kinematics(model, data)
    T_root_tip = np.linalg.inv(place(data, "base")) @ place(data, "d_l")
    np.testing.assert_allclose(T_root_tip, posed.fk(posed.posture("one"), "d_l"), atol=1e-12)
    typed = nk.joints.MultiDofModel(robot, intermediate="drop")
    x, y, z, w = typed.from_q(posed.posture("one"))[typed.columns["a+b+c"]]
    ours = data.joint("a+b+c").qpos
    np.testing.assert_allclose(np.abs(ours @ (w, x, y, z)), 1.0, atol=1e-12)


def test_what_the_file_says_of_friction_and_damping_is_kept(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", follows=("a", 2.0, 0.0)))
    tree = robot.tree
    joints = tuple(replace(joint, damping=0.3, friction=0.07, effort=4.0, velocity=8.0) for joint in tree.joints)
    model = exported(nk.RobotModel(replace(tree, joints=joints)), tmp_path / "model")
    # Of the driving joint the motor's 4 N m / 8 rad/s comes on top.
    assert np.ravel(model.joint("a").damping)[0] == pytest.approx(0.3 + 0.5)
    assert np.ravel(model.joint("b").damping)[0] == pytest.approx(0.3)
    assert float(model.joint("a").frictionloss[0]) == pytest.approx(0.07)


def test_an_effort_that_nobody_has_published_bounds_nothing(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b"))
    tree = robot.tree
    joints = tuple(replace(joint, effort=effort) for joint, effort in zip(tree.joints, (0.0, np.inf), strict=True))
    done = nk.export.mjcf(nk.RobotModel(replace(tree, joints=joints)), tmp_path / "model")
    model = mujoco.MjModel.from_xml_path(str(done.path))
    assert not model.actuator_forcelimited.any()
    assert "no effort is published for a, b: force without bounds, gain 100" in done.changes


def test_masses_are_spread_as_pinocchio_has_them(tmp_path: Path) -> None:
    # Two links on a fixed joint, askew: what the body has is the sum, in its own frame.
    robot = made_up(
        tmp_path,
        J("a", (0.0, 0.6, 0.8), (0.1, 0.0, 0.2), (0.3, -0.4, 0.5)),
        J("held", kind="fixed", xyz=(0.2, -0.1, 0.3), rpy=(0.7, 0.2, -1.1)),
        J("b", (1.0, 0.0, 0.0), (0.0, 0.1, 0.0), kind="prismatic"),
        J("c", (0.0, 1.0, 0.0), (0.1, 0.1, 0.0)),
    )
    model = exported(robot, tmp_path / "m", base="fixed", inertia="published")
    model.dof_armature[:] = 0.0
    data, ours = mujoco.MjData(model), np.empty((3, 3))
    theirs = pin.buildModelFromUrdf(str(robot.urdf_path))
    for q in robot.random(0, 4):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        for axis in range(3):  # a column of the mass matrix for each unit vector
            mujoco.mj_mulM(model, data, ours[axis], np.eye(3)[axis])
        M = pin.crba(theirs, theirs.createData(), q)
        np.testing.assert_allclose(ours, np.triu(M) + np.triu(M, 1).T, atol=1e-8)  # MuJoCo 3.3 turns tensors to 2e-9


def test_the_root_has_the_name_of_a_link_in_its_own_frame(tmp_path: Path) -> None:
    for at, name in (((0.0, 0.0, 0.0), "trunk_l"), ((0.0, 0.0, 0.1), "base")):
        robot = made_up(tmp_path, J("trunk", kind="fixed", xyz=at), J("a", xyz=(0.1, 0.0, 0.0)))
        inertials = {link: body for link, body in robot.tree.inertials.items() if link != "base"}
        bare = nk.RobotModel(replace(robot.tree, inertials=inertials))
        assert exported(bare, tmp_path / "m", overwrite=True).body(1).name == name


def test_links_between_merged_axes_are_named_with_what_is_fixed_to_them(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a", (0.0, 0.0, 1.0)),
        J("b", (0.0, 1.0, 0.0)),
        J("plate", kind="fixed", parent="a"),
        J("screw", kind="fixed", parent="plate"),
    )
    done = nk.export.mjcf(robot, tmp_path / "m", typed=True)
    assert "a_l, plate_l, screw_l are between merged axes: fixed to the bodies before them" in done.changes


def test_neighbours_across_a_link_without_shapes_do_not_touch(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a", xyz=(0.5, 0.0, 0.0)), J("b", xyz=(0.5, 0.0, 0.0)))
    shapes = tuple(Collision(link, Origin(), Sphere(0.1)) for link in ("base", "b_l"))
    model = exported(nk.RobotModel(replace(robot.tree, collisions=shapes)), tmp_path / "m")
    pairs = [{int(signature) >> 16, int(signature) & 0xFFFF} for signature in model.exclude_signature]
    assert pairs == [{model.body("base").id, model.body("b_l").id}]


def test_sizes_of_shapes_are_exact(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"))
    box = Collision("a_l", Origin(), Box((0.123456789012, 0.2, 0.3)))
    model = exported(nk.RobotModel(replace(robot.tree, collisions=(box,))), tmp_path / "m")
    assert model.geom("a_l_collision").size[0] == 0.5 * 0.123456789012


def test_a_motor_is_as_strong_and_fast_as_published(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("turn"), J("rail", kind="prismatic"))
    model = exported(robot, tmp_path / "m")
    for name, error in (("turn", 1.0 / 60.0), ("rail", 1.0 / 600.0)):
        actuator, joint = model.actuator(name), model.joint(name)
        kp, kv = float(actuator.gainprm[0]), -float(actuator.biasprm[2])
        assert kp * error == pytest.approx(5.0)  # the full effort at that error
        assert actuator.biasprm[1] == -kp
        damping = float(model.dof_damping[joint.dofadr[0]].flat[0])
        armature = float(model.dof_armature[joint.dofadr[0]])
        assert damping * 2.0 == pytest.approx(5.0)  # nothing is left at the largest speed
        assert armature == pytest.approx(0.015 * damping)
        assert kv + damping == pytest.approx(2.0 * (kp * armature) ** 0.5)  # critically damped


def test_a_ball_is_turned_by_the_weakest_of_its_motors(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a", (0.0, 0.0, 1.0)), J("b", (0.0, 1.0, 0.0)), J("c", (1.0, 0.0, 0.0)))
    efforts = {"a": 7.0, "b": 3.0, "c": 5.0}
    joints = tuple(
        replace(joint, effort=efforts[joint.name], friction=efforts[joint.name]) for joint in robot.tree.joints
    )
    model = exported(nk.RobotModel(replace(robot.tree, joints=joints)), tmp_path / "m", typed=True)
    assert model.nu == 3
    for letter in "xyz":
        np.testing.assert_array_equal(model.actuator(f"a+b+c_{letter}").forcerange, (-3.0, 3.0))
    np.testing.assert_array_equal(model.dof_frictionloss[model.joint("a+b+c").dofadr[0]], 7.0)


def test_a_joint_that_its_limits_hold_is_held(tmp_path: Path) -> None:
    # To MuJoCo a range of no width is no range.
    held = {"a": 0.0, "b": 0.5}
    robot = made_up(tmp_path, *(J(name, limits=(value, value)) for name, value in held.items()))
    model = exported(robot, tmp_path / "m")
    for name, value in held.items():
        assert model.jnt_limited[model.joint(name).id]
        assert model.actuator_ctrllimited[model.actuator(name).id]
        for ends in (model.joint(name).range, model.actuator(name).ctrlrange):
            np.testing.assert_allclose(ends, value, atol=2e-9)
            assert ends[0] < ends[1]


def test_a_joint_with_one_limit_has_it_in_mujoco_too(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a", limits=(-0.5, np.inf)), J("b", limits=(-np.inf, 0.25)), J("c"))
    done = nk.export.mjcf(robot, tmp_path / "model")
    model = mujoco.MjModel.from_xml_path(str(done.path))
    for name, ends in (("a", (-0.5, 1e9)), ("b", (-1e9, 0.25))):
        assert model.joint(name).limited
        np.testing.assert_array_equal(model.joint(name).range, ends)
        np.testing.assert_array_equal(model.actuator(name).ctrlrange, ends)
    assert sum("has one limit" in line for line in done.changes) == 2


def test_the_key_frame_of_a_robot_without_postures_is_within_its_limits(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a", limits=(0.5, 1.0)), J("b"), J("c", limits=(-1.0, -0.25)))
    model = exported(robot, tmp_path / "m", base="fixed")
    np.testing.assert_array_equal(model.key("zero").qpos, [0.5, 0.0, -0.25])
    np.testing.assert_array_equal(model.key("zero").ctrl, [0.5, 0.0, -0.25])


def test_feet_end_in_the_planes_of_their_soles(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("hip", (0.0, 1.0, 0.0), (0.0, 0.0, -0.3)))
    turned = Origin((0.02, 0.0, -0.10), (0.0, np.pi / 2.0, 0.0))
    tree = replace(robot.tree, collisions=(Collision("hip_l", turned, Box((0.044, 0.08, 0.2)), "foot"),))
    # The sole is the link's frame lowered by 120 mm: the box, with x along the sole's normal, ends 2 mm above.
    tree = _with_a_frame(tree, "sole", "hip_l", (0.0, 0.0, -0.12))
    standing = nk.RobotModel(tree, Semantics(soles=("sole",), cameras=("sole",), postures={"one": Posture({})}))
    done = nk.export.mjcf(standing, tmp_path / "model")
    model = mujoco.MjModel.from_xml_path(str(done.path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_kinematics(model, data)
    assert abs(data.site("sole").xpos[2]) < 1e-12
    np.testing.assert_allclose(model.geom("foot").size, (0.022 - 0.001 + 0.002, 0.04, 0.1), atol=2e-3)
    upper = data.geom("foot").xpos[2] + model.geom("foot").size[0]
    assert upper == pytest.approx(0.12 - 0.10 + 0.022, abs=1e-12)
    assert any("moved by -2.00 mm to sole" in line or "moved by 2.00 mm to sole" in line for line in done.changes)
    assert any("field of view of sole is unknown" in line for line in done.changes)


def test_a_sole_without_a_shape_is_said(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("hip"))
    done = nk.export.mjcf(nk.RobotModel(robot.tree, Semantics(soles=("hip_l",))), tmp_path / "model")
    assert "the body of the sole hip_l has no shape: it touches nothing" in done.changes


def test_a_root_called_world_is_no_trouble(tmp_path: Path) -> None:
    made_up(tmp_path, J("a", (0.0, 1.0, 0.0)), J("root_joint", (1.0, 0.0, 0.0)))
    text = (tmp_path / "robot.urdf").read_text().replace('"base"', '"world"').replace('"made_up"', '"scene"')
    (tmp_path / "robot.urdf").write_text(text)
    model = exported(nk.RobotModel.from_urdf(tmp_path / "robot.urdf"), tmp_path / "model")
    assert model.body(1).name == "world_link"
    assert model.joint(0).name == "root_joint_2"
    assert (tmp_path / "model" / "robot.xml").is_file()


@pytest.mark.full
def test_romeo_is_exported_with_its_meshes(tmp_path: Path) -> None:
    pytest.importorskip("cmeel", reason="example-robot-data")
    romeo = nk.load_robot("romeo")
    model = exported(romeo, tmp_path / "romeo")
    q = romeo.random(4)
    assert worst_pose(model, romeo, q, all_values(romeo, q)) < 1e-12
    assert float(model.body_mass.sum()) == pytest.approx(romeo.mass, abs=1e-9)
    assert model.nmesh > 40


def test_a_foot_without_a_box_stands_on_what_it_has(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("hip", (0.0, 1.0, 0.0), (0.0, 0.0, -0.3)))
    shapes = [Cylinder(0.05, 0.02), Sphere(0.03), Box((0.1, 0.1, 0.1))]
    for shape, reach in zip(shapes, (0.01, 0.03, 0.05), strict=True):
        tree = replace(robot.tree, collisions=(Collision("hip_l", Origin((0.0, 0.0, -0.1)), shape),))
        standing = nk.RobotModel(tree, Semantics(soles=("hip_l",), postures={"one": Posture({})}))
        model = exported(standing, tmp_path / "model", overwrite=True)
        assert model.key("one").qpos[2] == pytest.approx(0.3 + 0.1 + reach, abs=1e-12)


# --- bad input ----------------------------------------------------------------------------------------------------


def test_a_missing_mesh_is_named_and_nothing_is_written(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"))
    tree = replace(robot.tree, visuals=(Visual("a_l", Origin(), MeshFile("gone.stl")),))
    with pytest.raises(BadArgument, match=r"gone\.stl"):
        nk.export.mjcf(nk.RobotModel(tree), tmp_path / "model")
    (tmp_path / "gone.stl").write_bytes(b"solid nothing")
    with pytest.raises(BadArgument, match=r"gone\.stl"):
        nk.export.mjcf(nk.RobotModel(tree), tmp_path / "model")
    assert not (tmp_path / "model").exists()
    done = nk.export.mjcf(nk.RobotModel(tree), tmp_path / "model", meshes="none")
    assert "1 shapes that are meshes are left out" in done.changes


def test_a_robot_without_mass_is_refused_as_published_and_mended_otherwise(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b"))
    bare = nk.RobotModel(replace(robot.tree, inertials={}))
    with pytest.raises(BadModel, match="inertia='physical'"):
        nk.export.mjcf(bare, tmp_path / "model", inertia="published")
    assert not (tmp_path / "model").exists()
    assert exported(bare, tmp_path / "model").body_mass.sum() > 0.0


def test_published_inertias_are_kept_where_they_can_be(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"))
    body = Inertial(2.0, Origin((0.1, 0.0, 0.0), (0.3, 0.4, 0.5)), (0.02, 0.0, 0.0, 0.03, 0.0, 0.04))
    tree = replace(robot.tree, inertials={**robot.tree.inertials, "a_l": body})
    model = exported(nk.RobotModel(tree), tmp_path / "model", inertia="published")
    a = model.body("a_l")
    np.testing.assert_allclose(sorted(a.inertia), (0.02, 0.03, 0.04), atol=1e-12)
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, a.iquat)
    ours = R.reshape(3, 3) @ np.diag(a.inertia) @ R.reshape(3, 3).T
    turned = nk.rotations.matrix_from_rpy((0.3, 0.4, 0.5))
    np.testing.assert_allclose(ours, turned @ np.diag((0.02, 0.03, 0.04)) @ turned.T, atol=1e-8)


def test_without_mujoco_the_extra_is_named(nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtra, match=r"nao-kin\[mujoco\]"):
        nk.export.mjcf(nao, tmp_path / "nao")
    assert not list(tmp_path.iterdir())


def _with_a_frame(tree: UrdfTree, name: str, parent: str, xyz: tuple[float, float, float]) -> UrdfTree:
    """The tree with one more link, fixed to another."""
    from nao_kin.robot.urdf import UrdfJoint

    joint = UrdfJoint(f"{name}_fixed", "fixed", parent, name, Origin(xyz))
    return replace(tree, links=(*tree.links, name), joints=(*tree.joints, joint))
