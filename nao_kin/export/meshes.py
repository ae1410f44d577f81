"""The mesh files of a robot, and their names in an export."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any
from xml.etree import ElementTree as ET

from nao_kin._core.text import abbreviated, fresh_name, quoted
from nao_kin.errors import BadArgument
from nao_kin.robot import read_mesh
from nao_kin.robot.urdf import Collision, MeshFile, Packages, Rgba, UnreadableShape, UrdfTree, Visual

MESH_FOLDER = "meshes"
# The colour of a visual shape without one.
GREY: Rgba = (0.7, 0.7, 0.7, 1.0)

# Suffixes of meshes that are copied from the robot's package unread; any other file must be readable as a mesh.
_MESHES = frozenset(".stl .obj .dae .ply .off .glb .gltf .3mf .3ds .fbx .mesh .msh .x".split())
# Suffixes of files to which a mesh may refer: materials, buffers of glTF, textures.
_COMPANIONS = frozenset(
    ".mtl .bin .png .jpg .jpeg .bmp .tif .tiff .tga .gif .webp .dds .exr .hdr .ktx .ktx2 .pcx .ppm .psd".split()
)
# References of an .obj or its .mtl to other files: `mtllib a.mtl`, `map_Kd -s 1 1 1 a.png`.
_OBJ_FILES = re.compile(r"^\s*(?:mtllib|map_\w+|bump|disp|decal|refl)\s+(?:-\S+\s+(?:[-+.\d]+\s+)*)*(\S.*?)\s*$", re.M)


def shapes_of(tree: UrdfTree) -> tuple[Visual | Collision, ...]:
    """Return the visual shapes of all links, and after them the collision shapes."""
    return (*tree.visuals, *tree.collisions)


def mesh_files(tree: UrdfTree) -> dict[str, Path]:
    """Return mesh name → its file; BadArgument for a missing file, or one outside of the package that is not a mesh."""
    found: dict[str, Path] = {}
    packages = tree.packages
    meshes = (shape.geometry for shape in shapes_of(tree) if isinstance(shape.geometry, MeshFile))
    for name in dict.fromkeys(mesh.filename for mesh in meshes):
        path = packages.file(name)
        if path is None:
            raise BadArgument(
                f"{tree.name}: the mesh {quoted(name)} is not there; meshes='none' (--meshes none) leaves meshes out"
            )
        found[name] = file = Path(os.path.realpath(path))
        if file.suffix.lower() not in _MESHES or not packages.contain(file):
            scene_of(file, packages)
    return found


@dataclass(frozen=True)
class TakenMeshes:
    """The meshes of an export."""

    names: dict[str, str] | None  # mesh name in the tree → in the document; None leaves out meshes
    files: Mapping[str, bytes] = field(default_factory=dict)  # name relative to the document → content
    notes: tuple[str, ...] = ()  # one line for each mesh from outside the package or with files left out


def taken_meshes(tree: UrdfTree, meshes: str, package: str = "") -> TakenMeshes:
    """Return the meshes of a tree by a choice: "none", "relative" copies them, "absolute" refers to the original files.

    Any other choice refers to the meshes below `package`, the address of a folder, and copies nothing. Copies include
    materials and textures, if they exist and are allowed in the export.
    """
    if meshes == "none":
        return TakenMeshes(None)
    paths = mesh_files(tree)
    notes = list(_unit_notes(tree))
    if meshes == "absolute" or not paths:
        return TakenMeshes({name: str(path) for name, path in paths.items()}, notes=tuple(notes))
    files: dict[Path, None] = {}
    for path in paths.values():
        left_out: list[str] = []
        files |= dict.fromkeys((path, *_companions(path, tree.packages, left_out)))
        notes += (*outside_note(path, tree.packages), *left_out_note(path, left_out))
    # The files keep their relative paths, below their common folder.
    top = Path(os.path.commonpath([file.parent for file in files]))
    folder = MESH_FOLDER if meshes == "relative" else package
    names = {name: f"{folder}/{path.relative_to(top).as_posix()}" for name, path in paths.items()}
    if meshes != "relative":
        return TakenMeshes(names, notes=tuple(notes))
    contents = {f"{folder}/{file.relative_to(top).as_posix()}": _content(file) for file in files}
    return TakenMeshes(names, contents, tuple(dict.fromkeys(notes)))


def _unit_notes(tree: UrdfTree) -> Iterator[str]:
    """Yield one line for each mesh whose file has a unit other than the metre."""
    meshes = (shape.geometry for shape in shapes_of(tree))
    units = {Path(mesh.filename).name: mesh.unit(tree.packages) for mesh in meshes if isinstance(mesh, MeshFile)}
    for name, unit in units.items():
        if unit != 1.0:
            yield f"{name} is in units of {unit:g} m: RViz and Gazebo scale it, Pinocchio and yourdfpy do not"


def scene_of(path: Path, packages: Packages) -> Any:
    """Read a mesh as a trimesh.Scene of triangles, or raise BadArgument."""
    try:
        return read_mesh(path, lambda scene: scene, resolver=resolver(path, packages, []))
    except UnreadableShape as reason:
        advice = "meshes='none' (--meshes none) leaves meshes out"
        raise BadArgument(f"cannot read the mesh {abbreviated(path)}: {reason}; {advice}") from None


def resolver(path: Path, packages: Packages, left_out: list[str]) -> Any:
    """Return a trimesh resolver of a mesh's materials and textures; it adds refused files to `left_out`."""
    from trimesh.resolvers import FilePathResolver

    real = Path(os.path.realpath(path))

    class Resolver(FilePathResolver):
        def get(self, name: str) -> bytes:
            file = real.parent / name.strip()
            if not _is_file(file):
                raise FileNotFoundError(name)
            if not _may_have(file, real, packages):
                left_out.append(name.strip())
                raise PermissionError(name)
            return file.read_bytes()

    return Resolver(str(real))


def outside_note(mesh: Path, packages: Packages) -> list[str]:
    """Return one line about a mesh that is not in the robot's package, as it becomes part of the export."""
    real = Path(os.path.realpath(mesh))
    return [] if packages.contain(real) else [f"{real.name} is from outside the robot's package: {abbreviated(real)}"]


def left_out_note(mesh: Path, names: list[str]) -> list[str]:
    """Return one line about files that a mesh names and an export must not contain; none without such files."""
    if not names:
        return []
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return [
        f"{mesh.name} names {quoted(names[0])}{more}: left out, because only materials and textures below the "
        "mesh's folder or in the robot's package are taken"
    ]


def _companions(mesh: Path, packages: Packages, left_out: list[str]) -> tuple[Path, ...]:
    """Return existing, allowed files that a mesh names: materials and textures of an .obj, textures of a .dae."""

    def allowed(file: Path, names: list[str]) -> dict[Path, None]:
        existing = {name: file.parent / name for name in names if _is_file(file.parent / name)}
        refused = [name for name, path in existing.items() if not _may_have(path, mesh, packages)]
        left_out.extend(refused)
        return {Path(os.path.realpath(path)): None for name, path in existing.items() if name not in refused}

    ending = mesh.suffix.lower()
    if ending == ".obj":
        found = allowed(mesh, _obj_names(mesh))
        for file in [file for file in found if file.suffix.lower() == ".mtl"]:
            found |= allowed(file, _obj_names(file))
        return tuple(found)
    if ending == ".dae":
        try:
            texts = (element.text for element in ET.parse(mesh).iter() if element.tag.endswith("init_from"))
            return tuple(allowed(mesh, [text.strip().removeprefix("file://") for text in texts if text]))
        except (ET.ParseError, OSError):
            return ()
    return ()


def _may_have(file: Path, mesh: Path, packages: Packages) -> bool:
    """Return whether an export may contain a file that a mesh names, because a mesh could name any private file."""
    real = Path(os.path.realpath(file))
    near = real.is_relative_to(mesh.parent) or packages.contain(real)
    return near and real.suffix.lower() in _COMPANIONS


def _obj_names(file: Path) -> list[str]:
    try:
        return _OBJ_FILES.findall(file.read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return []


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that no system accepts
        return False


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise BadArgument(f"cannot read the mesh {abbreviated(path)}: {error.strerror or error}") from None


# --- Colours of visual shapes, and their names.

# Name of the material, "" for none, and the colour of a visual shape.
Paint = tuple[str, Rgba]


def paint_names(paints: Iterable[Paint]) -> dict[Paint, str]:
    """Return paint → a unique name: that of its material, or a new one where two colours share it."""
    found: dict[Paint, str] = {}
    for paint in paints:
        if paint not in found:
            found[paint] = fresh_name(paint[0] or "colour", found.values())
    return found


# --- Meshes with the colours of a URDF in their files, for tools that ignore colours of a URDF for an .obj.
#
# RViz is one: it gives every .obj the material in the file, or else one grey for all, and uses the colours of a URDF
# for .stl files and plain shapes alone (ros2/rviz, rviz_rendering, assimp_loader; rviz_default_plugins, robot_link).

_MATERIAL = re.compile(rb"^\s*(?:usemtl|mtllib)\b", re.M)
_UNSAFE = re.compile(r"\W", re.ASCII)


def coloured(
    tree: UrdfTree, names: Mapping[str, str], files: Mapping[str, bytes], library: str
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return mesh files with their colours in them, and one line for each change; `library` is the material file."""
    colours: dict[str, set[Rgba]] = {}
    for visual in tree.visuals:
        if isinstance(visual.geometry, MeshFile) and visual.rgba is not None:
            colours.setdefault(names[visual.geometry.filename], set()).add(visual.rgba)
    plain = sorted(name for name in colours if name.lower().endswith(".obj") and not _MATERIAL.search(files[name]))
    painted = {name: next(iter(colours[name])) for name in plain if len(colours[name]) == 1}
    words = _words(tree)
    made = dict(files)
    libraries: dict[str, dict[str, Rgba]] = {}
    for name, rgba in painted.items():
        made[name] = f"mtllib {library}\nusemtl {words[rgba]}\n".encode() + files[name]
        libraries.setdefault(str(PurePosixPath(name).with_name(library)), {})[words[rgba]] = rgba
    made |= {name: _library(materials) for name, materials in libraries.items()}
    painted_note = f"{len(painted)} meshes have their colours in {library}: RViz ignores those of a URDF"
    changes = [painted_note] if painted else []
    several = (name.removeprefix(f"{MESH_FOLDER}/") for name in plain if name not in painted)
    changes += [f"{name} has several colours in the URDF, and none in RViz" for name in several]
    return made, tuple(changes)


def _words(tree: UrdfTree) -> dict[Rgba, str]:
    """Return colour → its name, that of its material if no other colour has this name."""
    words: dict[Rgba, str] = {}
    for visual in tree.visuals:
        if visual.rgba is not None and visual.rgba not in words:
            word = _UNSAFE.sub("_", visual.material)
            digits = "".join(f"{round(255 * part):02x}" for part in visual.rgba)
            words[visual.rgba] = word if word and word not in words.values() else f"colour_{digits}_{len(words)}"
    return words


def _library(materials: Mapping[str, Rgba]) -> bytes:
    """Return the content of a file of materials for .obj files."""
    lines = []
    for word, (*rgb, opacity) in sorted(materials.items()):
        colour = " ".join(f"{part:.6g}" for part in rgb)
        lines += [f"newmtl {word}", f"Ka {colour}", f"Kd {colour}", f"d {opacity:.6g}", ""]
    return "\n".join(lines).encode()


# --- Mesh files for MuJoCo: unchanged if MuJoCo reads them, otherwise as STL.

FOLDER = "assets"

_MOST_IN_STL = 200_000


def assets(tree: UrdfTree) -> TakenMeshes:
    """Return the meshes of a tree as files that MuJoCo reads; their names are those in the folder of meshes."""
    paths, names, files = mesh_files(tree), dict[Path, str](), dict[str, bytes]()
    notes: list[str] = []
    for path in dict.fromkeys(paths.values()):
        notes += outside_note(path, tree.packages)
        content, suffix = _readable(path, tree.packages)
        names[path] = fresh_name(path.stem, {Path(name).stem for name in names.values()}) + suffix
        files[f"{FOLDER}/{names[path]}"] = content
    return TakenMeshes({mesh: names[path] for mesh, path in paths.items()}, files, tuple(notes))


def _readable(path: Path, packages: Packages) -> tuple[bytes, str]:
    """Return content and suffix of a mesh for MuJoCo: OBJ, and binary STL that is not too long."""
    content = _content(path)
    suffix = path.suffix.lower()
    # Binary STL has 80 bytes, the number of its triangles, and 50 bytes for each.
    count = int.from_bytes(content[80:84], "little")
    is_short = len(content) == 84 + 50 * count and 0 < count <= _MOST_IN_STL
    if suffix == ".obj" or (suffix == ".stl" and is_short):
        return content, suffix
    mesh = scene_of(path, packages).to_mesh()
    mesh.process()
    kind = "stl" if len(mesh.faces) <= _MOST_IN_STL else "obj"
    file = io.BytesIO()
    mesh.export(file, file_type=kind)
    return file.getvalue(), f".{kind}"
