"""Self-collision against coal: distances of shapes, clearances of robots, and verdicts on the meshes."""

from __future__ import annotations

import functools
import os
import pickle
import subprocess
import sys
from dataclasses import replace
from itertools import combinations, combinations_with_replacement, product
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings, strategies as st
from loops import EACH_VERSION, full
from made_up_robots import J, made_up
from scipy.spatial import ConvexHull

import nao_kin as nk
from nao_kin._kernels import hulls as kernels
from nao_kin.errors import BadArgument, MissingShapeWarning, NaoKinError, UnknownName
from nao_kin.robot import LinkShapes, read_mesh
from nao_kin.robot.collision_pairs import never_touch
from nao_kin.robot.geometry import Shape, covering_capsule, hull_shape, round_shape, shapes_of
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf import Box, Collision, Cylinder, MeshFile, Origin, Sphere
from nao_kin.rotations import random_rotation

SIGNED = coal.DistanceRequest()
SIGNED.enable_signed_distance = True
SIGNED.gjk_tolerance = SIGNED.epa_tolerance = 1e-10

# --- Distances of two shapes.

LENGTHS = st.sampled_from([1e-9, 0.03, 0.1])
CENTRES = st.sampled_from([0.0, 1e-9, 0.02, 0.05, 0.08, 0.1, 0.16, 0.3])
TURNS = st.sampled_from(["none", "quarter", "tiny", "any"])
KINDS = ("ball", "capsule", "box", "plate", "prism", "thin", "cloud")


def _turn(kind: str, seed: int) -> np.ndarray:
    if kind == "any":
        return random_rotation(seed)
    if kind == "tiny":
        return nk.rotations.exp(1e-8 * np.random.default_rng(seed).normal(size=3))
    return np.eye(3)[[1, 2, 0]] if kind == "quarter" else np.eye(3)


def _shape(kind: str, length: float, seed: int) -> Shape:
    if kind == "ball":
        return round_shape("", np.zeros((2, 3)), 0.02)
    if kind == "capsule":
        return round_shape("", np.array([[0.0, 0.0, -0.5 * length], [0.0, 0.0, 0.5 * length]]), 0.03)
    if kind == "prism":
        angles = np.pi / 16.0 * np.arange(32)
        rim = np.column_stack([0.05 * np.cos(angles), 0.05 * np.sin(angles), np.full(32, 0.02)])
        return hull_shape("", np.concatenate([rim, -rim]))
    if kind == "cloud":
        return hull_shape("", np.random.default_rng(seed).normal(size=(60, 3)) * [0.05, 0.03, 0.08])
    half = (0.05, 0.03, {"box": 0.08, "thin": 1e-6, "plate": 0.0}[kind])
    return hull_shape("", np.array(list(product(*((-x, x) for x in half)))))


def _gap(shapes: tuple[Shape, Shape], T: np.ndarray) -> float:
    """The distance by the compiled kernel."""
    points = np.concatenate([shape.points for shape in shapes])
    first = np.cumsum([0, *(len(shape.points) for shape in shapes)])
    radii, around = np.array([shape.radius for shape in shapes]), [covering_capsule(shape.points) for shape in shapes]
    ends = np.array([ends.ravel() for ends, _ in around])
    widths, parts = radii + [width for _, width in around], np.array([[0, 1], [1, 2]])
    table = kernels.HullTable(np.arange(2), first, points, radii, ends, widths, parts)
    gaps, which = np.empty(1), np.empty(1, np.int64)
    kernels.clearances(np.array(T[None]), table, np.array([[0, 1]]), np.inf, gaps, which)
    assert which[0] == 0
    return float(gaps[0])


def _coals(shapes: tuple[Shape, Shape], T: np.ndarray) -> float:
    placed: list[Any] = []
    for shape, pose in zip(shapes, T @ [shape.T_link_geometry for shape in shapes], strict=True):
        placed += [shape.geometry, coal.Transform3s(pose[:3, :3], pose[:3, 3])]
    return float(coal.distance(*placed, SIGNED, coal.DistanceResult()))


def _depth(shapes: tuple[Shape, Shape], T: np.ndarray) -> float | None:
    """Return the depth of the origin in the hull of all differences of corners, by Qhull; None if it is outside."""
    one, other = (shape.points @ pose[:3, :3].T + pose[:3, 3] for shape, pose in zip(shapes, T, strict=True))
    # Faces that Qhull would merge stay apart.
    hull = ConvexHull((one[:, None] - other).reshape(-1, 3), qhull_options="Qt Q12 C-0")
    outside = float(hull.equations[:, 3].max())
    return -outside if outside < -1e-9 else None


@pytest.mark.parametrize("kinds", list(combinations_with_replacement(KINDS, 2)))
@settings(max_examples=15)
@given(
    st.tuples(LENGTHS, LENGTHS),
    st.tuples(*[CENTRES] * 3),
    st.tuples(TURNS, TURNS),
    st.tuples(*[st.sampled_from([-1.0, 1.0])] * 3),
    st.integers(0, 10_000),
)
def test_distances_are_those_of_coal_parallel_crossing_or_degenerate(
    kinds: tuple[str, str], lengths: Any, centre: Any, turns: Any, signs: Any, seed: int
) -> None:
    one, other = (_shape(kind, length, seed + k) for k, (kind, length) in enumerate(zip(kinds, lengths, strict=True)))
    T = np.tile(np.eye(4), (2, 1, 1))
    T[:, :3, :3] = [_turn(turn, seed + k) for k, turn in enumerate(turns)]
    T[1, :3, 3] = np.multiply(signs, centre)
    found, radius = _gap((one, other), T), one.radius + other.radius
    assert _gap((other, one), T[::-1]) == pytest.approx(found, abs=1e-9)
    if found > -radius + 1e-9:  # the cores are apart
        assert found == pytest.approx(_coals((one, other), T), abs=2e-8)
    elif len(one.points) * len(other.points) > 4:
        assert found == pytest.approx(-(_depth((one, other), T) or 0.0) - radius, abs=1e-8)
    else:
        assert found == pytest.approx(-radius, abs=1e-9)


def test_a_depth_is_the_least_translation_that_separates() -> None:
    seen = 0
    for seed in range(40):
        shapes = _shape("cloud", 0.0, seed), _shape("cloud", 0.0, seed + 100)
        T = np.tile(np.eye(4), (2, 1, 1))
        T[1, :3, 3] = 0.03 * np.random.default_rng(seed).normal(size=3)
        found = _gap(shapes, T)
        if found >= 0.0:
            continue
        seen += 1
        assert -found == pytest.approx(_depth(shapes, T) or 0.0, abs=1e-9)
        for direction in random_rotation(seed, 20)[:, 0]:
            moved = T.copy()
            moved[1, :3, 3] += 0.99 * -found * direction
            assert _gap(shapes, moved) < 1e-9
    assert seen > 30


def test_the_nearest_point_of_four_corners_in_a_plane_is_that_of_its_nearest_triangle() -> None:
    rng = np.random.default_rng(0)
    for number in range(400):
        W = rng.normal(size=(4, 3)) + rng.choice([0.0, 1.0]) * rng.normal(size=3)
        W[3] = rng.dirichlet(np.ones(3)) @ W[:3] if number % 2 else W[0] + W[1] - W[2]
        least = min(np.linalg.norm(kernels._of_triangle(W, *corners)[0]) for corners in combinations(range(4), 3))
        found, count = kernels._nearest(W.copy(), 4)
        assert count < 4
        assert np.linalg.norm(found) == pytest.approx(least, abs=1e-12)


def test_an_expanding_polytope_is_opened_in_one_piece() -> None:
    V = np.concatenate([np.eye(3), -np.eye(3)])
    F, N, E = np.zeros((8, 4), np.int64), np.zeros((8, 4)), np.zeros((24, 2), np.int64)
    for face, signs in enumerate(product((0, 3), repeat=3)):
        i, j, k = (axis + sign for axis, sign in enumerate(signs))
        outwards = signs.count(3) % 2 == 0
        kernels._add_face(V, i, j if outwards else k, k if outwards else j, face, F, N)
    N[7, 3] = -np.inf  # as if rounding let the point see the opposite face
    assert kernels._open_up(0, (0.4, 0.4, 0.4), 8, F, N, E) == 3
    assert F[:, 3].tolist() == [2, 0, 0, 0, 0, 0, 0, 1]


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
            T = nao.fk(q, visual.link, reference=reference)
            found.append(_vertices(visual.geometry.path(nao.tree.packages)) @ T[:3, :3].T + T[:3, 3])
    return np.concatenate(found)


@functools.cache
def _vertices(mesh: Path) -> np.ndarray:
    return np.asarray(read_mesh(mesh, lambda scene: scene.to_geometry().vertices))


def _outside(shape: Shape, points: np.ndarray) -> np.ndarray:
    """Return the distances of points from a shape, negative inside."""
    if len(shape.points) <= 2:
        one, along = shape.points[0], shape.points[-1] - shape.points[0]
        share = np.clip((points - one) @ along / max(float(along @ along), 1e-30), 0.0, 1.0)
        return np.linalg.norm(points - one - share[:, None] * along, axis=1) - shape.radius
    faces = ConvexHull(shape.points).equations
    return np.asarray((points @ faces[:, :3].T + faces[:, 3]).max(axis=1))


@pytest.mark.parametrize("version", EACH_VERSION)
def test_every_vertex_of_a_mesh_is_inside_a_hull_and_inside_a_simple_shape_of_its_link(version: str) -> None:
    nao = nk.load_nao(version)
    assert set(nao.link_shapes.links) == {visual.link for visual in nao.tree.visuals if "_link" not in visual.link} | {
        "LAnklePitch_link",
        "RAnklePitch_link",
    }
    simple = list(shapes_of(nao.tree))
    for link in nao.link_shapes.links:
        for opening in (0.0, 0.35, 1.0) if link in ("l_wrist", "r_wrist") else (0.0,):
            q = nao.configuration({"LHand": opening, "RHand": opening}, limits="ignore")
            points = _corners(nao, q, link, link)
            for shapes in (nao.link_shapes.shapes, simple):
                outside = np.min([_outside(shape, points) for shape in shapes if shape.link == link], axis=0)
                assert outside.max() <= 0.0, (link, opening)


@pytest.mark.parametrize("version", EACH_VERSION)
def test_the_hull_of_each_phalanx_contains_its_mesh_and_is_in_that_of_the_fingers(version: str) -> None:
    nao = nk.load_nao(version)
    fingers = [shape for shape in nao.link_shapes.shapes if shape.parts]
    assert [(shape.link, len(shape.parts)) for shape in fingers] == [("l_wrist", 8), ("r_wrist", 8)]
    meshes = {visual.link: visual.geometry.path(nao.tree.packages) for visual in nao.tree.visuals}
    q = nao.configuration({hand: np.linspace(0.0, 1.0, 21) for hand in ("LHand", "RHand")}, limits="ignore")
    for shape in fingers:
        for part in shape.parts:
            assert _outside(part, _vertices(meshes[part.link])).max() <= 0.0
            for T in nao.fk(q, part.link, reference=shape.link):
                assert _outside(shape, part.points @ T[:3, :3].T + T[:3, 3]).max() < 0.003, part.link


def test_the_fingers_are_where_the_opening_of_the_hand_puts_them() -> None:
    # The hull of the fingers at all openings is 18 mm in the other forearm.
    nao = nk.load_nao("v3.2")
    q = nao.posture("Sit")
    assert nao.clearance(q).is_free
    rows = nao.random(3, 4000)
    closed, opened = (rows.copy() for _ in range(2))
    closed[:, nao.joint_names.index("LHand")], opened[:, nao.joint_names.index("LHand")] = 0.0, 1.0
    apart, touching = nao.clearance(closed), nao.clearance(opened)
    hits = np.flatnonzero(apart.is_free & (touching.distance < -0.003))
    assert len(hits) > 3
    assert all("l_wrist" in touching.pair[k] for k in hits)  # type: ignore[index]


@pytest.mark.parametrize("version", ["v3.2", "v3.3", "v6"])
def test_hulls_are_near_the_meshes_and_left_and_right_alike(version: str) -> None:
    nao = nk.load_nao(version)
    q = [nao.configuration({"LHand": opening}, limits="ignore") for opening in np.linspace(0.0, 1.0, 11)]
    hulls = nao.link_shapes.shapes
    gaps = {"Head": 0.0016, "LBicep": 0.0011, "LForeArm": 0.0028}  # hulls of several versions are farther from each
    for link in (*gaps, "LPelvis", "LThigh", "LTibia", "l_ankle"):
        (hull,) = [shape for shape in hulls if shape.link == link]
        mesh = ConvexHull(_corners(nao, q[0], link, link)).equations
        assert (hull.points @ mesh[:, :3].T + mesh[:, 3]).max() < gaps.get(link, 0.0021), link
    for link in ("LForeArm", "l_wrist", "LThigh"):
        left, right = (
            [shape.points for shape in hulls if shape.link == name]
            for name in (link, {"L": "R", "l": "r"}[link[0]] + link[1:])
        )
        for one, other in zip(left, right, strict=True):
            mirrored = other * [1.0, -1.0, 1.0]
            np.testing.assert_array_equal(one[np.lexsort(one.T)], mirrored[np.lexsort(mirrored.T)])


def test_clearances_are_those_of_a_loop_over_coal() -> None:
    nao = nk.load_nao()
    q = np.concatenate([nao.random(1, 12), [nao.posture(name) for name in nao.posture_names]])
    found = nao.clearance(q)
    assert found.distance.min() < -0.02
    assert found.distance.max() > 0.005
    shapes = [(whole.link, shape) for whole in nao.link_shapes.shapes for shape in whole.parts or (whole,)]
    for sample, row in enumerate(q):
        T = nao.fk(row, [shape.link for _, shape in shapes])
        least = min(
            _coals((shapes[a][1], shapes[b][1]), T[[a, b]])
            for a, b in combinations(range(len(shapes)), 2)
            if tuple(sorted((shapes[a][0], shapes[b][0]))) in nao.link_shapes.pairs
        )
        assert found.distance[sample] == pytest.approx(least, abs=1e-9)


def _at_limits(robot: nk.RobotModel, n: int, seed: int) -> np.ndarray:
    """Random configurations with three of five joints at a limit, where clamping and inverse kinematics end."""
    rng = np.random.default_rng(seed)
    limits = np.where(rng.random((n, robot.nq)) < 0.5, robot.lower, robot.upper)
    return robot.clamp(np.where(rng.random((n, robot.nq)) < 0.6, limits, robot.random(rng, n)))


@pytest.mark.parametrize("version", EACH_VERSION)
def test_pairs_that_are_not_compared_do_not_overlap_at_the_limits(version: str) -> None:
    nao = nk.load_nao(version)
    never = {pair for pair, reason in nao.link_shapes.disabled.items() if reason == "Never"}
    assert len(never) > 100
    every = combinations(sorted(nao.link_shapes.links), 2)
    shapes = LinkShapes(nao, nao.link_shapes.shapes, disabled={pair: "" for pair in every if pair not in never})
    assert shapes.pairs == tuple(sorted(never))
    assert shapes.clearance(_at_limits(nao, 4000, 0), 0.0).is_free.all()


@pytest.mark.parametrize("seed", [0, 1, *full(*range(2, 6))])
def test_what_is_proven_apart_overlaps_in_no_configuration(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinds, axes = rng.choice(["revolute", "revolute", "prismatic"], 5).tolist(), rng.normal(size=(5, 3))
    axes = (axes / np.linalg.norm(axes, axis=1, keepdims=True)).tolist()
    places, limits = rng.uniform(-0.15, 0.15, (5, 3)).tolist(), np.sort(rng.uniform(-1.0, 1.5, (5, 2))).tolist()
    joints = [
        J(f"j{k}", tuple(axes[k]), xyz=tuple(places[k]), kind=kinds[k], limits=tuple(limits[k]), parent=parent)
        for k, parent in enumerate(("base", "j0", "j1", "base", "j3"))
    ]
    robot = made_up(tmp_path, *joints)
    links = ["base", *(f"j{k}_l" for k in range(5))]
    capsules = {link: [(rng.uniform(-0.1, 0.1, (2, 3)), rng.uniform(0.03, 0.08))] for link in links}
    q = np.concatenate([robot.random(1, 1000), _at_limits(robot, 1000, 2)])
    share, T = np.linspace(0.0, 1.0, 15)[:, None], robot.fk(q, links)
    segments = {}
    for place, link in enumerate(links):
        ends, _ = capsules[link][0]
        points = (1.0 - share) * ends[0] + share * ends[1]
        segments[link] = points @ T[:, place, :3, :3].swapaxes(1, 2) + T[:, place, None, :3, 3]
    proven = 0
    for one, other in combinations(links, 2):
        gaps = np.linalg.norm(segments[one][:, :, None] - segments[other][:, None], axis=-1).min(axis=(1, 2))
        radii = capsules[one][0][1] + capsules[other][0][1]
        if never_touch(robot, capsules, (one, other), 2000):
            proven += 1
            assert gaps.min() > radii
        else:  # a proof needs few boxes unless the capsules nearly touch
            assert gaps.min() < radii + 0.05
    assert 0 < proven < 15


def test_no_collision_of_the_meshes_is_missed() -> None:
    _verdicts("v6", 200, 3)


@pytest.mark.full
@pytest.mark.parametrize(("version", "n"), [("v6", 3000), ("v5", 1000), ("v4", 1000), ("v3.3", 1000), ("v3.2", 1000)])
def test_no_collision_of_the_meshes_is_missed_in_any_version(version: str, n: int) -> None:
    _verdicts(version, n, 4)


def _verdicts(version: str, n: int, seed: int) -> None:
    """Compare with coal on the meshes of all links but neighbours, also of the pairs found never to touch."""
    nao = nk.load_nao(version)
    above = {joint.child: joint.parent for joint in nao.tree.joints}

    def host(link: str) -> str:
        return link if link in nao.link_shapes.links else host(above[link])

    collisions = tuple(Collision(row.link, row.origin, row.geometry, row.name) for row in nao.tree.visuals)
    meshes = LinkShapes.exact(nk.RobotModel(replace(nao.tree, collisions=collisions), nao.semantics))
    skipped = {pair for pair, reason in nao.link_shapes.disabled.items() if reason != "Never"}
    hosts = {pair: tuple(sorted(map(host, pair))) for pair in meshes.pairs}
    pairs = {pair for pair, both in hosts.items() if both[0] != both[1] and both not in skipped}
    at_limits = _at_limits(nao, n // 3, seed)
    assert {sample for _, sample in meshes.touching(at_limits, pairs)} <= set(
        np.flatnonzero(~nao.clearance(at_limits).is_free)
    )
    q = nao.random(seed, n)
    touching = {sample for _, sample in meshes.touching(q, pairs)}
    overlapping = set(np.flatnonzero(~nao.clearance(q).is_free).tolist())
    assert 0.2 * n < len(touching)
    assert touching <= overlapping
    assert len(overlapping) <= 1.01 * len(touching) + 1
    assert len(touching) < (nao.clearance(q, exact=False).distance < 0.0).sum() < 1.12 * len(touching)


def test_an_arm_beside_the_head_does_not_overlap_it() -> None:
    nao = nk.load_nao("v5")
    for side, sign in (("L", -1.0), ("R", 1.0)):
        q = nao.posture("Stand", **{f"{side}ShoulderPitch": -1.4, f"{side}ShoulderRoll": sign * 0.18})
        found = nao.clearance(q, exact=False)
        assert (found.pair, found.is_free) == (("Head", f"{side}Bicep"), True)


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
    # The axes of the phalanges are rounded.
    np.testing.assert_allclose(here.distance, there.distance, atol=1e-7)


def test_the_postures_are_free_but_for_what_touches_in_the_meshes_or_nearly() -> None:
    nao = nk.load_nao()
    deepest = {"Crouch": -0.006, "Sit": -0.005}
    for name in nao.posture_names:
        assert nao.clearance(nao.posture(name)).distance > deepest.get(name, 0.002), name
        assert bool(nao.collisions(nao.posture(name))) == (name in deepest)
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
        assert apart == pytest.approx(abs(contact.distance), abs=1e-9)
        for link, point in zip(contact.links, contact.points, strict=True):
            parts = [
                (part, nao.fk(q[contact.index], part.link))
                for shape in nao.link_shapes.shapes
                if shape.link == link
                for part in shape.parts or (shape,)
            ]
            outside = [_outside(part, ((point - T[:3, 3]) @ T[:3, :3])[None])[0] for part, T in parts]
            assert np.abs(outside).min() < 1e-7


def test_without_compiled_code_clearances_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    nao = nk.load_nao()
    q = nao.random(6, 200)
    kernels.clearances.ready()
    compiled = nao.clearance(q)
    monkeypatch.setattr(kernels.clearances, "_compiled", None)
    monkeypatch.setattr("nao_kin.robot.link_shapes.may_compile", lambda: False)
    plain = nao.clearance(q)
    np.testing.assert_allclose(plain.distance, compiled.distance, atol=1e-9)
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


def _all_pairs(robot: nk.RobotModel) -> LinkShapes:
    return LinkShapes(robot, shapes_of(robot.tree), disabled={})


def _shaped(tmp_path: Path, *shapes: tuple[str, Any, tuple[float, float, float]], **more: Any) -> nk.RobotModel:
    robot = made_up(tmp_path, J("a", xyz=(0.0, 0.0, 0.5)), J("b", xyz=(0.0, 0.0, 0.5)))
    rows = tuple(Collision(link, Origin(xyz), shape) for link, shape, xyz in shapes)
    return nk.RobotModel(replace(robot.tree, collisions=rows, visuals=()), Semantics(**more))


def test_a_cylinder_with_two_spheres_is_a_capsule_and_alone_has_flat_ends(tmp_path: Path) -> None:
    capsule = [
        ("base", Cylinder(0.1, 0.2), (0.0, 0.0, 0.0)),
        *(("base", Sphere(0.1), (0.0, 0.0, z)) for z in (-0.1, 0.1)),
    ]
    ball = ("b_l", Sphere(0.05), (0.0, 0.0, 0.0))
    robot, alone = _shaped(tmp_path, *capsule, ball), _shaped(tmp_path, capsule[0], ball)
    assert len(robot.link_shapes.shapes) == 2
    for other, distance in ((robot, 0.75), (alone, 0.85)):
        shapes = _all_pairs(other)
        assert shapes.pairs == (("b_l", "base"),)
        assert shapes.clearance(np.zeros(2)).distance == pytest.approx(distance)
    beside = _shaped(tmp_path, ("base", Cylinder(0.1, 0.2), (0.0, 0.0, 0.0)), ("b_l", Sphere(0.05), (0.3, 0.0, -1.0)))
    assert 0.15 - 0.0005 < _all_pairs(beside).clearance(np.zeros(2)).distance <= 0.15
    assert len(_shaped(tmp_path, *capsule[:2], ("base", Sphere(0.1), (0.0, 0.0, 0.11)), ball).link_shapes.shapes) == 4


@pytest.mark.parametrize(
    ("vertices", "distance"),
    [
        ("0 0 0,0.1 0 0,0 0.1 0,0.1 0.1 0", 0.9),  # flat
        ("0 0 0,0 0.1 0,0 0.2 0", 0.9),
        ("0 0 0.2,0 0 0.2,0 0 0.2", 0.7),
        ("0 0 0,nan 0 0,0 1 0,0 0 1", None),
        ("0 0 0,1e300 0 0,0 1e300 0,0 0 1e300", None),
    ],
)
def test_a_mesh_without_a_volume_counts_and_one_that_is_no_shape_is_left_out(
    tmp_path: Path, vertices: str, distance: float | None
) -> None:
    lines = [f"v {vertex}" for vertex in vertices.split(",")]
    faces = ["f 1 2 3"] + ["f 1 2 4"] * (len(lines) > 3)
    (tmp_path / "a.obj").write_text("\n".join([*lines, *faces]) + "\n")
    shapes = ("base", MeshFile("a.obj"), (0.0, 0.0, 0.0)), ("b_l", Sphere(0.1), (0.0, 0.0, 0.0))
    robot = _shaped(tmp_path, *shapes)
    if distance is None:
        with pytest.warns(MissingShapeWarning, match="left out: its mesh 'a.obj' has vertices that are not finite"):
            assert _all_pairs(robot).pairs == ()
    else:
        assert _all_pairs(robot).clearance(np.zeros(2)).distance == pytest.approx(distance, abs=3e-6)


def test_pairs_are_those_of_the_semantics_or_else_found_by_proof(tmp_path: Path) -> None:
    # In reach of each other only where the middle joint folds; neighbours never count.
    shapes = [(link, Sphere(0.1), (0.0, 0.0, 0.0)) for link in ("base", "a_l", "b_l")]
    robot = _shaped(tmp_path, *shapes)
    assert robot.link_shapes.disabled[("a_l", "base")] == robot.link_shapes.disabled[("a_l", "b_l")] == "Adjacent"
    named = _shaped(tmp_path, *shapes, disabled_collisions=[("base", "b_l", "User")])
    assert named.link_shapes.pairs == (("a_l", "b_l"), ("a_l", "base"))
    wrong = _shaped(tmp_path, *shapes, disabled_collisions=[("base", "c_l", "User")])
    with pytest.raises(UnknownName, match="'c_l' .valid: base, a_l, b_l"):
        wrong.clearance(np.zeros(2))
    with pytest.raises(BadArgument, match="two links and a reason"):
        Semantics(disabled_collisions=[("base", "a_l")])  # type: ignore[list-item]


def test_an_srdf_names_the_pairs(tmp_path: Path) -> None:
    nao = nk.load_nao()
    nk.export.srdf(nao, tmp_path / "nao.srdf", samples=1)
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


@pytest.mark.parametrize("kind", ["boxes", "meshes"])
def test_what_is_thin_and_inside_a_hollow_mesh_overlaps_it_by_default(tmp_path: Path, kind: str) -> None:
    edges, shapes = (0.2, 0.002), [Box((0.2, 0.2, 0.2)), Box((0.002, 0.002, 0.002))]
    if kind == "meshes":
        for edge in edges:
            trimesh.creation.box([edge] * 3).export(tmp_path / f"{edge}.stl")
        shapes = [MeshFile(f"{edge}.stl") for edge in edges]
    places = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0988 - 1.0)  # 0.2 mm below the surface
    rows = zip(("base", "b_l"), shapes, places, strict=True)
    robot = _shaped(tmp_path, *rows, disabled_collisions=[("a_l", "base", "User")])
    assert robot.clearance(np.zeros(2)).distance == pytest.approx(-0.0022, abs=1e-6)
    assert bool(robot.collisions(np.zeros(2)))
    assert "meshes" not in vars(robot.link_shapes)  # not read in vain
    assert robot.clearance(np.zeros(2), exact=True).is_free == (kind == "meshes")


@pytest.mark.parametrize("count", [1, 2, 3, 50])
def test_a_covering_capsule_contains_its_points(count: int) -> None:
    for seed in range(10):
        points = np.random.default_rng(seed).normal(size=(count, 3)) * [0.1, 0.01, 0.05]
        ends, radius = covering_capsule(points)
        assert _outside(Shape("", ends, radius, None, np.eye(4)), points).max() <= 1e-12


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


@pytest.mark.full
def test_the_fitted_shapes_do_not_depend_on_the_processor() -> None:
    script = Path(__file__).parents[2] / "scripts" / "generate_collision_shapes.py"
    oldest = os.environ | {"OPENBLAS_CORETYPE": "Nehalem"}  # its matrix products round in another order
    subprocess.run([sys.executable, script, "--check"], env=oldest, check=True, timeout=300)
