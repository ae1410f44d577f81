"""URDF 1.1: orientations as quaternions, and capsules; what a file says that this library cannot take, and says so."""

from __future__ import annotations

from pathlib import Path

import coal
import mujoco
import numpy as np
import pinocchio as pin
import pytest
import trimesh

import nao_kin as nk
from nao_kin.cli.app import run as run_program
from nao_kin.errors import BadModel, MissingShapeWarning
from nao_kin.robot.urdf import Cylinder, Sphere

LIMIT = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'
CAPSULE = '<capsule radius="0.1" length="0.3"/>'
# Of several lengths; the last has a pitch of 90°.
QUATERNIONS = (
    "0.1 -0.2 0.3 0.9",
    "0.5 0 0 0.5",
    "-2 1 0.3 0.4",
    "0.1 0.2 0.3 -0.9",
    "0 0.7071067811865476 0 0.7071067811865476",
)


def _robot(folder: Path, body: str, version: str = "1.1") -> nk.RobotModel:
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r" version="{version}">{body}</robot>', encoding="utf-8")
    return nk.RobotModel.from_urdf(path)


def _joint(name: str, parent: str, child: str, origin: str) -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin {origin}/>'
        f'<axis xyz="0 1 0"/>{LIMIT}</joint>'
    )


def _turned(quaternion: str) -> str:
    """Return a robot with the quaternion in the origins of a joint, an inertia, a visual and a collision."""
    origin = f'<origin xyz="0.1 0.2 -0.3" quat_xyzw="{quaternion}"/>'
    shapes = "".join(f'<{kind}>{origin}<geometry><box size="1 2 3"/></geometry></{kind}>' for kind in KINDS)
    inertial = f'<inertial>{origin}<mass value="2"/><inertia ixx="1" iyy="1.2" izz="1.5" ixy="0.1" ixz="0" iyz="0.2"/>'
    link = f'<link name="a"/><link name="b">{inertial}</inertial>{shapes}</link><link name="c"/>'
    return (
        link + _joint("j", "a", "b", origin.strip("</>").removeprefix("origin ")) + _joint("k", "b", "c", 'xyz="1 0 0"')
    )


KINDS = ("visual", "collision")


@pytest.mark.parametrize("quaternion", QUATERNIONS)
def test_a_quaternion_in_an_origin_turns_joint_inertia_and_shapes(tmp_path: Path, quaternion: str) -> None:
    robot = _robot(tmp_path, _turned(quaternion))
    assert robot.load_notes == ()
    plain = pin.buildModelFromUrdf(str(robot.urdf_path))
    data = plain.createData()
    for q in robot.random(0, 3):
        pin.framesForwardKinematics(plain, data, q)
        for link in robot.link_names:
            expected = data.oMf[plain.getFrameId(link, pin.FrameType.BODY)].homogeneous
            np.testing.assert_allclose(robot.fk(q, link), expected, atol=1e-15)
        np.testing.assert_allclose(robot.com(q), pin.centerOfMass(plain, data, q), atol=1e-15)
    np.testing.assert_allclose(robot.model.inertias[1].inertia, plain.inertias[1].inertia, atol=1e-15)
    for kind, pinocchios in zip(KINDS, (pin.GeometryType.VISUAL, pin.GeometryType.COLLISION), strict=True):
        (theirs,) = pin.buildGeomFromUrdf(plain, str(robot.urdf_path), pinocchios).geometryObjects
        (ours,) = robot.geometry(kind).geometryObjects
        np.testing.assert_allclose(ours.placement.homogeneous, theirs.placement.homogeneous, atol=1e-15)
    report = nk.crosscheck.run(robot, 10)
    assert report.ok, report.failures
    (row,) = (row for row in report.rows if row.convention == "poses by Pinocchio" and row.against == "yourdfpy")
    assert row.note.startswith("4 frames left out")  # yourdfpy does not know quat_xyzw


def test_a_quaternion_in_a_file_of_version_1_0_is_ignored_with_a_note(tmp_path: Path) -> None:
    for version in ("1.0", "1", "next"):
        robot = _robot(tmp_path, _turned("0.5 0 0 0.5"), version)
        note = 'quat_xyzw of 4 origins is ignored: it needs <robot version="1.1">, as in other readers'
        assert robot.load_notes == (note,)
        assert np.array_equal(robot.rotation([0.0, 0.0], "b"), np.eye(3))
    for version in ("1.2", "1.10", "2.0"):
        robot = _robot(tmp_path, _turned("0.5 0 0 0.5"), version)
        np.testing.assert_allclose(robot.rotation([0.0, 0.0], "b"), [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-15)


@pytest.mark.parametrize(
    ("orientation", "reason"),
    [
        ('quat_xyzw="1 0 0"', "origin has quat_xyzw '1 0 0', expected 4 finite numbers"),
        ('quat_xyzw="1 0 0 nan"', "origin has quat_xyzw '1 0 0 nan', expected 4 finite numbers"),
        ('quat_xyzw="0 0 0 0"', "origin has quat_xyzw '0 0 0 0', which is no rotation"),
        ('quat_xyzw="0 0 0 1" rpy="0 0 0"', "origin has both rpy and quat_xyzw"),
    ],
)
def test_an_orientation_that_is_none_is_refused(tmp_path: Path, orientation: str, reason: str) -> None:
    with pytest.raises(BadModel, match=f"joint 'j': {reason}"):
        _robot(tmp_path, f'<link name="a"/><link name="b"/>{_joint("j", "a", "b", orientation)}')
    shape = f"<visual><origin {orientation}/><geometry>{CAPSULE}</geometry></visual>"
    (note,) = _robot(tmp_path, f'<link name="a">{shape}</link>').load_notes
    assert note == f"a visual of a is not shown: {note.split(': ')[1]}"
    assert reason in note


def _two_links(geometry: str) -> str:
    box = '<collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>'
    shapes = "".join(f'<{kind}><origin rpy="0.3 0 0"/><geometry>{geometry}</geometry></{kind}>' for kind in KINDS)
    links = f'<link name="a">{box}</link><link name="b"/><link name="c">{shapes}</link>'
    return links + _joint("j", "a", "b", 'xyz="0 0 0.5"') + _joint("k", "b", "c", 'xyz="0 0 0.5"')


@pytest.mark.parametrize("version", ["1.1", "1.0"])
def test_a_capsule_is_kept_clear_of(tmp_path: Path, version: str) -> None:
    robot = _robot(tmp_path, _two_links(CAPSULE), version)
    assert robot.load_notes == ()
    box, capsule, request = coal.Box(0.2, 0.2, 0.2), coal.Capsule(0.1, 0.3), coal.DistanceRequest()
    request.enable_signed_distance = True
    turn = pin.SE3(pin.rpy.rpyToMatrix(0.3, 0.0, 0.0), np.zeros(3))
    for q in ([0.0, 0.0], [3.0, 0.0], [2.2, 1.0], [-1.0, 2.5]):
        T = pin.SE3(robot.fk(q, "c")) * turn
        placed = coal.Transform3s(T.rotation, T.translation)
        expected = coal.distance(box, coal.Transform3s(), capsule, placed, request, coal.DistanceResult())
        assert robot.clearance(q).distance == pytest.approx(expected, abs=1e-6)
    assert [contact.links for contact in robot.collisions([3.0, 0.0])] == [("a", "c")]


def test_a_capsule_is_a_cylinder_with_a_sphere_at_each_end_in_every_use(tmp_path: Path) -> None:
    robot = _robot(tmp_path, _two_links(CAPSULE))
    for shapes in (robot.tree.visuals, robot.tree.collisions[1:]):
        assert [shape.geometry for shape in shapes] == [Cylinder(0.1, 0.3), Sphere(0.1), Sphere(0.1)]
    T = robot.fk([3.0, 0.0], "c")
    lowest = T[2, 3] - 0.15 * abs(T[2, :3] @ pin.rpy.rpyToMatrix(0.3, 0.0, 0.0)[:, 2]) - 0.1
    assert robot.set_down([3.0, 0.0]).T_world_base[2, 3] == pytest.approx(-lowest, abs=1e-3)  # on the floor
    exported = nk.export.urdf(robot, tmp_path / "again.urdf").path
    assert nk.RobotModel.from_urdf(exported).tree.visuals == robot.tree.visuals
    geoms = mujoco.MjModel.from_xml_path(str(nk.export.mjcf(robot, tmp_path / "r.xml").path)).geom_type.tolist()
    assert geoms.count(mujoco.mjtGeom.mjGEOM_CAPSULE) == 1
    assert nk.export.sdf(robot, tmp_path / "r.sdf").path.read_text().count("<sphere>") == 4
    scene = trimesh.load_scene(nk.export.gltf(robot, tmp_path / "r.glb").path)
    np.testing.assert_allclose(np.ptp(scene.bounds, axis=0).max(), 0.5, atol=0.02)


def test_a_capsule_without_length_is_a_sphere_and_one_without_radius_none(tmp_path: Path) -> None:
    shape = "<collision><geometry>{}</geometry></collision>"
    body = '<link name="a">' + shape.format('<capsule radius="0.1" length="0"/>') + "</link>"
    assert [row.geometry for row in _robot(tmp_path, body).tree.collisions] == [Sphere(0.1)]
    body = '<link name="a">' + shape.format('<capsule radius="0" length="1"/>') + "</link>"
    assert _robot(tmp_path, body).load_notes == (
        "a collision shape of a is left out: capsule has radius 0 and length 1",
    )


@pytest.mark.parametrize(
    ("geometry", "reason"),
    [("<cone/>", "geometry 'cone' is unknown"), ('<capsule radius="1"/>', "capsule has length '', expected 1 finite")],
)
def test_a_collision_shape_that_is_not_understood_is_said_wherever_it_matters(
    tmp_path: Path, geometry: str, reason: str
) -> None:
    left_out = f"a collision shape of c is left out: {reason}"
    robot = _robot(tmp_path, _two_links(geometry))
    assert robot.load_notes[0].startswith("a visual of c is not shown")
    assert robot.load_notes[1].startswith(left_out)
    for ask in ("clearance", "collisions"):
        robot = nk.RobotModel.from_urdf(robot.urdf_path)
        with pytest.warns(MissingShapeWarning, match=left_out):
            getattr(robot, ask)([0.0, 0.0])


def test_the_command_says_which_collision_shape_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    robot = _robot(tmp_path, _two_links("<cone/>"))
    assert run_program(["collisions", "--urdf", str(robot.urdf_path)]) == 0
    out, err = capsys.readouterr()
    assert out == "no clearance: there are no pairs of links to compare\n"
    assert err == "nao-kin: r: a collision shape of c is left out: geometry 'cone' is unknown\n"
