"""The geoms of MuJoCo as visuals and collision shapes of links.

MJCF does not say which geoms are looks: MuJoCo shows the groups 0 to 2, and authors put collision shapes into 3 and
above. Here, too, those three groups are the visuals; all geoms are where they hold none. A geom that takes part in
contacts is a collision shape.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._text import abbreviated
from nao_kin.urdf.mjcf.compiled import Compiled
from nao_kin.urdf.mjcf.joints import origin, pose, translation
from nao_kin.urdf.visuals import Box, Collision, Cylinder, Geometry, MeshFile, Rgba, Sphere, Visual

# Kinds of geoms, as `mujoco.mjtGeom` numbers them.
_PLANE, _SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX, _MESH = 0, 2, 3, 4, 5, 6, 7
_LAST_VISIBLE_GROUP = 2
# The colour of a geom that is given none.
_DEFAULT = (0.5, 0.5, 0.5, 1.0)


class Shapes:
    """The geoms of the bodies of a robot.

    Attributes:
        visuals: what the links look like.
        visual_notes: what of it cannot be shown, one line each.
        collisions: the shapes that stand for the links in contacts.
        collision_notes: what of them is left out, one line each.
    """

    def __init__(self, compiled: Compiled, links: Mapping[int, str], path: Path) -> None:
        """Read the geoms.

        Args:
            compiled: the model.
            links: body → name of its link.
            path: the file, beside which mesh files are named.
        """
        self._compiled, self._model, self._folder = compiled, compiled.model, path.absolute().parent
        known = (geom for geom in range(int(self._model.ngeom)) if geom not in compiled.specks)
        geoms = [geom for geom in known if int(self._model.geom_bodyid[geom]) in links]
        seen = [geom for geom in geoms if int(self._model.geom_group[geom]) <= _LAST_VISIBLE_GROUP] or geoms
        visuals, collisions = list[Visual](), list[Collision]()
        for geom in geoms:
            link, name = links[int(self._model.geom_bodyid[geom])], str(self._model.geom(geom).name)
            for T_link_shape, geometry in self._parts(geom):
                place = origin(T_link_shape)
                if geom in seen:
                    visuals.append(Visual(link, place, geometry, self._material(geom), self._colour(geom), name))
                if self._model.geom_contype[geom] or self._model.geom_conaffinity[geom]:
                    collisions.append(Collision(link, place, geometry, name))
        self.visuals, self.collisions = tuple(visuals), tuple(collisions)
        self.visual_notes = tuple(self._notes(seen))
        self.collision_notes: tuple[str, ...] = ()

    def _parts(self, geom: int) -> Iterator[tuple[Floats, Geometry]]:
        """The shapes, with their poses in the link, that make a geom."""
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
            yield T_link_geom, Cylinder(a, 2.0 * b)
            for end in (b, -b):
                yield T_link_geom @ translation(np.array([0.0, 0.0, end])), Sphere(a)

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

    def _material(self, geom: int) -> str:
        material = int(self._model.geom_matid[geom])
        return str(self._model.mat(material).name) if material >= 0 else ""

    def _colour(self, geom: int) -> Rgba | None:
        """Its own colour, else that of its material."""
        r, g, b, a = (float(np.float32(value)) for value in self._model.geom_rgba[geom])
        if (r, g, b, a) != _DEFAULT:
            return r, g, b, a
        material = int(self._model.geom_matid[geom])
        if material < 0:
            return None
        r, g, b, a = (float(value) for value in self._model.mat_rgba[material])
        return r, g, b, a

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
