"""A robot as a tree of scene nodes, so that the browser composes the transforms.

Every moving joint is a node with its constant placement in the parent link; the child link is a node below it whose
rotation, or translation, is the joint's. Nothing else changes, so only configurations have to be sent.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.files import URDF_FOLDERS
from nao_kin._core.text import abbreviated
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import MeshFile, Rgba, UnreadableShape, UrdfJoint, UrdfTree
from nao_kin.viewer.meshes import Mesh, Shape, lights_of, load_meshes
from nao_kin.viewer.messages import content_name, geometry_document, node_name, panel_message

ROBOT = "robot"
_GREY: Rgba = (0.75, 0.77, 0.8, 1.0)


@dataclass(frozen=True, eq=False)
class Drawable:
    """One shape of one link, in one colour and opacity, each in [0, 1]."""

    link: str
    T_link_shape: Floats
    shape: Shape
    rgba: Rgba
    light: str = ""  # name of the light, "" for other shapes

    @cached_property
    def geometry(self) -> tuple[str, bytes]:
        """A name, the same for equal shapes, and the message of the shape without colour and pose."""
        if not isinstance(self.shape, Mesh):
            return _geometry(self.shape)
        if self.shape not in _geometries:
            _geometries[self.shape] = _geometry(self.shape)
        return _geometries[self.shape]


def _geometry(shape: Shape) -> tuple[str, bytes]:
    document = geometry_document(shape)
    name = content_name(document)
    return name, panel_message("geometry", {"name": name, "geometry": document})


_geometries: WeakKeyDictionary[Mesh, tuple[str, bytes]] = WeakKeyDictionary()


def _meshes(path: Path, scale: tuple[float, float, float]) -> tuple[Mesh, ...]:
    return load_meshes(path, np.array(scale))


_own_meshes = cache(_meshes)
"""`_meshes` of files of our NAO, read once per process: the files of the package do not change."""


def robot_drawables(tree: UrdfTree) -> tuple[tuple[Drawable, ...], tuple[str, ...]]:
    """Return a robot's visuals with their meshes loaded, one per colour and light, and notes on missing ones."""
    found: list[Drawable] = []
    missing: list[str] = []
    notes: list[str] = []
    loaded: dict[tuple[Path, tuple[float, ...]], tuple[Mesh, ...]] = {}
    packages, own = tree.packages, set(URDF_FOLDERS)
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
                read = _own_meshes if own.intersection(path.parents) else _meshes
                loaded[path, geometry.scale] = read(path, geometry.scale)
        except UnreadableShape as reason:
            notes.append(f"a visual of {abbreviated(visual.link)} is not shown: {path.name}: {reason}")
            continue
        for mesh in loaded[path, geometry.scale]:
            rgba = visual.rgba or mesh.colour or _GREY
            for name, part in (lights_of(geometry.filename, mesh) or {"": mesh}).items():
                found.append(Drawable(visual.link, T_link_shape, part, rgba, name))
    if missing:
        more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
        notes.insert(0, f"mesh files not found: {abbreviated(missing[0])}{more}")
    return tuple(found), (*notes, *tree.visual_notes)


def carriers(tree: UrdfTree, shown: Iterable[Drawable]) -> dict[str, str]:
    """Return link without a shape → nearest link with a shape that carries it through fixed joints alone."""
    seen = {drawable.link for drawable in shown}
    found: dict[str, str] = {}
    for joint in tree.joints:
        if joint.kind == "fixed" and joint.child not in seen:
            carrier = joint.parent if joint.parent in seen else found.get(joint.parent)
            if carrier is not None:
                found[joint.child] = carrier
    return found


def link_paths(tree: UrdfTree) -> dict[str, str]:
    """Return the path of every link's node, parents first."""
    paths = {tree.root: f"{ROBOT}/{node_name('link', tree.root)}"}
    for joint in tree.joints:
        paths[joint.child] = f"{holder(paths, joint)}/{node_name('link', joint.child)}"
    return paths


@dataclass(frozen=True)
class Driver:
    """The coordinate that moves a joint: its value is multiplier · q[column] + offset [rad or m]."""

    column: int
    multiplier: float = 1.0
    offset: float = 0.0
    follows: str = ""  # the driving joint of a mimic joint, otherwise ""

    def values(self, q: Floats) -> Floats:
        """Return the joint's values in configurations, shape (..., nq)."""
        return np.asarray(self.multiplier * q[..., self.column] + self.offset)


def drivers_of(robot: RobotModel) -> dict[str, Driver]:
    """Return the driver of each joint of a robot, by name."""
    own = {name: Driver(column) for column, name in enumerate(robot.joint_names, robot.nq_base)}
    return own | {
        name: Driver(own[mimic.joint].column, mimic.multiplier, mimic.offset, mimic.joint)
        for name, mimic in robot.mimics.items()
    }


def numbered(drawables: Iterable[Drawable]) -> Iterator[tuple[int, Drawable]]:
    """Yield the drawables with their indices among those of their link."""
    count: dict[str, int] = {}
    for drawable in drawables:
        count[drawable.link] = index = count.get(drawable.link, -1) + 1
        yield index, drawable


def holder(paths: Mapping[str, str], joint: UrdfJoint) -> str:
    """Return the node of the child link: the joint's own, or for a fixed joint the parent link's."""
    parent = paths[joint.parent]
    return parent if joint.kind == "fixed" else f"{parent}/{node_name('joint', joint.name)}"
