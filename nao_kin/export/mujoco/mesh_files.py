"""Mesh files for MuJoCo: those it reads as they are, others as STL."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadModel
from nao_kin.urdf import MeshFile, mesh_in

FOLDER = "assets"


class MeshFiles:
    """The mesh files of an export, each once.

    Attributes:
        contents: name of the file → its content.
    """

    def __init__(self, urdf: Path) -> None:
        self.contents: dict[str, bytes] = {}
        self._folder = urdf.resolve().parent
        self._names: dict[Path, str] = {}

    def add(self, mesh: MeshFile, of: str) -> str:
        """Name of the file in the folder of meshes.

        Args:
            mesh: as the URDF has it.
            of: the link, for messages.

        Raises:
            BadModel: it is not there or cannot be read.
        """
        path = mesh_in(self._folder, mesh.filename)
        if path is None:
            raise BadModel(
                f"the mesh {quoted(mesh.filename)} of {abbreviated(of)} is not there; meshes='none' exports without"
            )
        if path not in self._names:
            content, suffix = _readable(path, of)
            self._names[path] = name = self._free(path.stem, suffix)
            self.contents[name] = content
        return self._names[path]

    def _free(self, stem: str, suffix: str) -> str:
        stems, count = {Path(name).stem for name in self.contents}, 1
        free = stem
        while free in stems:
            count += 1
            free = f"{stem}_{count}"
        return free + suffix


def _readable(path: Path, of: str) -> tuple[bytes, str]:
    """Content and suffix of what MuJoCo reads: OBJ and binary STL."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BadModel(f"cannot read {abbreviated(path)}: {error.strerror or error}") from None
    suffix = path.suffix.lower()
    if suffix == ".obj" or (suffix == ".stl" and not content.lstrip().startswith(b"solid")):
        return content, suffix
    import trimesh

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mesh = trimesh.load_scene(path).to_mesh()
            file = io.BytesIO()
            mesh.export(file, file_type="stl")
    except Exception as error:  # whatever its many readers raise on a bad file
        reason = abbreviated(error) or type(error).__name__
        raise BadModel(f"cannot read the mesh {abbreviated(path.name)} of {abbreviated(of)}: {reason}") from None
    return file.getvalue(), ".stl"
