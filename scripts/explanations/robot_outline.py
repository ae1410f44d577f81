"""The robot as pale shapes behind a figure: the visible outline of each link's shape."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull

import nao_kin as nk
from explanations.drawing import LINE, Drawing, Floats, View

SHADE = "#eef0f3"


@lru_cache
def nao_shapes() -> tuple[nk.NaoModel, tuple[tuple[int, Floats], ...]]:
    """Return the NAO, and for each of its shapes the joint that carries it and its corners there."""
    nao = nk.load_nao()
    folder = str(nao.urdf_path.parent)
    shapes = pin.buildGeomFromUrdf(nao.model, str(nao.urdf_path), pin.GeometryType.VISUAL, package_dirs=[folder])
    found = []
    for shape in shapes.geometryObjects:
        if not hasattr(shape.geometry, "vertices"):
            continue
        corners = np.asarray(shape.geometry.vertices()) * shape.meshScale
        hull = corners[np.sort(ConvexHull(corners).vertices)]
        found.append((shape.parentJoint, hull @ shape.placement.rotation.T + shape.placement.translation))
    return nao, tuple(found)


def coarse(outline: Floats, detail: float = 2.5) -> list[Floats]:
    """Return an outline without corners that are closer than `detail` [pixels] to the previous corner."""
    kept = [outline[0]]
    for point in outline[1:]:
        if np.linalg.norm(point - kept[-1]) > detail:
            kept.append(point)
    return kept


def draw_robot(
    drawing: Drawing,
    view: View,
    q: Floats,
    only: str = "",
    fill: str = SHADE,
    stroke: str = LINE,
    detail: float = 2.5,
) -> None:
    """Draw the outlines of all links, back to front.

    Args:
        drawing: the drawing.
        view: the view.
        q: the configuration.
        only: a joint, to draw only its links and all that they carry; empty for all.
        fill: the colour of the shapes.
        stroke: the colour of their edges.
        detail: the smallest distance of two corners of an outline [pixels].
    """
    nao, shapes = nao_shapes()
    data = nao.model.createData()
    pin.forwardKinematics(nao.model, data, q)
    drawn = []
    for joint, corners in shapes:
        if only and nao.model.getJointId(only) not in nao.model.supports[joint]:
            continue
        placed = corners @ data.oMi[joint].rotation.T + data.oMi[joint].translation
        points = view.flat(placed)
        outline = points[ConvexHull(points).vertices]
        outline = np.roll(outline, -int(np.lexsort(outline.T)[0]), axis=0)
        drawn.append((float(np.mean(placed @ view.towards)), coarse(outline, detail)))
    for _, outline in sorted(drawn, key=lambda item: item[0]):
        drawing.path(outline, fill=fill, stroke=stroke, width=0.8, closed=True)
