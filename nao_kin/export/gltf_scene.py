"""A robot as a glTF scene, for Blender, web pages and game engines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.documents import check_replaceable, write_document
from nao_kin._common.free_names import fresh_name, with_underscores
from nao_kin._text import quoted
from nao_kin.errors import BadArgument
from nao_kin.export.exported import Exported
from nao_kin.export.glb import Glb
from nao_kin.export.joint_values import joint_values
from nao_kin.export.scene_nodes import Node, motion_of, scene_nodes
from nao_kin.export.scene_shapes import Shape, linear, scene_shapes
from nao_kin.export.urdf_export import variant
from nao_kin.export.variants.placement import transform
from nao_kin.motion import Motion, Trajectory, read_motion
from nao_kin.robot import RobotModel, check_robot
from nao_kin.urdf import UrdfTree

FRAMES_PER_SECOND = 30.0
_STILL = (0.0, 0.0, 0.0, 1.0)


def gltf(
    robot: RobotModel,
    path: Path | str,
    *,
    posture: str | None = None,
    motion: Motion | Path | str | None = None,
    fps: float = FRAMES_PER_SECOND,
    frames: str = "all",
    names: str = "naoqi",
    overwrite: bool = False,
) -> Exported:
    """Write a binary glTF 2.0 scene (.glb): the posed robot, each joint a node, and a motion as an animation.

    Metres, y up. The scene's first node has the robot's name and turns z up into y up. A joint is a node of its name
    that stands where the joint is; in it stands the node of the link that it moves, whose rotation or position is that
    of the joint and nothing else. Axis, limits and coupling of the joint are in the node's `extras`.

    Args:
        robot: the robot.
        path: the file; its name ends in .glb.
        posture: the posture it stands in; None for the one it starts in, or the first configuration of the motion.
        motion: a motion, or a file of one: the animation.
        fps: poses per second in the animation; between them, glTF turns evenly.
        frames: see `urdf`; frames are empty nodes.
        names: see `urdf`.
        overwrite: replace a file that is there.

    Returns:
        The file, and one line for each look that cannot be read.

    Raises:
        UnknownName: no such posture, names or frames, or a joint of the motion that the robot lacks.
        BadArgument: another ending, no rate, posture and motion both, a file is there, or it cannot be written.

    Examples:
        >>> nod = nk.Motion([0.0, 1.0], ["HeadPitch"], [[0.0], [0.4]])
        >>> nk.export.gltf(nk.load_nao("v6"), "nod.glb", motion=nod).changes
        ()
    """
    check_robot(robot)
    if not str(path).lower().endswith((".glb", "/dev/stdout")):
        raise BadArgument(f"the file is a binary glTF; end its name in .glb, got {quoted(path)}")
    check_replaceable(path, overwrite=overwrite)
    tree, _ = variant(robot, frames=frames, names=names)
    moving = _trajectory(robot, motion, fps, posture)
    values = joint_values(robot, moving.q, names)
    nodes = scene_nodes(tree, {name: float(value[0]) for name, value in values.items()}, _base(robot, moving.q[0]))
    shapes, paints, notes = scene_shapes(tree)
    glb = Glb(_scene(tree, nodes, shapes))
    _place(glb, nodes)
    colours = {paint.name: linear(paint.rgba) for paint in paints}
    for row in glb.tree.get("materials", ()):
        factors = row["pbrMetallicRoughness"]
        if row.get("name") in colours and not any(factors["baseColorFactor"][:3]):
            factors["baseColorFactor"] = colours[row["name"]]
    if motion is not None:
        _animate(glb, nodes, moving, values)
    glb.tree["asset"]["generator"] = "nao_kin, trimesh"
    return Exported(Path(path), write_document(path, glb.content(), overwrite=overwrite), notes)


def _trajectory(robot: RobotModel, motion: Motion | Path | str | None, fps: float, posture: str | None) -> Trajectory:
    if isinstance(fps, bool) or not isinstance(fps, (int, float)) or not 0.0 < fps <= 1000.0:
        raise BadArgument(f"fps must be a number above 0 and at most 1000, got {quoted(fps)}")
    if motion is None:
        start = robot.semantics.start if posture is None else posture
        q = robot.posture(start) if start or posture is not None else robot.clamp(robot.neutral())
        return Trajectory(np.zeros(1), q[None])
    if posture is not None:
        raise BadArgument("give a posture or a motion: the scene stands as the motion begins")
    known = motion if isinstance(motion, Motion) else read_motion(motion, robot=robot)
    return known.configurations(robot, rate=float(fps))


def _base(robot: RobotModel, q: Floats) -> Floats:
    """Position and quaternion of the root link, shape (7,): no motion moves it."""
    return q[:7] if robot.base == "floating" else np.array([0.0, 0.0, 0.0, *_STILL])


def _scene(tree: UrdfTree, nodes: tuple[Node, ...], shapes: tuple[Shape, ...]) -> bytes:
    """The scene as trimesh writes it; where its nodes stand is written over later."""
    import trimesh
    import trimesh.exchange.gltf

    taken = {node.name for node in nodes}
    scene: Any = trimesh.Scene(base_frame=with_underscores("world", taken))
    for node in nodes:
        scene.graph.update(frame_to=node.name, frame_from=node.parent or scene.graph.base_frame, matrix=np.eye(4))
    geometries = dict[tuple[object, ...], str]()
    for shape in shapes:
        name = fresh_name(shape.name or f"{shape.link}_visual", taken)
        taken.add(name)
        place = transform(shape.origin)
        if shape.key in geometries:
            scene.graph.update(frame_to=name, frame_from=shape.link, matrix=place, geometry=geometries[shape.key])
        else:
            geometries[shape.key] = name
            scene.add_geometry(shape.mesh, geom_name=name, node_name=name, parent_node_name=shape.link, transform=place)
    writer: Any = trimesh.exchange.gltf  # not typed
    exported: bytes = writer.export_glb(scene, include_normals=True)
    return exported


def _place(glb: Glb, nodes: tuple[Node, ...]) -> None:
    """Position and rotation of every node of the robot, which an animation may then move, in place of a matrix."""
    by_name = {row["name"]: row for row in glb.tree["nodes"]}
    for node in nodes:
        row = by_name[node.name]
        row.pop("matrix", None)
        if any(node.position):
            row["translation"] = node.position.tolist()
        if tuple(node.quaternion) != _STILL:
            row["rotation"] = node.quaternion.tolist()
        extras = node.extras()
        if extras:
            row["extras"] = extras


def _animate(glb: Glb, nodes: tuple[Node, ...], moving: Trajectory, values: dict[str, Floats]) -> None:
    places = {row["name"]: index for index, row in enumerate(glb.tree["nodes"])}
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    times = glb.add_numbers(moving.times, bounds=True)

    def add(name: str, path: str, rows: Floats) -> None:
        samplers.append({"input": times, "output": glb.add_numbers(rows), "interpolation": "LINEAR"})
        channels.append({"sampler": len(samplers) - 1, "target": {"node": places[name], "path": path}})

    for node in nodes:
        if node.joint is not None and np.ptp(values[node.joint.name]) > 0.0:
            positions, quaternions = motion_of(node.joint, values[node.joint.name])
            sliding = node.joint.kind == "prismatic"
            add(node.name, "translation" if sliding else "rotation", positions if sliding else quaternions)
    if channels:
        glb.tree["animations"] = [{"name": "motion", "samplers": samplers, "channels": channels}]
