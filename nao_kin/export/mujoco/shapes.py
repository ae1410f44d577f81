"""Visual and collision shapes as MuJoCo's geoms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from nao_kin._common.free_names import fresh_name
from nao_kin.export.mujoco.bodies import Bodies
from nao_kin.export.mujoco.frames import pos_quat, pose
from nao_kin.export.mujoco.mesh_files import MeshFiles
from nao_kin.urdf import Box, Collision, Cylinder, Geometry, MeshFile, Rgba, Sphere, UrdfTree, Visual

VISUAL, COLLISION = "visual", "collision"
_VISUAL_GROUP, _COLLISION_GROUP = 2, 3
_GREY: Rgba = (0.7, 0.7, 0.7, 1.0)


class Shapes:
    """Adds geoms to the bodies of a specification; of two classes, that say which touch and in which group they are."""

    def __init__(self, spec: Any, added: list[Any], bodies: Bodies, files: MeshFiles | None) -> None:
        """Prepare the two classes.

        Args:
            spec: the specification.
            added: what it has for each body.
            bodies: of the robot.
            files: where mesh files go; None leaves out the shapes of meshes.
        """
        self._spec, self._files = spec, files
        self._bodies = {
            link: (one, T) for body, one in zip(bodies.bodies, added, strict=True) for link, T in body.links.items()
        }
        self._names: set[str] = set()
        self._materials: dict[tuple[str, Rgba], str] = {}
        self._meshes: dict[tuple[str, tuple[float, ...]], str] = {}
        self._visual = spec.add_default(VISUAL, spec.default)
        self._visual.geom.group = _VISUAL_GROUP
        self._visual.geom.contype = self._visual.geom.conaffinity = 0
        self._collision = spec.add_default(COLLISION, spec.default)
        self._collision.geom.group = _COLLISION_GROUP

    def add(self, tree: UrdfTree) -> tuple[str, ...]:
        """Add all shapes of a tree.

        Returns:
            One line for what is left out.
        """
        everything: tuple[Visual | Collision, ...] = (*tree.visuals, *tree.collisions)
        meshes = [shape for shape in everything if isinstance(shape.geometry, MeshFile)]
        for visual in self._kept(tree.visuals):
            geom = self._add(visual, self._visual, f"{visual.link}_{VISUAL}")
            if visual.material or visual.rgba:
                geom.material = self._material(visual.material or "colour", visual.rgba or _GREY)
        for collision in self._kept(tree.collisions):
            self._add(collision, self._collision, f"{collision.link}_{COLLISION}")
        if self._files is not None:
            return ()
        return (f"{len(meshes)} shapes that are meshes are left out",) if meshes else ()

    def _kept(self, shapes: tuple[Any, ...]) -> Iterator[Any]:
        return (shape for shape in shapes if self._files is not None or not isinstance(shape.geometry, MeshFile))

    def _add(self, shape: Visual | Collision, default: Any, name: str) -> Any:
        one, T_link = self._bodies[shape.link]
        T_shape = T_link * pose(shape.origin)
        geom = one.add_geom(default, name=self._free(shape.name or name), **pos_quat(T_shape))
        self._set_geometry(geom, shape.geometry)
        return geom

    def _set_geometry(self, geom: Any, geometry: Geometry) -> None:
        import mujoco

        kinds = mujoco.mjtGeom
        if isinstance(geometry, Box):
            geom.type, geom.size = kinds.mjGEOM_BOX, [0.5 * length for length in geometry.size]
        elif isinstance(geometry, Cylinder):
            geom.type, geom.size = kinds.mjGEOM_CYLINDER, [geometry.radius, 0.5 * geometry.length, 0.0]
        elif isinstance(geometry, Sphere):
            geom.type, geom.size = kinds.mjGEOM_SPHERE, [geometry.radius, 0.0, 0.0]
        else:
            geom.type, geom.meshname = kinds.mjGEOM_MESH, self._mesh(geometry)

    def _mesh(self, geometry: MeshFile) -> str:
        import mujoco

        assert self._files is not None
        file = self._files.add(geometry)
        key = file, geometry.scale
        if key not in self._meshes:
            stem = file.rpartition(".")[0]
            self._meshes[key] = name = fresh_name(stem, self._meshes.values())
            # The masses are those of the bodies: a mesh may be open, or flat.
            shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
            self._spec.add_mesh(name=name, file=file, scale=geometry.scale, inertia=shell)
        return self._meshes[key]

    def _material(self, name: str, rgba: Rgba) -> str:
        if (name, rgba) not in self._materials:
            self._materials[name, rgba] = free = fresh_name(name, self._materials.values())
            self._spec.add_material(name=free, rgba=rgba)
        return self._materials[name, rgba]

    def _free(self, name: str) -> str:
        free = fresh_name(name, self._names)
        self._names.add(free)
        return free
