"""How far down the shapes of a robot reach that can touch the floor."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def lowest_point(model: Any, data: Any) -> float:
    """Least height of all geoms that can touch something; without any, of the bodies' frames [m]."""
    heights = [_lowest(model, data, geom) for geom in range(model.ngeom) if model.geom_contype[geom]]
    return min(heights) if heights else float(data.xpos[1:, 2].min())


def _lowest(model: Any, data: Any, geom: int) -> float:
    import mujoco

    kinds = mujoco.mjtGeom
    kind, size = kinds(int(model.geom_type[geom])), model.geom_size[geom]
    height, down = data.geom_xpos[geom, 2], data.geom_xmat[geom].reshape(3, 3)[2]
    if kind == kinds.mjGEOM_SPHERE:
        reach = size[0]
    elif kind == kinds.mjGEOM_CYLINDER:
        reach = abs(down[2]) * size[1] + math.hypot(down[0], down[1]) * size[0]
    elif kind == kinds.mjGEOM_BOX:
        reach = np.abs(down) @ size
    else:
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
        reach = -(vertices @ down).min()
    return float(height - reach)
