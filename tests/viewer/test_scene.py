"""The messages of the viewer to the page, without a browser: the tree of transforms, the shapes, the document."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import trimesh
from made_up_robots import J, made_up
from viewer_pages import made_of, messages_of, unpacked

import nao_kin as nk
from nao_kin.errors import BadArgument, NaoKinWarning
from nao_kin.motion import mirror
from nao_kin.naoqi import joint_names as naoqi_names
from nao_kin.robot.semantics import CoupledLimit, Semantics
from nao_kin.robot.urdf import Box, Cylinder, MeshFile, Origin, Packages, Sphere
from nao_kin.rotations import exp, matrix_from_rpy
from nao_kin.viewer import OutsideLimitsWarning, Viewer
from nao_kin.viewer.description import SceneRobot, robot_drawables
from nao_kin.viewer.meshes import load_meshes


@pytest.fixture(scope="module")
def viewer(nao: nk.NaoModel) -> Viewer:
    return Viewer(nao)


class Tree:
    """The nodes of a page, composed as a browser composes them."""

    def __init__(self, viewer: Viewer) -> None:
        messages = messages_of(viewer.static_html())
        self.about = next(message["about"] for message in messages if message.get("kind") == "model")
        self.placed = {"/".join(place["path"]): np.reshape(place["matrix"], (4, 4)).T for place in self.about["places"]}

    def poses(self, q: np.ndarray) -> dict[str, np.ndarray]:
        moved = {}
        for joint in self.about["joints"]:
            value = joint["multiplier"] * q[joint["column"]] + joint["offset"]
            T = np.eye(4)
            if joint["slides"]:
                T[:3, 3] = value * np.array(joint["axis"])
            else:
                T[:3, :3] = exp(value * np.array(joint["axis"]))
            moved["/".join(self.about["links"][joint["link"]]["path"])] = T
        poses = {}
        for link in self.about["links"]:
            T, path = np.eye(4), ""
            for step in link["path"]:
                path = f"{path}/{step}".lstrip("/")
                T = T @ self.placed.get(path, np.eye(4)) @ moved.get(path, np.eye(4))
            poses[link["name"]] = T
        return poses


def _compare(viewer: Viewer, qs: list[np.ndarray], tolerance: float) -> None:
    tree, robot = Tree(viewer), viewer.robot
    for q in qs:
        poses = tree.poses(q)
        stacked = np.array([poses[name] for name in robot.link_names])
        assert np.abs(stacked - robot.fk(q)).max() < tolerance


def test_the_nested_nodes_compose_to_forward_kinematics(viewer: Viewer, nao: nk.NaoModel) -> None:
    _compare(viewer, made_of(nao), 1e-13)


def test_every_version_composes(each_nao: nk.NaoModel) -> None:
    _compare(Viewer(each_nao), [each_nao.posture("Crouch"), each_nao.random(3)], 1e-13)


def test_a_calibrated_model_is_shown_as_calibrated() -> None:
    nao = nk.load_nao()
    placement = nao.model.jointPlacements[5]
    placement.translation = placement.translation + np.array([0.01, -0.02, 0.03])
    nao.model.jointPlacements[5] = placement
    _compare(Viewer(nao), [nao.random(4)], 1e-13)


def test_sliding_following_and_limitless_joints_compose(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("turn", axis=(1.0, 2.0, -1.0), rpy=(0.1, 0.2, 0.3), kind="continuous"),
        J("slide", axis=(0.0, 1.0, 1.0), xyz=(0.1, 0.0, 0.2), kind="prismatic", limits=(-0.2, 0.3)),
        J("follow", axis=(0.0, 0.0, -1.0), rpy=(-0.4, 0.0, 1.0), follows=("turn", -0.5, 0.3)),
        J("follow/slide", axis=(1.0, 0.0, 0.0), kind="prismatic", follows=("slide", 2.0, -0.1)),
    )
    _compare(Viewer(robot), [robot.neutral(), *robot.random(1, 5)], 1e-13)


def test_links_and_joints_may_bear_any_name(tmp_path: Path) -> None:
    names = ("__proto__", "constructor", "a/b", "100%", "visual:0", "link:x", "a", "toString", "  ", "Ω")
    robot = made_up(tmp_path, *(J(name, axis=(0.0, 1.0, 0.0), xyz=(0.0, 0.0, 0.1)) for name in names))
    _compare(Viewer(robot), [robot.random(2)], 1e-13)


def test_names_that_differ_by_a_slash_stay_apart(tmp_path: Path) -> None:
    joints = (J(name, xyz=(0.1 * k, 0.0, 0.0), parent="base") for k, name in enumerate(("x", "x/", "x//", "/x", "%2F")))
    robot = made_up(tmp_path, *joints, chain=False)
    _compare(Viewer(robot), [robot.random(2)], 1e-13)


def test_only_a_configuration_is_sent_for_a_new_pose(viewer: Viewer, nao: nk.NaoModel) -> None:
    before = {key: viewer._messages.get(key) for key in viewer._messages.names()}
    viewer.display(nao.posture("Crouch"))
    changed = [key for key in viewer._messages.names() if viewer._messages.get(key) != before.get(key)]
    assert changed == ["joints"]
    assert len(viewer._messages.get("joints")) < 8 * nao.nq + 80


# --- shapes -----------------------------------------------------------------------------------------------------------


def _robot(folder: Path, links: str, materials: str = "") -> nk.RobotModel:
    path = folder / "shapes.urdf"
    path.write_text(f'<robot name="shapes">{materials}{links}</robot>', encoding="utf-8")
    return nk.RobotModel.from_urdf(path)


def _visual(geometry: str, extra: str = "") -> str:
    return f"<visual>{extra}<geometry>{geometry}</geometry></visual>"


def _fixed(parent: str, child: str) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{parent} to {child}" type="fixed">{ends}</joint>'


def test_primitives_poses_and_colours_are_read(tmp_path: Path) -> None:
    shapes = (
        _visual('<box size="1 2 3"/>', '<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><material name="red"/>')
        + _visual('<cylinder radius="0.5" length="2"/>', '<material name="own"><color rgba="0 1 0 0.5"/></material>')
        + _visual('<sphere radius="0.25"/>')
    )
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    robot = _robot(tmp_path, f'<link name="a">{shapes}</link>', red)
    (box, cylinder, sphere), notes = robot_drawables(robot.tree)
    assert notes == ()
    assert (box.shape, cylinder.shape, sphere.shape) == (Box((1.0, 2.0, 3.0)), Cylinder(0.5, 2.0), Sphere(0.25))
    assert np.array_equal(box.T_link_shape[:3, 3], [1, 2, 3])
    assert np.allclose(box.T_link_shape[:3, :3], matrix_from_rpy([0.1, 0.2, 0.3]))
    assert (box.rgba, cylinder.rgba) == ((1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 0.5))


def test_a_urdf_visual_holds_what_the_file_says_in_numbers(tmp_path: Path) -> None:
    shapes = (
        _visual('<mesh filename="package://a/b.dae" scale="1 -1 0.5"/>', '<origin xyz="1 2 3"/><material name="red"/>')
        + _visual('<mesh filename="c.stl"/>', '<origin rpy="0.1 0.2 0.3"/><material name="unknown"/>')
        + _visual('<sphere radius="1_0"/>')
        + _visual('<sphere radius="1"/>', '<material name="bright"><color rgba="2 -1 0.5 1"/></material>')
    )
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    robot = _robot(tmp_path, f'<link name="a"/><link name="b">{shapes}</link>' + _fixed("a", "b"), red)
    (first, second, third), (note,) = robot.tree.visuals, robot.tree.visual_notes
    assert (first.link, first.origin) == ("b", Origin((1.0, 2.0, 3.0), (0.0, 0.0, 0.0)))
    assert first.geometry == MeshFile("package://a/b.dae", (1.0, -1.0, 0.5))
    assert (first.material, first.rgba) == ("red", (1.0, 0.0, 0.0, 1.0))
    assert (second.geometry, second.origin.rpy) == (MeshFile("c.stl"), (0.1, 0.2, 0.3))
    assert (second.material, second.rgba) == ("unknown", None)
    assert (third.material, third.rgba) == ("bright", (1.0, 0.0, 0.5, 1.0))
    assert "a visual of b is not shown: sphere has radius '1_0', expected 1 finite number" in note


def test_a_note_repeats_no_more_than_two_hundred_characters(tmp_path: Path) -> None:
    long = "x" * 240
    for geometry in (f'<sphere radius="{long}"/>', f'<mesh filename="{long}.stl"/>', f"<{long}/>"):
        (note,) = Viewer(_robot(tmp_path, f'<link name="a">{_visual(geometry)}</link>')).notes
        assert 150 * "x" in note
        assert 201 * "x" not in note


@pytest.mark.parametrize(
    ("visual", "reason"),
    [
        ('<visual><geometry><mesh filename="nowhere.stl"/></geometry></visual>', "not found: nowhere.stl"),
        ('<visual><geometry><box size="1 2"/></geometry></visual>', "expected 3 finite numbers"),
        ('<visual><origin xyz="a b c"/><geometry><sphere radius="1"/></geometry></visual>', "origin has xyz 'a b c'"),
        ("<visual><geometry><torus/></geometry></visual>", "'torus' is unknown"),
        ("<visual/>", "no geometry"),
        ('<visual><geometry><mesh filename="broken.stl"/></geometry></visual>', "broken.stl"),
    ],
)
def test_what_cannot_be_shown_is_left_out_with_a_note(tmp_path: Path, visual: str, reason: str) -> None:
    (tmp_path / "broken.stl").write_bytes(b"solid nothing\nfacet normal")
    robot = _robot(
        tmp_path, f'<link name="a">{visual}<visual><geometry><sphere radius="1"/></geometry></visual></link>'
    )
    viewer = Viewer(robot)
    assert len(viewer.notes) == 1
    assert reason in viewer.notes[0]
    assert sum(message["kind"] == "geometry" for message in messages_of(viewer.static_html())) == 1


@pytest.mark.parametrize(
    ("suffix", "scale"),
    [(".stl", (-1.0, 1.0, 1.0)), (".obj", (2.0, 0.5, 3.0)), (".ply", (-1.0, -2.0, -0.5)), (".glb", (1.0, 1.0, 1.0))],
)
def test_meshes_keep_their_outside_outside_under_any_scale(
    tmp_path: Path, suffix: str, scale: tuple[float, float, float]
) -> None:
    solid = trimesh.creation.box(extents=(0.2, 0.4, 0.6))
    path = tmp_path / f"solid{suffix}"
    solid.export(path)
    (mesh,) = load_meshes(path, np.array(scale))
    corners = mesh.vertices[mesh.faces]
    outwards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middles = corners.mean(axis=1)
    assert (np.einsum("ij,ij->i", outwards, middles) > 0.0).all()
    assert np.allclose(np.ptp(mesh.vertices, axis=0), np.abs(scale) * [0.2, 0.4, 0.6], rtol=1e-5)
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-4)
    assert (np.einsum("ijk,ijk->ij", mesh.normals[mesh.faces], corners) > 0.0).all()


def test_sharp_edges_stay_sharp_and_round_ones_become_smooth(tmp_path: Path) -> None:
    for name, solid in (
        ("box", trimesh.creation.box(extents=(1.0, 1.0, 1.0))),
        ("ball", trimesh.creation.icosphere(subdivisions=3)),
    ):
        solid.export(tmp_path / f"{name}.stl")
    (box,) = load_meshes(tmp_path / "box.stl", np.ones(3))
    assert len(box.vertices) == 24
    assert np.allclose(np.sort(np.abs(box.normals), axis=1), [0.0, 0.0, 1.0])
    (ball,) = load_meshes(tmp_path / "ball.stl", np.ones(3))
    assert len(ball.vertices) == len(trimesh.creation.icosphere(subdivisions=3).vertices)
    assert np.abs(ball.normals - ball.vertices).max() < 0.02


def test_a_solid_without_any_smooth_edge_keeps_all_its_edges(tmp_path: Path) -> None:
    trimesh.creation.icosahedron().convex_hull.export(tmp_path / "icosahedron.stl")  # its faces meet at 42°
    (solid,) = load_meshes(tmp_path / "icosahedron.stl", np.ones(3))
    assert len(solid.vertices) == 60
    corners = solid.vertices[solid.faces]
    outwards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    assert np.allclose(solid.normals[solid.faces], outwards[:, None], atol=1e-6)


def test_a_flat_face_stays_flat_beside_a_rounding(tmp_path: Path) -> None:
    profile = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.98), (0.99, 0.9973), (0.9727, 1.007), (0.0, 1.007)]
    trimesh.creation.revolve(profile, sections=64).export(tmp_path / "button.stl")
    (button,) = load_meshes(tmp_path / "button.stl", np.ones(3))
    centre = np.linalg.norm(button.vertices - [0.0, 0.0, 1.007], axis=1) < 1e-6
    rim = np.abs(np.linalg.norm(button.vertices - [0.0, 0.0, 1.007], axis=1) - 0.9727) < 1e-4
    assert centre.sum() == 1
    assert rim.sum() == 64
    assert (button.normals[centre | rim, 2] > np.cos(np.radians(3.0))).all()


@pytest.mark.parametrize(
    "name", ["ball.stl", "file://ball.stl", "package://meshes/ball.stl", "package:///meshes/ball.stl"]
)
def test_mesh_files_are_found_wherever_a_urdf_points(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "meshes" if name.startswith("package") else tmp_path / "urdf"
    for path in (folder, tmp_path / "urdf"):
        path.mkdir(exist_ok=True)
    trimesh.creation.icosphere(subdivisions=1).export(folder / "ball.stl")
    monkeypatch.chdir("/")
    visual = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    assert Viewer(_robot(tmp_path / "urdf", f'<link name="a">{visual}</link>')).notes == ()


def test_a_name_that_no_file_can_have_is_not_found(tmp_path: Path) -> None:
    for name in ("x" * 5000, "file://" + "x" * 5000, "package://a/" + "x" * 5000, ""):
        assert Packages(tmp_path / "robot.urdf").file(name) is None


def test_a_file_without_triangles_is_no_mesh(tmp_path: Path) -> None:
    path = tmp_path / "points.ply"
    trimesh.PointCloud(np.eye(3)).export(path)
    with pytest.raises(nk.urdf.UnreadableShape, match="no triangles"):
        load_meshes(path, np.ones(3))


def test_the_meshes_of_the_nao_are_read_once(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    first, _ = robot_drawables(nao.tree)
    monkeypatch.setattr("nao_kin.robot.geometry.read_mesh", None)
    monkeypatch.setattr("nao_kin.viewer.meshes.read_mesh", None)
    again, notes = robot_drawables(nao.with_offsets({"HeadYaw": 0.01}).tree)
    assert notes == ()
    assert [one.geometry for one in again] == [one.geometry for one in first]


def test_the_nao_is_shown_whole(viewer: Viewer, nao: nk.NaoModel) -> None:
    drawables, notes = robot_drawables(nao.tree)
    assert notes == viewer.notes == ()
    assert len({drawable.link for drawable in drawables}) > 30
    assert len({drawable.rgba for drawable in drawables}) >= 5


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_the_page_knows_the_mirror_image_and_naoqis_order(base: Literal["fixed", "floating"]) -> None:
    nao = nk.load_nao(base=base)
    about = Tree(Viewer(nao)).about
    assert about["naoqi"] == list(naoqi_names(nao, "Body"))
    q = nao.random(4)
    mirrored = q.copy()
    for row in about["mirror"]:
        mirrored[row["column"]] = row["multiplier"] * q[row["of"]] + row["offset"]
    motion = nk.Motion([0.0], nao.body_order, nao.to_body(q)[None])
    expected = mirror(nao, motion).configurations(nao).q[0]
    assert np.allclose(mirrored[-25:], expected[-25:], rtol=0.0, atol=1e-12)


def test_a_joint_of_several_groups_is_listed_once_in_the_smallest() -> None:
    panda = nk.load_robot("panda")
    assert panda.chains["arm_and_hand"]
    chains = {
        chain["title"]: [joint["name"] for joint in chain["joints"]] for chain in SceneRobot(panda).about()["chains"]
    }
    assert [*chains] == ["arm", "hand"]
    assert [joint for joints in chains.values() for joint in joints] == list(panda.joint_names)


def test_limbs_end_at_tools_or_at_the_far_side_of_shapes_and_fingers_belong_to_the_hand(tmp_path: Path) -> None:
    def fixed(name: str, x: float) -> J:
        return J(name, kind="fixed", parent="c", xyz=(x, 0.0, 0.0))

    def ends(*more: J, shape: str = "") -> dict[str, list[float]]:
        made_up(tmp_path, J("a"), J("b", xyz=(0.3, 0.0, 0.0)), J("c", xyz=(0.3, 0.0, 0.0)), *more)
        path = tmp_path / "robot.urdf"
        path.write_text(path.read_text(encoding="utf-8").replace('"c_l"><', f'"c_l">{shape}<'), encoding="utf-8")
        about = SceneRobot(nk.RobotModel.from_urdf(path)).about()
        assert [row["frame"] for row in about["ends"]] == about["effectors"]
        return {row["frame"]: row["point"] for row in about["ends"]}

    def finger(name: str, length: float) -> tuple[J, J]:
        return J(name, parent="hand", axis=(0.0, 1.0, 0.0)), J(f"{name}_tip", xyz=(length, 0.0, 0.0))

    box = '<visual><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.04 0.02"/></geometry></visual>'
    nothing, zero = {"c_l": pytest.approx([0.0, 0.0, 0.0])}, [0.0, 0.0, 0.0]
    assert ends() == nothing
    assert ends(shape=box) == {"c_l": pytest.approx([0.2, 0.0, 0.0])}
    # A name, or being the only one, makes an end; a frame near the joint is none, and the farther of two is.
    assert ends(fixed("imu", 0.1), fixed("lamp", 0.2)) == nothing
    assert ends(fixed("imu", 0.1), fixed("tool", 0.08), fixed("tool_near", 0.03), shape=box) == {"tool_l": zero}
    assert ends(fixed("lamp", 0.1), shape=box) == {"lamp_l": zero}
    assert ends(fixed("lamp", 0.04), shape=box) == {"c_l": pytest.approx([0.2, 0.0, 0.0])}
    # Grippers and fingers.
    assert ends(J("grip", parent="c", xyz=(0.1, 0.0, 0.0))) == nothing
    slides = J("left", kind="prismatic"), J("right", kind="prismatic", parent="c", follows=("left", -1.0, 0.0))
    assert ends(*slides) == nothing
    assert ends(fixed("hand", 0.1), *finger("f", 0.05), *finger("g", 0.05)) == {"hand_l": zero}
    assert ends(fixed("hand", 0.1), *finger("f", 0.3), *finger("g", 0.05)) == {"hand_l": zero, "f_tip_l": zero}


def test_a_floating_base_moves_the_root() -> None:
    nao = nk.load_nao(base="floating")
    viewer = Viewer(nao)
    about = Tree(viewer).about
    assert about["floating"]
    assert min(coordinate["column"] for coordinate in about["coordinates"]) == 7
    assert len(viewer.q) == 32


def test_links_have_naoqis_names_for_the_trunk_and_the_feet(viewer: Viewer) -> None:
    about = Tree(viewer).about
    titles = {link["name"]: link["title"] for link in about["links"]}
    known = {"torso": "Torso", "l_ankle": "LFoot", "r_ankle": "RFoot"}
    assert titles == {name: known.get(name, name) for name in viewer.robot.link_names}
    assert about["root"] == "Torso"


# --- the document -----------------------------------------------------------------------------------------------------


def test_a_page_contains_the_licences_of_the_libraries_in_it(viewer: Viewer) -> None:
    folder = Path(importlib.util.find_spec("meshcat").origin).parent / "viewer"
    bundled = json.loads((folder / "dist" / "main.min.js.THIRD_PARTY_LICENSES.json").read_text(encoding="utf-8"))
    texts = [part["licenseText"] for part in bundled if part.get("licenseText")]
    assert {"three", "dat.gui"} <= {part["name"] for part in bundled}
    document = unpacked(viewer.static_html(), "scripts").decode()
    for text in (*texts, (folder / "LICENSE").read_text(encoding="utf-8")):
        assert text.strip() in document
    assert all(f"{part['name']} {part['version']}, {part['license']}" in document for part in bundled)


def test_the_page_is_one_small_file_that_asks_nobody(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    rows = 300
    viewer.animate(np.linspace(nao.posture("StandInit"), nao.posture("Crouch"), rows), fps=60)
    document = viewer.static_html()
    assert len(document.encode()) < 1_200_000
    assert "default-src 'none'" in document
    head = document[: document.index("<script")]
    assert "http" not in head.replace("http-equiv", "")
    assert document == viewer.static_html()
    assert document.count("</script>") == 3


def test_equal_robots_give_equal_pages(nao: nk.NaoModel) -> None:
    assert Viewer(nao).static_html() == Viewer(nao).static_html()


def test_hundreds_of_displays_do_not_grow_the_page_or_the_memory(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    qs = nao.random(1, 400)
    sizes = set()
    for index, q in enumerate(qs):
        viewer.display(q)
        viewer.show_ghosts(q)
        viewer.show_targets({"a": nao.position(q, "LArm")})
        viewer.show_frames(["LArm"])
        viewer.color_links({"Head": 0.1 * index + 1.0, "torso": 0.0}, low=0.0, high=50.0)
        viewer.animate(qs[:3])
        if index % 100 == 0:
            sizes.add(sum(len(message) for message in viewer._messages.messages()))
    assert len(sizes) == 1
    assert np.array_equal(viewer.q, qs[0])


def test_foreign_names_cannot_leave_their_place(tmp_path: Path) -> None:
    evil = "</script><script>window.hacked=1</script>"
    path = tmp_path / "evil.urdf"
    quoted = evil.replace("<", "&lt;").replace(">", "&gt;")
    path.write_text(f'<robot name="{quoted}"><link name="{quoted}"/></robot>', encoding="utf-8")
    document = Viewer(nk.RobotModel.from_urdf(path)).static_html()
    assert "hacked" not in document.replace(quoted, "")
    assert f"<title>{quoted}</title>" in document


def test_the_file_is_written_whole_or_not_at_all(
    viewer: Viewer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "nao.html"
    assert viewer.save_html(path) == path
    assert path.read_text(encoding="utf-8") == viewer.static_html()
    path.write_text("old", encoding="utf-8")
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(BadArgument, match="cannot write .*: No space left on device"):
        viewer.save_html(path, overwrite=True)
    assert path.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_is_there_is_replaced_only_by_force(viewer: Viewer, tmp_path: Path) -> None:
    page, picture = tmp_path / "nao.html", tmp_path / "nao.png"
    film = tmp_path / "nao.webm"
    for path, save in ((page, viewer.save_html), (picture, viewer.save_png), (film, viewer.save_video)):
        path.write_text("mine", encoding="utf-8")
        with pytest.raises(BadArgument, match=r"overwrite=True \(--force\) replaces it"):
            save(path)
        with pytest.raises(BadArgument, match="overwrite must be True or False, got 'no'"):
            save(path, overwrite="no")
        assert path.read_text(encoding="utf-8") == "mine"
    viewer.save_html(page, overwrite=True)
    assert page.read_text(encoding="utf-8") == viewer.static_html()


def test_a_video_needs_a_clip_and_the_ending_of_one(viewer: Viewer, nao: nk.NaoModel, tmp_path: Path) -> None:
    with pytest.raises(BadArgument, match=r"nao.mp4: a video is written as WEBM; end the name in \.webm"):
        viewer.save_video(tmp_path / "nao.mp4")
    with pytest.raises(BadArgument, match="the viewer has no clip to film; call animate first"):
        viewer.save_video(tmp_path / "nao.webm")
    viewer.animate(nao.random(1, 2), play=False)
    with pytest.raises(BadArgument, match="size"):
        viewer.save_video(tmp_path / "nao.webm", size=(3, 3))
    for fps in (0.0, 241.0):
        with pytest.raises(BadArgument, match="fps must be above 0 and at most 240, got"):
            viewer.save_video(tmp_path / "nao.webm", fps=fps)
    viewer.display(nao.posture("Stand"))
    with pytest.raises(BadArgument, match="the viewer has no clip to film; call animate first"):
        viewer.save_video(tmp_path / "nao.webm")
    assert list(tmp_path.iterdir()) == []


def test_an_unwritable_path_is_refused(viewer: Viewer, tmp_path: Path) -> None:
    with pytest.raises(BadArgument, match="cannot write"):
        viewer.save_html(tmp_path / "no" / "such" / "folder.html")
    with pytest.raises(BadArgument, match="cannot write '': no file name"):
        viewer.save_html("")


# --- bad input --------------------------------------------------------------------------------------------------------


def test_a_link_without_a_shape_colours_what_it_is_fixed_to(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    names = list(viewer._look.paths)
    for values, coloured in (
        ({"LFoot": 1.0, "Head": 0.0}, {"l_ankle", "LFoot", "Head"}),
        ({"LFoot": 1.0, "l_ankle": 0.0}, {"l_ankle", "LFoot"}),
    ):
        viewer.color_links(values)
        (message,) = (m for m in messages_of(viewer.static_html()) if m.get("kind") == "colours")
        rgb = {names[row["link"]]: row["rgb"] for row in message["links"]}
        assert set(rgb) == coloured
        assert (rgb["l_ankle"] == rgb["LFoot"]) == ("l_ankle" not in values)


def test_pages_get_the_hulls_by_which_they_find_links_that_overlap(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    (hulls,) = (m for m in messages_of(viewer.static_html()) if m.get("kind") == "hulls")
    names = list(viewer._look.paths)
    links = [names[link] for link in hulls["links"]]
    pairs = np.frombuffer(hulls["pairs"].data, dtype=np.uint16).reshape(-1, 2).tolist()
    assert {tuple(sorted((links[a], links[b]))) for a, b in pairs} == set(nao.link_shapes.pairs)
    assert sum(hulls["counts"]) == len(hulls["points"].data) / 12
    assert len(hulls["links"]) == len(hulls["counts"]) == len(hulls["radii"]) == len(hulls["parts"])
    fingers = {links[k] for first, last in hulls["parts"] for k in range(first, last) if last - first > 1}
    assert fingers == {name for name in nao.link_names if "Finger" in name or "Thumb" in name}


def test_the_pairs_of_other_robots_are_searched_for_on_request(tmp_path: Path) -> None:
    shape = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"
    limit = "<axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/>"
    links = "".join(f"<link name='{name}'>{shape}</link>" for name in "abc")
    joints = "".join(
        f"<joint name='to_{name}' type='prismatic'><parent link='a'/><child link='{name}'/>{limit}</joint>"
        for name in "bc"
    )
    path = tmp_path / "balls.urdf"
    path.write_text(f"<robot name='balls'>{links}{joints}</robot>", encoding="utf-8")
    viewer = Viewer(nk.RobotModel.from_urdf(path))
    assert "hulls" not in {m.get("kind") for m in messages_of(viewer.static_html())}
    viewer.show_collisions()
    (hulls,) = (m for m in messages_of(viewer.static_html()) if m.get("kind") == "hulls")
    assert hulls["radii"] == [0.1, 0.1, 0.1]
    assert hulls["counts"] == [1, 1, 1]
    assert {"collisions": True} in [m.get("shown") for m in messages_of(viewer.static_html())]
    viewer.show_collisions(on=False)
    assert {"collisions": False} in [m.get("shown") for m in messages_of(viewer.static_html())]


def test_outside_the_limits_is_shown_and_warned_of_once(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    q = nao.configuration({"HeadYaw": 3.0, "LKneePitch": -1.0}, limits="ignore")
    with pytest.warns(OutsideLimitsWarning, match="HeadYaw"):
        viewer.display(q)
    assert np.array_equal(viewer.q, q)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        viewer.display(q)
    with pytest.warns(OutsideLimitsWarning, match="in red: RKneePitch$"):
        viewer.animate([q, nao.configuration({"RKneePitch": -1.0, "HeadYaw": 3.0}, limits="ignore")])


def test_only_joints_that_somebody_set_are_warned_of(nao: nk.NaoModel) -> None:
    viewer, neutral = Viewer(nao), nao.neutral()
    assert {row.joint for row in nao.limit_violations(neutral)} == {"LElbowRoll", "RElbowRoll"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        viewer.display(neutral)
        viewer.animate([neutral, -neutral])
    with pytest.warns(NaoKinWarning, match="in red: LElbowRoll$"):
        viewer.display(nao.configuration({"LElbowRoll": 0.1}, limits="ignore"))


def test_a_clip_warns_of_the_joints_that_its_frames_warn_of_in_their_order(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    clip = np.where(rng.random((300, nao.nq)) < 0.98, 0.0, rng.uniform(-3.0, 3.0, (300, nao.nq)))
    clip[:, :8] = 0.0
    rows = nao.limit_violations(clip)
    expected = dict.fromkeys(row.joint for row in rows if row.value != 0.0 or row.of_value != 0.0)
    with pytest.warns(OutsideLimitsWarning) as warned:
        Viewer(nao).animate(clip)
    assert str(warned[0].message).endswith(f"in red: {', '.join(expected)}")


def test_a_joint_at_zero_is_warned_of_where_another_one_leaves_it_no_zero(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("neck"), J("nod"))
    table = CoupledLimit("nod", "neck", at=(0.0, 1.0), lower=(-0.1, 0.2), upper=(0.5, 0.5))
    robot = nk.RobotModel(robot.tree, Semantics(coupled_limits=(table,)))
    clip = np.zeros((4, 2))
    clip[2:, robot.joint_names.index("neck")] = 1.0
    with pytest.warns(OutsideLimitsWarning, match="in red: nod$"):
        Viewer(robot).animate(clip)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Viewer(robot).animate(clip[:2])


def test_nothing_given_is_aliased(viewer: Viewer, nao: nk.NaoModel) -> None:
    q = nao.posture("Stand")
    viewer.display(q)
    q[:] = 0.0
    assert np.array_equal(viewer.q, nao.posture("Stand"))
    viewer.q[:] = 0.0
    assert np.array_equal(viewer.q, nao.posture("Stand"))


def test_the_library_loads_without_the_viewer() -> None:
    heavy = "tornado", "trimesh", "meshcat", "umsgpack", "IPython"
    code = f"import sys, nao_kin; nao_kin.load_nao(); print([m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
