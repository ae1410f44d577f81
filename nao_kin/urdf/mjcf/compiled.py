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

from nao_kin._common.mujoco_warnings import mujoco_warnings
from nao_kin._common.optional import need_extra
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadModel
from nao_kin.urdf.mjcf.mesh_files import MeshAsset, MeshFiles, mesh_asset

# To MuJoCo a body that moves must have a mass. Where its meshes are not there, it gets this one, which is then dropped.
_NO_MASS = 1e-14
_TINY = 1e-3
# What must be finite of each kind of thing in a model; a range may have no end.
_FINITE = {
    "body": ("pos", "quat", "ipos", "iquat", "mass", "inertia"),
    "joint": ("pos", "axis"),
    "geom": ("pos", "quat", "size"),
    "site": ("pos", "quat"),
    "camera": ("pos", "quat"),
}
_SHORT = {"joint": "jnt", "camera": "cam"}


@dataclass(frozen=True, eq=False)
class Compiled:
    """A compiled model.

    Attributes:
        model: the `mujoco.MjModel`.
        name: its name, "" without one.
        meshes: geom id → the mesh that it is.
        loaded: geom ids whose meshes MuJoCo has loaded; it has moved them to their centres of mass.
        specks: geom ids of which only the pose is known, not the shape.
    """

    model: Any
    name: str
    meshes: Mapping[int, MeshAsset]
    loaded: frozenset[int]
    specks: frozenset[int]

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


def compile_mjcf(path: Path, content: bytes, package_dirs: tuple[Path, ...], notes: list[str]) -> Compiled:
    """The file compiled.

    Args:
        path: the file.
        content: what it holds.
        package_dirs: folders to search for meshes that are not where the file says.
        notes: gets a line for what is not there, and for what MuJoCo warns of.

    Raises:
        MissingExtra: MuJoCo is not installed.
        BadModel: MuJoCo refuses the file.
    """
    mujoco = import_mujoco()
    try:
        with mujoco_warnings(mujoco) as warned:
            spec = _parsed(mujoco, path.absolute(), content)
            shapes = _lightened(spec, path, content, package_dirs, notes)
            model = _compiled(spec, shapes, notes)
    except (ValueError, mujoco.FatalError) as error:
        raise BadModel(f"{path}: MuJoCo refuses it: {abbreviated(error)}") from None
    _check_finite(model, path)
    notes += [f"MuJoCo says: {abbreviated(text)}" for text in dict.fromkeys(warned)]
    kind = int(mujoco.mjtGeom.mjGEOM_MESH)
    meshes = {int(shape.geom.id): shape.asset for shape in shapes if shape.asset is not None}
    specks = frozenset(int(shape.geom.id) for shape in shapes if shape.asset is None)
    loaded = frozenset(geom for geom in meshes if int(model.geom_type[geom]) == kind)
    names = "" if spec.modelname == "MuJoCo Model" else str(spec.modelname)
    return Compiled(model, names, meshes, loaded, specks)


def _parsed(mujoco: ModuleType, path: Path, content: bytes) -> Any:
    """The `mujoco.MjSpec` of a file; since MuJoCo 4 it reads MJCF under the ending .xml only."""
    if path.suffix == ".xml" and path.is_file():
        return mujoco.MjSpec.from_file(str(path))
    # Not under its own name: MuJoCo takes an attached file of that name, in any folder, for this one, and never ends.
    name = f"{path}.xml"
    return mujoco.MjSpec.from_file(name, include={name: content})


def _compiled(spec: Any, shapes: list[_Shape], notes: list[str]) -> Any:
    """The `mujoco.MjModel`; with massless bodies where masses were to come from meshes that are missing."""
    try:
        return spec.compile()
    except ValueError:
        if not any(shape.is_missing for shape in shapes):
            raise
        for compiler in _compilers(spec):
            compiler.boundmass = compiler.boundinertia = _NO_MASS
        # In MuJoCo 3.3 no bound reaches the bodies of a model that is attached.
        for body in (shape.body for shape in shapes if shape.is_missing):
            if not body.explicitinertial and all(geom.mass == 0.0 for geom in body.geoms):
                body.explicitinertial, body.mass, body.inertia = True, _NO_MASS, [_NO_MASS] * 3
        model = spec.compile()
        notes.append("bodies whose mass was to come from missing meshes are taken as massless")
        return model


def _compilers(spec: Any) -> list[Any]:
    """The settings of the compiler: those of the model, and those of the models that it attaches."""
    return [spec.compiler, *(body.compiler for body in spec.bodies if getattr(body, "compiler", None) is not None)]


def _check_finite(model: Any, path: Path) -> None:
    """Refuse poses and masses that are no numbers, which MuJoCo takes.

    Raises:
        BadModel: one is not finite.
    """
    for kind, parts in _FINITE.items():
        for part in parts:
            bad = np.argwhere(~np.isfinite(getattr(model, f"{_SHORT.get(kind, kind)}_{part}")))
            if bad.size:
                name = str(getattr(model, kind)(int(bad[0, 0])).name) or str(bad[0, 0])
                raise BadModel(f"{path}: the {part} of {kind} {quoted(name)} is not finite")


@dataclass(frozen=True, eq=False)
class _Shape:
    """A geom that is made of a mesh, or of which only the pose is kept: then without the mesh."""

    geom: Any
    body: Any
    asset: MeshAsset | None
    is_missing: bool


def _lightened(spec: Any, path: Path, content: bytes, package_dirs: tuple[Path, ...], notes: list[str]) -> list[_Shape]:
    """Take out of a model what only a picture needs; the geoms that are meshes."""
    mujoco = import_mujoco()
    for compiler in _compilers(spec):
        compiler.discardvisual = compiler.fusestatic = False
    for skin in list(spec.skins):
        spec.delete(skin)
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for light in spec.lights:
        if hasattr(light, "texture"):
            light.texture = ""
    for texture in list(spec.textures):
        spec.delete(texture)
    used, found = set[str](), list[_Shape]()
    kind = mujoco.mjtGeom.mjGEOM_HFIELD
    fields = [(body, geom) for body in spec.bodies for geom in body.geoms if geom.type == kind]
    if fields:
        notes.append(f"height fields left out: {len(fields)}")
    for body, geom in fields:
        _make_speck(geom)
        found.append(_Shape(geom, body, None, False))
    for hfield in list(spec.hfields):
        spec.delete(hfield)
    meshes = {mesh.name: mesh for mesh in spec.meshes}
    search = MeshFiles(spec, path, content, package_dirs)
    files = {name: search.find(mesh) for name, mesh in meshes.items()}
    for body in spec.bodies:
        for geom in body.geoms:
            name = geom.meshname
            if name not in meshes:
                continue
            there = not meshes[name].file or files[name] is not None
            is_mesh = geom.type == mujoco.mjtGeom.mjGEOM_MESH
            if is_mesh or not there:
                home = path.absolute().parent
                asset = mesh_asset(meshes[name], files[name], home) if is_mesh else None
                found.append(_Shape(geom, body, asset, not there))
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
