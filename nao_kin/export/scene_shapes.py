"""The looks of a robot as triangles with a colour, for scenes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_kin._common.free_names import fresh_name
from nao_kin._text import abbreviated, quoted
from nao_kin.export.meshes import left_out_note, load_scene
from nao_kin.urdf import Box, Cylinder, Geometry, MeshFile, Origin, Packages, Rgba, Sphere, UrdfTree

GREY: Rgba = (0.7, 0.7, 0.7, 1.0)


@dataclass(frozen=True)
class Paint:
    """A colour that a URDF gives.

    Attributes:
        name: a name that no other colour has.
        rgba: the colour, as screens take it.
    """

    name: str
    rgba: Rgba


@dataclass(frozen=True)
class Shape:
    """A part of the looks of a link, of one colour.

    Attributes:
        link: the link.
        name: its name, "" without one.
        key: what shapes of the same triangles and colour have in common.
        mesh: a trimesh.Trimesh in its own frame, with its material.
        origin: its pose in the link's frame.
    """

    link: str
    name: str
    key: tuple[object, ...]
    mesh: Any
    origin: Origin


def scene_shapes(tree: UrdfTree) -> tuple[tuple[Shape, ...], tuple[Paint, ...], tuple[str, ...]]:
    """The looks of a robot, their colours, and one line for each look that cannot be read."""
    shapes: list[Shape] = []
    notes: list[str] = []
    known: dict[tuple[object, ...], list[Any]] = {}
    paints: dict[tuple[str, Rgba], Paint] = {}
    packages = tree.packages
    for visual in tree.visuals:
        key = (visual.geometry, visual.material, visual.rgba)
        try:
            if key not in known:
                parts = _parts(visual.geometry, packages, notes)
                for part in parts:
                    _paint(part, visual.material, visual.rgba, paints)
                known[key] = parts
        except _Unreadable as reason:
            notes.append(f"a look of {visual.link} is left out: {reason}")
            continue
        several = enumerate(known[key])
        shapes += [Shape(visual.link, visual.name, (*key, index), mesh, visual.origin) for index, mesh in several]
    return tuple(shapes), tuple(paints.values()), tuple(notes)


class _Unreadable(Exception):
    """Why a look cannot be shown."""


def _parts(geometry: Geometry, packages: Packages, notes: list[str]) -> list[Any]:
    """The meshes that a shape is made of, each of one material; `notes` gets a line for textures that are left out."""
    import trimesh

    if isinstance(geometry, Box):
        return [trimesh.creation.box(extents=geometry.size)]
    if isinstance(geometry, Cylinder):
        return [trimesh.creation.cylinder(radius=geometry.radius, height=geometry.length, sections=48)]
    if isinstance(geometry, Sphere):
        return [trimesh.creation.icosphere(subdivisions=3, radius=geometry.radius)]
    return _read(geometry, packages, notes)


def _read(geometry: MeshFile, packages: Packages, notes: list[str]) -> list[Any]:
    path = packages.file(geometry.filename)
    if path is None:
        raise _Unreadable(f"its mesh {quoted(geometry.filename)} is not there")
    left_out: list[str] = []
    try:
        loaded: list[Any] = list(load_scene(path, packages, left_out).dump())
    except Exception as error:  # whatever its many readers raise on a bad file
        raise _Unreadable(f"its mesh {quoted(geometry.filename)} cannot be read: {abbreviated(error)}") from None
    notes += left_out_note(path, left_out)
    parts = [part for part in loaded if hasattr(part, "faces")]  # and no lines or points
    for part in parts:
        part.metadata.clear()  # names of files and folders
        part.apply_transform(np.diag([*geometry.scale, 1.0]))
        # A triangle without an area has no normal.
        part.update_faces(part.nondegenerate_faces())
        part.remove_unreferenced_vertices()
    parts = [part for part in parts if len(part.faces)]
    if not parts:
        raise _Unreadable(f"its mesh {quoted(geometry.filename)} has no triangles")
    return parts


def _paint(mesh: Any, material: str, rgba: Rgba | None, paints: dict[tuple[str, Rgba], Paint]) -> None:
    """Give a mesh a colour of its own, unless the URDF gives none and its file does."""
    import trimesh

    if rgba is None and getattr(mesh.visual, "kind", None) is not None:
        return
    key = (material, rgba or GREY)
    if key not in paints:
        paints[key] = Paint(fresh_name(material or "grey", {paint.name for paint in paints.values()}), key[1])
    visual: Any = trimesh.visual  # not typed
    opacity = key[1][3]
    paint = visual.material.PBRMaterial(
        name=paints[key].name,
        baseColorFactor=[0.0, 0.0, 0.0, opacity],  # trimesh rounds colours to 8 bits: they are set afterwards
        metallicFactor=0.0,
        roughnessFactor=0.6,
        alphaMode="OPAQUE" if opacity == 1.0 else "BLEND",
    )
    mesh.visual = visual.TextureVisuals(material=paint)


def linear(rgba: Rgba) -> list[float]:
    """A colour as screens take it (sRGB) → as glTF has it, proportional to light (IEC 61966-2-1); opacity stays."""
    *rgb, opacity = rgba
    return [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in rgb] + [opacity]
