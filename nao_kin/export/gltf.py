"""Export of a robot as a glTF scene, for Blender, web pages and game engines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.text import fresh_name, quoted, with_underscores
from nao_kin.errors import BadArgument
from nao_kin.export.meshes import GREY, left_out_note, outside_note, resolver
from nao_kin.export.pipeline import Destination, Exported
from nao_kin.export.variants import Variant, joint_values
from nao_kin.motion import Motion, Trajectory, read_motion
from nao_kin.robot import RobotModel, read_mesh
from nao_kin.robot.urdf import Box, Cylinder, Geometry, Packages, Rgba, Sphere, UnreadableShape, UrdfJoint, UrdfTree
from nao_kin.rotations import quat_from_matrix, quat_to_xyzw

# --- The nodes of a scene: for each joint a fixed node at the pose of the joint, with a moving node in it.

# From the robots' z up to glTF's y up: a quarter turn about x. Order x, y, z, w.
Y_UP = (-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))


@dataclass(frozen=True)
class Node:
    """A node of a scene."""

    name: str  # unique in the scene
    parent: str  # name of the parent node; "" for the first
    position: Floats  # in its parent [m]
    quaternion: Floats  # in its parent, in the order x, y, z, w
    joint: UrdfJoint | None = None  # the joint whose value moves it
    link: str = ""  # the link at this node, "" for none

    def extras(self) -> dict[str, Any]:
        """Return properties that glTF lacks: the joint, its axis and its limits."""
        if self.joint is None:
            return {}
        row: dict[str, Any] = {"joint": self.joint.name, "kind": self.joint.kind, "axis": list(self.joint.axis)}
        if np.isfinite(self.joint.upper - self.joint.lower):
            row |= {"lower": self.joint.lower, "upper": self.joint.upper}
        if self.joint.mimic is not None:
            mimic = self.joint.mimic
            row["mimic"] = {"joint": mimic.joint, "multiplier": mimic.multiplier, "offset": mimic.offset}
        return row


def scene_nodes(tree: UrdfTree, values: Mapping[str, float], base: Floats) -> tuple[Node, ...]:
    """Return the nodes of a robot, parents first; `base` is position and quaternion x, y, z, w of the root link."""
    taken = set(tree.links)
    top = fresh_name(tree.name, taken, "", "_joint")
    taken.add(top)
    nodes = [Node(top, "", np.zeros(3), np.array(Y_UP)), Node(tree.root, top, base[:3], base[3:], link=tree.root)]
    for joint in tree.joints:
        position, quaternion = np.array(joint.origin.xyz), quat_to_xyzw(quat_from_matrix(joint.origin.matrix[:3, :3]))
        if joint.kind == "fixed":
            nodes.append(Node(joint.child, joint.parent, position, quaternion, link=joint.child))
            continue
        fixed = fresh_name(joint.name, taken, "", "_joint")
        taken.add(fixed)
        nodes.append(Node(fixed, joint.parent, position, quaternion))
        moved, turned = motion_of(joint, np.array(values[joint.name]))
        nodes.append(Node(joint.child, fixed, moved, turned, joint, joint.child))
    return tuple(nodes)


def motion_of(joint: UrdfJoint, values: Floats) -> tuple[Floats, Floats]:
    """Return position (..., 3) and quaternion x, y, z, w (..., 4) of a joint's child node at values (...)."""
    axis = np.array(joint.axis)
    if joint.kind == "prismatic":
        return values[..., None] * axis, np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*values.shape, 4))
    half = values[..., None] / 2.0
    # Not in canonical sign, because the quaternion must be continuous along a motion.
    return np.zeros((*values.shape, 3)), np.concatenate([np.sin(half) * axis, np.cos(half)], axis=-1)


# --- Visual shapes as triangles with a colour.


def _add_looks(scene: Any, tree: UrdfTree, taken: set[str]) -> tuple[dict[str, Rgba], tuple[str, ...]]:
    """Add the visual shapes of a robot to its nodes in a trimesh.Scene, with names not in `taken`.

    Returns name of a colour → colour in sRGB, and one line for each shape that cannot be read.
    """
    notes: list[str] = []
    known: dict[tuple[object, ...], list[Any]] = {}
    names: dict[tuple[object, ...], str] = {}  # of the triangles in the scene
    paints: dict[tuple[str, Rgba], str] = {}  # material and colour → a name that no other colour has
    packages = tree.packages
    for visual in tree.visuals:
        key = (visual.geometry, visual.material, visual.rgba)
        try:
            if key not in known:
                known[key] = _parts(visual.geometry, packages, notes)
                for part in known[key]:
                    _paint(part, visual.material, visual.rgba, paints)
        except UnreadableShape as reason:
            notes.append(f"a visual shape of {visual.link} is left out: {reason}")
            continue
        place = visual.origin.matrix
        for index, mesh in enumerate(known[key]):
            name = fresh_name(visual.name or f"{visual.link}_visual", taken)
            taken.add(name)
            same = names.setdefault((*key, index), name)
            if same == name:
                scene.add_geometry(mesh, name, name, parent_node_name=visual.link, transform=place)
            else:
                scene.graph.update(name, visual.link, matrix=place, geometry=same)
    return {name: rgba for (_, rgba), name in paints.items()}, tuple(dict.fromkeys(notes))


def _parts(geometry: Geometry, packages: Packages, notes: list[str]) -> list[Any]:
    """Return the meshes of a shape, each of one material; add to `notes` what is left out, or from outside."""
    import trimesh

    if isinstance(geometry, Box):
        return [trimesh.creation.box(extents=geometry.size)]
    if isinstance(geometry, Cylinder):
        return [trimesh.creation.cylinder(radius=geometry.radius, height=geometry.length, sections=48)]
    if isinstance(geometry, Sphere):
        return [trimesh.creation.icosphere(subdivisions=3, radius=geometry.radius)]
    path, left_out = geometry.path(packages), list[str]()
    try:
        loaded = read_mesh(path, lambda scene: list(scene.dump()), resolver=resolver(path, packages, left_out))
    except UnreadableShape as reason:
        raise UnreadableShape(f"its mesh {quoted(geometry.filename)} cannot be read: {reason}") from None
    notes += (*outside_note(path, packages), *left_out_note(path, left_out))
    parts = [part for part in loaded if hasattr(part, "faces")]  # not lines or points
    for part in parts:
        part.metadata.clear()  # names of files and folders
        part.apply_transform(np.diag([*geometry.scale, 1.0]))
        # A triangle without an area has no normal.
        part.update_faces(part.nondegenerate_faces())
        part.remove_unreferenced_vertices()
    parts = [part for part in parts if len(part.faces)]
    if not parts:
        raise UnreadableShape(f"its mesh {quoted(geometry.filename)} has no triangles")
    return parts


def _paint(mesh: Any, material: str, rgba: Rgba | None, paints: dict[tuple[str, Rgba], str]) -> None:
    """Give a mesh the colour of its visual shape, unless the shape has no colour and the mesh file has one."""
    import trimesh

    if rgba is None and getattr(mesh.visual, "kind", None) is not None:
        return
    key = (material, rgba or GREY)
    if key not in paints:
        paints[key] = fresh_name(material or "grey", paints.values())
    visual: Any = trimesh.visual  # not typed
    opacity = key[1][3]
    paint = visual.material.PBRMaterial(
        name=paints[key],
        baseColorFactor=[0.0, 0.0, 0.0, opacity],  # set afterwards, because trimesh rounds colours to 8 bits
        metallicFactor=0.0,
        roughnessFactor=0.6,
        alphaMode="OPAQUE" if opacity == 1.0 else "BLEND",
    )
    mesh.visual = visual.TextureVisuals(material=paint)


def linear(rgba: Rgba) -> list[float]:
    """Return an sRGB colour in glTF's linear form, proportional to light (IEC 61966-2-1), with the same opacity."""
    *rgb, opacity = rgba
    return [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in rgb] + [opacity]


# --- The numbers of an animation, added to a glTF document.
#
# Source: Khronos, glTF 2.0 specification, "Accessors".

_FLOAT = 5126
_KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


def _add_numbers(document: Any, buffers: Any, values: Floats, *, bounds: bool = False) -> int:
    """Add rows (n,), (n, 3) or (n, 4) as float32, with `bounds` for times of an animation; return the accessor."""
    rows = np.ascontiguousarray(values, dtype="<f4")
    kind, index = _KINDS[1 if rows.ndim == 1 else rows.shape[1]], len(document["accessors"])
    accessor = {"bufferView": len(buffers), "componentType": _FLOAT, "count": len(rows), "type": kind}
    if bounds:
        accessor |= {"min": [float(rows.min())], "max": [float(rows.max())]}
    document["accessors"][f"motion {index}"], buffers[f"motion {index}"] = accessor, rows.tobytes()
    return index


# --- The export.

FRAMES_PER_SECOND = 30.0
_IDENTITY = (0.0, 0.0, 0.0, 1.0)


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
    """Write a binary glTF 2.0 scene (.glb): the robot in a posture, a node for each joint, a motion as animation.

    Metres, y up. The scene's first node has the robot's name and turns z up into y up. A joint is a node with its name
    at the pose of the joint; its child is the node of the link that it moves, whose rotation or position is the joint's
    value. Axis, limits and coupling of the joint are in the node's `extras`.

    Args:
        robot: any robot.
        path: the file; its name ends in .glb.
        posture: a posture of the robot; None for its start posture, or the first configuration of the motion.
        motion: a motion, or a motion file, which becomes the animation.
        fps: poses per second in the animation; between them, glTF interpolates linearly.
        frames: as in `urdf`; frames are empty nodes.
        names: as in `urdf`.
        overwrite: replace an existing file.

    Returns:
        The file, and one line for each visual shape that cannot be read.

    Raises:
        BadArgument: another suffix, a posture together with a motion, or an existing file.

    Examples:
        >>> nod = nk.Motion([0.0, 1.0], ["HeadPitch"], [[0.0], [0.4]])
        >>> nk.export.gltf(nk.load_nao("v6"), "nod.glb", motion=nod).changes
        ()
    """
    if not str(path).lower().endswith((".glb", "/dev/stdout")):
        raise BadArgument(f"the file is a binary glTF; end its name in .glb, got {quoted(path)}")
    target = Destination(path, overwrite=overwrite)
    tree, _ = Variant(frames, names).tree_of(robot)
    moving = _trajectory(robot, motion, fps, posture)
    values = joint_values(robot, moving.q, names)
    # The pose of the root, which no motion moves.
    base = moving.q[0, :7] if robot.base == "floating" else np.array([0.0, 0.0, 0.0, *_IDENTITY])
    nodes = scene_nodes(tree, {name: float(value[0]) for name, value in values.items()}, base)
    scene, paints, notes = _scene(tree, nodes)

    def finish(buffers: Any, document: Any) -> None:
        _place(document, nodes)
        for row in document["materials"]:
            factors = row["pbrMetallicRoughness"]
            if row.get("name") in paints and not any(factors["baseColorFactor"][:3]):
                factors["baseColorFactor"] = linear(paints[row["name"]])
        if motion is not None:
            _animate(document, buffers, nodes, moving, values)
        document["asset"]["generator"] = "nao_kin, trimesh"

    import trimesh.exchange.gltf

    writer: Any = trimesh.exchange.gltf  # not typed
    content = writer.export_glb(scene, include_normals=True, buffer_postprocessor=finish)
    return target.write({"": content}, notes)


def _trajectory(robot: RobotModel, motion: Motion | Path | str | None, fps: float, posture: str | None) -> Trajectory:
    if not 0.0 < fps <= 1000.0:
        raise BadArgument(f"fps must be a number above 0 and at most 1000, got {quoted(fps)}")
    if motion is None:
        start = robot.semantics.start if posture is None else posture
        q = robot.posture(start) if start or posture is not None else robot.clamp(robot.neutral())
        return Trajectory(np.zeros(1), q[None])
    if posture is not None:
        raise BadArgument("give a posture or a motion, not both: the scene has the first configuration of the motion")
    known = motion if isinstance(motion, Motion) else read_motion(motion, robot=robot)
    return known.configurations(robot, rate=float(fps))


def _scene(tree: UrdfTree, nodes: tuple[Node, ...]) -> tuple[Any, dict[str, Rgba], tuple[str, ...]]:
    """Return the trimesh.Scene, its colours, and missing shapes; `_place` writes the poses of nodes."""
    import trimesh

    taken = {node.name for node in nodes}
    scene: Any = trimesh.Scene(base_frame=with_underscores("world", taken))
    for node in nodes:
        scene.graph.update(frame_to=node.name, frame_from=node.parent or scene.graph.base_frame, matrix=np.eye(4))
    return scene, *_add_looks(scene, tree, taken)


def _place(document: Any, nodes: tuple[Node, ...]) -> None:
    """Write position and rotation of every node of the robot instead of a matrix, so that an animation can move it."""
    by_name = {row["name"]: row for row in document["nodes"]}
    for node in nodes:
        row = by_name[node.name]
        row.pop("matrix", None)
        if any(node.position):
            row["translation"] = node.position.tolist()
        if tuple(node.quaternion) != _IDENTITY:
            row["rotation"] = node.quaternion.tolist()
        extras = node.extras()
        if extras:
            row["extras"] = extras


def _animate(
    document: Any, buffers: Any, nodes: tuple[Node, ...], moving: Trajectory, values: dict[str, Floats]
) -> None:
    places = {row["name"]: index for index, row in enumerate(document["nodes"])}
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    times = _add_numbers(document, buffers, moving.times, bounds=True)
    for node in nodes:
        if node.joint is not None and np.ptp(values[node.joint.name]) > 0.0:
            positions, quaternions = motion_of(node.joint, values[node.joint.name])
            slides = node.joint.kind == "prismatic"
            path, rows = ("translation", positions) if slides else ("rotation", quaternions)
            output = _add_numbers(document, buffers, rows)
            samplers.append({"input": times, "output": output, "interpolation": "LINEAR"})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": places[node.name], "path": path}})
    if channels:
        document["animations"] = [{"name": "motion", "samplers": samplers, "channels": channels}]
