"""Mesh files as arrays for drawing, and the lights among them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.robot import read_mesh
from nao_kin.robot.urdf import Box, Cylinder, Rgba, Sphere, UnreadableShape

# Neighbouring faces that meet at less than this angle are one smooth surface [rad].
_CREASE = np.radians(40.0)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one colour."""

    vertices: Floats  # in the frame of the file, shape (n, 3) [m]
    normals: Floats  # unit vectors, shape (n, 3)
    faces: NDArray[np.uint32]  # rows of `vertices` at the corners, shape (m, 3)
    colour: Rgba | None = None  # in the file


Shape = Box | Cylinder | Sphere | Mesh


def shape_box(shape: Shape) -> tuple[Floats, Floats]:
    """Return the least and the greatest coordinates of a shape in its own frame, shape (3,) each."""
    if isinstance(shape, Mesh):
        return shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    if isinstance(shape, Box):
        half = np.array(shape.size) / 2.0
    elif isinstance(shape, Cylinder):
        half = np.array([shape.radius, shape.radius, shape.length / 2.0])
    else:
        half = np.full(3, shape.radius)
    return -half, half


def load_meshes(path: Path, scale: Floats) -> tuple[Mesh, ...]:
    """Return the triangles of a file, one mesh per colour, scaled along the axes; mirrored faces point outwards."""

    def parts_of(scene: Any) -> list[Mesh]:
        # Normals in the file determine the smooth edges, otherwise the angle between faces.
        return list(_parts(scene, path.suffix.lower() == ".obj" and b"\nvn " in path.read_bytes()))

    parts = read_mesh(path, parts_of)
    if not parts:
        raise UnreadableShape("no triangles in it")
    return tuple(_scaled(mesh, scale) for mesh in _by_colour(parts))


def mesh_of(vertices: Floats, faces: NDArray[np.uint32]) -> Mesh:
    """Return a mesh from arrays, smooth at small angles; raise UnreadableShape if no triangle has an area."""
    from trimesh import Trimesh

    part = _split_at_creases(Trimesh(vertices, faces, process=False))
    if not len(part.faces):
        raise UnreadableShape("no triangle has an area")
    rows = np.asarray(part.vertices, dtype=np.float64)
    return Mesh(rows, _turned(_area_normals(part), np.eye(3)), np.asarray(part.faces, dtype=np.uint32))


def pieces(mesh: Mesh) -> tuple[Mesh, ...]:
    """Return the connected parts of a mesh, in the order of their first triangles."""
    _, point = np.unique(mesh.vertices, axis=0, return_inverse=True)  # an edge has separate vertices for each face
    corners = point.reshape(-1)[mesh.faces]
    labels = np.arange(len(mesh.vertices))
    while True:  # each triangle gives its points the lowest label among them, until nothing changes
        lowest = labels[corners].min(axis=1)
        lower = labels.copy()
        np.minimum.at(lower, corners, lowest[:, None])
        if np.array_equal(lower, labels):
            break
        labels = lower[lower]
    found = []
    for label in dict.fromkeys(lowest.tolist()):
        used, faces = np.unique(mesh.faces[lowest == label], return_inverse=True)
        found.append(Mesh(mesh.vertices[used], mesh.normals[used], faces.reshape(-1, 3).astype(np.uint32), mesh.colour))
    return tuple(found)


def _parts(scene: Any, has_normals: bool) -> Iterator[Mesh]:
    for node in scene.graph.nodes_geometry:
        T_file_part, name = scene.graph[node]
        part = scene.geometry[name]
        if not hasattr(part, "faces") or not len(part.faces) or not np.isfinite(part.vertices[part.faces]).all():
            continue
        colour = _colour(part)
        if has_normals:
            normals = np.asarray(part.vertex_normals, dtype=np.float64)
        else:
            part = _split_at_creases(part)
            normals = _area_normals(part)
        vertices, faces = np.asarray(part.vertices, dtype=np.float64), np.asarray(part.faces, dtype=np.uint32)
        R_file_part = np.asarray(T_file_part[:3, :3], dtype=np.float64)
        moved = Mesh(vertices @ R_file_part.T + T_file_part[:3, 3], _turned(normals, R_file_part), faces, colour)
        if len(faces) and np.isfinite(moved.vertices).all() and np.isfinite(moved.normals).all():
            yield moved if np.linalg.det(R_file_part) > 0.0 else _flipped(moved)


def _split_at_creases(part: Any) -> Any:
    """Return the same faces in patches that share no vertices; faces at a smooth edge are in one patch."""
    from trimesh import Trimesh
    from trimesh.graph import smooth_shade

    welded = Trimesh(part.vertices, part.faces, process=False)
    welded.merge_vertices()
    welded.update_faces(welded.area_faces > 0.0)
    if (welded.face_adjacency_angles < _CREASE).any():
        return smooth_shade(welded, angle=_CREASE, facet_minarea=None)
    welded.unmerge_vertices()  # smooth_shade does not split a mesh without any smooth edge
    return welded


def _area_normals(part: Any) -> Floats:
    """Return area-weighted sums of the normals around each vertex: a flat face keeps its normal at a rounded edge."""
    sums = np.zeros((len(part.vertices), 3))
    np.add.at(sums, part.faces, (part.face_normals * part.area_faces[:, None])[:, None])
    return sums


def _by_colour(parts: list[Mesh]) -> Iterator[Mesh]:
    for colour in dict.fromkeys(part.colour for part in parts):
        same = [part for part in parts if part.colour == colour]
        starts = np.cumsum([0, *(len(part.vertices) for part in same[:-1])])
        yield Mesh(
            np.concatenate([part.vertices for part in same]),
            np.concatenate([part.normals for part in same]),
            np.concatenate([part.faces + np.uint32(start) for part, start in zip(same, starts, strict=True)]),
            colour,
        )


def _scaled(mesh: Mesh, scale: Floats) -> Mesh:
    scaled = Mesh(mesh.vertices * scale, _turned(mesh.normals, np.diag(scale)), mesh.faces, mesh.colour)
    return scaled if np.prod(scale) > 0.0 else _flipped(scaled)


def _turned(normals: Floats, linear: Floats) -> Floats:
    """Return unit normals after a linear map: they transform with the cofactors, and so stay perpendicular."""
    cofactors = np.stack([np.cross(linear[(i + 1) % 3], linear[(i + 2) % 3]) for i in range(3)])
    turned = normals @ cofactors.T
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(np.divide(turned, lengths, out=np.zeros_like(turned), where=lengths > 0.0))


def _flipped(mesh: Mesh) -> Mesh:
    """Return the surface after a reflection: corners in reverse order, normals outwards."""
    return Mesh(mesh.vertices, -mesh.normals, mesh.faces[:, ::-1], mesh.colour)


def _colour(mesh: Any) -> Rgba | None:
    visual = mesh.visual
    if not visual.defined:
        return None
    try:
        rgba = np.asarray(visual.material.main_color if visual.kind == "texture" else visual.main_color) / 255.0
    except (AttributeError, TypeError, ValueError):
        return None
    r, g, b, a = (float(value) for value in rgba)
    return r, g, b, a


# --- The lights among a robot's shapes: the LEDs of this library's own NAO meshes.
#
# A mesh of LEDs is drawn in separate pieces, so that each light has its own colour. Robots without these meshes have no
# lights.

# Stem of a mesh file → light.
_WHOLE: Mapping[str, str] = {"torso_led": "Chest", "l_foot_led": "LeftFoot", "r_foot_led": "RightFoot"}
_EYES = "head_led"
# Eye → sign of its y.
_SIDES: Mapping[str, float] = {"LeftEye": 1.0, "RightEye": -1.0}
_SEGMENTS = 8

# Group of lights → their names.
GROUPS: Mapping[str, tuple[str, ...]] = {eye: tuple(f"{eye}{number}" for number in range(_SEGMENTS)) for eye in _SIDES}


def lights_of(filename: str, mesh: Mesh) -> dict[str, Mesh]:
    """Return the lights in a mesh of the URDF's file `filename`, by name; empty for other meshes.

    Segments of an eye are numbered from its top towards the nose, as NAOqi's FaceLedLeft0 … 7 and FaceLedRight0 … 7.
    Source: docs.ros.org, nao_command_msgs, LeftEyeLeds and RightEyeLeds.
    """
    stem = PurePosixPath(filename).stem
    if stem in _WHOLE:
        return {_WHOLE[stem]: mesh}
    return _eyes(mesh) if stem == _EYES else {}


def _eyes(mesh: Mesh) -> dict[str, Mesh]:
    parts = pieces(mesh)
    centres = [part.vertices.mean(axis=0) for part in parts]
    found: dict[str, Mesh] = {}
    for eye, side in _SIDES.items():
        ring = [(part, centre) for part, centre in zip(parts, centres, strict=True) if side * centre[1] > 0.0]
        middle = np.mean([centre for _, centre in ring], axis=0) if ring else np.zeros(3)
        for part, centre in ring:
            turn = math.atan2(-side * (centre[1] - middle[1]), centre[2] - middle[2])  # from the top to the nose
            found[f"{eye}{round(turn / math.tau * _SEGMENTS) % _SEGMENTS}"] = part
    complete = len(found) == len(parts) == len(_SIDES) * _SEGMENTS
    return {name: found[name] for eye in GROUPS.values() for name in eye} if complete else {}
