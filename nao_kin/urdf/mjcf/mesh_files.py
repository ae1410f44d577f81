"""The files of an MJCF's meshes: where MuJoCo looks for them, and where else they may be."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.urdf.mjcf.joints import pose
from nao_kin.urdf.packages import Packages


@dataclass(frozen=True, eq=False)
class MeshAsset:
    """A mesh as the file has it.

    Attributes:
        path: its file; None where the mesh is not from a file.
        scale: factors along its axes, shape (3,).
        T_mesh_file: pose of the file's coordinates, scaled, in those of the mesh (refpos and refquat), shape (4, 4).
        is_rigid: whether this is all; a mesh that is turned and then scaled unevenly is sheared.
    """

    path: Path | None
    scale: Floats
    T_mesh_file: Floats
    is_rigid: bool


def mesh_asset(mesh: Any, file: Path | None, home: Path) -> MeshAsset:
    """A mesh of a `mujoco.MjSpec`.

    Args:
        mesh: the mesh.
        file: its file, None where that is not there.
        home: the folder of the MJCF.
    """
    if file is None and mesh.file:
        file = home / mesh.file
    scale = np.array(mesh.scale, dtype=np.float64)
    T_mesh_file = np.asarray(np.linalg.inv(pose(mesh.refpos, mesh.refquat)), dtype=np.float64)
    T_mesh_file[:3, 3] *= scale  # MuJoCo moves and turns the vertices before it scales them
    R = T_mesh_file[:3, :3]
    return MeshAsset(file, scale, T_mesh_file, bool(np.allclose(scale[:, None] * R, R * scale)))


class MeshFiles:
    """The search for the files of a model's meshes.

    Args:
        spec: the `mujoco.MjSpec`.
        path: the MJCF.
        content: what it holds.
        folders: folders to search for what is not where the file says.
    """

    def __init__(self, spec: Any, path: Path, content: bytes, folders: tuple[Path, ...]) -> None:
        self._spec, self._home, self._folders = spec, path.absolute().parent, folders
        self._packages = Packages(path, folders)
        # Prefix of the names of its meshes → where an attached model has their files.
        self._attached = sorted(_attached(path.absolute(), content), key=lambda found: -len(found[0]))

    def find(self, mesh: Any) -> Path | None:
        """The file of a mesh, None where there is none; MuJoCo is told of one that is found elsewhere than it looks."""
        if not mesh.file:
            return None
        name = str(mesh.file)
        base = re.split(r"[\\/]", name)[-1]
        try:
            if not self._spec.strippath:
                for folder in self._where_mujoco_looks(mesh):
                    if (folder / name).is_file():
                        return folder / name
            elsewhere = [self._packages.file(name), *(folder / name for folder in self._folders)]
            if self._spec.strippath:
                elsewhere = [folder / base for folder in (*self._where_mujoco_looks(mesh), *self._folders)]
            found = next((file for file in elsewhere if file is not None and file.is_file()), None)
        except (OSError, ValueError):  # a name that no system takes
            return None
        if found is not None:
            mesh.file = str(found.absolute())
        return found

    def _where_mujoco_looks(self, mesh: Any) -> Iterator[Path]:
        """The folder of the file that has the mesh, with its `meshdir`: that of a model attached, or of this one."""
        own = getattr(mesh, "compiler", None)
        meshdirs = [str(getattr(where, "meshdir", "")) for where in (own, self._spec.compiler, self._spec) if where]
        for prefix, folder, meshdir in self._attached:
            if prefix and str(mesh.name).startswith(prefix):
                yield from (folder / inner for inner in dict.fromkeys((meshdir, *meshdirs)))
        yield from (self._home / meshdir for meshdir in dict.fromkeys(meshdirs))
        yield from (folder / meshdir for prefix, folder, meshdir in self._attached if not prefix)


def _attached(path: Path, content: bytes) -> Iterator[tuple[str, Path, str]]:
    """Prefix, folder and `meshdir` of the models that a file attaches, and of those that these attach."""
    elements = list(_elements(path, content, path.parent))
    models = {
        model.get("name") or _model_name(path.parent / model.get("file", "")): model
        for model in elements
        if model.tag == "model"
    }
    for element in elements:
        model = models.get(element.get("model", "")) if element.tag == "attach" else None
        if model is not None:
            prefix, file = element.get("prefix", ""), path.parent / model.get("file", "")
            inside = _content(file)
            compilers = [inner for inner in _elements(file, inside, file.parent) if inner.tag == "compiler"]
            meshdirs = [inner.get("meshdir", inner.get("assetdir", "")) for inner in compilers]
            yield prefix, file.parent, next(filter(None, meshdirs), "")
            yield from ((prefix + inner, folder, meshdir) for inner, folder, meshdir in _attached(file, inside))


def _model_name(file: Path) -> str:
    """The name that a file gives its model."""
    return next((root.get("model", "") for root in _elements(file, _content(file), file.parent)), "")


def _elements(path: Path, content: bytes, home: Path) -> Iterator[ET.Element]:
    """The elements of a file and of those that it includes; none of one that MuJoCo takes and XML does not."""
    try:
        document = ET.fromstring(content)
    except (ET.ParseError, ValueError):
        return
    for element in document.iter():
        yield element
        if element.tag == "include":
            beside, name = path.parent, element.get("file", "")
            inside = beside / name if (beside / name).is_file() else home / name
            yield from _elements(inside, _content(inside), home)


def _content(file: Path) -> bytes:
    """What a file holds that MuJoCo has read; nothing where it cannot be read again."""
    try:
        return file.read_bytes()
    except (OSError, ValueError):
        return b""
