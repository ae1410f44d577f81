"""The polygon on which a robot stands, beside hulls that SciPy makes of the corners of its soles."""

from __future__ import annotations

import numpy as np
import pytest
from loops import for_all
from scipy.spatial import ConvexHull

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.robot.support_polygon import sole_corners


@for_all("posture", ["Stand", "StandInit", "StandZero", "Crouch"])
@for_all("soles", [None, ["LLeg"], ["RLeg"], ["RLeg", "LLeg"]])
def test_it_is_the_hull_of_the_corners_of_the_soles(
    each_nao: nk.NaoModel, posture: str, soles: list[str] | None
) -> None:
    q = each_nao.posture(posture)
    names = list(each_nao.semantics.soles) if soles is None else soles
    polygon = each_nao.support_polygon(q, soles)
    points = []
    for name in names:
        T = np.linalg.inv(each_nao.fk(q, names[0])) @ each_nao.fk(q, name)
        points.append(sole_corners(each_nao, name) @ T[:3, :3].T + T[:3, 3])
    hull = ConvexHull(np.concatenate(points)[:, :2])
    area = 0.5 * abs(np.linalg.det(np.stack([polygon.vertices, np.roll(polygon.vertices, -1, axis=0)], axis=1)).sum())
    assert area == pytest.approx(hull.volume, rel=1e-9)  # of a plane hull SciPy calls the area its volume
    assert polygon.signed_distance(np.concatenate(points)) == pytest.approx(
        np.abs(polygon.signed_distance(np.concatenate(points))), abs=1e-12
    )


def test_a_reference_moves_its_vertices(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    own, torso = nao.support_polygon(q), nao.support_polygon(q, reference="Torso")
    T = nao.fk(q, nao.semantics.soles[0])
    moved = np.column_stack([own.vertices, np.zeros(len(own.vertices))]) @ T[:3, :3].T + T[:3, 3]
    assert np.abs(torso.signed_distance(moved)).max() < 1e-12


def test_points_on_an_edge_are_not_vertices() -> None:
    points = [[0, 0], [1, 0], [0.5, 0], [1, 1], [1, 0.25], [0, 1], [0, 0.5], [0, 0]]
    vertices = nk.robot.SupportPolygon.around(points).vertices.tolist()
    assert vertices == [[0, 0], [1, 0], [1, 1], [0, 1]]


def test_the_distance_from_a_rectangle_is_that_of_its_closed_form() -> None:
    """Beside an edge, beyond a corner and inside: with d = |p − c| − h, outside it is the length of max(d, 0)."""
    half, turn, centre = np.array([0.3, 0.1]), nk.rotations.rot_z(0.4)[:2, :2], np.array([0.2, -0.1])
    corners = half * [[1, 1], [-1, 1], [-1, -1], [1, -1]] @ turn.T + centre
    offsets = np.random.default_rng(0).uniform(-3.0, 3.0, (500, 2)) * half
    offsets[:4] = half * [[1.5, 1.5], [-1.5, 1.5], [-1.5, -1.5], [1.5, -1.5]]
    d = np.abs(offsets) - half
    expected = -np.linalg.norm(np.maximum(d, 0.0), axis=-1) - np.minimum(d.max(axis=-1), 0.0)
    found = nk.robot.SupportPolygon.around(corners).signed_distance(offsets @ turn.T + centre)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_what_has_no_polygon_is_refused(nao: nk.NaoModel) -> None:
    q = nao.posture("Stand")
    with pytest.raises(WrongShape, match="one configuration"):
        nao.support_polygon(np.stack([q, q]))
    with pytest.raises(UnknownName, match="LFot"):
        nao.support_polygon(q, ["LFot"])
    with pytest.raises(BadArgument, match="soles must name at least one frame"):
        nao.support_polygon(q, [])
    with pytest.raises(BadArgument, match="no outline of Head"):
        nao.support_polygon(q, ["Head"])
