"""The shapes of a robot's links: mesh files, and geometry and hulls for Pinocchio and its collision library coal."""

from __future__ import annotations

import contextlib
import functools
import io
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path, PurePath
from typing import IO, Any, Literal, TypeVar
from xml.etree import ElementTree as ET

import coal
import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import Floats, choice, join_poses
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import MissingShapeWarning
from nao_kin.robot.build import FrameTable
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


# --- The shapes for collisions: hulls, balls and capsules.

# Sides of the prism around a cylinder: it is larger by 0.5 % of the radius.
_SIDES = 32
# Hulls flatter than this, or than this share of their extent, have no volume [m, 1]: in coal they end the process.
_THIN = 1e-6


@dataclass(frozen=True, eq=False)
class Shape:
    """A shape of a link: coal's geometry and its pose in the link, and points whose hull, grown, contains it [m].

    The hull grown by the radius is the shape, except for a flat-ended cylinder (two points) and a concave mesh.
    """

    link: str
    points: Floats  # one with a radius is a ball, two a capsule; a hull of more has no radius
    radius: float
    geometry: Any
    T_link_geometry: Floats
    triangles: tuple[Any, Floats] | None = None  # coal's mesh of which `geometry` is the hull, if it counts; its pose
    parts: tuple[Shape, ...] = ()  # shapes of other links, such as fingers, inside this one; if given, they count


def round_shape(link: str, ends: Floats, radius: float) -> Shape:
    """Return a ball, or a capsule: its ends in the link, shape (2, 3), and its radius [m]."""
    T, along = np.eye(4), ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    T[:3, 3] = 0.5 * (ends[0] + ends[1])
    if length <= _THIN:
        return Shape(link, T[None, :3, 3], radius + 0.5 * length, coal.Sphere(radius + 0.5 * length), T)
    axes = np.linalg.svd(along[None])[2][[1, 2, 0]].T
    T[:3, :3] = np.linalg.det(axes) * axes
    return Shape(link, ends, radius, coal.Capsule(radius, length), T)


def hull_shape(link: str, points: Floats) -> Shape:
    """Return the convex hull of points in a link, shape (n, 3) [m]: the only way to coal's hulls.

    Points in a plane, on a line or in one point get a thickness of 2 µm, or of 2 millionths of their extent.
    """
    centre = check_points(points).mean(axis=0)
    local, extent = points - centre, float(np.ptp(points, axis=0).max())
    axes = np.linalg.svd(np.concatenate([local, np.zeros((3, 3))]), full_matrices=False)[2]
    thin = _THIN * max(1.0, extent)
    flat = [axis for axis in axes if np.ptp(local @ axis) < thin]
    if flat:
        local = np.unique(local, axis=0)
    elif np.abs(centre).max() < extent:  # a more distant origin costs qhull its digits
        local, centre = points, np.zeros(3)
    for axis in flat:
        local = np.concatenate([local - thin * axis, local + thin * axis])
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(0, 0)
    mesh.addVertices(local)
    mesh.endModel()
    mesh.buildConvexHull(True, "Qt Pp")  # Pp: coal gives qhull no file for its warnings, and that ends the process
    corners = np.array(mesh.convex.points()).reshape(-1, 3) + centre
    return Shape(link, corners, 0.0, mesh.convex, join_poses(np.eye(3), centre))


def exact_shape(link: str, T: Floats, shape: Geometry, tree: UrdfTree) -> Shape:
    """Return a box, a cylinder with flat ends, or a mesh with its triangles; T is the pose in the link."""
    geometry, radius = shape_geometry(shape, tree.packages), 0.0
    if isinstance(shape, MeshFile):
        corners = np.array(geometry.vertices()) @ T[:3, :3].T + T[:3, 3]
        return replace(hull_shape(link, corners), triangles=(geometry, T))
    if isinstance(shape, Cylinder):
        points, radius = np.array([[0.0, 0.0, -0.5 * shape.length], [0.0, 0.0, 0.5 * shape.length]]), shape.radius
    else:
        points = hull_corners(shape, tree.packages)
    return Shape(link, points @ T[:3, :3].T + T[:3, 3], radius, geometry, T)


def _hull_of(link: str, T: Floats, shape: Geometry, tree: UrdfTree) -> Shape:
    return hull_shape(link, hull_corners(shape, tree.packages) @ T[:3, :3].T + T[:3, 3])


def shapes_of(tree: UrdfTree) -> Iterator[Shape]:
    """Yield the hulls of the collision shapes of a tree, or else of the visual ones; warn of those left out."""
    notes = list(tree.collision_notes if tree.collisions else (*tree.collision_notes, *tree.visual_notes))
    yield from link_shapes_of(tree.collisions or tree.visuals, tree, _hull_of, notes)
    warn_of_shapes(tree, notes)


def link_shapes_of(
    rows: tuple[Visual | Collision, ...], tree: UrdfTree, make: Callable[..., Shape], notes: list[str]
) -> Iterator[Shape]:
    """Yield the shapes of rows, with capsules joined; add a note for each that cannot be read."""
    round_ended = capsules(rows)
    caps = {cap for both in round_ended.values() for cap in both}
    for index, row in enumerate(rows):
        T, shape = row.origin.matrix, row.geometry
        if index in caps:
            continue
        try:
            check_points(T[None, :3, 3])
            if isinstance(shape, Sphere) or index in round_ended:
                check_size(shape)  # type: ignore[arg-type]
                half = 0.5 * shape.length * T[:3, 2] if isinstance(shape, Cylinder) else np.zeros(3)
                yield round_shape(row.link, np.array([T[:3, 3] - half, T[:3, 3] + half]), shape.radius)  # type: ignore[union-attr]
            else:
                yield make(row.link, T, shape, tree)
        except UnreadableShape as reason:
            kind = "visual" if isinstance(row, Visual) else "collision"
            notes.append(f"a {kind} shape of {abbreviated(row.link)} is left out: {reason}")


def hull_corners(shape: Geometry, packages: Packages) -> Floats:
    """Return points whose hull is a box or a mesh, or contains a cylinder."""
    if isinstance(shape, MeshFile):
        corners = read_mesh(shape.path(packages), lambda scene: np.array(scene.to_mesh().vertices))
        return check_points(corners * np.array(shape.scale), f"its mesh {quoted(shape.filename)}")
    check_size(shape)
    if isinstance(shape, Box):
        return np.array(list(product((-0.5, 0.5), repeat=3))) * shape.size
    assert isinstance(shape, Cylinder)
    angles = 2.0 * np.pi / _SIDES * np.arange(_SIDES)
    x, y = shape.radius / np.cos(np.pi / _SIDES) * np.array([np.cos(angles), np.sin(angles)])
    return np.concatenate(
        [np.column_stack([x, y, np.full(_SIDES, z)]) for z in (-0.5 * shape.length, 0.5 * shape.length)]
    )


def hulls_in(text: str, version: str) -> Iterator[Shape]:
    """Yield the shapes of an OBJ file: the hull of each object, in the link after which it is named ("torso.2").

    "l_wrist.Fingers.LThumb1_link" is a part of the object "l_wrist.Fingers", in the link LThumb1_link. "LBicep@v3.2"
    replaces the object "LBicep" in that version.
    """
    hulls, parts = dict[str, Shape](), defaultdict[str, list[Shape]](list)
    for block in text.split("\no ")[1:]:
        header, *lines = block.splitlines()
        name, _, only = header.partition("@")
        if only not in ("", version):
            continue
        points = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)
        owner, *others = name.split(".")
        if len(others) == 2:
            parts[f"{owner}.{others[0]}"].append(hull_shape(others[1], points))
        else:
            hulls[name] = hull_shape(owner, points)
    yield from (replace(shape, parts=tuple(parts[name])) for name, shape in hulls.items())


def covering_capsule(points: Floats) -> tuple[Floats, float]:
    """Return ends (2, 3) and radius of a capsule that contains points (n, 3), along their longest principal axis."""
    if len(points) <= 2:
        return points[[0, -1]], 0.0
    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2].T[:, ::-1]
    low, high = (points @ axes).min(axis=0), (points @ axes).max(axis=0)
    local = points @ axes - (low + high) / 2.0
    across = np.linalg.norm(local[:, :2], axis=1)
    radius = float(across.max())
    # Each point is within the radius of the segment if this reaches so far along the axis.
    half = max(float((np.abs(local[:, 2]) - np.sqrt(np.maximum(radius**2 - across**2, 0.0))).max()), 0.0)
    centre = axes @ (low + high) / 2.0
    return np.array([centre - half * axes[:, 2], centre + half * axes[:, 2]]), radius
