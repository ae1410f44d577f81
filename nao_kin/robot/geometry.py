"""The shapes of a robot's links: their mesh files, and as Pinocchio and its collision library coal have them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path, PurePath
from typing import Any, Literal, TypeVar

import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import choice
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import MissingShapeWarning
from nao_kin.robot.kinematics import FrameTable
from nao_kin.robot.urdf import Box, Cylinder, Geometry, MeshFile, Packages, Sphere, UnreadableShape, UrdfTree, Visual

Made = TypeVar("Made")
GeometryKind = Literal["visual", "collision"]
KINDS: tuple[GeometryKind, ...] = ("visual", "collision")

# Mesh files that Pinocchio's visualizers read themselves, with the scale of their object. They draw any other mesh from
# the triangles that coal has read, which are scaled already.
_READ_BY_VISUALIZERS = (".dae", ".obj", ".stl")
# The colour that Pinocchio gives to a shape without one.
_GREY = (0.9, 0.9, 0.9, 1.0)


def shape_geometry(shape: Geometry, packages: Packages) -> Any:
    """Return a shape of a URDF as coal's geometry.

    Args:
        shape: a box, cylinder or sphere, or the name of a mesh file.
        packages: the search for that file.

    Raises:
        UnreadableShape: the mesh file is missing or cannot be read.
    """
    import coal

    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius)
    path = mesh_path(shape, packages)
    try:
        return coal.MeshLoader().load(str(path), np.array(shape.scale))
    except (RuntimeError, ValueError) as error:
        raise UnreadableShape(f"its mesh {quoted(shape.filename)} cannot be read: {abbreviated(error)}") from None


def mesh_path(mesh: MeshFile, packages: Packages) -> Path:
    """Return the file of a mesh.

    Raises:
        UnreadableShape: it is not there.
    """
    path = packages.file(mesh.filename)
    if path is None:
        raise UnreadableShape(f"its mesh {quoted(mesh.filename)} is not there")
    return path


def read_mesh(path: Path, made_of: Callable[[Any], Made], **options: Any) -> Made:
    """Return what `made_of` makes of the triangles of a mesh file.

    Args:
        path: any mesh file that trimesh reads.
        made_of: called with a `trimesh.Scene` that holds triangles, as the file has them.
        **options: of `trimesh.load_scene`; "resolver" finds the files that the mesh names.

    Raises:
        UnreadableShape: the file cannot be read or has no triangles, or `made_of` has failed.
    """
    import trimesh

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(path, process=False, **options)
            if not any(len(getattr(part, "faces", ())) for part in scene.geometry.values()):
                raise UnreadableShape("no triangles in it")
            return made_of(scene)
    except Exception as error:  # whatever its many readers raise on a bad file
        raise UnreadableShape(abbreviated(error) or type(error).__name__) from None


def geometry_model(model: pin.Model, frames: FrameTable, tree: UrdfTree, kind: GeometryKind) -> pin.GeometryModel:
    """Return the shapes of a robot as a `GeometryModel`.

    The objects are named as Pinocchio's own parser names them: the link and the number among its shapes of this kind.

    Args:
        model: the robot's model, which places the links.
        frames: its frames by name.
        tree: the URDF as read.
        kind: "visual" or "collision".

    Raises:
        UnknownName: no such kind.

    Warns:
        MissingShapeWarning: some shapes are left out, because their meshes are missing or cannot be read.
    """
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
    if notes:
        more = f" (and {len(notes) - 1} more)" if len(notes) > 1 else ""
        warn_caller(f"{tree.name}: {notes[0]}{more}", MissingShapeWarning)
    return geometry
