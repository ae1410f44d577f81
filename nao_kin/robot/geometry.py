"""The shapes of a robot's links: mesh files, and geometry for Pinocchio and its collision library coal."""

from __future__ import annotations

import contextlib
import functools
import io
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path, PurePath
from typing import IO, Any, Literal, TypeVar
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import Floats, choice
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
from nao_kin.robot.urdf.tree import mesh_unit

Made = TypeVar("Made")
GeometryKind = Literal["visual", "collision"]
KINDS: tuple[GeometryKind, ...] = ("visual", "collision")

# Pinocchio's visualizers read and scale mesh files with these suffixes. They draw any other mesh from the triangles
# of the geometry, which are already scaled, also by the unit of the file.
_READ_BY_VISUALIZERS = (".dae", ".obj", ".stl")
# coal reads these without the seconds that trimesh takes to load, and refuses what is wrong in them. Other formats end
# its process: a PLY whose triangles name corners that do not exist, a COLLADA node inside itself.
_READ_BY_COAL = (".obj", ".stl")
# Larger or more distant shapes are errors of the file: they end the process in coal, or give wrong distances [m].
LARGEST = 1e6
# The colour that Pinocchio gives to a shape without one.
_GREY = (0.9, 0.9, 0.9, 1.0)


def shape_geometry(shape: Geometry, packages: Packages) -> Any:
    """Return a shape of a URDF as coal's geometry; raise `UnreadableShape` for one that coal must not get."""
    import coal

    if not isinstance(shape, MeshFile):
        check_size(shape)
        if isinstance(shape, Box):
            return coal.Box(*shape.size)
        return coal.Cylinder(shape.radius, shape.length) if isinstance(shape, Cylinder) else coal.Sphere(shape.radius)
    path, scale = shape.path(packages), np.array(shape.scale)
    if path.suffix.lower() in _READ_BY_COAL:
        with contextlib.suppress(RuntimeError, ValueError, UnreadableShape):  # trimesh is less strict, and may read it
            mesh = coal.MeshLoader().load(str(path), scale)
            check_points(np.array(mesh.vertices()))
            return mesh
    try:
        return read_mesh(path, lambda scene: _coal_mesh(scene.to_mesh(), scale))
    except UnreadableShape as reason:
        raise UnreadableShape(f"its mesh {quoted(shape.filename)} cannot be read: {reason}") from None


def _coal_mesh(mesh: Any, scale: Floats) -> Any:
    import coal

    points, triangles = check_points(np.array(mesh.vertices) * scale), np.array(mesh.faces, dtype=np.int64)
    made = coal.BVHModelOBBRSS()
    made.beginModel(len(triangles), len(points))
    made.addVertices(points)
    made.addTriangles(triangles)
    made.endModel()
    return made


def check_size(shape: Box | Cylinder | Sphere) -> None:
    """Raise `UnreadableShape` for lengths of a shape that are negative, not finite or too large."""
    lengths = shape.size if isinstance(shape, Box) else tuple(vars(shape).values())
    if not all(0.0 <= length < LARGEST for length in lengths):
        raise UnreadableShape(f"{type(shape).__name__.lower()} of {' × '.join(f'{length:g}' for length in lengths)} m")


def check_points(points: Floats, what: str = "it") -> Floats:
    """Return points (n, 3); raise `UnreadableShape` if there are none, or one is not finite or too far away."""
    if not len(points):
        raise UnreadableShape(f"{what} has no vertices")
    if not (np.abs(points) < LARGEST).all():
        raise UnreadableShape(f"{what} has vertices that are not finite, or too far away")
    return points


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
    """Return `convert(scene)` for the triangles of a mesh file in metres, read by `trimesh.load_scene`.

    `options` are those of `load_scene`. The unit of the file scales the scene (`mesh_unit`); the axis that points up in
    it does not turn the scene, as in RViz.
    """
    import trimesh

    _leave_log_to_others()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            unit = mesh_unit(path)
            scene: Any = trimesh.load_scene(path, process=False, **options)
            if not _triangles(scene) and path.suffix.lower() == ".dae":
                scene = trimesh.load_scene(_without_materials(path), file_type="dae", process=False)
            parts = _triangles(scene)
            if not parts:
                raise UnreadableShape("no triangles in it")
            if any(part.faces.min() < 0 or part.faces.max() >= len(part.vertices) for part in parts):
                raise UnreadableShape("a triangle has a corner that does not exist")
            if unit != 1.0:
                scene.apply_transform(np.diag([unit, unit, unit, 1.0]))
            return convert(scene)
    except Exception as error:  # trimesh's readers raise errors of many types for a bad file
        raise UnreadableShape(abbreviated(error) or type(error).__name__) from None


def _triangles(scene: Any) -> list[Any]:
    return [part for part in scene.geometry.values() if len(getattr(part, "faces", ()))]


def _without_materials(path: Path) -> IO[bytes]:
    """Return a COLLADA file without materials: pycollada drops the shapes whose materials it cannot find."""
    document = ET.parse(path).getroot()
    for parent in list(document.iter()):
        for child in [child for child in parent if child.tag.endswith("}bind_material")]:
            parent.remove(child)
    return io.BytesIO(ET.tostring(document))


def unit_notes(tree: UrdfTree) -> tuple[str, ...]:
    """Return one line for each unit other than the metre in the mesh files of a robot."""
    names: dict[float, dict[str, None]] = {}
    rows: tuple[Visual | Collision, ...] = (*tree.visuals, *tree.collisions)
    for mesh in dict.fromkeys(row.geometry for row in rows if isinstance(row.geometry, MeshFile)):
        if (unit := mesh.unit(tree.packages)) != 1.0:
            names.setdefault(unit, {})[PurePath(mesh.filename).name] = None
    return tuple(
        f"meshes scaled by {unit:g}, the unit in their files [m]: {abbreviated(', '.join(files), 100)}"
        for unit, files in names.items()
    )


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
            path = row.geometry.path(packages)
            if path.suffix.lower() in _READ_BY_VISUALIZERS and mesh_unit(path) == 1.0:
                placed.meshPath, placed.meshScale = str(path), np.array(row.geometry.scale)
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
