"""An export copies the files that belong to the robot and no other file of the user, whatever paths its files name."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from loops import every_value

import nao_kin as nk
from nao_kin.errors import BadArgument
from nao_kin.export import Exported

SECRET = b"SECRET-of-the-reader"
SOLID = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
ROBOT = '<robot name="r"><link name="a"><visual><geometry><mesh filename="{}"/></geometry></visual></link></robot>'
EXPORTS: dict[str, Callable[[nk.RobotModel, Path], Exported]] = {
    "urdf": lambda robot, out: nk.export.urdf(robot, out / "r.urdf"),
    "ros2": lambda robot, out: nk.export.ros2(robot, out / "r_description", samples=10),
    "sdf": lambda robot, out: nk.export.sdf(robot, out / "r", inertia="published"),
    "mjcf": lambda robot, out: nk.export.mjcf(robot, out / "r"),
    "gltf": lambda robot, out: nk.export.gltf(robot, out / "r.glb"),
}


@pytest.fixture
def given(tmp_path: Path) -> Path:
    """A folder with a robot's files, beside files of the reader."""
    (tmp_path / "given" / "meshes").mkdir(parents=True)
    (tmp_path / "secret").write_bytes(SECRET)
    (tmp_path / "secret.png").write_bytes(SECRET)
    (tmp_path / "out").mkdir()
    (tmp_path / "given" / "link.png").symlink_to(tmp_path / "secret")
    return tmp_path / "given"


def _exported(given: Path, mesh: str, format: str) -> Exported:
    if format == "mjcf":
        pytest.importorskip("mujoco")
    (given / "r.urdf").write_text(ROBOT.format(mesh).replace("<visual>", BALL + "<visual>"))
    return EXPORTS[format](nk.RobotModel.from_urdf(given / "r.urdf"), given.parent / "out")


BALL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
OUTSIDE = ["../../secret.png", "../../secret", "{}/secret.png", "../link.png", "../../given/../secret.png"]


@pytest.mark.parametrize(("format", "name"), every_value(["urdf", "ros2", "sdf", "gltf"], OUTSIDE))
def test_what_a_material_names_outside_of_the_package_is_left_out_and_named(
    given: Path, format: str, name: str
) -> None:
    name = name.format(given.parent)
    (given / "meshes" / "a.mtl").write_text(f"newmtl x\nKd 1 0 0\nmap_Kd {name}\n")
    (given / "meshes" / "a.obj").write_text(f"mtllib a.mtl\nusemtl x\nvt 0 0\n{SOLID}f 1/1 2/1 3/1\n")
    done = _exported(given, "meshes/a.obj", format)
    assert not any(SECRET in file.read_bytes() for file in done.files)
    (note,) = [change for change in done.changes if name in change]
    assert note.startswith(f"a.obj names '{name}': left out")


@pytest.mark.parametrize(("format", "name"), every_value(["urdf", "ros2", "sdf"], OUTSIDE))
def test_what_a_collada_names_outside_of_the_package_is_left_out_and_named(given: Path, format: str, name: str) -> None:
    name = name.format(given.parent)
    (given / "meshes" / "a.dae").write_text(f"<COLLADA><image><init_from>file://{name}</init_from></image></COLLADA>")
    done = _exported(given, "meshes/a.dae", format)
    assert not any(SECRET in file.read_bytes() for file in done.files)
    assert any(change.startswith(f"a.dae names '{name}': left out") for change in done.changes)


def test_materials_that_lie_outside_are_left_out_with_what_they_name(given: Path) -> None:
    (given.parent / "a.mtl").write_text("newmtl x\nmap_Kd secret\n")
    (given / "meshes" / "a.obj").write_text(f"mtllib ../../a.mtl\n{SOLID}")
    done = _exported(given, "meshes/a.obj", "urdf")
    assert {file.name for file in done.files} == {"r.urdf", "a.obj"}
    assert done.changes[-1].startswith("a.obj names '../../a.mtl': left out")


@pytest.mark.parametrize(
    ("format", "mesh"),
    every_value(EXPORTS, ["../secret", "{}/secret", "file://{}/secret", "../secret.png", "link.png", "a.stl"]),
)
def test_a_file_that_is_no_mesh_is_not_taken_for_one(given: Path, format: str, mesh: str) -> None:
    (given / "a.stl").symlink_to(given.parent / "secret")
    mesh = mesh.format(given.parent)
    if format == "gltf":  # which shows what it can
        assert _exported(given, mesh, format).changes[0].startswith("a visual shape of a is left out: its mesh")
    else:
        with pytest.raises(BadArgument, match="cannot read the mesh .*/secret"):
            _exported(given, mesh, format)
    assert not any(SECRET in file.read_bytes() for file in (given.parent / "out").rglob("*") if file.is_file())


@pytest.mark.parametrize(
    ("format", "mesh"),
    every_value(EXPORTS, ["{}/a.obj", "../a.obj", "file://{}/a.obj", "package://given/../a.obj", "link.obj"]),
)
def test_a_mesh_from_outside_of_the_package_is_named(given: Path, format: str, mesh: str) -> None:
    (given.parent / "a.obj").write_text(SOLID)
    (given / "link.obj").symlink_to(given.parent / "a.obj")
    (given / "own.obj").write_text(SOLID)
    two = f'{mesh.format(given.parent)}"/></geometry></visual><visual><geometry><mesh filename="own.obj'
    done = _exported(given, two, format)
    notes = [change for change in done.changes if "outside the robot's package" in change]
    assert notes == [f"a.obj is from outside the robot's package: {given.parent / 'a.obj'}"]


@pytest.mark.parametrize("format", EXPORTS)
def test_meshes_of_another_package_are_taken_and_so_are_those_behind_links(given: Path, format: str) -> None:
    (given.parent / "other").mkdir()
    (given.parent / "other" / "a.obj").write_text(SOLID)
    (given / "meshes" / "a.obj").symlink_to(given.parent / "other" / "a.obj")
    for mesh in ("../other/a.obj", "package://other/a.obj", "meshes/a.obj"):
        assert not any("left out" in change for change in _exported(given, mesh, format).changes)
        shutil.rmtree(given.parent / "out")
        (given.parent / "out").mkdir()


def test_textures_elsewhere_in_the_robots_package_are_taken(given: Path) -> None:
    (given / "package.xml").write_text("<package><name>given</name></package>")
    (given / "textures").mkdir()
    (given / "textures" / "x.png").write_bytes(b"png")
    (given / "urdf").mkdir()
    (given / "meshes" / "a.mtl").write_text("newmtl x\nmap_Kd ../textures/x.png\n")
    (given / "meshes" / "a.obj").write_text(f"mtllib a.mtl\n{SOLID}")
    (given / "urdf" / "r.urdf").write_text(ROBOT.format("package://given/meshes/a.obj"))
    done = nk.export.urdf(nk.RobotModel.from_urdf(given / "urdf" / "r.urdf"), given.parent / "out" / "r.urdf")
    assert {file.name for file in done.files} == {"r.urdf", "a.obj", "a.mtl", "x.png"}
    assert done.changes == ()


def test_no_buffer_of_a_gltf_is_read_from_outside_of_the_package(given: Path) -> None:
    (given.parent / "secret.bin").write_bytes(np.zeros((3, 3), "<f4").tobytes())
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "../../secret.bin", "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 4}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    (given / "meshes" / "a.gltf").write_text(json.dumps(tree))
    assert "cannot be read: ../../secret.bin" in _exported(given, "meshes/a.gltf", "gltf").changes[0]
    pytest.importorskip("mujoco")
    with pytest.raises(BadArgument, match="cannot read the mesh"):
        _exported(given, "meshes/a.gltf", "mjcf")


@pytest.mark.parametrize("unit", [1.0, 0.0254])
def test_a_mesh_in_another_unit_than_the_metre_is_named(given: Path, unit: float) -> None:
    (given / "meshes" / "a.dae").write_text(f'<COLLADA><asset><unit meter="{unit}"/></asset></COLLADA>')
    notes = _exported(given, "meshes/a.dae", "urdf").changes
    assert [note.split(":")[0] for note in notes] == ([] if unit == 1.0 else ["a.dae is in units of 0.0254 m"])
