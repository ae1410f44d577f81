"""The mesh files that a robot's looks and shapes are made of, and under which names an export has them."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument
from nao_kin.urdf import MeshFile, UrdfTree

MESH_FOLDER = "meshes"

# What an .obj or its .mtl says of other files: `mtllib a.mtl`, `map_Kd -s 1 1 1 a.png`.
_OBJ_FILES = re.compile(r"^\s*(?:mtllib|map_\w+|bump|disp|decal|refl)\s+(?:-\S+\s+(?:[-+.\d]+\s+)*)*(\S.*?)\s*$", re.M)


def mesh_files(tree: UrdfTree) -> dict[str, Path]:
    """Every mesh that the tree names → its file.

    Raises:
        BadArgument: one of them is not there.
    """
    found: dict[str, Path] = {}
    packages = tree.packages
    shapes = (*(visual.geometry for visual in tree.visuals), *(shape.geometry for shape in tree.collisions))
    for name in dict.fromkeys(shape.filename for shape in shapes if isinstance(shape, MeshFile)):
        path = packages.file(name)
        if path is None:
            raise BadArgument(
                f"{tree.name}: the mesh {quoted(name)} is not there; meshes='none' (--meshes none) leaves meshes out"
            )
        found[name] = Path(os.path.realpath(path))
    return found


def mesh_names(tree: UrdfTree) -> tuple[dict[str, str], dict[str, Path]]:
    """How an export names the meshes, and which files it needs for that.

    The files keep their places beside each other, below the folder that holds them all.

    Args:
        tree: the robot.

    Returns:
        Name of a mesh in the tree → its name in the export's folder of meshes; and name there → file, with the
        materials and textures that the meshes name and that are there.

    Raises:
        BadArgument: a mesh is not there.
    """
    meshes = mesh_files(tree)
    if not meshes:
        return {}, {}
    files = {file: None for path in meshes.values() for file in (path, *companions(path))}
    top = Path(os.path.commonpath([file.parent for file in files]))
    return (
        {name: path.relative_to(top).as_posix() for name, path in meshes.items()},
        {file.relative_to(top).as_posix(): file for file in files},
    )


def companions(mesh: Path) -> tuple[Path, ...]:
    """Files that a mesh names and that are there: materials of an .obj, textures of it or of a .dae."""
    ending = mesh.suffix.lower()
    if ending == ".obj":
        found = _named_in(mesh, _obj_names(mesh))
        materials = [file for file in found if file.suffix.lower() == ".mtl"]
        textures = [texture for file in materials for texture in _named_in(file, _obj_names(file))]
        return tuple(dict.fromkeys((*found, *textures)))
    if ending == ".dae":
        try:
            texts = (element.text for element in ET.parse(mesh).iter() if element.tag.endswith("init_from"))
            return _named_in(mesh, [text.strip().removeprefix("file://") for text in texts if text])
        except (ET.ParseError, OSError):
            return ()
    return ()


def _obj_names(file: Path) -> list[str]:
    try:
        return _OBJ_FILES.findall(file.read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return []


def _named_in(file: Path, names: list[str]) -> tuple[Path, ...]:
    found = (file.parent / name for name in names)
    return tuple(Path(os.path.realpath(path)) for path in dict.fromkeys(found) if _is_file(path))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that no system takes
        return False


def read_files(files: Mapping[str, Path]) -> dict[str, bytes]:
    """The contents of files.

    Raises:
        BadArgument: one cannot be read.
    """
    contents: dict[str, bytes] = {}
    for name, path in files.items():
        try:
            contents[name] = path.read_bytes()
        except OSError as error:
            raise BadArgument(f"cannot read the mesh {abbreviated(path)}: {error.strerror or error}") from None
    return contents
