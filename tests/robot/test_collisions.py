"""Self-collision against coal: distances of shapes, clearances of robots, and verdicts on the meshes."""

from __future__ import annotations

import pickle
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin._kernels import capsules as kernels
from nao_kin.errors import BadArgument, MissingShapeWarning, NaoKinError, UnknownName
from nao_kin.robot import LinkContacts, LinkShapes, mesh_path, read_mesh
from nao_kin.robot.collisions import covering_capsule
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf import Box, Collision, Cylinder, Origin, Sphere
from nao_kin.rotations import random_rotation

SIGNED = coal.DistanceRequest()
SIGNED.enable_signed_distance = True

# --- Distances of two shapes.

LENGTHS = st.sampled_from([0.0, 1e-12, 1e-6, 0.03, 0.1])
CENTRES = st.sampled_from([0.0, 1e-9, 0.02, 0.1, 0.15, 0.2, 0.3])
TURNS = st.sampled_from(["none", "quarter", "tiny", "any"])


def _turn(kind: str, seed: int) -> np.ndarray:
    if kind == "any":
        return random_rotation(seed)
    if kind == "tiny":
        return nk.rotations.exp(1e-8 * np.random.default_rng(seed).normal(size=3))
    return np.eye(3)[[1, 2, 0]] if kind == "quarter" else np.eye(3)


def _gap(kinds: tuple[int, int], halves: np.ndarray, radii: np.ndarray, T: np.ndarray, *, compiled: bool) -> float:
    reach = np.linalg.norm(halves, axis=1) + radii
    table = kernels.ShapeTable(
        np.arange(2), np.array(kinds), np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1)), halves, radii, reach
    )
    pairs = np.array([[0, 1]])
    if not compiled:
        return float(kernels.pair_gaps(T[None, :, :3, 3], T[None, :, :3, :3], table, pairs, np.zeros(1, int))[0])
    gaps, which = np.empty(1), np.empty(1, np.int64)
    kernels.clearances(T[None], table, pairs, np.inf, gaps, which)
    assert which[0] == 0
    return float(gaps[0])


def _coals(kind: int, half: np.ndarray, radius: float) -> Any:
    if kind == kernels.BOX:
        return coal.Box(*(2.0 * half))
    return coal.Capsule(radius, 2.0 * half[2]) if half[2] > 1e-9 else coal.Sphere(radius)


@pytest.mark.parametrize("kinds", [(0, 0), (1, 0), (1, 1)])
@settings(max_examples=150)
@given(
    st.tuples(LENGTHS, LENGTHS),
    st.tuples(*[CENTRES] * 3),
    st.tuples(TURNS, TURNS),
    st.tuples(*[st.sampled_from([-1.0, 1.0])] * 3),
    st.integers(0, 10_000),
)
def test_distances_are_those_of_coal_parallel_crossing_or_degenerate(
    kinds: tuple[int, int], lengths: Any, centre: Any, turns: Any, signs: Any, seed: int
) -> None:
    halves = np.array([(0.05, 0.03, 0.08) if kind else (0.0, 0.0, n) for kind, n in zip(kinds, lengths, strict=True)])
    radii = np.where(np.array(kinds) == kernels.BOX, 0.0, [0.02, 0.03])
    T = np.tile(np.eye(4), (2, 1, 1))
    T[:, :3, :3] = [_turn(turn, seed + k) for k, turn in enumerate(turns)]
    T[1, :3, 3] = np.multiply(signs, centre)
    found = _gap(kinds, halves, radii, T, compiled=False)
    result = coal.DistanceResult()
    one, other = (_coals(k, h, r) for k, h, r in zip(kinds, halves, radii, strict=True))
    places = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in T]
    expected = coal.distance(one, places[0], other, places[1], SIGNED, result)
    if expected >= 0.0 or kinds == (0, 0):
        # Between crossing segments the direction, and with it coal's depth, is not defined.
        assert found == pytest.approx(expected, abs=3e-6)
    else:  # coal's depth is an iterated bound; ours is that of the separating axis
        assert found < 1e-9
        assert found == pytest.approx(expected, abs=1e-4)
    assert _gap(kinds, halves, radii, T, compiled=True) == pytest.approx(found, abs=1e-12)


def test_a_distance_does_not_depend_on_the_order_or_the_ends_of_segments() -> None:
    rng = np.random.default_rng(0)
    r, u, v = (tuple(rng.normal(size=(3, 1000))) for _ in range(3))
    found = kernels.segments_squared(r, u, v)
    back = tuple(-c for c in r)
    np.testing.assert_allclose(kernels.segments_squared(back, v, u), found, atol=1e-12)
    np.testing.assert_allclose(kernels.segments_squared(r, tuple(-c for c in u), v), found, atol=1e-12)
    s, t = rng.uniform(-1.0, 1.0, (2, 300, 1))
    between = [a + s * b - t * c for a, b, c in zip(r, u, v, strict=True)]
    assert (found <= sum(c * c for c in between).min(axis=0) + 1e-12).all()


# --- The NAO.


def _corners(nao: nk.NaoModel, q: np.ndarray, wanted: str, reference: str) -> np.ndarray:
    """Vertices of the meshes of a link, and of the links without shapes that it carries, in a link."""
    above = {joint.child: joint.parent for joint in nao.tree.joints}
    found = []
    for visual in nao.tree.visuals:
        link = visual.link
        while link not in nao.link_shapes.links:
            link = above[link]
        if link == wanted:
            corners = read_mesh(
                mesh_path(visual.geometry, nao.tree.packages), lambda scene: scene.to_geometry().vertices
            )
            T = nao.fk(q, visual.link, reference=reference)
            found.append(np.asarray(corners) @ T[:3, :3].T + T[:3, 3])
    return np.concatenate(found)


@pytest.mark.parametrize("version", ["v3.2", "v3.3", "v4", "v5", "v6"])
def test_every_vertex_of_a_mesh_is_inside_a_shape_of_its_link(version: str) -> None:
    nao = nk.load_nao(version)
    assert set(nao.link_shapes.links) == {visual.link for visual in nao.tree.visuals if "_link" not in visual.link} | {
        "LAnklePitch_link",
        "RAnklePitch_link",
    }
    for opening in (0.0, 0.35, 1.0):
        q = nao.configuration({"LHand": opening, "RHand": opening}, limits="ignore")
        for link in nao.link_shapes.links:
            points = _corners(nao, q, link, link)
            outside = np.full(len(points), np.inf)
            for shape in (shape for shape in nao.link_shapes.shapes if shape.link == link):
                local = (points - shape.centre) @ shape.axes
                away = np.linalg.norm(local - np.clip(local, -np.array(shape.half), shape.half), axis=1)
                outside = np.minimum(outside, away - shape.radius)
            assert outside.max() <= 0.0, (link, opening)


def test_clearances_are_those_of_a_loop_over_coal() -> None:
    nao = nk.load_nao()
    q = np.concatenate([nao.random(1, 40), [nao.posture(name) for name in nao.posture_names]])
    found = nao.clearance(q)
    assert found.distance.min() < -0.02
    assert found.distance.max() > 0.005
    shapes = nao.link_shapes
    for sample, row in enumerate(q):
        T = {link: nao.fk(row, link) for link in shapes.links}
        places = [
            coal.Transform3s(
                T[shape.link][:3, :3] @ shape.axes, T[shape.link][:3, :3] @ shape.centre + T[shape.link][:3, 3]
            )
            for shape in shapes.shapes
        ]
        least = np.inf
        for a, b in combinations(range(len(shapes.shapes)), 2):
            pair = tuple(sorted((shapes.shapes[a].link, shapes.shapes[b].link)))
            if pair in shapes.pairs:
                args = shapes.geometries[a], places[a], shapes.geometries[b], places[b]
                least = min(least, coal.distance(*args, SIGNED, coal.DistanceResult()))
        assert found.distance[sample] == pytest.approx(least, abs=2e-5)


def test_no_collision_of_the_meshes_is_missed() -> None:
    _verdicts("v6", 1500, 3)


@pytest.mark.full
@pytest.mark.parametrize("version", ["v3.2", "v3.3", "v4", "v5", "v6"])
def test_no_collision_of_the_meshes_is_missed_in_any_version(version: str) -> None:
    _verdicts(version, 3000, 4)


def _verdicts(version: str, n: int, seed: int) -> None:
    """Compare with coal on the meshes of all links but neighbours, also of the pairs found never to touch."""
    nao = nk.load_nao(version)
    above = {joint.child: joint.parent for joint in nao.tree.joints}

    def host(link: str) -> str:
        return link if link in nao.link_shapes.links else host(above[link])

    collisions = tuple(Collision(row.link, row.origin, row.geometry, row.name) for row in nao.tree.visuals)
    meshes = LinkContacts(nk.RobotModel(replace(nao.tree, collisions=collisions), nao.semantics))
    skipped = {pair for pair, reason in nao.link_shapes.disabled.items() if reason != "Never"}
    hosts = {pair: tuple(sorted(map(host, pair))) for pair in meshes.pairs}
    pairs = {pair for pair, both in hosts.items() if both[0] != both[1] and both not in skipped}
    q = nao.random(seed, n)
    touching = {sample for _, sample in meshes.touching(q, pairs)}
    overlapping = set(np.flatnonzero(~nao.clearance(q).is_free).tolist())
    assert 0.2 * n < len(touching)
    assert touching <= overlapping
    # V3.2 has the most false alarms, for the shapes contain the longer arms of the other versions, too.
    assert len(overlapping) < 2.0 * len(touching)


def test_left_and_right_are_alike() -> None:
    nao = nk.load_nao()
    q = nao.random(5, 200)
    body = nao.to_body(q)
    mirrored = np.empty_like(body)
    for column, name in enumerate(nao.body_order):
        other = {"L": "R", "R": "L"}.get(name[0], name[0]) + name[1:]
        turns = name == "HeadYaw" or name.endswith(("Roll", "ElbowYaw", "WristYaw"))
        mirrored[:, nao.body_order.index(other)] = -body[:, column] if turns else body[:, column]
    here, there = nao.clearance(q), nao.clearance(nao.from_body(mirrored))
    np.testing.assert_allclose(here.distance, there.distance, atol=1e-12)


def test_the_standing_postures_are_free_and_the_start_is_named_with_its_nearest_links() -> None:
    nao = nk.load_nao()
    for name in ("Stand", "StandInit", "StandZero", "SitRelax"):
        assert nao.clearance(nao.posture(name)).is_free, name
        assert nao.collisions(nao.posture(name)) == ()
    found = nao.clearance(nao.posture("StandInit"))
    (nearest,) = nao.collisions(nao.posture("StandInit"), margin=float(found.distance) + 1e-9)[:1]
    assert nearest.links == found.pair


def test_contacts_have_points_on_both_shapes_at_their_distance() -> None:
    nao = nk.load_nao()
    q = nao.random(2, (3, 4))
    contacts = nao.collisions(q, margin=0.01)
    assert [contact.index for contact in contacts] == sorted(contact.index for contact in contacts)
    assert len({contact.index for contact in contacts}) > 5
    for contact in contacts:
        apart = float(np.linalg.norm(contact.points[1] - contact.points[0]))
        assert apart == pytest.approx(abs(contact.distance), abs=1e-4)
        for link, point in zip(contact.links, contact.points, strict=True):
            T = nao.fk(q[contact.index], link)
            local = T[:3, :3].T @ (point - T[:3, 3])
            gaps = [
                np.linalg.norm(p - np.clip(p, -np.array(shape.half), shape.half)) - shape.radius
                for shape in nao.link_shapes.shapes
                if shape.link == link
                for p in [shape.axes.T @ (local - shape.centre)]
            ]
            assert min(gaps) < 1e-5
    clearance = nao.clearance(q)
    for index in np.ndindex(3, 4):
        least = min((c.distance for c in contacts if c.index == index), default=np.inf)
        assert min(least, 0.01) == pytest.approx(min(clearance.distance[index], 0.01), abs=1e-12)
        if least < 0.01:
            assert clearance.pair[index] == min((c.distance, c.links) for c in contacts if c.index == index)[1]


def test_without_compiled_code_clearances_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    nao = nk.load_nao()
    q = nao.random(6, 200)
    kernels.clearances.ready()
    compiled = nao.clearance(q)
    monkeypatch.setattr(kernels.clearances, "_compiled", None)
    monkeypatch.setattr("nao_kin.robot.collisions.may_compile", lambda: False)
    plain = nao.clearance(q)
    np.testing.assert_allclose(plain.distance, compiled.distance, atol=1e-12)
    np.testing.assert_array_equal(plain.pair_index, compiled.pair_index)


def test_batches_bases_and_copies_agree() -> None:
    nao, floating = nk.load_nao(), nk.load_nao(base="floating")
    q = nao.random(7, (2, 3))
    found = nao.clearance(q)
    assert found.distance.shape == found.is_free.shape == found.pair.shape == (2, 3)
    assert nao.clearance(np.empty((0, nao.nq))).distance.shape == (0,)
    base = np.broadcast_to([0.3, -0.2, 0.5, *(np.array([0.1, 0.2, 0.3, 0.9]) / np.sqrt(0.95))], (2, 3, 7))
    moved = floating.clearance(np.concatenate([base, q], axis=-1))
    np.testing.assert_allclose(moved.distance, found.distance, atol=1e-12)
    again = pickle.loads(pickle.dumps(nao))
    np.testing.assert_allclose(again.clearance(q).distance, found.distance, atol=1e-15)
    turned = nao.with_offsets(joints={"LShoulderPitch": 0.1})
    shifted = q.copy()
    shifted[..., nao.joint_names.index("LShoulderPitch")] -= 0.1
    np.testing.assert_allclose(turned.clearance(shifted).distance, found.distance, atol=1e-9)


def test_random_configurations_can_be_free_of_collisions() -> None:
    nao = nk.load_nao()
    q = nao.random(8, (5, 60), collision_free=True)
    assert q.shape == (5, 60, 25)
    assert nao.clearance(q).is_free.all()
    assert nao.within_limits(q).all()
    assert not nao.clearance(nao.random(8, (5, 60))).is_free.all()
    np.testing.assert_array_equal(q, nao.random(8, (5, 60), collision_free=True))
    assert nao.random(np.random.default_rng(1), collision_free=True).shape == (25,)


# --- Other robots.


def _shaped(tmp_path: Path, *shapes: tuple[str, Any, tuple[float, float, float]], **more: Any) -> nk.RobotModel:
    robot = made_up(tmp_path, J("a", xyz=(0.0, 0.0, 0.5)), J("b", xyz=(0.0, 0.0, 0.5)))
    rows = tuple(Collision(link, Origin(xyz), shape) for link, shape, xyz in shapes)
    return nk.RobotModel(replace(robot.tree, collisions=rows, visuals=()), Semantics(**more))


def test_a_cylinder_with_two_spheres_is_a_capsule_and_alone_has_round_ends(tmp_path: Path) -> None:
    capsule = [
        ("base", Cylinder(0.1, 0.2), (0.0, 0.0, 0.0)),
        *(("base", Sphere(0.1), (0.0, 0.0, z)) for z in (-0.1, 0.1)),
    ]
    ball = ("b_l", Sphere(0.05), (0.0, 0.0, 0.0))
    robot, alone = _shaped(tmp_path, *capsule, ball), _shaped(tmp_path, capsule[0], ball)
    assert len(robot.link_shapes.shapes) == 2
    for other in (robot, alone):
        shapes = LinkShapes(other, {})
        assert shapes.pairs == (("b_l", "base"),)
        assert shapes.clearance(np.zeros(2)).distance == pytest.approx(0.75)
    assert len(_shaped(tmp_path, *capsule[:2], ("base", Sphere(0.1), (0.0, 0.0, 0.11)), ball).link_shapes.shapes) == 4


def test_pairs_are_those_of_the_semantics_or_else_found_by_sampling(tmp_path: Path) -> None:
    # In reach of each other only where the middle joint folds; neighbours never count.
    shapes = [(link, Sphere(0.1), (0.0, 0.0, 0.0)) for link in ("base", "a_l", "b_l")]
    robot = _shaped(tmp_path, *shapes)
    assert robot.link_shapes.disabled[("a_l", "base")] == robot.link_shapes.disabled[("a_l", "b_l")] == "Adjacent"
    named = _shaped(tmp_path, *shapes, disabled_collisions=[("base", "b_l", "User")])
    assert named.link_shapes.pairs == (("a_l", "b_l"), ("a_l", "base"))
    wrong = _shaped(tmp_path, *shapes, disabled_collisions=[("base", "c_l", "User")])
    with pytest.raises(UnknownName, match="'c_l'.*nearest"):
        wrong.clearance(np.zeros(2))
    with pytest.raises(BadArgument, match="two links and a reason"):
        Semantics(disabled_collisions=[("base", "a_l")])  # type: ignore[list-item]


def test_an_srdf_names_the_pairs(tmp_path: Path) -> None:
    nao = nk.load_nao()
    nk.export.srdf(nao, tmp_path / "nao.srdf", samples=50)
    robot = nk.RobotModel.from_urdf(nao.urdf_path, semantics=tmp_path / "nao.srdf")
    rows = robot.semantics.disabled_collisions
    assert len(rows) > 50
    assert {reason for *_, reason in rows} <= {"Adjacent", "Default", "Always", "Never"}
    assert set(robot.link_shapes.disabled) == {(min(a, b), max(a, b)) for a, b, _ in rows}


def test_without_collision_elements_the_visuals_count(tmp_path: Path) -> None:
    nao = nk.load_nao()
    robot = nk.RobotModel(replace(nao.tree, collisions=()), nao.semantics)
    assert len(robot.link_shapes.shapes) == len(nao.tree.visuals)
    free = nao.clearance(nao.posture("StandInit")).distance
    assert -0.03 < robot.clearance(nao.posture("StandInit")).distance <= free + 0.02
    bare = _shaped(tmp_path)
    with pytest.raises(BadArgument, match="has no shapes"):
        bare.clearance(np.zeros(2))
    gone = replace(nao.tree, path=tmp_path / "nao.urdf")
    with pytest.warns(MissingShapeWarning, match="left out"), pytest.raises(BadArgument, match="has no shapes"):
        nk.RobotModel(replace(gone, collisions=()), nao.semantics).clearance(nao.neutral())


@pytest.mark.parametrize("count", [1, 2, 3, 50])
def test_a_covering_capsule_contains_its_points(count: int) -> None:
    for seed in range(10):
        points = np.random.default_rng(seed).normal(size=(count, 3)) * [0.1, 0.01, 0.05]
        shape = covering_capsule(points)
        local = (points - shape.centre) @ shape.axes
        away = local - np.clip(local, -np.array(shape.half), shape.half)
        assert np.linalg.norm(away, axis=1).max() <= shape.radius + 1e-12


@pytest.mark.parametrize("margin", [np.nan, np.inf, "1 cm", [0.1, 0.2]])
def test_a_margin_is_one_finite_number(margin: Any) -> None:
    nao = nk.load_nao()
    with pytest.raises(NaoKinError, match="margin must"):
        nao.collisions(nao.neutral(), margin=margin)


def test_one_link_alone_is_at_no_distance_from_any(tmp_path: Path) -> None:
    robot = _shaped(tmp_path, ("base", Box((0.1, 0.1, 0.1)), (0.0, 0.0, 0.0)))
    found = robot.clearance(np.zeros((3, 2)))
    assert np.isinf(found.distance).all()
    assert found.pair.tolist() == [None] * 3
    assert robot.clearance(np.zeros(2)).as_dict() == {"distance": None, "pair": None}
