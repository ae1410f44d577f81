"""What the links of a robot look like, ready to draw: the visuals of its URDF with their mesh files loaded."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._text import abbreviated
from nao_kin.rotations import matrix_from_rpy
from nao_kin.urdf import Box, Cylinder, MeshFile, Rgba, Sphere, UrdfTree, Visual
from nao_kin.viewer.meshes import Mesh, UnreadableMesh, load_meshes, mesh_path

_GREY: Rgba = (0.75, 0.77, 0.8, 1.0)

Shape = Box | Cylinder | Sphere | Mesh


@dataclass(frozen=True, eq=False)
class Drawable:
    """One shape of one link, in one colour.

    Attributes:
        link: name of the link.
        T_link_shape: pose of the shape in the link's frame.
        shape: what it is.
        rgba: its colour and opacity, each in [0, 1].
    """

    link: str
    T_link_shape: Floats
    shape: Shape
    rgba: Rgba


def robot_drawables(tree: UrdfTree) -> tuple[tuple[Drawable, ...], tuple[str, ...]]:
    """The visuals of a robot with their mesh files loaded, one drawable per colour, and a line for each not shown."""
    found: list[Drawable] = []
    missing: list[str] = []
    notes: list[str] = []
    loaded: dict[tuple[Path, tuple[float, ...]], tuple[Mesh, ...]] = {}
    for visual in tree.visuals:
        T_link_shape, geometry = _pose(visual), visual.geometry
        if not isinstance(geometry, MeshFile):
            found.append(Drawable(visual.link, T_link_shape, geometry, visual.rgba or _GREY))
            continue
        path = mesh_path(tree.path, geometry.filename)
        if path is None:
            missing.append(geometry.filename)
            continue
        try:
            if (path, geometry.scale) not in loaded:
                loaded[path, geometry.scale] = load_meshes(path, np.array(geometry.scale))
        except UnreadableMesh as reason:
            notes.append(f"a visual of {abbreviated(visual.link)} is not shown: {path.name}: {reason}")
            continue
        for mesh in loaded[path, geometry.scale]:
            found.append(Drawable(visual.link, T_link_shape, mesh, visual.rgba or mesh.colour or _GREY))
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


def _pose(visual: Visual) -> Floats:
    T_link_shape = np.eye(4)
    T_link_shape[:3, :3] = matrix_from_rpy(visual.origin.rpy)
    T_link_shape[:3, 3] = visual.origin.xyz
    return T_link_shape
