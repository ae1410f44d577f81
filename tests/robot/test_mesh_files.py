"""Meshes as they are found: flat, damaged, in inches. What could end the interpreter runs in its own process."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument, BadInputFile, MissingShapeWarning
from nao_kin.robot import Obstacle
from nao_kin.robot.urdf import Box, MeshFile, Sphere
from nao_kin.viewer.meshes import load_meshes

INCH = 0.0254
# Three edges of 0.1, 0.2 and 0.3 m from one corner.
EDGES = np.diag([0.1, 0.2, 0.3])
TETRAHEDRON = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


def _robot(folder: Path, *shapes: str) -> Path:
    """A URDF of two turns: the shapes are collisions and visuals of the root, 0.9 m above it is a box of 0.2 m."""
    turns = "".join(
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 .5"/>'
        '<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        for name, parent, child in (("j", "a", "m"), ("k", "m", "b"))
    )
    parts = "".join(
        f"<{tag}><geometry>{shape}</geometry></{tag}>" for shape in shapes for tag in ("visual", "collision")
    )
    path = folder / "r.urdf"
    path.write_text(
        f'<robot name="r"><link name="a">{parts}</link><link name="m"/><link name="b"><collision><geometry>'
        f'<box size=".2 .2 .2"/></geometry></collision></link>{turns}</robot>'
    )
    return path


def _mesh(name: str, scale: str = "1 1 1") -> str:
    return f'<mesh filename="{name}" scale="{scale}"/>'


def _collada(unit: str, length: float = 1.0, material: str = "", node: str = "") -> str:
    """A COLLADA file of the tetrahedron, in units of a length [m]."""
    corners = " ".join(f"{float(value)!r}" for value in np.concatenate([np.zeros((1, 3)), EDGES]).ravel() / length)
    source = (
        f'<source id="p"><float_array id="a" count="12">{corners}</float_array><technique_common><accessor source="#a" '
        'count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/'
        "></accessor></technique_common></source>"
    )
    bound = (
        f'<bind_material><technique_common><instance_material symbol="{material}" target="#{material}"/>'
        "</technique_common></bind_material>"
        if material
        else ""
    )
    return (
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f"<asset>{unit}<up_axis>Z_UP</up_axis></asset>"
        f'<library_geometries><geometry id="g"><mesh>{source}<vertices id="v"><input semantic="POSITION" source="#p"/>'
        f'</vertices><triangles count="4" material="{material}"><input semantic="VERTEX" source="#v" offset="0"/>'
        "<p>0 2 1 0 1 3 1 2 3 0 3 2</p></triangles></mesh></geometry></library_geometries><library_visual_scenes>"
        f'<visual_scene id="s"><node id="n">{node}<instance_geometry url="#g">{bound}</instance_geometry></node>'
        '</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )


def _in_inches(folder: Path) -> nk.RobotModel:
    (folder / "hand.dae").write_text(_collada(f'<unit meter="{INCH}" name="inch"/>', INCH))
    return nk.RobotModel.from_file(_robot(folder, _mesh("hand.dae")))


def _run(code: str, *words: str) -> str:
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.returncode, done.stdout, done.stderr[-500:])
    return done.stdout


# --- hulls ----------------------------------------------------------------------------------------------------------

# Points of which coal's qhull makes no hull: it ends the process, or warns, which ends it, too.
FLAT = {
    "a point": "np.zeros((1, 3))",
    "many equal points": "np.full((20, 3), 0.3)",
    "two points": "np.array([[0, 0, 0], [1.0, 0, 0]])",
    "a line": "np.outer(np.arange(6.0), [1, 2, 3])",
    "a square": "np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1.0, 0]])",
    "a tilted plate": "np.array([[0, 0, 0], [0.1, 0, 0.03], [0.1, 0.1, 0.03], [0, 0.1, 0]])",
    "almost a plane": "np.array([[0, 0, 0], [1, 0, 1e-8], [1, 1, 0], [0, 1.0, 0]])",
    "a floor of 10 m": "grid * 10",
    "a floor of 100 km": "grid * 1e5",
    "a distant plate": "grid * 0.01 + [5e4, -3e5, 7.0]",
    "grains of one size": "np.eye(4, 3) * 1e-12",
}


def test_flat_points_give_a_thin_hull_at_their_place() -> None:
    code = """
import json, sys
import numpy as np
from nao_kin.robot.geometry import hull_shape
grid = np.array([[x, y, 0.3 * x - 0.2 * y] for x in np.linspace(0, 1, 11) for y in np.linspace(0, 1, 11)])
for name, text in json.loads(sys.argv[1]).items():
    print(name, end=" ", flush=True)
    points = eval(text)
    hull, thin = hull_shape("a", points).points, 4e-6 * max(1.0, np.ptp(points, axis=0).max())
    error = max(np.abs(end(hull, axis=0) - end(points, axis=0)).max() for end in (np.min, np.max))
    assert len(hull) >= 4 and error < thin, error
print("all")
"""
    assert _run(code, json.dumps(FLAT)).endswith("all\n")


@pytest.mark.full
def test_any_scale_of_a_flat_mesh_is_exported_or_refused(tmp_path: Path) -> None:
    vertices = "".join(f"v {x} {y} {0.3 * x}\n" for y in range(11) for x in range(11))
    faces = "".join(f"f {11 * y + x + 1} {11 * y + x + 2} {11 * y + x + 13}\n" for y in range(10) for x in range(10))
    (tmp_path / "plate.obj").write_text(vertices + faces)
    scales = [".1 .1 .1", "1 1 0", "0 0 0", "-1 1 1", "1e300 1 1"]
    paths = [
        _robot(tmp_path, _mesh("plate.obj", scale)).rename(tmp_path / f"{k}.urdf") for k, scale in enumerate(scales)
    ]
    code = """
import sys, nao_kin as nk
for path in sys.argv[1:]:
    print(path, flush=True)  # the last one, if the process ends
    nk.export.srdf(nk.RobotModel.from_file(path), f"{path}.srdf", samples=20)
"""
    assert _run(code, *map(str, paths)).split() == [*map(str, paths)]


# --- damaged files --------------------------------------------------------------------------------------------------

DAMAGED = {
    "nan.obj": f"v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan nan nan\n{TETRAHEDRON}",
    "inf.obj": f"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 inf\n{TETRAHEDRON}",
    "far.obj": f"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1e300\n{TETRAHEDRON}",
    "missing_corner.ply": "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n3 0 1 77\n",
    "inside_itself.dae": _collada("", node='<instance_node url="#n"/>'),
    "nan_node.dae": _collada("", node="<matrix>nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>"),
    "no_length.dae": _collada('<unit meter="abc"/>'),
    "negative.dae": _collada('<unit meter="-1"/>'),
}


@pytest.mark.full
def test_a_damaged_mesh_is_left_out_everywhere(tmp_path: Path) -> None:
    code = """
import pathlib, sys, warnings
import nao_kin as nk
warnings.simplefilter("ignore")
for folder in sorted(pathlib.Path(sys.argv[1]).iterdir()):
    print(folder.name, flush=True)  # the last one, if the process ends
    robot = nk.RobotModel.from_file(folder / "r.urdf")
    assert len(robot.geometry("collision").geometryObjects) == 1
    assert robot.link_shapes.links == ("b",), robot.link_shapes.links
    robot.clearance(robot.random(0, 5), exact=True)
    nk.export.srdf(robot, folder / "r.srdf", samples=20)
    try:
        nk.robot.Obstacle.mesh("it", folder / folder.name, [0, 0, 0])
    except nk.errors.BadInputFile:
        print("refused")
"""
    for name, text in DAMAGED.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / name).write_text(text)
        assert _robot(tmp_path / name, _mesh(name)).name == "r.urdf"
    assert _run(code, str(tmp_path)).split() == [word for name in sorted(DAMAGED) for word in (name, "refused")]


@pytest.mark.parametrize("size", ["-1 1 1", "1e300 1 1"])
def test_a_box_without_a_size_is_left_out(tmp_path: Path, size: str) -> None:
    robot = nk.RobotModel.from_file(_robot(tmp_path, f'<box size="{size}"/>'))
    with pytest.warns(MissingShapeWarning, match="box of"):
        assert robot.link_shapes.links == ("b",)


@pytest.mark.parametrize("geometry", [Box((np.nan, 1, 1)), Box((1e300, 1, 1)), Sphere(-1.0), Sphere(np.inf)])
def test_an_obstacle_without_a_size_is_refused(geometry: Box | Sphere) -> None:
    with pytest.raises(BadArgument, match="'it'"):
        Obstacle("it", geometry, np.zeros(3))


def test_a_distant_obstacle_and_one_without_a_file_are_refused() -> None:
    with pytest.raises(BadArgument, match="'it'"):
        Obstacle.ball("it", 0.1, [0.0, 0.0, 1e9])
    with pytest.raises(BadInputFile):
        Obstacle("it", MeshFile("nowhere.stl"), np.zeros(3))


def test_a_mesh_whose_materials_are_missing_keeps_its_triangles(tmp_path: Path) -> None:
    (tmp_path / "foot.dae").write_text(_collada("", material="carbon"))
    (mesh,) = load_meshes(tmp_path / "foot.dae", np.ones(3))
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), EDGES.sum(axis=0))
    robot = nk.RobotModel.from_file(_robot(tmp_path, _mesh("foot.dae")))
    assert len(robot.geometry("collision").geometryObjects) == 2


# --- units ----------------------------------------------------------------------------------------------------------


def test_all_rooms_scale_a_mesh_by_the_unit_in_its_file(tmp_path: Path) -> None:
    robot, size = _in_inches(tmp_path), EDGES.sum(axis=0)
    assert any("hand.dae" in note and str(INCH) in note for note in robot.load_notes)
    assert robot.clearance([0.0, 0.0]).distance == pytest.approx(0.6, abs=1e-6)
    (hull,) = (shape for shape in robot.link_shapes.shapes if shape.link == "a")
    (mesh,) = load_meshes(tmp_path / "hand.dae", np.ones(3))
    triangles = robot.geometry("collision").geometryObjects[0]
    assert triangles.meshPath == ""  # Pinocchio's visualizers draw the triangles, and do not read the file again
    for points in (hull.points, mesh.vertices, np.array(triangles.geometry.vertices())):
        np.testing.assert_allclose(np.ptp(points, axis=0), size, atol=1e-6)
    # On the floor it rests on the largest face; the head of the robot is less than a metre and a half above it.
    assert 0.0 <= robot.set_down([0.0, 0.0]).T_world_base[2, 3] < 1.5


def test_exports_scale_a_mesh_by_the_unit_in_its_file_or_keep_both(tmp_path: Path) -> None:
    import trimesh

    mujoco = pytest.importorskip("mujoco")
    robot, size = _in_inches(tmp_path), EDGES.sum(axis=0)
    done = nk.export.gltf(robot, tmp_path / "r.glb")
    scene = trimesh.load_scene(done.path)
    np.testing.assert_allclose(np.sort(scene.extents), size, atol=1e-6)
    done = nk.export.mjcf(robot, tmp_path / "mujoco")
    model = mujoco.MjModel.from_xml_path(str(done.path))
    between = np.linalg.norm(model.mesh_vert[:, None] - model.mesh_vert, axis=-1)
    assert between.max() == pytest.approx(np.hypot(0.2, 0.3), abs=1e-5)
    done = nk.export.urdf(robot, tmp_path / "copy.urdf")
    assert any("hand.dae" in note and str(INCH) in note for note in done.changes)
    again = nk.RobotModel.from_file(done.path)
    assert again.clearance([0.0, 0.0]).distance == pytest.approx(0.6, abs=1e-6)


def test_the_scale_of_the_urdf_applies_on_top_of_the_unit(tmp_path: Path) -> None:
    (tmp_path / "cm.dae").write_text(_collada('<unit name="centimeter" meter="0.01"/>', 0.01))
    robot = nk.RobotModel.from_file(_robot(tmp_path, _mesh("cm.dae", "1 1 2")))
    assert robot.clearance([0.0, 0.0]).distance == pytest.approx(0.3, abs=1e-6)


@pytest.mark.parametrize("unit", ["", '<unit name="meter" meter="1"/>', '<unit name="m"/>'])
def test_a_mesh_in_metres_or_without_a_unit_is_not_scaled(tmp_path: Path, unit: str) -> None:
    (tmp_path / "m.dae").write_text(_collada(unit))
    robot = nk.RobotModel.from_file(_robot(tmp_path, _mesh("m.dae")))
    assert robot.load_notes == ()
    assert robot.clearance([0.0, 0.0]).distance == pytest.approx(0.6, abs=1e-6)
    assert robot.geometry("visual").geometryObjects[0].meshPath.endswith("m.dae")


@pytest.mark.parametrize(("word", "unit"), [("", 1e-3), (' unit="inch"', INCH)])
def test_a_3mf_is_in_millimetres_unless_it_says_otherwise(tmp_path: Path, word: str, unit: float) -> None:
    corners = np.concatenate([np.zeros((1, 3)), EDGES]) / unit
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in corners)
    triangles = "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
    )
    with zipfile.ZipFile(tmp_path / "part.3mf", "w") as archive:
        archive.writestr(
            "3D/3dmodel.model",
            f'<model{word} xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" '
            f'type="model"><mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object>'
            '</resources><build><item objectid="1"/></build></model>',
        )
    robot = nk.RobotModel.from_file(_robot(tmp_path, _mesh("part.3mf")))
    assert any("part.3mf" in note for note in robot.load_notes)
    assert robot.clearance([0.0, 0.0]).distance == pytest.approx(0.6, abs=1e-6)


# --- pairs that are not checked -------------------------------------------------------------------------------------


def test_pairs_that_touch_at_the_start_are_named(tmp_path: Path) -> None:
    robot = nk.RobotModel.from_file(_robot(tmp_path, '<box size="2 2 2"/>'))
    found = robot.clearance([0.0, 0.0])
    assert found.distance == np.inf
    (note,) = found.notes
    assert "a and b" in note
    ball = Obstacle.ball("ball", 0.1, [0.0, 0.0, 3.0])
    assert robot.clearance([0.0, 0.0], obstacles=[ball]).notes == found.notes
    assert nk.load_nao().clearance(nk.load_nao().posture("Sit")).notes == ()
