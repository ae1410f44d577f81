"""The looks of a robot from MJCF: every shape where MuJoCo has it, and none that keeps a robot from loading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from mjcf_samples import BOX, Mujoco, write

import nao_kin as nk
from nao_kin.robot.urdf import Box, Cylinder, MeshFile, Sphere, Visual
from nao_kin.rotations import matrix_from_rpy

pytest.importorskip("mujoco", reason="MuJoCo reads MJCF")


def _load(folder: Path, inside: str) -> nk.RobotModel:
    return nk.RobotModel.from_mjcf(write(folder, inside))


def _bone(folder: Path, name: str = "bone.stl") -> trimesh.Trimesh:
    """A mesh file whose centre and axes are not those of its coordinates."""
    mesh = trimesh.creation.box((0.1, 0.2, 0.3))
    mesh.apply_translation((0.5, 0.1, -0.2))
    mesh = mesh.subdivide()
    mesh.vertices[:, 0] += 0.3 * mesh.vertices[:, 1] ** 2
    folder.mkdir(exist_ok=True)
    mesh.export(folder / name)
    return trimesh.load(folder / name)


def _T(visual: Visual) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = matrix_from_rpy(visual.origin.rpy), visual.origin.xyz
    return T


def test_primitives_keep_their_sizes_and_places(tmp_path: Path) -> None:
    robot = _load(
        tmp_path,
        """<asset><material name="red" rgba="1 0 0 1"/></asset>
        <worldbody><body name="a"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
          <geom name="box" type="box" size="1 2 3" pos="0 0 1" material="red"/>
          <geom type="cylinder" fromto="0 0 0 0 2 0" size=".1" rgba="0 1 0 .5"/>
          <geom type="sphere" size=".4"/></body></worldbody>""",
    )
    box, cylinder, sphere = robot.tree.visuals
    assert (box.geometry, box.material, box.rgba, box.name) == (
        Box((2.0, 4.0, 6.0)),
        "red",
        (1.0, 0.0, 0.0, 1.0),
        "box",
    )
    assert cylinder.geometry == Cylinder(0.1, 2.0)
    assert np.allclose(np.abs(_T(cylinder)[:3, 2]), (0, 1, 0))
    assert cylinder.rgba == (0.0, 1.0, 0.0, 0.5)
    assert (sphere.geometry, sphere.rgba) == (Sphere(0.4), None)
    assert len(robot.tree.collisions) == 3


def test_a_capsule_is_a_cylinder_with_two_spheres(tmp_path: Path) -> None:
    robot = _load(
        tmp_path, '<worldbody><body name="a"><geom type="capsule" fromto="0 0 0 0 0 2" size=".1"/></body></worldbody>'
    )
    shapes = [(visual.geometry, visual.origin.xyz) for visual in robot.tree.visuals]
    assert shapes[0] == (Cylinder(0.1, 2.0), (0.0, 0.0, 1.0))
    assert sorted(xyz[2] for shape, xyz in shapes[1:] if shape == Sphere(0.1)) == [0.0, 2.0]


def test_groups_above_two_are_no_looks_and_what_touches_nothing_no_collision_shape(tmp_path: Path) -> None:
    look = '<geom group="2" contype="0" conaffinity="0" type="sphere" size=".1" mass="1"/>'
    hull = '<geom group="3" type="box" size=".1 .1 .1"/>'
    robot = _load(tmp_path, f'<worldbody><body name="a">{look}{hull}</body></worldbody>')
    assert [visual.geometry for visual in robot.tree.visuals] == [Sphere(0.1)]
    assert [collision.geometry for collision in robot.tree.collisions] == [Box((0.2, 0.2, 0.2))]
    assert len(_load(tmp_path, f'<worldbody><body name="a">{hull}</body></worldbody>').tree.visuals) == 1


def test_what_cannot_be_shown_is_noted(tmp_path: Path) -> None:
    robot = _load(
        tmp_path,
        f"""<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset><worldbody><body name="a">{BOX}
        <geom type="ellipsoid" size=".1 .2 .3"/><geom name="blob" type="mesh" mesh="m"/></body></worldbody>""",
    )
    assert any("1 ellipsoids are shown as spheres" in note for note in robot.tree.visual_notes)
    assert any("come from no file are not shown: blob" in note for note in robot.tree.visual_notes)
    assert np.cbrt(0.1 * 0.2 * 0.3) == pytest.approx(robot.tree.visuals[1].geometry.radius)


@pytest.mark.parametrize("inertial", ["", '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'])
@pytest.mark.parametrize(
    "asset",
    [
        "",
        'scale="2 2 2"',
        'scale=".5 1 -2"',
        'refpos=".1 .2 .3" scale=".5 1 2"',
        'refpos=".1 .2 .3" refquat=".8 .1 .5 -.2" scale="2 2 2"',
    ],
)
def test_a_mesh_stands_where_mujoco_draws_it(tmp_path: Path, inertial: str, asset: str) -> None:
    """Loaded for the mass of its body, whose file MuJoCo then moves to its centre; or not loaded at all."""
    file = _bone(tmp_path / "meshes")
    robot = _load(
        tmp_path,
        f"""<compiler angle="radian" meshdir="meshes"/><asset><mesh name="m" file="bone.stl" {asset}/></asset>
        <worldbody><body name="a">{inertial}
          <geom type="mesh" mesh="m" pos=".1 .2 .3" euler=".3 .4 .5"/></body></worldbody>""",
    )
    (visual,) = robot.tree.visuals
    assert isinstance(visual.geometry, MeshFile)
    assert visual.geometry.filename == "meshes/bone.stl"
    assert robot.tree.packages.file(visual.geometry.filename) == (tmp_path / "meshes" / "bone.stl").resolve()
    ours = (file.vertices * visual.geometry.scale) @ _T(visual)[:3, :3].T + _T(visual)[:3, 3]
    own = Mujoco(tmp_path / "robot.xml")
    own.set({})
    theirs = own.model.mesh_vert @ own.data.geom_xmat[0].reshape(3, 3).T + own.data.geom_xpos[0]
    apart = np.linalg.norm(ours[:, None] - theirs[None], axis=2)
    assert apart.min(axis=0).max() < 1e-6  # MuJoCo keeps vertices in single precision
    assert apart.min(axis=1).max() < 1e-6


def test_a_robot_of_meshes_and_textures_that_are_not_there_loads_all_the_same(tmp_path: Path) -> None:
    robot = _load(
        tmp_path,
        """<asset><mesh name="m" file="gone.stl"/><texture name="t" type="2d" file="gone.png"/>
          <material name="skin" texture="t" rgba=".1 .2 .3 1"/><hfield name="h" file="gone.png" size="1 1 1 1"/></asset>
        <worldbody><geom type="hfield" hfield="h"/><body name="a"><geom type="mesh" mesh="m" material="skin"/>
          <body name="b" pos="0 0 1"><joint name="J"/><geom type="mesh" mesh="m"/></body></body></worldbody>""",
    )
    assert robot.joint_names == ("J",)
    assert robot.mass == 0.0
    assert robot.load_notes[:3] == (
        "height fields left out: 1",
        "1 of 1 mesh files are missing, first 'gone.stl'",
        "bodies whose masses depend on missing meshes are taken as massless",
    )
    assert robot.tree.visuals[0].rgba == pytest.approx((0.1, 0.2, 0.3, 1.0))
    assert np.allclose(robot.position(robot.neutral(), "b"), (0, 0, 1))


def test_missing_meshes_are_found_in_folders_given(tmp_path: Path) -> None:
    _bone(tmp_path / "elsewhere")
    text = """<asset><mesh name="m" file="bone.stl"/></asset>
      <worldbody><body name="a"><geom type="mesh" mesh="m"/></body></worldbody>"""
    path = write(tmp_path, text)
    found = nk.RobotModel.from_mjcf(path, package_dirs=[tmp_path / "elsewhere"])
    assert found.load_notes == ()
    assert found.mass > 1.0
    assert found.tree.packages.file(found.tree.visuals[0].geometry.filename) is not None
    assert nk.RobotModel.from_mjcf(path).mass == 0.0


def test_the_viewer_shows_a_robot_from_mjcf(tmp_path: Path) -> None:
    _bone(tmp_path / "meshes")
    robot = _load(
        tmp_path,
        f"""<compiler meshdir="meshes"/><asset><mesh name="m" file="bone.stl"/></asset><worldbody><body name="a">{BOX}
        <body name="b"><joint name="J"/><geom type="mesh" mesh="m"/></body></body></worldbody>""",
    )
    with nk.Viewer(robot) as viewer:
        assert viewer.notes == ()
        assert viewer.save_html(tmp_path / "page.html").stat().st_size > 100_000


def test_what_only_touches_or_is_only_touched_is_a_collision_shape_too(tmp_path: Path) -> None:
    geoms = '<geom type="sphere" size=".1" contype="0"/><geom type="sphere" size=".2" conaffinity="0"/>'
    robot = _load(tmp_path, f'<worldbody><body name="a">{geoms}</body></worldbody>')
    assert [collision.geometry for collision in robot.tree.collisions] == [Sphere(0.1), Sphere(0.2)]


def test_bodies_and_looks_that_the_compiler_may_drop_are_kept(tmp_path: Path) -> None:
    robot = _load(
        tmp_path,
        f"""<compiler fusestatic="true" discardvisual="true"/><worldbody><body name="a">{BOX}
          <body name="b">{BOX}<geom type="sphere" size=".1" contype="0" conaffinity="0" mass="0"/></body>
          <body name="c"><joint name="J"/>{BOX}</body></body></worldbody>""",
    )
    assert {*robot.link_names} == {"a", "b", "c"}
    assert Sphere(0.1) in [visual.geometry for visual in robot.tree.visuals]


def test_an_inertia_that_gives_way_to_the_geoms_comes_from_the_mesh(tmp_path: Path) -> None:
    _bone(tmp_path)
    robot = _load(
        tmp_path,
        """<compiler inertiafromgeom="true"/><asset><mesh name="m" file="bone.stl"/></asset><worldbody><body name="a">
          <inertial pos="0 0 0" mass="77" diaginertia="1 1 1"/><geom type="mesh" mesh="m"/></body></worldbody>""",
    )
    assert robot.mass == pytest.approx(Mujoco(tmp_path / "robot.xml").model.body_mass[1])
    assert 1.0 < robot.mass < 77.0


@pytest.mark.parametrize("weightless", ['mass="0"', 'density="0"'])
def test_a_mesh_without_weight_need_not_be_readable(tmp_path: Path, weightless: str) -> None:
    (tmp_path / "bad.stl").write_text("no mesh")
    robot = _load(
        tmp_path,
        f"""<asset><mesh name="m" file="bad.stl"/></asset>
        <worldbody><body name="a">{BOX}<geom type="mesh" mesh="m" {weightless}/></body></worldbody>""",
    )
    assert robot.mass == pytest.approx(0.4)
