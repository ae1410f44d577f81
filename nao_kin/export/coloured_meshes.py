"""Meshes that carry the colours which a URDF gives them, for tools that take no colour from a URDF for an .obj.

RViz is one: it gives every .obj the material in the file, or else one grey for all, and uses the colours of a URDF for
.stl files and plain shapes alone (ros2/rviz, rviz_rendering, assimp_loader; rviz_default_plugins, robot_link).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import PurePosixPath

from nao_kin.urdf import MeshFile, Rgba, UrdfTree

_MATERIAL = re.compile(rb"^\s*(?:usemtl|mtllib)\b", re.M)
_UNSAFE = re.compile(r"\W", re.ASCII)


def coloured(
    tree: UrdfTree, names: Mapping[str, str], files: Mapping[str, bytes], library: str
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """The mesh files with their colours in them.

    Args:
        tree: the robot.
        names: name of a mesh in the tree → its name among the files.
        files: name → content.
        library: name of the files of materials, one in each folder with meshes that get a colour.

    Returns:
        The files, .obj files without a material of their own now with one; and one line for what has changed.
    """
    colours: dict[str, set[Rgba]] = {}
    for visual in tree.visuals:
        if isinstance(visual.geometry, MeshFile) and visual.rgba is not None:
            colours.setdefault(names[visual.geometry.filename], set()).add(visual.rgba)
    bare = {
        name for name in colours if PurePosixPath(name).suffix.lower() == ".obj" and not _MATERIAL.search(files[name])
    }
    several = sorted(name for name in bare if len(colours[name]) > 1)
    painted = {name: next(iter(colours[name])) for name in sorted(bare) if len(colours[name]) == 1}
    words = _words(tree)
    made = dict(files)
    libraries: dict[str, dict[str, Rgba]] = {}
    for name, rgba in painted.items():
        made[name] = f"mtllib {library}\nusemtl {words[rgba]}\n".encode() + files[name]
        libraries.setdefault(str(PurePosixPath(name).with_name(library)), {})[words[rgba]] = rgba
    made |= {name: _library(materials) for name, materials in libraries.items()}
    changes = (
        [f"{len(painted)} meshes have their colours in {library}, for RViz takes none from a URDF"] if painted else []
    )
    changes += [f"{name} has several colours in the URDF, and none in RViz" for name in several]
    return made, tuple(changes)


def _words(tree: UrdfTree) -> dict[Rgba, str]:
    """Colour → a name for it, that of its material where no other colour has it."""
    words: dict[Rgba, str] = {}
    for visual in tree.visuals:
        if visual.rgba is not None and visual.rgba not in words:
            word = _UNSAFE.sub("_", visual.material)
            digits = "".join(f"{round(255 * part):02x}" for part in visual.rgba)
            words[visual.rgba] = word if word and word not in words.values() else f"colour_{digits}_{len(words)}"
    return words


def _library(materials: Mapping[str, Rgba]) -> bytes:
    """A file of materials, as an .obj names them."""
    lines = []
    for word, (*rgb, opacity) in sorted(materials.items()):
        colour = " ".join(f"{part:.6g}" for part in rgb)
        lines += [f"newmtl {word}", f"Ka {colour}", f"Kd {colour}", f"d {opacity:.6g}", ""]
    return "\n".join(lines).encode()
