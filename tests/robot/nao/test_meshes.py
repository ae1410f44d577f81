from __future__ import annotations

import functools
import importlib
import math
import re
import shutil
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
import trimesh
import yourdfpy
from loops import EACH_VERSION, for_all, full
from manifold3d import Manifold, Mesh
from scipy.spatial import ConvexHull

import nao_kin as nk
from nao_kin.robot.nao import VERSIONS, nao_parameters
from nao_kin.robot.nao.model import nao_urdf_path
from nao_kin.robot.nao.parameters import VISUALS
from nao_kin.robot.nao.rows import ShapeRow
from nao_kin.robot.nao.tables import NAOQI_SHAPES

ROOT = Path(__file__).resolve().parents[3]
SCRIPT = ROOT / "scripts" / "generate_meshes.py"
MESHES = nao_urdf_path("v6").parent / "meshes"
FILES = sorted(MESHES.glob("*.obj"))
# V3.2 has shorter arms; V3.3 to V6 are alike.
SHAPES = ("v3.2", "v6")


@functools.cache
def mesh(name: str) -> trimesh.Trimesh:
    loaded = trimesh.load_mesh(MESHES / f"{name}.obj")
    loaded.merge_vertices(merge_norm=True, merge_tex=True)
    return loaded


@functools.cache
def visuals(version: str) -> dict[str, list[str]]:
    """Link → names of its meshes, as the URDF has them."""
    links = ET.parse(nao_urdf_path(version)).getroot().findall("link")
    named = {link.get("name"): [Path(m.get("filename")).stem for m in link.findall("visual//mesh")] for link in links}
    return {link: meshes for link, meshes in named.items() if meshes}


@functools.cache
def solid(version: str, link: str) -> Manifold:
    """All meshes of a link as one solid, in the link's frame [mm]."""
    parts = [mesh(name) for name in visuals(version)[link]]
    return sum(
        (Manifold(Mesh(np.float32(1000 * m.vertices), m.faces.astype(np.uint32))) for m in parts), start=Manifold()
    )


@functools.cache
def robot(version: str) -> nk.NaoModel:
    return nk.load_nao(version)


def placed(version: str, link: str, pose: np.ndarray) -> Manifold:
    return solid(version, link).transform(np.column_stack([pose[:3, :3], 1000 * pose[:3, 3]]))


def vertices(version: str, q: np.ndarray, reference: str, links: list[str] | None = None) -> np.ndarray:
    """All vertices of some links in the frame `reference` [m]."""
    links = links or list(visuals(version))
    poses = robot(version).fk(q, links, reference=reference)
    return np.concatenate(
        [
            mesh(name).vertices @ pose[:3, :3].T + pose[:3, 3]
            for link, pose in zip(links, poses, strict=True)
            for name in visuals(version)[link]
        ]
    )


# --- the files ----------------------------------------------------------------------------------------------------


@pytest.mark.full
def test_the_check_names_files_that_are_changed_missing_or_left_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(SCRIPT.parent)
    generate_meshes = importlib.import_module("generate_meshes")
    # Drawing them takes seconds, and `make check-drawn` compares these files with what is drawn.
    monkeypatch.setattr(generate_meshes, "mesh_texts", lambda: [(path.stem, path.read_text()) for path in FILES])
    folder = tmp_path / "meshes"
    shutil.copytree(MESHES, folder)
    changed = folder / "head_white.obj"
    changed.write_text(changed.read_text().replace("v 0", "v 1", 1))
    (folder / "l_thigh_grey.obj").unlink()
    (folder / "tail_white.obj").write_text("o tail\n")
    assert generate_meshes.main(["--check", "--output", str(folder)]) == 1
    assert re.findall(r"(\w+)\.obj", capsys.readouterr().err) == ["head_white", "l_thigh_grey", "tail_white"]


def test_all_meshes_together_take_at_most_two_and_a_quarter_megabytes() -> None:
    assert 0 < sum(path.stat().st_size for path in FILES) <= 2_250_000


def test_every_mesh_is_in_use_and_every_mesh_in_use_exists() -> None:
    used = {name for version in VERSIONS for names in visuals(version).values() for name in names}
    assert used == {path.stem for path in FILES} == {name for row in VISUALS for name in row.meshes}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_faces_of_a_mesh_use_all_its_points_and_normals(path: Path) -> None:
    lines = path.read_text().splitlines()
    corners = [c.split("//") for line in lines if line.startswith("f ") for c in line.split()[1:]]
    for key, used in zip(("v ", "vn "), zip(*corners, strict=True), strict=True):
        count = sum(line.startswith(key) for line in lines)
        assert set(map(int, used)) == set(range(1, count + 1)), key


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_mesh_is_closed_and_its_faces_and_normals_point_outwards(path: Path) -> None:
    body = mesh(path.stem)
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.volume > 0
    lines = path.read_text().splitlines()
    points, normals = (
        np.array([line.split()[1:] for line in lines if line.startswith(key)], dtype=float) for key in ("v ", "vn ")
    )
    assert np.abs(np.linalg.norm(normals, axis=1) - 1).max() < 0.01
    faces = [[tuple(map(int, c.split("//"))) for c in line.split()[1:]] for line in lines if line.startswith("f ")]
    v = np.array([[face[k][0] - 1 for k in (0, 1, 2, -1)] for face in faces])
    areas = np.cross(points[v[:, 2]] - points[v[:, 0]], points[v[:, 3]] - points[v[:, 1]])
    owner, n = np.array([(k, corner - 1) for k, face in enumerate(faces) for _, corner in face]).T
    inwards = (normals[n] * areas[owner]).sum(axis=1) <= 0
    assert not (inwards & (np.linalg.norm(areas, axis=1)[owner] > 1e-7)).any()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_mesh_has_no_cracks_no_slivers_and_no_folds(path: Path) -> None:
    """No mesh has dark specks, which come from open edges, triangles thinner than 0.05 mm, and folds."""
    body = mesh(path.stem)
    corners = body.vertices[body.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    assert (2 * body.area_faces / longest).min() > 5e-5
    assert body.face_adjacency_angles.max() < math.radians(165.0)


@for_all("version", VERSIONS)
def test_the_page_of_a_version_stays_within_one_point_two_megabytes(version: str) -> None:
    assert len(nk.Viewer(robot(version)).static_html()) < 1_200_000


# --- left and right -----------------------------------------------------------------------------------------------


@for_all("left", [path.stem for path in FILES if path.stem.startswith("l_")])
def test_left_and_right_are_exact_mirror_images(left: str) -> None:
    ours, theirs = ((MESHES / f"{name}.obj").read_text().splitlines() for name in (left, f"r_{left[2:]}"))
    assert len(ours) == len(theirs)
    for a, b in zip(ours[2:], theirs[2:], strict=True):
        kind, *one = a.split()
        _, *other = b.split()
        if kind == "f":
            assert one == other[::-1]
        else:
            assert [float(x) for x in one] == [float(x) * s for x, s in zip(other, (1, -1, 1), strict=True)]


@for_all("name", [path.stem for path in FILES if path.stem.startswith(("torso", "head", "neck", "ears", "sensors"))])
def test_what_sits_in_the_middle_is_its_own_mirror_image(name: str) -> None:
    points = {tuple(point) for point in mesh(name).vertices.round(5).tolist()}
    assert points == {(x, 0.0 - y, z) for x, y, z in points}


def test_a_phalanx_fits_the_fingers_of_both_hands() -> None:
    for name in ("phalanx_dark", "fingertip_dark"):
        points = {tuple(point) for point in mesh(name).vertices.round(5).tolist()}
        assert points == {(x, y, 0.0 - z) for x, y, z in points}


# --- the shape of the robot ---------------------------------------------------------------------------------------


@pytest.mark.full
@for_all("version", SHAPES)
def test_neighbouring_links_overlap_over_the_whole_range_of_their_joint(version: str) -> None:
    """One joint alone moves a link against its neighbour: this covers every posture."""
    nao, tree = robot(version), ET.parse(nao_urdf_path(version)).getroot()
    postures = np.array([nao.posture(name) for name in nao.posture_names])
    seen = 0
    for joint in tree.findall("joint"):
        parent, child = joint.find("parent").get("link"), joint.find("child").get("link")
        if joint.get("type") != "revolute" or child not in visuals(version):
            continue
        name = joint.find("mimic").get("joint") if joint.find("mimic") is not None else joint.get("name")
        index = nao.joint_names.index(name)
        values = np.concatenate([np.linspace(nao.lower[index], nao.upper[index], 5), postures[:, index]])
        q = np.repeat(nao.neutral()[None], len(values), axis=0)
        q[:, index] = values
        smallest = 0.15 * min(solid(version, parent).volume(), solid(version, child).volume(), 4000.0)
        for pose in np.unique(nao.fk(q, child, reference=parent).round(9), axis=0):
            overlap = (solid(version, parent) ^ placed(version, child, pose)).volume()
            assert overlap > smallest, f"{joint.get('name')}: {overlap:.0f} mm³ at {pose.round(3)}"
        seen += 1
    assert seen == 24 + 16


@for_all("side", ["l", "r"])
@for_all("posture", ["Stand", "StandInit", "StandZero"])
def test_nothing_sinks_into_the_floor(posture: str, side: str) -> None:
    nao = robot("v6")
    assert vertices("v6", nao.posture(posture), f"{side}_sole")[:, 2].min() > -1e-3


# Not Crouch: there the ankles are 75 mm apart, less than twice the 38.8 mm that a foot reaches inwards.
@for_all("posture", ["Stand", "StandInit", "StandZero", "Sit", "SitRelax", "LyingBelly", "LyingBack"])
def test_the_feet_and_shins_keep_apart(posture: str) -> None:
    nao = robot("v6")
    left, right = ["LTibia", "LAnklePitch_link", "l_ankle"], ["RTibia", "RAnklePitch_link", "r_ankle"]
    poses = dict(zip(left + right, nao.fk(nao.posture(posture), left + right), strict=True))
    for one in left:
        for other in right:
            assert (placed("v6", one, poses[one]) ^ placed("v6", other, poses[other])).is_empty(), (one, other)


def test_a_foot_stays_within_the_outline_of_the_real_one() -> None:
    points = np.concatenate([mesh(name).vertices for name in visuals("v6")["l_ankle"]])
    low, high = points.min(axis=0), points.max(axis=0)
    assert 0.100 < high[0] < 0.104
    assert -0.054 - 1e-5 < low[0] < -0.050
    assert -0.0388 - 1e-5 < low[1] < -0.037
    assert 0.048 < high[1] < 0.050 + 1e-5


@pytest.mark.parametrize("side", ["L", *full("R")])
def test_no_bend_of_the_knee_bares_what_is_inside(side: str) -> None:
    """From all directions, the first visible surface of the knee is a shell."""
    nao = robot("v6")
    links = [f"{side}Thigh", f"{side}Tibia"]
    shells = [(link, name) for link in links for name in visuals("v6")[link]]
    angle, across = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 2 * np.pi, 30), np.linspace(-0.028, 0.028, 4)))
    outwards = np.column_stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)])
    starts = 0.2 * outwards + across[:, None] * (0.0, 1.0, 0.0)
    index = nao.joint_names.index(f"{side}KneePitch")
    for value in (*np.linspace(nao.lower[index], nao.upper[index], 5), nao.posture("Crouch")[index]):
        q = nao.neutral()
        q[index] = value
        poses = dict(zip(links, nao.fk(q, links, reference=links[1]), strict=True))
        first, nearest = np.full(len(starts), "nothing", dtype=object), np.full(len(starts), np.inf)
        for link, name in shells:
            body = mesh(name).copy().apply_transform(poses[link])
            distance = distances(starts, -outwards, body)
            first[distance < nearest] = name.rpartition("_")[2]
            nearest = np.minimum(nearest, distance)
        assert set(first) <= {"white", "accent"}, f"{value:.2f} rad"


@for_all("posture", ["Sit", "SitRelax"])
def test_who_sits_sits_on_the_covers_of_the_hips(posture: str) -> None:
    """The face of the convex hull that carries the centre of mass of an upright trunk."""
    nao = robot("v6")
    q = nao.posture(posture)
    links = list(visuals("v6"))
    points = [vertices("v6", q, "torso", [link]) for link in links]
    owners = np.repeat(links, [len(part) for part in points])
    hull = ConvexHull(np.concatenate(points))
    com = np.linalg.solve(nao.fk(q, "torso", reference=nao.link_names[0]), np.append(nao.com(q), 1.0))[:3]
    carriers = []
    for simplex, (*down, offset) in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = hull.points[simplex]
        foot = com - np.array(down) * (com @ down + offset)
        share = np.linalg.solve(np.column_stack([a, b, c]), foot)
        if down[2] < -0.8 and (share > 0).all():
            carriers.append(set(owners[simplex]))
    assert len(carriers) == 1
    assert {"LHip", "RHip"} < carriers[0] <= {"LHip", "RHip", "l_ankle", "r_ankle"}


@for_all("version", VERSIONS)
def test_the_cameras_look_out_of_their_lenses(version: str) -> None:
    nao = robot(version)
    (lenses,) = (mesh(name) for name in visuals(version)["Head"] if re.fullmatch(r"sensors.*_black", name))
    for camera in ("CameraTop", "CameraBottom"):
        pose = nao.fk(nao.neutral(), camera, reference="Head")
        behind = pose[:3, 3] - 0.01 * pose[:3, 0]
        assert distances(behind[None], pose[None, :3, 0], lenses)[0] < 0.022, camera


def test_versions_are_told_apart_by_their_looks() -> None:
    accents = {
        version: {n for names in visuals(version).values() for n in names if "accent" in n} for version in VERSIONS
    }
    assert nao_parameters("v6").colours["accent"] != nao_parameters("v5").colours["accent"]
    assert accents["v4"] == accents["v5"] == accents["v6"]
    assert accents["v6"] - accents["v3.3"] == {"ears_accent", "l_forearm_accent", "r_forearm_accent"}
    # The microphones moved with V6, the cameras with V4.
    heads = [frozenset(n for n in visuals(version)["Head"] if n.startswith("sensors")) for version in VERSIONS]
    assert len(set(heads)) == 3


def test_the_shells_lie_close_to_the_collision_primitives() -> None:
    links = {"torso": "torso"} | {joint.name: joint.link for joint in nao_parameters("v6").joints}
    for parent in {shape.parent for shape in NAOQI_SHAPES}:
        points = np.concatenate([mesh(name).vertices for name in visuals("v6")[links[parent]]])
        outside = np.min([distance_to(shape, points) for shape in NAOQI_SHAPES if shape.parent == parent], axis=0)
        # The axles of shoulders and hips, which no primitive covers, reach 35 mm out of the trunk.
        assert outside.max() < (0.036 if parent == "torso" else 0.017), parent


def test_forearm_and_hand_fill_the_capsule_of_the_forearm() -> None:
    (capsule,) = (shape for shape in NAOQI_SHAPES if shape.name == "LElbowRollBothCollision")
    q = robot("v6").configuration({"LHand": 0.0, "LElbowRoll": -0.04})
    points = vertices("v6", q, "LForeArm", ["LForeArm", "l_wrist", "LFinger13_link", "LFinger23_link"])
    assert distance_to(capsule, points).max() < 0.010


def distances(starts: np.ndarray, directions: np.ndarray, body: trimesh.Trimesh) -> np.ndarray:
    """Return the distance along each ray to a mesh, else infinity: start + t d = a + u (b − a) + v (c − a)."""
    a, b, c = np.moveaxis(body.vertices[body.faces], 1, 0)
    sides = np.stack([b - a, c - a], axis=-1)[None].repeat(len(starts), axis=0)
    columns = np.concatenate([-directions[:, None, :, None].repeat(len(a), axis=1), sides], axis=-1)
    flat = np.abs(np.linalg.det(columns)) < 1e-12
    columns[flat] = np.eye(3)
    t, u, v = np.moveaxis(np.linalg.solve(columns, (starts[:, None] - a)[..., None])[..., 0], -1, 0)
    met = ~flat & (t > 0) & (u >= 0) & (v >= 0) & (u + v <= 1)
    return np.where(met, t, np.inf).min(axis=1)


def distance_to(shape: ShapeRow, points: np.ndarray) -> np.ndarray:
    """Return the distances of points from a primitive; NAOqi's cylinders are capsules of the printed total length."""
    local = points - shape.center_m
    if shape.kind == "box":
        return np.linalg.norm(np.maximum(np.abs(local) - np.array(shape.size_m) / 2, 0), axis=1)
    if shape.kind == "cylinder":
        axis = np.array(shape.axis) / math.hypot(*shape.axis)
        along = local @ axis
        local = local - np.clip(along, -shape.size_m[1] / 2, shape.size_m[1] / 2)[:, None] * axis
    return np.maximum(np.linalg.norm(local, axis=1) - shape.size_m[0], 0)


# --- in the hands of URDF readers ---------------------------------------------------------------------------------


@pytest.mark.parametrize("version", EACH_VERSION)
def test_pinocchio_loads_every_mesh_in_its_colour(
    version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    path = nao_urdf_path(version)
    model = pin.buildModelFromUrdf(str(path), mimic=True)
    shown = pin.buildGeomFromUrdf(model, str(path), pin.GeometryType.VISUAL, package_dirs=[str(path.parent)])
    loaded = [Path(shape.meshPath).stem for shape in shown.geometryObjects]
    assert sorted(loaded) == sorted(name for names in visuals(version).values() for name in names)
    for shape, name in zip(shown.geometryObjects, loaded, strict=True):
        assert shape.meshColor == pytest.approx(nao_parameters(version).colours[name.rpartition("_")[2]], abs=1e-6)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("version", SHAPES)
def test_yourdfpy_loads_every_mesh(version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scene = yourdfpy.URDF.load(str(nao_urdf_path(version))).scene
    assert len(scene.geometry) == sum(map(len, visuals(version).values()))
    assert 0.57 < np.ptp(scene.bounds[:, 2]) < 0.58
