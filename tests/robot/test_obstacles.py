"""Obstacles near a robot: distances by coal, and what searches, motions and random configurations make of them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pytest
import trimesh

import nao_kin as nk
from nao_kin.errors import BadArgument, BadInputFile, NotARotation, UnknownName, WrongShape
from nao_kin.ik import Reason
from nao_kin.robot import CollisionRule, Obstacle

SIGNED = coal.DistanceRequest()
SIGNED.enable_signed_distance = True
SIGNED.gjk_tolerance = SIGNED.epa_tolerance = 1e-10

TABLE = Obstacle.box("table", [0.3, 0.6, 0.02], [0.2, 0.0, -0.05])
BALL = Obstacle.ball("ball", 0.03, [0.2, 0.1, 0.1])


def _pose(rng: np.random.Generator, at: Any) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = nk.rotations.random_rotation(rng)
    T[:3, 3] = at
    return T


def _cone(folder: Path) -> Path:
    path = folder / "cone.stl"
    trimesh.creation.cone(0.05, 0.15).export(path)
    return path


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_distances_to_obstacles_are_coals(tmp_path: Path, base: Any) -> None:
    nao = nk.load_nao(base=base)
    rng = np.random.default_rng(1)
    T = [_pose(rng, at) for at in ([0.25, 0.05, 0.0], [0.1, -0.2, 0.1])]
    cone = _cone(tmp_path)
    obstacles = [Obstacle.box("box", [0.1, 0.2, 0.05], T[0]), BALL, Obstacle.mesh("cone", str(cone), T[1], scale=1.2)]
    q = nao.random(2, 60)
    if base == "floating":
        q[:, :3] = rng.uniform(-0.1, 0.1, (60, 3))
    mesh = coal.MeshLoader().load(str(cone), np.full(3, 1.2))
    mesh.buildConvexHull(True, "Qt")
    theirs = {"box": (coal.Box(0.1, 0.2, 0.05), T[0]), "ball": (coal.Sphere(0.03), BALL.T), "cone": (mesh.convex, T[1])}
    own, found = nao.clearance(q, exact=False), nao.clearance(q, exact=False, obstacles=obstacles)
    shapes = [(whole.link, shape) for whole in nao.link_shapes.shapes for shape in whole.parts or (whole,)]
    nearest = []
    for k, row in enumerate(q):
        least = (float(own.distance[k]), own.pair[k])  # type: ignore[index]
        for (link, shape), T_link in zip(shapes, nao.fk(row, [shape.link for _, shape in shapes]), strict=True):
            for name, (geometry, T_obstacle) in theirs.items():
                places = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (T_link, T_obstacle)]
                args = shape.geometry, places[0], geometry, places[1], SIGNED, coal.DistanceResult()
                least = min(least, (coal.distance(*args), (min(link, name), max(link, name))))
        nearest.append(least[1])
        assert found.distance[k] == pytest.approx(least[0], abs=2e-6)
    assert {"box", "ball", "cone"} <= {name for pair in nearest for name in pair}
    assert sum(pair == other for pair, other in zip(nearest, found.pair, strict=True)) > 55  # type: ignore[arg-type]


def test_one_configuration_and_a_batch_without_compiled_code_say_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    nao = nk.load_nao()
    q = nao.random(4, 10)
    expected = nao.clearance(q, obstacles=[TABLE, BALL])
    fresh = nk.load_nao()
    monkeypatch.setattr("nao_kin.robot.link_shapes.may_compile", lambda: False)
    monkeypatch.setattr(type(nk._kernels.hulls.clearances), "in_memory", False)
    found = fresh.clearance(q, obstacles=[TABLE, BALL])
    np.testing.assert_allclose(found.distance, expected.distance, atol=1e-9)
    for k, row in enumerate(q):
        contacts = fresh.collisions(row, obstacles=[TABLE, BALL], margin=0.2)
        assert contacts[0].distance == pytest.approx(float(expected.distance[k]), abs=1e-9)


def test_a_hand_in_a_ring_touches_its_hull_and_not_the_ring(tmp_path: Path, nao: nk.NaoModel) -> None:
    ring = tmp_path / "ring.stl"
    trimesh.creation.annulus(0.06, 0.08, 0.01).export(ring)
    q = nao.posture("StandZero")
    across = nao.fk(q, "l_wrist") @ np.array([[0.0, 0, 1, 0.06], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]])
    obstacle = Obstacle.mesh("ring", ring, across)
    assert nao.clearance(q, obstacles=[obstacle]).pair == ("l_wrist", "ring")
    assert not nao.clearance(q, obstacles=[obstacle]).is_free
    assert nao.collisions(q, obstacles=[obstacle], exact=True) == ()
    assert nao.clearance(q, obstacles=[obstacle], exact=True).is_free
    (near,) = [c for c in nao.collisions(q, obstacles=[obstacle], margin=0.06, exact=True) if "ring" in c.links][:1]
    assert near.links == ("l_wrist", "ring")
    assert 0.0 < near.distance < 0.06
    # The robot's own meshes are read once, however often obstacles move.
    own = nao.link_shapes.meshes._own
    assert all(
        shapes is own[link] for link, shapes in nao.link_shapes.among((obstacle,)).meshes._own.items() if link != "ring"
    )
    aside = Obstacle.mesh("ring", ring, across @ _moved([0.0, 0.05, 0.0]))
    assert not nao.clearance(q, obstacles=[aside], exact=True).is_free


def _moved(by: Any) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = by
    return T


# --- What others make of them.


def test_an_arm_does_not_reach_into_a_table(nao: nk.NaoModel) -> None:
    q = nao.posture("StandZero", LShoulderPitch=0.6)
    above, rule = nao.posture("StandZero"), CollisionRule(obstacles=[TABLE])
    T = nao.fk(q, "LArm")
    assert nk.ik.arm(nao, "L", T, near=above, collisions=True).success
    found = nk.ik.arm(nao, "L", T, near=above, collisions=rule)
    assert found.reason == Reason.COLLISION
    assert "l_wrist and table by 19.1 mm" in found.message
    allowed = CollisionRule(obstacles=[TABLE], allowed=[("table", "l_wrist"), ("table", "LForeArm")])
    assert nk.ik.arm(nao, "L", T, near=above, collisions=allowed).success
    # The head moves no link that is in the table.
    assert nk.ik.head(nao, nao.rotation(q, "Head"), near=q, collisions=rule).success
    # From a pose in the table an arm comes out of it, not deeper.
    out, deeper = (nao.posture("StandZero", LShoulderPitch=pitch) for pitch in (0.55, 0.65))
    assert nk.ik.arm(nao, "L", nao.fk(out, "LArm"), near=q, collisions=rule).success
    assert not nk.ik.arm(nao, "L", nao.fk(deeper, "LArm"), near=q, collisions=rule).success


def test_a_path_names_the_obstacle_and_the_sample(nao: nk.NaoModel) -> None:
    q = nao.posture("StandZero", {"LShoulderPitch": 0.6})
    start = nao.posture("StandZero")
    rows = start + np.linspace(0.0, 1.0, 9)[:, None] * (q - start)
    path = {"LArm": nao.position(rows, "LArm")}
    found = nk.ik.follow(nao, path, near=start, collisions=CollisionRule(obstacles=[TABLE]))
    assert not found.success
    assert "and table by" in found.message
    assert found.limbs[0].reached[:4].all()


def test_a_base_that_moves_brings_links_to_obstacles() -> None:
    nao = nk.load_nao(base="floating")
    start = nao.posture("StandInit")
    feet = {side: nao.fk(start, f"{side}Leg") for side in "LR"}
    wall = Obstacle.box("wall", [0.02, 1.0, 1.0], nao.position(start, "LArm") + np.array([0.15, 0.0, 0.0]))
    assert nao.clearance(start, obstacles=[wall]).is_free
    shapes = nao.link_shapes.among((wall,))
    moved = dict(zip(shapes.pairs, shapes.moved(range(7)), strict=True))
    assert [pair for pair, is_moved in moved.items() if is_moved] == [pair for pair in shapes.pairs if "wall" in pair]
    hand = nao.position(start, "LArm") + np.array([0.05, 0.0, 0.0])
    rule = CollisionRule(obstacles=[wall])
    found = nk.ik.whole_body(nao, {"LArm": hand}, feet=feet, near=start, collisions=rule)
    assert found.success
    assert nao.clearance(found.q, obstacles=[wall]).is_free


def test_random_configurations_and_motions_mind_obstacles(nao: nk.NaoModel) -> None:
    rule = CollisionRule(obstacles=[TABLE, BALL], tolerance=0.002)
    q = nao.random(0, 200, collision_free=rule)
    assert nao.clearance(q, obstacles=[TABLE, BALL], tolerance=0.002).is_free.all()
    assert not nao.clearance(nao.random(0, 200, collision_free=True), obstacles=[TABLE, BALL]).is_free.all()
    down = nk.Motion([0.0, 1.0], ["LShoulderPitch"], [[0.0], [0.6]])
    found = nk.motion.check(nao, down, missing="StandZero", collisions=CollisionRule(obstacles=[TABLE]))
    (row,) = [row for row in found.violations if row.kind == "collision"]
    assert "l_wrist" in row.describe()
    assert "table" in row.describe()
    assert nk.motion.check(nao, down, missing="StandZero", collisions=True).ok


def test_without_obstacles_answers_are_those_of_before(nao: nk.NaoModel) -> None:
    q = nao.random(6, 50)
    before = nao.clearance(q)
    nao.clearance(q, obstacles=[TABLE])
    after = nao.clearance(q, obstacles=())
    np.testing.assert_array_equal(before.distance, after.distance)
    assert before.pairs == after.pairs
    far = nao.clearance(q, obstacles=[Obstacle.ball("moon", 1.0, [0.0, 0.0, 100.0])])
    np.testing.assert_array_equal(before.distance, far.distance)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: Obstacle.box("a", [1, 1, 0], [0, 0, 0]), BadArgument, "size of 'a'"),
        (lambda: Obstacle.ball("a", 1.0, [0, 0]), WrongShape, r"\(3,\) or \(4, 4\)"),
        (lambda: Obstacle.ball("a", 1.0, 2.0 * np.eye(4)), NotARotation, "at"),
        (lambda: Obstacle.mesh("a", "none.stl", [0, 0, 0]), BadInputFile, "none.stl"),
        (lambda: _clearance(Obstacle.ball("Head", 1.0, [0, 0, 0])), BadArgument, "'Head'"),
        (lambda: _clearance(BALL, BALL), BadArgument, "'ball'"),
        (lambda: _clearance(BALL, allowed=[("bal", "Head")]), UnknownName, "'bal'"),
    ],
)
def test_what_is_no_obstacle_is_refused(make: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        make()


@pytest.mark.full
def _clearance(*obstacles: Obstacle, **options: Any) -> Any:
    nao = nk.load_nao()
    return nao.clearance(nao.posture("Stand"), obstacles=obstacles, **options)


def test_a_mesh_with_a_wrong_normal_is_read_without_a_word(tmp_path: Path) -> None:
    corners = "vertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\n"
    facet = f"facet normal 0 0 x\nouter loop\n{corners}endloop\nendfacet\n"
    (tmp_path / "mesh.stl").write_text(f"solid\n{facet}endsolid\n", encoding="utf-8")
    # In a process of its own, because pytest handles what is logged.
    code = "import nao_kin as nk; nk.robot.Obstacle.mesh('mesh', 'mesh.stl', [0.0, 0.0, 0.0])"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")
