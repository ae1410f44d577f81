"""A robot as a tree of scene nodes, so that the browser composes the transforms.

Every moving joint is a node with its fixed placement in the link that carries it; the link it moves is a child of that
node whose rotation, or translation, is the joint's. Nothing else ever changes, so a configuration is all that has to
be sent.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

from nao_kin._core.arrays import Floats, join_poses
from nao_kin._core.text import abbreviated
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import MeshFile, Rgba, UnreadableShape, UrdfJoint, UrdfTree
from nao_kin.rotations import exp
from nao_kin.viewer.meshes import Mesh, Shape, lights_of, load_meshes, shape_box
from nao_kin.viewer.messages import Command, node_name, set_object, set_transform

ROBOT = "robot"
# What the names of our NAO's meshes end in that its editions differ by.
_ACCENT = "_accent"
_GREY: Rgba = (0.75, 0.77, 0.8, 1.0)


@dataclass(frozen=True, eq=False)
class Drawable:
    """One shape of one link, in one colour.

    Attributes:
        link: name of the link.
        T_link_shape: pose of the shape in the link's frame.
        shape: what it is.
        rgba: its colour and opacity, each in [0, 1].
        light: name of the light that it is; "" for none.
        accent: whether its colour differs between the editions of our NAO.
    """

    link: str
    T_link_shape: Floats
    shape: Shape
    rgba: Rgba
    light: str = ""
    accent: bool = False


def robot_drawables(tree: UrdfTree) -> tuple[tuple[Drawable, ...], tuple[str, ...]]:
    """The visuals of a robot with their mesh files loaded, and a line for each not shown.

    There is one drawable per colour, and one per light.
    """
    found: list[Drawable] = []
    missing: list[str] = []
    notes: list[str] = []
    loaded: dict[tuple[Path, tuple[float, ...]], tuple[Mesh, ...]] = {}
    packages = tree.packages
    for visual in tree.visuals:
        T_link_shape, geometry = visual.origin.matrix, visual.geometry
        if not isinstance(geometry, MeshFile):
            found.append(Drawable(visual.link, T_link_shape, geometry, visual.rgba or _GREY))
            continue
        path = packages.file(geometry.filename)
        if path is None:
            missing.append(geometry.filename)
            continue
        try:
            if (path, geometry.scale) not in loaded:
                loaded[path, geometry.scale] = load_meshes(path, np.array(geometry.scale))
        except UnreadableShape as reason:
            notes.append(f"a visual of {abbreviated(visual.link)} is not shown: {path.name}: {reason}")
            continue
        for mesh in loaded[path, geometry.scale]:
            rgba = visual.rgba or mesh.colour or _GREY
            accent = PurePosixPath(geometry.filename).stem.endswith(_ACCENT)
            for name, part in (lights_of(geometry.filename, mesh) or {"": mesh}).items():
                found.append(Drawable(visual.link, T_link_shape, part, rgba, name, accent))
    if missing:
        more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
        notes.insert(0, f"mesh files not found: {abbreviated(missing[0])}{more}")
    return tuple(found), (*notes, *tree.visual_notes)


def carriers(tree: UrdfTree, shown: Iterable[Drawable]) -> dict[str, str]:
    """Link without a shape → the nearest link with one that carries it through fixed joints alone."""
    seen = {drawable.link for drawable in shown}
    found: dict[str, str] = {}
    for joint in tree.joints:
        if joint.kind == "fixed" and joint.child not in seen:
            carrier = joint.parent if joint.parent in seen else found.get(joint.parent)
            if carrier is not None:
                found[joint.child] = carrier
    return found


def link_paths(tree: UrdfTree) -> dict[str, str]:
    """Path of every link's node, parents first."""
    paths = {tree.root: f"{ROBOT}/{node_name('link', tree.root)}"}
    for joint in tree.joints:
        paths[joint.child] = f"{_holder(paths, joint)}/{node_name('link', joint.child)}"
    return paths


@dataclass(frozen=True)
class Driver:
    """What moves a joint: its value is multiplier · q[column] + offset.

    Attributes:
        column: place of the coordinate in q.
        multiplier: of the coordinate.
        offset: added to it [rad or m].
        follows: the joint that it follows, "" for none.
    """

    column: int
    multiplier: float = 1.0
    offset: float = 0.0
    follows: str = ""

    def values(self, q: Floats) -> Floats:
        """The joint's values in configurations, shape (..., nq)."""
        return np.asarray(self.multiplier * q[..., self.column] + self.offset)


def drivers_of(robot: RobotModel) -> dict[str, Driver]:
    """What moves each joint of a robot, by the joint's name."""
    first = robot.nq - len(robot.joint_names)
    own = {name: Driver(first + index) for index, name in enumerate(robot.joint_names)}
    return own | {
        name: Driver(own[mimic.joint].column, mimic.multiplier, mimic.offset, mimic.joint)
        for name, mimic in robot.mimics.items()
    }


def scene_commands(
    robot: RobotModel, drawables: tuple[Drawable, ...], *, under: str = "", opacity: float = 1.0
) -> Iterator[tuple[str, Command]]:
    """Key and command of everything that stands still: placements and shapes.

    Args:
        robot: the robot.
        drawables: its shapes.
        under: path of the node that carries its root's node, with a slash; "" for the scene.
        opacity: factor for that of every shape.
    """
    paths = {link: f"{under}{path}" for link, path in link_paths(robot.tree).items()}
    for joint, T_parent_joint in _placements(robot):
        path = paths[joint.child] if joint.kind == "fixed" else _holder(paths, joint)
        yield f"place {path}", set_transform(path, T_parent_joint)
    for index, drawable in numbered(drawables):
        path = f"{paths[drawable.link]}/visual:{index}"
        red, green, blue, alpha = drawable.rgba
        yield f"shape {path}", set_object(path, drawable.shape, (red, green, blue, opacity * alpha))
        yield f"place {path}", set_transform(path, drawable.T_link_shape)


def numbered(drawables: Iterable[Drawable]) -> Iterator[tuple[int, Drawable]]:
    """Drawables with their numbers among those of their link."""
    count: dict[str, int] = {}
    for drawable in drawables:
        count[drawable.link] = index = count.get(drawable.link, -1) + 1
        yield index, drawable


def width(robot: RobotModel, drawables: Iterable[Drawable], q: Floats) -> float:
    """How far to the left or right of its root's frame a robot reaches with its shapes [m]."""
    poses = dict(zip(robot.link_names, robot.fk(q), strict=True))
    most = 0.0
    for drawable in drawables:
        T = poses[drawable.link] @ drawable.T_link_shape
        low, high = shape_box(drawable.shape)
        middle, half = T[:3, :3] @ ((low + high) / 2.0) + T[:3, 3], np.abs(T[:3, :3]) @ ((high - low) / 2.0)
        most = max(most, abs(middle[1]) + half[1])
    return float(most)


def motion(joint: UrdfJoint, value: float) -> Floats:
    """What a joint value does: the pose of the moved link in the joint's node."""
    along = value * np.array(joint.axis)
    if joint.kind == "prismatic":
        return join_poses(np.eye(3), along)
    return join_poses(exp(along) if joint.kind == "revolute" else np.eye(3), np.zeros(3))


def _holder(paths: dict[str, str], joint: UrdfJoint) -> str:
    """The node that holds the moved link: the joint's own, or for a fixed joint the carrying link itself."""
    parent = paths[joint.parent]
    return parent if joint.kind == "fixed" else f"{parent}/{node_name('joint', joint.name)}"


def _placements(robot: RobotModel) -> Iterator[tuple[UrdfJoint, Floats]]:
    """T_parent_joint of every joint, from the model's own forward kinematics: what was calibrated stays calibrated."""
    poses = dict(zip(robot.link_names, robot.fk(robot.neutral()), strict=True))
    for joint in robot.tree.joints:
        mimic = robot.mimics.get(joint.name)
        moved = motion(joint, mimic.offset if mimic is not None else 0.0)
        yield joint, np.linalg.solve(poses[joint.parent], poses[joint.child]) @ np.linalg.inv(moved)
