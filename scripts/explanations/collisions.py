"""The coupled limits against self-collision: where NAOqi's tables are stricter than the shapes, and where looser."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

import nao_kin as nk
from explanations.drawing import INK, ORANGE, Drawing, Floats
from explanations.limits import FREE, Chart
from nao_kin.robot.collision_pairs import LinkPair
from nao_kin.robot.link_shapes import LinkShapes
from nao_kin.robot.urdf import Collision

Mask = NDArray[np.bool_]
OVERLAP, TOUCH = ORANGE, "#b91c1c"
# Cells along both axes.
CELLS = 64, 48


def cells(nao: nk.NaoModel, joint: str, pairs: set[LinkPair]) -> tuple[Floats, Mask, Mask, Mask]:
    """Return corners of cells (k, 2, 2) [°], and whether shapes overlap, meshes touch, and the table allows them."""
    table = next(limit for limit in nao.coupled_limits if limit.joint == joint)
    columns = [nao.joint_names.index(name) for name in (table.of, joint)]
    edges = [np.linspace(nao.lower[c], nao.upper[c], n + 1) for c, n in zip(columns, CELLS, strict=True)]
    low = np.stack(np.meshgrid(*(edge[:-1] for edge in edges), indexing="ij"), axis=-1).reshape(-1, 2)
    high = np.stack(np.meshgrid(*(edge[1:] for edge in edges), indexing="ij"), axis=-1).reshape(-1, 2)
    q = np.tile(nao.posture("Stand"), (len(low), 1))
    q[:, columns] = 0.5 * (low + high)
    disabled = {pair: "" for pair in combinations(sorted(nao.link_shapes.links), 2) if pair not in pairs}
    overlap = LinkShapes(nao, nao.link_shapes.shapes, disabled=disabled).clearance(q).distance < 0.0
    rows = tuple(Collision(row.link, row.origin, row.geometry, row.name) for row in nao.tree.visuals)
    meshes = LinkShapes.exact(nk.RobotModel(replace(nao.tree, collisions=rows), nao.semantics))
    touch = np.zeros(len(q), bool)
    touch[[sample for _, sample in meshes.touching(q, pairs)]] = True
    return np.degrees(np.stack([low, high], axis=1)), overlap, touch, nao.within_limits(q)


def tables() -> Drawing:
    """Draw the ranges of both tables over the cells in which shapes overlap and meshes touch."""
    nao = nk.load_nao("v6")
    head = {(one, other) for one in ("Head",) for other in ("LShoulder", "RShoulder", "LBicep", "RBicep")}
    drawing = Drawing(760, 420, "The coupled limits of head and left ankle, and where shapes or meshes of links meet")
    size, foot = (62.0, 300.0, 270.0), {("LTibia", "l_ankle")}
    panels = (
        ("HeadPitch", "HeadYaw", head, (62.0, *size), (-130.0, 130.0), (-45.0, 35.0), (60.0, 10.0)),
        ("LAnkleRoll", "LAnklePitch", foot, (442.0, *size), (-75.0, 60.0), (-30.0, 50.0), (30.0, 10.0)),
    )
    for joint, of, pairs, box, x, y, steps in panels:
        chart = Chart(drawing, box, x, y, steps)
        corners, overlap, touch, _ = cells(nao, joint, pairs)
        if joint == "HeadPitch":  # foot and shin are too near to each other for their shapes
            _fill(drawing, chart, corners, overlap & ~touch, OVERLAP, 0.28)
        _fill(drawing, chart, corners, touch, TOUCH, 0.5)
        _, region, _ = chart.region(nao, joint)
        drawing.path(chart.at(region), stroke=FREE, width=2.6, closed=True)
        drawing.text((box[0], 40), f"{joint} over {of}", 14.5, INK, weight="600")
    for left, colour, opacity, words in (
        (62.0, TOUCH, 0.5, "meshes touch"),
        (200.0, OVERLAP, 0.28, "only the shapes overlap"),
    ):
        square = [(left, 380.0), (left + 16.0, 380.0), (left + 16.0, 396.0), (left, 396.0)]
        drawing.path(square, fill=colour, opacity=opacity, closed=True)
        drawing.text((left + 22.0, 393.0), words, 13.5, INK)
    drawing.line((412.0, 388.0), (430.0, 388.0), FREE, 2.6)
    drawing.text((436.0, 393.0), "NAOqi's table allows what is inside", 13.5, INK)
    return drawing


def _fill(drawing: Drawing, chart: Chart, corners: Floats, chosen: Mask, colour: str, opacity: float) -> None:
    """Fill cells; cells directly above one another are drawn as one rectangle."""
    places = np.flatnonzero(chosen)
    if not len(places):
        return
    breaks = np.flatnonzero((np.diff(places) > 1) | (places[1:] % CELLS[1] == 0)) + 1
    for run in np.split(places, breaks):
        (x0, y0), (x1, y1) = corners[run[0], 0], corners[run[-1], 1]
        drawing.path(chart.at([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]), fill=colour, opacity=opacity, closed=True)


FIGURES = {"collision_tables": tables}
