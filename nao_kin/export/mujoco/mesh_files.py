"""Mesh files for MuJoCo: those it reads as they are, others as STL."""

from __future__ import annotations

import io
from pathlib import Path

from nao_kin._common.free_names import fresh_name
from nao_kin.export.meshes import mesh_files, read_files, read_mesh
from nao_kin.urdf import MeshFile, Packages, UrdfTree

FOLDER = "assets"

_MOST_IN_STL = 200_000


class MeshFiles:
    """The mesh files of an export, each once.

    Attributes:
        contents: name of the file → its content.
    """

    def __init__(self, tree: UrdfTree) -> None:
        """Find the files.

        Raises:
            BadArgument: one of them is not there.
        """
        self.contents: dict[str, bytes] = {}
        self._paths, self._packages = mesh_files(tree), tree.packages
        self._names: dict[Path, str] = {}

    def add(self, mesh: MeshFile) -> str:
        """Name of a mesh in the folder of meshes.

        Raises:
            BadArgument: it cannot be read.
        """
        path = self._paths[mesh.filename]
        if path not in self._names:
            content, suffix = _readable(path, self._packages)
            stems = {Path(name).stem for name in self.contents}
            self._names[path] = name = fresh_name(path.stem, stems) + suffix
            self.contents[name] = content
        return self._names[path]


def _readable(path: Path, packages: Packages) -> tuple[bytes, str]:
    """Content and suffix of what MuJoCo reads: OBJ, and binary STL that is not too long."""
    content = read_files({path.name: path})[path.name]
    suffix = path.suffix.lower()
    if suffix == ".obj" or (suffix == ".stl" and _is_short_stl(content)):
        return content, suffix
    mesh = read_mesh(path, packages).to_mesh()
    mesh.process()
    kind = "stl" if len(mesh.faces) <= _MOST_IN_STL else "obj"
    file = io.BytesIO()
    mesh.export(file, file_type=kind)
    return file.getvalue(), f".{kind}"


def _is_short_stl(content: bytes) -> bool:
    """Whether this is binary STL of no more triangles than MuJoCo takes: 80 bytes, their number, 50 bytes for each."""
    count = int.from_bytes(content[80:84], "little")
    return len(content) == 84 + 50 * count and 0 < count <= _MOST_IN_STL
