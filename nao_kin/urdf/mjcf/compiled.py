"""An MJCF file as MuJoCo compiles it: includes, classes, angles, orientations and inertias resolved by itself.

Looks never keep a robot from loading. Textures, height fields and skins are taken out before; a mesh is loaded only
where a body's mass depends on it, which also makes a robot of many meshes load in milliseconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.optional import need_extra
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadModel
from nao_kin.urdf.mjcf.joints import pose
from nao_kin.urdf.packages import Packages

# To MuJoCo a body that moves must have a mass. Where its meshes are not there, it gets this one, which is then dropped.
_NO_MASS = 1e-14
_TINY = 1e-3


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


@dataclass(frozen=True, eq=False)
class Compiled:
    """A compiled model.

    Attributes:
        model: the `mujoco.MjModel`.
        name: its name, "" without one.
        meshes: geom id → the mesh that it is.
        loaded: geom ids whose meshes MuJoCo has loaded; it has moved them to their centres of mass.
    """

    model: Any
    name: str
    meshes: Mapping[int, MeshAsset]
    loaded: frozenset[int]

    def has_mass(self, body: int) -> bool:
        """Whether a body's mass is known, and more than nothing."""
        return bool(self.model.body_mass[body] > 2.0 * _NO_MASS)


def import_mujoco() -> ModuleType:
    """MuJoCo.

    Raises:
        MissingExtra: it is not installed.
    """
    need_extra("reading MJCF", "mujoco")
    import mujoco

    module: ModuleType = mujoco
    return module


def compile_mjcf(path: Path, package_dirs: tuple[Path, ...], notes: list[str]) -> Compiled:
    """The file compiled.

    Args:
        path: the file.
        package_dirs: folders to search for meshes that are not where the file says.
        notes: gets a line for what is not there.

    Raises:
        MissingExtra: MuJoCo is not installed.
        BadModel: MuJoCo refuses the file.
    """
    mujoco = import_mujoco()
    try:
        spec = _parsed(mujoco, path.absolute())
        shapes = _lightened(spec, path, package_dirs, notes)
        try:
            model = spec.compile()
        except ValueError:
            if not any(shape.is_missing for shape in shapes):
                raise
            spec.compiler.boundmass = spec.compiler.boundinertia = _NO_MASS
            model = spec.compile()
            notes.append("bodies whose mass was to come from missing meshes are taken as massless")
    except (ValueError, mujoco.FatalError) as error:
        raise BadModel(f"{path}: MuJoCo refuses it: {abbreviated(error)}") from None
    kind = int(mujoco.mjtGeom.mjGEOM_MESH)
    meshes = {int(shape.geom.id): shape.asset for shape in shapes}
    loaded = frozenset(geom for geom in meshes if int(model.geom_type[geom]) == kind)
    names = "" if spec.modelname == "MuJoCo Model" else str(spec.modelname)
    return Compiled(model, names, meshes, loaded)


def _parsed(mujoco: ModuleType, path: Path) -> Any:
    """The `mujoco.MjSpec` of a file; since MuJoCo 4 it reads MJCF under the ending .xml only."""
    if path.suffix == ".xml":
        return mujoco.MjSpec.from_file(str(path))
    name = f"{path}.xml"
    return mujoco.MjSpec.from_file(name, include={name: path.read_bytes()})


@dataclass(frozen=True, eq=False)
class _MeshGeom:
    geom: Any
    asset: MeshAsset
    is_missing: bool


def _lightened(spec: Any, path: Path, package_dirs: tuple[Path, ...], notes: list[str]) -> list[_MeshGeom]:
    """Take out of a model what only a picture needs; the geoms that are meshes."""
    mujoco = import_mujoco()
    spec.compiler.discardvisual = spec.compiler.fusestatic = False
    for skin in list(spec.skins):
        spec.delete(skin)
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for light in spec.lights:
        if hasattr(light, "texture"):
            light.texture = ""
    for texture in list(spec.textures):
        spec.delete(texture)
    used, found = set[str](), list[_MeshGeom]()
    fields = [geom for geom in spec.geoms if geom.type == mujoco.mjtGeom.mjGEOM_HFIELD]
    if fields:
        notes.append(f"height fields left out: {len(fields)}")
    for geom in fields:
        _make_speck(geom)
    for hfield in list(spec.hfields):
        spec.delete(hfield)
    meshes = {mesh.name: mesh for mesh in spec.meshes}
    packages = Packages(path, package_dirs)
    files = {name: _mesh_file(spec, mesh, path, packages, package_dirs) for name, mesh in meshes.items()}
    for body in spec.bodies:
        for geom in body.geoms:
            name = geom.meshname
            if name not in meshes:
                continue
            there = not meshes[name].file or files[name] is not None
            is_mesh = geom.type == mujoco.mjtGeom.mjGEOM_MESH
            if is_mesh:
                found.append(_MeshGeom(geom, _asset(meshes[name], files[name], path), not there))
            if there and (not meshes[name].file or not is_mesh or _gives_mass(spec, body, geom)):
                used.add(name)  # a primitive is fitted to its mesh
            else:
                _make_speck(geom)
    for site in spec.sites:
        if getattr(site, "meshname", "") in meshes:
            site.meshname, site.type = "", mujoco.mjtGeom.mjGEOM_SPHERE
    kept = used | {name for name in meshes if not meshes[name].file}
    for name in meshes.keys() - kept - set(_flexible(spec)):
        spec.delete(meshes[name])
    missing = sorted(meshes[name].file for name in meshes if meshes[name].file and files[name] is None)
    if missing:
        count = sum(bool(mesh.file) for mesh in meshes.values())
        notes.append(f"{len(missing)} of {count} mesh files are not there, first {quoted(missing[0])}")
    return found


def _flexible(spec: Any) -> Iterator[str]:
    """Meshes that something else than a geom may be made of: then all are kept."""
    return (mesh.name for mesh in spec.meshes) if len(spec.flexes) else iter(())


def _make_speck(geom: Any) -> None:
    """A geom without mass, so that its pose is compiled and nothing else of it."""
    mujoco = import_mujoco()
    geom.type, geom.meshname, geom.hfieldname = mujoco.mjtGeom.mjGEOM_SPHERE, "", ""
    geom.size, geom.mass, geom.fromto = [_TINY] * 3, 0.0, [math.nan] * 6


def _gives_mass(spec: Any, body: Any, geom: Any) -> bool:
    """Whether the mass or the tensor of the body depends on the shape of the geom."""
    compiler = getattr(body, "compiler", None) or spec.compiler
    if body.explicitinertial and int(compiler.inertiafromgeom) != 1:  # 1: always
        return False
    return bool(geom.mass != 0.0 and (not math.isnan(geom.mass) or geom.density != 0.0))


def _mesh_file(spec: Any, mesh: Any, path: Path, packages: Packages, folders: tuple[Path, ...]) -> Path | None:
    """The file of a mesh, None where there is none; MuJoCo is told of one that is found elsewhere than it looks."""
    if not mesh.file:
        return None
    own = getattr(mesh, "compiler", None)
    meshdirs = [str(getattr(where, "meshdir", "")) for where in (own, spec.compiler, spec) if where is not None]
    home = path.absolute().parent
    try:
        told = [home / folder / str(mesh.file) for folder in dict.fromkeys(meshdirs)]
        for file in told:
            if file.is_file():
                return file
        elsewhere = (packages.file(str(mesh.file)), *(folder / str(mesh.file) for folder in folders))
        found = next((file for file in elsewhere if file is not None and file.is_file()), None)
    except (OSError, ValueError):  # a name that no system takes
        return None
    if found is not None:
        mesh.file = str(found.absolute())
    return found


def _asset(mesh: Any, file: Path | None, path: Path) -> MeshAsset:
    if file is None and mesh.file:
        file = path.absolute().parent / mesh.file
    scale = np.array(mesh.scale, dtype=np.float64)
    T_mesh_file = np.asarray(np.linalg.inv(pose(mesh.refpos, mesh.refquat)), dtype=np.float64)
    T_mesh_file[:3, 3] *= scale  # MuJoCo moves and turns the vertices before it scales them
    R = T_mesh_file[:3, :3]
    return MeshAsset(file, scale, T_mesh_file, bool(np.allclose(scale[:, None] * R, R * scale)))
