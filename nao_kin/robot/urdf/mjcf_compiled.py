"""The model that MuJoCo compiles from an MJCF file, which resolves includes, classes, angles and inertias.

Shapes never prevent a robot from loading. Textures, height fields and skins are removed first, and a mesh is loaded
only if the mass of a body depends on it; so a robot with many meshes loads in milliseconds.
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._core.arrays import Floats, join_poses
from nao_kin._core.process import before_ending
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import mujoco_warnings, need_extra
from nao_kin.errors import BadModel
from nao_kin.robot.urdf.document import Packages
from nao_kin.robot.urdf.tree import (
    Box,
    Collision,
    Cylinder,
    Geometry,
    MeshFile,
    Origin,
    Rgba,
    Sphere,
    Visual,
    capsule_parts,
)
from nao_kin.rotations import matrix_from_quat


def pose(position: Any, quaternion: Any) -> Floats:
    """Return a pose (4, 4) from MuJoCo's position and quaternion (scalar first)."""
    unit = np.array(quaternion, dtype=np.float64)
    return join_poses(matrix_from_quat(unit / np.linalg.norm(unit)), np.asarray(position))


def translation(by: Floats) -> Floats:
    """Return a pose (4, 4) without rotation."""
    return join_poses(np.eye(3), by)


# --- The mesh files of an MJCF.


@dataclass(frozen=True, eq=False)
class MeshAsset:
    """A mesh of a model."""

    path: Path | None
    scale: Floats  # factors along its axes
    T_mesh_file: Floats  # pose of the scaled file's coordinates in the mesh (refpos and refquat)
    is_rigid: bool  # False for a mesh that is turned and then scaled unevenly, which shears it


def mesh_asset(mesh: Any, file: Path | None, home: Path) -> MeshAsset:
    """Return a mesh of a `mujoco.MjSpec`; `file` is its file if found, `home` the folder of the MJCF."""
    if file is None and mesh.file:
        file = home / mesh.file
    scale = np.array(mesh.scale, dtype=np.float64)
    T_mesh_file = np.asarray(np.linalg.inv(pose(mesh.refpos, mesh.refquat)), dtype=np.float64)
    T_mesh_file[:3, 3] *= scale  # MuJoCo moves and turns the vertices before it scales them
    R = T_mesh_file[:3, :3]
    return MeshAsset(file, scale, T_mesh_file, bool(np.allclose(scale[:, None] * R, R * scale)))


class MeshFiles:
    """The search for the mesh files of a `mujoco.MjSpec`; the folders that the caller gives are searched last."""

    def __init__(self, spec: Any, path: Path, content: bytes, folders: tuple[Path, ...]) -> None:
        self._spec, self._home, self._folders = spec, path.parent, folders
        self._packages = Packages(path, folders)
        # Prefix of mesh names, folder and `meshdir` of the attached models, longest prefix first.
        self._attached = sorted(_attached(path, content), key=lambda found: -len(found[0]))

    def find(self, mesh: Any) -> Path | None:
        """Return the file of a mesh, or None; tell MuJoCo of a file that is not where it looks."""
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
        except (OSError, ValueError):  # an invalid name
            return None
        if found is not None:
            mesh.file = str(found.absolute())
        return found

    def _where_mujoco_looks(self, mesh: Any) -> Iterator[Path]:
        """Yield the folder of the file that has the mesh, with its `meshdir`: an attached model or this one."""
        own = getattr(mesh, "compiler", None)
        meshdirs = [str(getattr(where, "meshdir", "")) for where in (own, self._spec.compiler, self._spec) if where]
        for prefix, folder, meshdir in self._attached:
            if prefix and str(mesh.name).startswith(prefix):
                yield from (folder / inner for inner in dict.fromkeys((meshdir, *meshdirs)))
        yield from (self._home / meshdir for meshdir in dict.fromkeys(meshdirs))
        yield from (folder / meshdir for prefix, folder, meshdir in self._attached if not prefix)


def _attached(path: Path, content: bytes | None = None) -> Iterator[tuple[str, Path, str]]:
    """Yield prefix, folder and `meshdir` of the models that a file attaches, and of the models that these attach."""
    elements, models = list(_elements(path, path.parent, content)), dict[str, ET.Element]()
    for element in elements:
        if element.tag == "model":
            file = path.parent / element.get("file", "")
            named = (root.get("model", "") for root in _elements(file, file.parent))
            models[element.get("name") or next(named, "")] = element
    for element in elements:
        model = models.get(element.get("model", "")) if element.tag == "attach" else None
        if model is not None:
            prefix, file = element.get("prefix", ""), path.parent / model.get("file", "")
            compilers = [inner for inner in _elements(file, file.parent) if inner.tag == "compiler"]
            meshdirs = [inner.get("meshdir", inner.get("assetdir", "")) for inner in compilers]
            yield prefix, file.parent, next(filter(None, meshdirs), "")
            yield from ((prefix + inner, folder, meshdir) for inner, folder, meshdir in _attached(file))


def _elements(
    path: Path, home: Path, content: bytes | None = None, seen: frozenset[Path] = frozenset()
) -> Iterator[ET.Element]:
    """Yield the elements of a file and of the files that it includes, without files that are not readable XML."""
    try:
        if path in seen or (content is None and not path.is_file()):
            return
        document = ET.fromstring(path.read_bytes() if content is None else content)
    except (OSError, ET.ParseError, ValueError):
        return
    for element in document.iter():
        yield element
        if element.tag == "include":
            name = element.get("file", "")
            inner = (path.parent if (path.parent / name).is_file() else home) / name
            yield from _elements(inner, home, seen=seen | {path})


# --- The compiled model.

# In MuJoCo a moving body must have a mass. A body whose meshes are missing gets this mass, which is not used later.
_NO_MASS = 1e-14
_TINY = 1e-3
# Arrays that must be finite; ranges may be infinite.
_FINITE = (
    "body_pos body_quat body_ipos body_iquat body_mass body_inertia jnt_pos jnt_axis geom_pos geom_quat geom_size "
    "site_pos site_quat cam_pos cam_quat"
).split()
_KINDS = {"jnt": "joint", "cam": "camera"}


@dataclass(frozen=True, eq=False)
class Compiled:
    """A compiled model."""

    model: Any  # the `mujoco.MjModel`
    name: str
    meshes: Mapping[int, MeshAsset]  # geom id → its mesh
    loaded: frozenset[int]  # geom ids whose meshes MuJoCo has loaded, and moved to their centres of mass
    shapeless: frozenset[int]  # geom ids of which only the pose is known, not the shape

    def has_mass(self, body: int) -> bool:
        """Return whether a body's mass is known and positive."""
        return bool(self.model.body_mass[body] > 2.0 * _NO_MASS)


def import_mujoco() -> ModuleType:
    """Return the module MuJoCo."""
    need_extra("reading MJCF", "mujoco")
    import mujoco

    module: ModuleType = mujoco
    return module


def compile_mjcf(path: Path, content: bytes, package_dirs: tuple[Path, ...], notes: list[str]) -> Compiled:
    """Return the compiled model of a file that contains `content`; note missing meshes and MuJoCo's warnings."""
    mujoco = import_mujoco()
    if not _is_bounded(path, content):
        _rehearse(path, content, package_dirs)
    try:
        spec, shapes, model = _by_mujoco(path, content, package_dirs, notes)
    except (ValueError, RuntimeError, MemoryError, mujoco.FatalError) as error:
        raise BadModel(f"{path}: MuJoCo refuses it: {abbreviated(error) or type(error).__name__}") from None
    _check_finite(model, path)
    kind = int(mujoco.mjtGeom.mjGEOM_MESH)
    meshes = {int(shape.geom.id): shape.asset for shape in shapes if shape.asset is not None}
    shapeless = frozenset(int(shape.geom.id) for shape in shapes if shape.asset is None)
    loaded = frozenset(geom for geom in meshes if int(model.geom_type[geom]) == kind)
    name = "" if spec.modelname == "MuJoCo Model" else str(spec.modelname)
    return Compiled(model, name, meshes, loaded, shapeless)


def _by_mujoco(
    path: Path, content: bytes, package_dirs: tuple[Path, ...], notes: list[str]
) -> tuple[Any, list[_Shape], Any]:
    """Return the `mujoco.MjSpec` of a file, its geoms whose shape is a mesh or a height field, and its model."""
    mujoco = import_mujoco()
    with mujoco_warnings(mujoco) as warned:
        spec = _parsed(mujoco, path, content)
        shapes = _strip_shapes(spec, path, content, package_dirs, notes)
        model = _compiled(spec, shapes, notes)
    notes += [f"MuJoCo says: {abbreviated(text)}" for text in dict.fromkeys(warned)]
    return spec, shapes, model


# --- Files whose numbers, and not their size, determine how long MuJoCo works and how much memory it takes.
#
# A call into MuJoCo takes no signal: neither Ctrl-C nor TERM ends it. Such files are first compiled in another process,
# which has limits and can be ended.

_SECONDS, _BYTES = 30, 4 << 30
_COPYING = frozenset(("replicate", "flexcomp", "composite", "model"))
# Elements with such an attribute are made by a formula.
_MADE_BY = {"mesh": "builtin", "hfield": "nrow"}
_LARGE = re.compile(r"(?<![\w.])\d{6,}(?![\w.])")
_REHEARSAL = "import sys; from nao_kin.robot.urdf.mjcf_compiled import rehearsal; rehearsal(*sys.argv[1:])"


def _is_bounded(path: Path, content: bytes) -> bool:
    """Return whether an MJCF, with the files that it includes, has no copies, formulas or large whole numbers."""
    elements = list(_elements(path, path.parent, content))
    return bool(elements) and not any(
        element.tag in _COPYING
        or _MADE_BY.get(element.tag) in element.attrib
        or any(map(_LARGE.search, element.attrib.values()))
        for element in elements
    )


def _rehearse(path: Path, content: bytes, package_dirs: tuple[Path, ...]) -> None:
    """Compile a file in another process; raise BadModel if that takes too long or too much memory."""
    import subprocess

    # In a frozen program, or in one that embeds Python, `sys.executable` is not Python.
    if not Path(sys.executable or "").name.startswith("python") or getattr(sys, "frozen", False):
        return
    places = [str(Path(__file__).parents[3]), *(entry for entry in sys.path if entry)]
    process = subprocess.Popen(
        [sys.executable, "-c", _REHEARSAL, str(path), *map(str, package_dirs)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(places), "OPENBLAS_NUM_THREADS": "1"},
    )
    with process, before_ending(process.kill):
        try:
            process.communicate(content, timeout=_SECONDS)
        except subprocess.TimeoutExpired:
            pass
        finally:
            process.kill()
    if process.returncode:
        raise BadModel(
            f"{path}: MuJoCo does not compile it within {_SECONDS} s and {_BYTES >> 30} GB: "
            "it replicates too much, or names too large a number"
        )


def rehearsal(path: str, *package_dirs: str) -> None:
    """Compile the file that standard input contains; raise an error if the time or the memory does not suffice."""
    import resource

    for limit, most in (("RLIMIT_CPU", 2 * _SECONDS), ("RLIMIT_AS", _BYTES)):
        with contextlib.suppress(OSError, ValueError):  # a lower limit of the system
            resource.setrlimit(getattr(resource, limit), (most, most))
    try:
        _by_mujoco(Path(path), sys.stdin.buffer.read(), tuple(map(Path, package_dirs)), [])
    except (ValueError, import_mujoco().FatalError) as error:  # the caller finds the same
        if "allocate" in str(error):
            raise


def _parsed(mujoco: ModuleType, path: Path, content: bytes) -> Any:
    """Return the `mujoco.MjSpec` of a file; from MuJoCo 4 on it reads MJCF only from files named .xml."""
    if path.suffix == ".xml" and path.is_file():
        return mujoco.MjSpec.from_file(str(path))
    # The content gets another name: MuJoCo would confuse it with an attached file of its own name, in any folder, and
    # hang.
    name = f"{path}.xml"
    return mujoco.MjSpec.from_file(name, include={name: content})


def _compiled(spec: Any, shapes: list[_Shape], notes: list[str]) -> Any:
    """Return the `mujoco.MjModel`, with massless bodies if their masses depend on missing meshes."""
    try:
        return spec.compile()
    except ValueError:
        if not any(shape.is_missing for shape in shapes):
            raise
        for compiler in _compilers(spec):
            compiler.boundmass = compiler.boundinertia = _NO_MASS
        # In MuJoCo 3.3 the bounds do not apply to the bodies of attached models.
        for body in (shape.body for shape in shapes if shape.is_missing):
            if not body.explicitinertial and all(geom.mass == 0.0 for geom in body.geoms):
                body.explicitinertial, body.mass, body.inertia = True, _NO_MASS, [_NO_MASS] * 3
        model = spec.compile()
        notes.append("bodies whose masses depend on missing meshes are taken as massless")
        return model


def _compilers(spec: Any) -> list[Any]:
    """Return the compiler settings of the model and of the models that it attaches."""
    return [spec.compiler, *(body.compiler for body in spec.bodies if getattr(body, "compiler", None) is not None)]


def _check_finite(model: Any, path: Path) -> None:
    """Refuse poses and masses that are not finite, which MuJoCo accepts."""
    for array in _FINITE:
        bad = np.argwhere(~np.isfinite(getattr(model, array)))
        if bad.size:
            short, _, part = array.partition("_")
            kind = _KINDS.get(short, short)
            name = str(getattr(model, kind)(int(bad[0, 0])).name) or str(bad[0, 0])
            raise BadModel(f"{path}: the {part} of {kind} {quoted(name)} is not finite")


@dataclass(frozen=True, eq=False)
class _Shape:
    """A geom with a mesh; `asset` is None for a geom of which only the pose is known."""

    geom: Any
    body: Any
    asset: MeshAsset | None
    is_missing: bool


def _strip_shapes(
    spec: Any, path: Path, content: bytes, package_dirs: tuple[Path, ...], notes: list[str]
) -> list[_Shape]:
    """Remove textures, skins and unused meshes; return the geoms whose shape is a mesh or a height field."""
    mujoco = import_mujoco()
    for compiler in _compilers(spec):
        compiler.discardvisual = compiler.fusestatic = False
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for light in spec.lights:
        if hasattr(light, "texture"):
            light.texture = ""
    geoms = [(body, geom) for body in spec.bodies for geom in body.geoms]
    fields = [(body, geom) for body, geom in geoms if geom.type == mujoco.mjtGeom.mjGEOM_HFIELD]
    if fields:
        notes.append(f"height fields left out: {len(fields)}")
    for _, geom in fields:
        _remove_shape(geom)
    used, found = set[str](), [_Shape(geom, body, None, False) for body, geom in fields]
    for element in (*spec.skins, *spec.textures, *spec.hfields):
        spec.delete(element)
    meshes = {mesh.name: mesh for mesh in spec.meshes}
    search = MeshFiles(spec, path, content, package_dirs)
    files = {name: search.find(mesh) for name, mesh in meshes.items()}
    for body, geom in geoms:
        name = geom.meshname
        if name not in meshes:
            continue
        available = not meshes[name].file or files[name] is not None
        is_mesh = geom.type == mujoco.mjtGeom.mjGEOM_MESH
        if is_mesh or not available:
            asset = mesh_asset(meshes[name], files[name], path.parent) if is_mesh else None
            found.append(_Shape(geom, body, asset, not available))
        if available and (not meshes[name].file or not is_mesh or _gives_mass(spec, body, geom)):
            used.add(name)  # a primitive is fitted to its mesh
        else:
            _remove_shape(geom)
    for site in spec.sites:
        if getattr(site, "meshname", "") in meshes:
            site.meshname, site.type = "", mujoco.mjtGeom.mjGEOM_SPHERE
    # Soft bodies may use any mesh.
    for name in () if len(spec.flexes) else meshes.keys() - used:
        if meshes[name].file:
            spec.delete(meshes[name])
    missing = sorted(meshes[name].file for name in meshes if meshes[name].file and files[name] is None)
    if missing:
        count = sum(bool(mesh.file) for mesh in meshes.values())
        notes.append(f"{len(missing)} of {count} mesh files are missing, first {quoted(missing[0])}")
    return found


def _remove_shape(geom: Any) -> None:
    """Replace a geom by a tiny massless sphere, so that only its pose is compiled."""
    mujoco = import_mujoco()
    geom.type, geom.meshname, geom.hfieldname = mujoco.mjtGeom.mjGEOM_SPHERE, "", ""
    geom.size, geom.mass, geom.fromto = [_TINY] * 3, 0.0, [math.nan] * 6


def _gives_mass(spec: Any, body: Any, geom: Any) -> bool:
    """Return whether the mass or the tensor of the body depends on the shape of the geom."""
    compiler = getattr(body, "compiler", None) or spec.compiler
    if body.explicitinertial and int(compiler.inertiafromgeom) != 1:  # 1: always
        return False
    return bool(geom.mass != 0.0 and (not math.isnan(geom.mass) or geom.density != 0.0))


# --- The geoms of MuJoCo as visuals and collision shapes of links.
#
# MJCF does not mark visuals: MuJoCo shows the groups 0 to 2, and authors put collision shapes into 3 and above. Here,
# too, these three groups are the visuals, or all geoms if the groups are empty. A geom with contacts is a collision
# shape.

# Kinds of geoms, as `mujoco.mjtGeom` numbers them.
_SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX, _MESH = range(2, 8)
_LAST_VISIBLE_GROUP = 2
# The default colour of a geom.
_DEFAULT = (0.5, 0.5, 0.5, 1.0)


class Shapes:
    """The geoms of a robot's bodies as `visuals`, `visual_notes` and `collisions` of links."""

    def __init__(self, compiled: Compiled, links: Mapping[int, str], path: Path) -> None:
        """Convert the geoms of the bodies in `links`, body → link; mesh files are named relative to `path`."""
        self._compiled, self._model, self._folder = compiled, compiled.model, path.parent
        known = (geom for geom in range(int(self._model.ngeom)) if geom not in compiled.shapeless)
        geoms = [geom for geom in known if int(self._model.geom_bodyid[geom]) in links]
        seen = [geom for geom in geoms if int(self._model.geom_group[geom]) <= _LAST_VISIBLE_GROUP] or geoms
        visuals, collisions = list[Visual](), list[Collision]()
        for geom in geoms:
            link, name = links[int(self._model.geom_bodyid[geom])], str(self._model.geom(geom).name)
            for T_link_shape, geometry in self._parts(geom):
                place = Origin.of(T_link_shape)
                if geom in seen:
                    visuals.append(Visual(link, place, geometry, *self._paint(geom), name))
                if self._model.geom_contype[geom] or self._model.geom_conaffinity[geom]:
                    collisions.append(Collision(link, place, geometry, name))
        self.visuals, self.collisions = tuple(visuals), tuple(collisions)
        self.visual_notes = tuple(self._notes(seen))

    def _parts(self, geom: int) -> Iterator[tuple[Floats, Geometry]]:
        """Yield the shapes that make a geom, with their poses in the link."""
        model, kind = self._model, int(self._model.geom_type[geom])
        T_link_geom = pose(model.geom_pos[geom], model.geom_quat[geom])
        a, b, c = (float(size) for size in model.geom_size[geom])
        if geom in self._compiled.meshes:
            yield from self._mesh(geom, T_link_geom)
        elif kind == _SPHERE:
            yield T_link_geom, Sphere(a)
        elif kind == _ELLIPSOID:
            yield T_link_geom, Sphere(float(np.cbrt(a * b * c)))
        elif kind == _CYLINDER:
            yield T_link_geom, Cylinder(a, 2.0 * b)
        elif kind == _BOX:
            yield T_link_geom, Box((2.0 * a, 2.0 * b, 2.0 * c))
        elif kind == _CAPSULE:
            yield from capsule_parts(T_link_geom, a, 2.0 * b)

    def _mesh(self, geom: int, T_link_geom: Floats) -> Iterator[tuple[Floats, Geometry]]:
        asset = self._compiled.meshes[geom]
        if asset.path is None:
            return
        if geom in self._compiled.loaded:
            mesh = int(self._model.geom_dataid[geom])
            T_link_geom = T_link_geom @ np.linalg.inv(pose(self._model.mesh_pos[mesh], self._model.mesh_quat[mesh]))
        x, y, z = (float(factor) for factor in asset.scale)
        try:
            name = os.path.relpath(asset.path, self._folder)
        except ValueError:  # on another drive
            name = str(asset.path)
        yield T_link_geom @ asset.T_mesh_file, MeshFile(Path(name).as_posix(), (x, y, z))

    def _paint(self, geom: int) -> tuple[str, Rgba | None]:
        """Return the name of a geom's material, and the geom's own colour or else that of its material."""
        material = int(self._model.geom_matid[geom])
        name = str(self._model.mat(material).name) if material >= 0 else ""
        r, g, b, a = (float(np.float32(value)) for value in self._model.geom_rgba[geom])
        if (r, g, b, a) == _DEFAULT:
            if material < 0:
                return name, None
            r, g, b, a = (float(value) for value in self._model.mat_rgba[material])
        return name, (r, g, b, a)

    def _notes(self, seen: list[int]) -> Iterator[str]:
        kinds = [int(self._model.geom_type[geom]) for geom in seen]
        if count := kinds.count(_ELLIPSOID):
            yield f"{count} ellipsoids are shown as spheres of the same volume"
        if sheared := sum(geom in self._compiled.meshes and not self._compiled.meshes[geom].is_rigid for geom in seen):
            yield f"{sheared} meshes that are turned and then scaled unevenly are shown without that shear"
        unseen = [
            geom
            for geom, kind in zip(seen, kinds, strict=True)
            if kind > _MESH or (geom in self._compiled.meshes and self._compiled.meshes[geom].path is None)
        ]
        if unseen:
            names = ", ".join(str(self._model.geom(geom).name) or f"geom {geom}" for geom in unseen)
            yield f"{len(unseen)} shapes that come from no file are not shown: {abbreviated(names, 100)}"
