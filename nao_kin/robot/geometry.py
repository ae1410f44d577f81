"""The shapes of a robot's links: mesh files, and geometry for Pinocchio and its collision library coal."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path, PurePath
from typing import Any, Literal, TypeVar

import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import choice
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import MissingShapeWarning
from nao_kin.robot.kinematics import FrameTable
from nao_kin.robot.urdf import (
    Box,
    Collision,
    Cylinder,
    Geometry,
    MeshFile,
    Packages,
    Sphere,
    UnreadableShape,
    UrdfTree,
    Visual,
)

Made = TypeVar("Made")
GeometryKind = Literal["visual", "collision"]
KINDS: tuple[GeometryKind, ...] = ("visual", "collision")

# Pinocchio's visualizers read and scale mesh files with these suffixes. They draw any other mesh from the triangles
# that coal has read, which are already scaled.
_READ_BY_VISUALIZERS = (".dae", ".obj", ".stl")
# The colour that Pinocchio gives to a shape without one.
_GREY = (0.9, 0.9, 0.9, 1.0)


def shape_geometry(shape: Geometry, packages: Packages) -> Any:
    """Return a shape of a URDF as coal's geometry; raise `UnreadableShape` for a mesh that is missing or unreadable."""
    import coal

    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius)
    path = shape.path(packages)
    try:
        return coal.MeshLoader().load(str(path), np.array(shape.scale))
    except (RuntimeError, ValueError) as error:
        raise UnreadableShape(f"its mesh {quoted(shape.filename)} cannot be read: {abbreviated(error)}") from None


# Largest difference of a capsule's cap from its cylinder's end, in centre and radius [m].
_SAME = 1e-6


def capsules(shapes: Sequence[Visual | Collision]) -> dict[int, tuple[int, int]]:
    """Return index of each cylinder that is a capsule → indices of its caps, spheres of its radius at its ends."""
    found = {}
    spheres = [index for index, shape in enumerate(shapes) if isinstance(shape.geometry, Sphere)]
    for index, shape in enumerate(shapes):
        if isinstance(shape.geometry, Cylinder):
            T, caps = shape.origin.matrix, []
            for sign in (-0.5, 0.5):
                end = T[:3, 3] + sign * shape.geometry.length * T[:3, 2]
                caps += [
                    other
                    for other in spheres
                    if shapes[other].link == shape.link
                    and abs(shapes[other].geometry.radius - shape.geometry.radius) < _SAME  # type: ignore[union-attr]
                    and np.abs(np.array(shapes[other].origin.xyz) - end).max() < _SAME
                ][:1]
            if len(caps) == 2:
                found[index] = caps[0], caps[1]
    return found


def read_mesh(path: Path, convert: Callable[[Any], Made], **options: Any) -> Made:
    """Return `convert(scene)` for the triangles of a mesh file, read by `trimesh.load_scene(path, **options)`."""
    import trimesh

    _leave_log_to_others()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(path, process=False, **options)
            if not any(len(getattr(part, "faces", ())) for part in scene.geometry.values()):
                raise UnreadableShape("no triangles in it")
            return convert(scene)
    except Exception as error:  # trimesh's readers raise errors of many types for a bad file
        raise UnreadableShape(abbreviated(error) or type(error).__name__) from None


@functools.cache
def _leave_log_to_others() -> None:
    """Keep Python from printing what trimesh logs about parts of a file that it can do without."""
    import logging

    logging.getLogger("trimesh").addHandler(logging.NullHandler())


def geometry_model(model: pin.Model, frames: FrameTable, tree: UrdfTree, kind: GeometryKind) -> pin.GeometryModel:
    """Return the shapes of a robot's links as a Pinocchio `GeometryModel`, with the names of Pinocchio's parser."""
    choice(kind, KINDS, "kind of geometry")
    geometry, packages = pin.GeometryModel(), tree.packages
    notes = list(tree.visual_notes if kind == "visual" else tree.collision_notes)
    count: dict[str, int] = {}
    for row in tree.visuals if kind == "visual" else tree.collisions:
        number = count[row.link] = count.get(row.link, -1) + 1
        try:
            shape = shape_geometry(row.geometry, packages)
        except UnreadableShape as reason:
            notes.append(f"a {kind} shape of {abbreviated(row.link)} is left out: {reason}")
            continue
        frame_id = frames.id(row.link)
        link = model.frames[frame_id]
        T_link_shape = pin.SE3(row.origin.matrix)
        name = f"{row.link}_{number}"
        placed = pin.GeometryObject(name, link.parentJoint, frame_id, link.placement * T_link_shape, shape)
        if isinstance(row.geometry, MeshFile):
            path = str(packages.file(row.geometry.filename))
            if PurePath(path).suffix.lower() in _READ_BY_VISUALIZERS:
                placed.meshPath, placed.meshScale = path, np.array(row.geometry.scale)
        colour = row.rgba if isinstance(row, Visual) else None
        placed.meshColor, placed.overrideMaterial = np.array(colour or _GREY), colour is not None
        geometry.addGeometryObject(placed)
    warn_of_shapes(tree, notes)
    return geometry


def warn_of_shapes(tree: UrdfTree, notes: Sequence[str]) -> None:
    """Warn of shapes that are left out, if there are notes on such shapes."""
    if notes:
        more = f" (and {len(notes) - 1} more)" if len(notes) > 1 else ""
        warn_caller(f"{tree.name}: {notes[0]}{more}", MissingShapeWarning)
