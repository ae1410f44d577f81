"""The glTF scene: every node is where the robot has its link, posed and in motion, and readers take it."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loops import EACH_VERSION
from made_up_robots import J, made_up
from scipy.spatial.transform import Rotation, Slerp

import nao_kin as nk
from nao_kin.export.variants import Variant

# x forward, y left, z up of the robot → x, y up, z of glTF.
Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


class _Scene:
    """A binary glTF, read according to the specification."""

    def __init__(self, path: Path) -> None:
        content = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", content)
        assert (magic, version, length) == (b"glTF", 2, len(content))
        size, kind = struct.unpack_from("<I4s", content, 12)
        assert kind == b"JSON"
        self.tree: dict[str, Any] = json.loads(content[20 : 20 + size])
        self.binary = content[28 + size :]
        if self.binary:
            rest, kind = struct.unpack_from("<I4s", content, 20 + size)
            assert kind == b"BIN\0"
            assert len(self.binary) == rest == self.tree["buffers"][0]["byteLength"]
        self.nodes = self.tree["nodes"]

    def numbers(self, accessor: int) -> np.ndarray[Any, Any]:
        row = self.tree["accessors"][accessor]
        view = self.tree["bufferViews"][row["bufferView"]]
        assert row["componentType"] == 5126
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[row["type"]]
        start = view.get("byteOffset", 0) + row.get("byteOffset", 0)
        assert start % 4 == 0
        rows = np.frombuffer(self.binary, "<f4", row["count"] * width, start).reshape(-1, width)
        return rows[:, 0] if width == 1 else rows

    def at(self, time: float) -> dict[tuple[int, str], np.ndarray[Any, Any]]:
        """Return the values that the animation sets at a time, by node and path."""
        found = {}
        for animation in self.tree.get("animations", []):
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                times, rows = self.numbers(sampler["input"]), self.numbers(sampler["output"])
                path = channel["target"]["path"]
                if path == "rotation":
                    value = Slerp(times, Rotation.from_quat(rows))(time).as_quat()
                else:
                    value = np.array([np.interp(time, times, column) for column in rows.T])
                found[channel["target"]["node"], path] = value
        return found

    def poses(self, time: float = 0.0) -> dict[str, np.ndarray[Any, Any]]:
        """Name of every node → its pose in the scene."""
        moved, found = self.at(time), {}

        def walk(index: int, above: np.ndarray[Any, Any]) -> None:
            node, T = self.nodes[index], np.eye(4)
            if "matrix" in node:
                assert not any(target == index for target, _ in moved)
                T = np.array(node["matrix"]).reshape(4, 4).T
            else:
                T[:3, 3] = moved.get((index, "translation"), node.get("translation", [0, 0, 0]))
                rotation = moved.get((index, "rotation"), node.get("rotation", [0, 0, 0, 1]))
                T[:3, :3] = Rotation.from_quat(rotation).as_matrix()
            assert node["name"] not in found
            found[node["name"]] = above @ T
            for child in node.get("children", []):
                walk(child, found[node["name"]])

        for index in self.tree["scenes"][0]["nodes"]:
            walk(index, np.eye(4))
        return found


@pytest.fixture(scope="module")
def nao() -> nk.NaoModel:
    return nk.load_nao("v6")


@pytest.fixture(scope="module")
def written(nao: nk.NaoModel, tmp_path_factory: pytest.TempPathFactory) -> nk.export.Exported:
    return nk.export.gltf(nao, tmp_path_factory.mktemp("gltf") / "nao.glb")


def _check(scene: _Scene, robot: nk.RobotModel, q: Any, time: float = 0.0, atol: float = 1e-12) -> None:
    poses = scene.poses(time)
    for link, T in zip(robot.link_names, robot.fk(q), strict=True):
        np.testing.assert_allclose(poses[link], Y_UP @ T, atol=atol, err_msg=link)


# --- poses ------------------------------------------------------------------------------------------------------------


def test_the_robot_stands_in_its_start_posture_with_y_up(nao: nk.NaoModel, written: nk.export.Exported) -> None:
    scene = _Scene(written.path)
    _check(scene, nao, nao.posture("StandInit"))
    assert scene.tree["asset"]["version"] == "2.0"
    assert "animations" not in scene.tree
    poses = scene.poses()
    assert poses["Head"][1, 3] > poses["LFoot"][1, 3] + 0.3


@pytest.mark.parametrize("version", EACH_VERSION)
def test_every_version_stands_in_any_posture(version: str, tmp_path: Path) -> None:
    robot = nk.load_nao(version)
    done = nk.export.gltf(robot, tmp_path / "nao.glb", posture="Crouch")
    assert done.changes == ()
    _check(_Scene(done.path), robot, robot.posture("Crouch"))


def test_a_joint_is_a_node_and_what_it_moves_turns_about_its_axis_alone(
    nao: nk.NaoModel, written: nk.export.Exported
) -> None:
    scene = _Scene(written.path)
    rows = {row["name"]: row for row in scene.nodes}
    angles = nao.angles(nao.posture("StandInit"))
    for joint in nao.tree.moving_joints:
        stand, moved = rows[joint.name], rows[joint.child]
        assert scene.nodes.index(moved) in stand["children"]
        assert "translation" not in moved
        mimic = nao.mimics.get(joint.name)
        value = float(mimic.value(np.asarray(angles[mimic.joint]))) if mimic else angles[joint.name]
        turned = Rotation.from_quat(moved.get("rotation", [0, 0, 0, 1])).as_rotvec()
        np.testing.assert_allclose(turned, value * np.array(joint.axis), atol=1e-12)
        extras = moved["extras"]
        assert (extras["joint"], extras["axis"]) == (joint.name, list(joint.axis))
        assert (extras["lower"], extras["upper"]) == (joint.lower, joint.upper)
        assert extras.get("mimic", {}).get("joint") == (mimic.joint if mimic else None)


def test_sliding_joints_and_floating_bases_stand_where_they_are(tmp_path: Path) -> None:
    slide = J("b", kind="prismatic", axis=(0.0, 0.6, 0.8), xyz=(0.1, 0.0, 0.2), rpy=(0.1, 0.2, 0.3))
    robot = made_up(tmp_path, J("a", rpy=(1.0, -0.5, 2.0)), slide, base="floating")
    motion = nk.Motion([0.0, 1.0], ["a", "b"], [[0.3, 0.5], [-1.0, 0.1]], interpolation="linear")
    done = nk.export.gltf(robot, tmp_path / "m.glb", motion=motion)
    scene = _Scene(done.path)
    _check(scene, robot, robot.configuration({"a": 0.3, "b": 0.5}), atol=1e-6)
    _check(scene, robot, robot.configuration({"a": -0.35, "b": 0.3}), time=0.5, atol=1e-6)


def test_frames_and_names_are_those_of_a_urdf(nao: nk.NaoModel, tmp_path: Path) -> None:
    scene = _Scene(nk.export.gltf(nao, tmp_path / "nao.glb", frames="none", names="ros").path)
    tree, _ = Variant(frames="none", names="ros").tree_of(nao)
    poses = scene.poses()
    assert set(tree.links) <= set(poses)
    # A joint and a link of one name: the joint's node gets another one.
    assert "LAnklePitch_joint" in poses
    np.testing.assert_allclose(poses["l_ankle"], Y_UP @ nao.fk(nao.posture("StandInit"), "l_ankle"), atol=1e-12)


# --- motion -----------------------------------------------------------------------------------------------------------


def test_the_animation_is_the_motion(nao: nk.NaoModel, tmp_path: Path) -> None:
    names = ["HeadYaw", "LShoulderPitch", "LHipYawPitch", "RHand"]
    keys = [[0.0, 1.4, 0.0, 0.0], [1.9, -1.0, -1.0, 1.0], [-1.9, 1.4, 0.5, 0.2]]
    motion = nk.Motion([0.5, 1.0, 2.0], names, keys, interpolation="linear")
    scene = _Scene(nk.export.gltf(nao, tmp_path / "nao.glb", motion=motion, fps=20).path)
    (animation,) = scene.tree["animations"]
    moved = {scene.nodes[channel["target"]["node"]]["extras"]["joint"] for channel in animation["channels"]}
    followers = {name for name, mimic in nao.mimics.items() if mimic.joint in names}
    assert moved == {*names, *followers}
    times = scene.numbers(animation["samplers"][0]["input"])
    assert (times[0], times[-1]) == (0.0, 1.5) or (times[0], times[-1]) == (0.5, 2.0)
    np.testing.assert_allclose(np.diff(times), 0.05, atol=1e-6)
    accessor = scene.tree["accessors"][animation["samplers"][0]["input"]]
    assert (accessor["min"], accessor["max"]) == ([times[0]], [times[-1]])
    start = float(times[0]) - 0.5
    for time in (0.5, 0.61, 0.975, 1.0, 1.234, 1.999, 2.0):
        q = motion.configurations(nao, times=[time]).q[0]
        _check(scene, nao, q, time=time + start, atol=2e-6)


def test_a_quaternion_never_jumps_to_its_opposite(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a", kind="continuous"))
    motion = nk.Motion([0.0, 1.0], ["a"], [[0.0], [6.0 * np.pi]])
    scene = _Scene(nk.export.gltf(robot, tmp_path / "m.glb", motion=motion).path)
    rows = scene.numbers(scene.tree["animations"][0]["samplers"][0]["output"])
    assert (np.sum(rows[1:] * rows[:-1], axis=1) > 0.9).all()
    np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1.0, atol=1e-6)


def test_a_motion_that_stands_still_has_no_animation(nao: nk.NaoModel, tmp_path: Path) -> None:
    motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.3], [0.3]])
    scene = _Scene(nk.export.gltf(nao, tmp_path / "nao.glb", motion=motion).path)
    assert "animations" not in scene.tree
    _check(scene, nao, motion.configurations(nao, times=[0.0]).q[0])


def test_a_motion_may_be_a_file(nao: nk.NaoModel, tmp_path: Path) -> None:
    motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.3]])
    nk.motion.write_motion(motion, tmp_path / "nod.json")
    scene = _Scene(nk.export.gltf(nao, tmp_path / "nao.glb", motion=tmp_path / "nod.json").path)
    assert len(scene.tree["animations"][0]["channels"]) == 1


# --- looks ------------------------------------------------------------------------------------------------------------


def test_trimesh_reads_the_scene_as_large_as_the_robot_is(nao: nk.NaoModel, written: nk.export.Exported) -> None:
    import trimesh

    scene = trimesh.load_scene(written.path)
    size = scene.bounds[1] - scene.bounds[0]
    assert 0.5 < size[1] < 0.6  # the height of a NAO
    assert 0.2 < size[2] < 0.45
    assert len(scene.graph.nodes_geometry) == len(nao.tree.visuals)


def test_equal_parts_are_one_mesh(nao: nk.NaoModel, written: nk.export.Exported) -> None:
    tree = _Scene(written.path).tree
    shapes = {(visual.geometry, visual.rgba) for visual in nao.tree.visuals}
    assert len(tree["meshes"]) == len(shapes) < len(nao.tree.visuals)
    assert sum("mesh" in node for node in tree["nodes"]) == len(nao.tree.visuals)


def test_colours_are_those_of_the_urdf_in_the_scale_of_light(nao: nk.NaoModel, written: nk.export.Exported) -> None:
    materials = {
        row["name"]: row["pbrMetallicRoughness"]["baseColorFactor"] for row in _Scene(written.path).tree["materials"]
    }
    colours = {visual.material: visual.rgba for visual in nao.tree.visuals}
    assert set(materials) == set(colours)
    for name, factor in materials.items():
        rgba = np.array(colours[name])
        # The approximation by a power of 2.2 is within 0.01 of the curve of the standard.
        np.testing.assert_allclose(factor[:3], rgba[:3] ** 2.2, atol=0.01)
        assert factor[3] == 1.0
    assert materials["black"][0] == pytest.approx(((0.05 + 0.055) / 1.055) ** 2.4, rel=1e-12)


def test_a_mesh_keeps_its_own_colour_beside_one_of_that_name_in_the_urdf(tmp_path: Path) -> None:
    import trimesh

    blue = trimesh.visual.material.PBRMaterial(name="paint", baseColorFactor=[0, 0, 255, 255])
    box = trimesh.creation.box()
    box.visual = trimesh.visual.TextureVisuals(material=blue)
    box.export(tmp_path / "own.glb")
    robot = _with_look(
        made_up(tmp_path, J("a")),
        '<geometry><mesh filename="own.glb"/></geometry>',
        '<geometry><box size="1 1 1"/></geometry><material name="paint"><color rgba="1 0 0 1"/></material>',
    )
    written = nk.export.gltf(robot, tmp_path / "robot.glb")
    rows = [row for row in _Scene(written.path).tree["materials"] if row["name"] == "paint"]
    colours = sorted(row["pbrMetallicRoughness"]["baseColorFactor"] for row in rows)
    assert colours == [[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 0.0, 1.0]]


def test_every_normal_has_the_length_one(written: nk.export.Exported) -> None:
    scene = _Scene(written.path)
    for mesh in scene.tree["meshes"]:
        for primitive in mesh["primitives"]:
            normals = scene.numbers(primitive["attributes"]["NORMAL"])
            np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)


def _with_look(robot: nk.RobotModel, *shapes: str) -> nk.RobotModel:
    looks = "".join(f"<visual>{shape}</visual>" for shape in shapes)
    text = robot.urdf_path.read_text(encoding="utf-8")
    robot.urdf_path.write_text(text.replace('<link name="base">', f'<link name="base">{looks}'), encoding="utf-8")
    return nk.RobotModel.from_urdf(robot.urdf_path)


def test_shapes_stand_where_their_origins_are(tmp_path: Path) -> None:
    import trimesh

    origin = '<origin xyz="1 2 3"/>'
    robot = _with_look(
        made_up(tmp_path, J("a")),
        origin + '<geometry><box size="0.2 0.4 0.6"/></geometry>',
        '<origin xyz="-1 0 0"/><geometry><cylinder radius="0.1" length="0.5"/></geometry>',
        '<origin xyz="0 -1 0"/><geometry><sphere radius="0.3"/></geometry>',
    )
    scene = trimesh.load_scene(nk.export.gltf(robot, tmp_path / "m.glb").path)
    parts = [part.bounds for part in scene.dump()]
    corners = sorted((Y_UP[:3, :3].T @ bounds.T).T.tolist() for bounds in parts)
    boxes = [np.sort(np.array(pair), axis=0) for pair in corners]
    np.testing.assert_allclose(boxes[0], [[-1.1, -0.1, -0.25], [-0.9, 0.1, 0.25]], atol=1e-3)
    np.testing.assert_allclose(boxes[1], [[-0.3, -1.3, -0.3], [0.3, -0.7, 0.3]], atol=5e-3)
    np.testing.assert_allclose(boxes[2], [[0.9, 1.8, 2.7], [1.1, 2.2, 3.3]], atol=1e-6)


def test_what_cannot_be_read_is_said_and_the_rest_is_written(tmp_path: Path) -> None:
    (tmp_path / "broken.obj").write_bytes(b"\xff\xfe")
    mesh = '<geometry><mesh filename="{}"/></geometry>'
    robot = made_up(tmp_path, J("a"))
    robot = _with_look(
        robot, mesh.format("gone.stl"), mesh.format("broken.obj"), '<geometry><sphere radius="1"/></geometry>'
    )
    done = nk.export.gltf(robot, tmp_path / "m.glb")
    assert done.changes[0] == "a visual shape of base is left out: its mesh 'gone.stl' is not there"
    assert done.changes[1].startswith("a visual shape of base is left out: its mesh 'broken.obj'")
    assert len(_Scene(done.path).tree["meshes"]) == 1


def test_a_robot_without_looks_is_a_scene_of_nodes(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", kind="fixed"))
    motion = nk.Motion([0.0, 1.0], ["a"], [[0.0], [0.3]])
    done = nk.export.gltf(robot, tmp_path / "m.glb", motion=motion)
    scene = _Scene(done.path)
    assert {"base", "a", "a_l", "b_l"} <= set(scene.poses())
    assert "meshes" not in scene.tree


def test_a_robot_without_a_start_stands_within_its_limits(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a", limits=(0.5, 1.0)), J("b", xyz=(0.1, 0.0, 0.0)))
    poses = _Scene(nk.export.gltf(robot, tmp_path / "m.glb").path).poses()
    np.testing.assert_allclose(poses["b_l"], Y_UP @ robot.fk([0.5, 0.0], "b_l"), atol=1e-6)


def test_a_shape_that_is_there_twice_stands_in_both_places(tmp_path: Path) -> None:
    import trimesh

    box = '<geometry><box size="0.2 0.2 0.2"/></geometry>'
    origins = [f'<origin xyz="{x} 0 0"/>' for x in (1, 3)]
    robot = _with_look(made_up(tmp_path, J("a")), *(origin + box for origin in origins))
    scene = trimesh.load_scene(nk.export.gltf(robot, tmp_path / "m.glb").path)
    assert sorted(part.bounds[0][0] for part in scene.dump()) == pytest.approx([0.9, 2.9])


@pytest.mark.parametrize("name", ["base", "a_l"])
def test_a_link_may_be_called_world(name: str, tmp_path: Path) -> None:
    robot = _with_look(made_up(tmp_path, J("a", xyz=(0.1, 0.2, 0.3))), '<geometry><box size="0.2 0.4 0.6"/></geometry>')
    text = robot.urdf_path.read_text(encoding="utf-8").replace(f'"{name}"', '"world"')
    robot.urdf_path.write_text(text, encoding="utf-8")
    robot = nk.RobotModel.from_urdf(robot.urdf_path)
    poses = _Scene(nk.export.gltf(robot, tmp_path / "m.glb").path).poses()
    for link in robot.link_names:
        np.testing.assert_allclose(poses[link], Y_UP @ robot.fk(robot.neutral(), link), atol=1e-6)


def test_no_folder_of_this_machine_is_in_the_file(written: nk.export.Exported) -> None:
    tree = _Scene(written.path).tree
    assert not any(row.get("extras") for row in (*tree["meshes"], *tree["scenes"]))
    content = json.dumps(tree)
    assert "/home" not in content
    assert str(Path(__file__).resolve().parents[2]) not in content
    assert ".obj" not in content
