"""Robots set down on the floor, beside their meshes read by trimesh, SciPy's hulls and gravity's potential."""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings, strategies as st
from loops import for_all, full
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName, WrongShape, ZeroNorm
from nao_kin.robot.nao.tables import SOLE_OUTLINES
from nao_kin.robot.semantics import Semantics


@functools.cache
def _nao() -> nk.NaoModel:
    return nk.load_nao()


@functools.cache
def _mesh(path: Path) -> np.ndarray:
    return np.asarray(trimesh.load(path, process=False).vertices)


def _vertices(nao: nk.NaoModel, q: np.ndarray) -> np.ndarray:
    """Return all vertices of the visual meshes in the root, read by trimesh."""
    poses = dict(zip(nao.link_names, nao.fk(q), strict=True))
    parts = []
    for visual in nao.tree.visuals:
        T = poses[visual.link] @ visual.origin.matrix
        points = _mesh(nao.urdf_path.parent / visual.geometry.filename) * visual.geometry.scale
        parts.append(points @ T[:3, :3].T + T[:3, 3])
    return np.concatenate(parts)


# What a person expects: the links on the floor, and for postures on soles that they are level.
EXPECTED = {
    "Stand": {"l_ankle", "r_ankle"},
    "StandInit": {"l_ankle", "r_ankle"},
    "StandZero": {"l_ankle", "r_ankle"},
    "Crouch": {"l_ankle", "r_ankle"},
    "Sit": {"LHip", "RHip", "l_ankle", "r_ankle"},
    "SitRelax": {"LHip", "RHip", "l_ankle", "r_ankle"},
    "LyingBelly": {"LThigh", "LForeArm", "RForeArm"},
    "LyingBack": {"torso", "l_ankle", "r_ankle"},
}


@for_all("posture", list(EXPECTED))
def test_the_eight_postures_rest_as_a_person_expects(nao: nk.NaoModel, posture: str) -> None:
    q = nao.posture(posture)
    down = nao.set_down(q, tolerance=0.005)  # the published values of Sit lift the feet by some millimetres
    assert {name for name, on in zip(nao.link_names, down.links, strict=True) if on} >= EXPECTED[posture]
    up = nao.semantics.postures[posture].up
    lean = Rotation.align_vectors([[0, 0, 1]], [down.T_world_base[:3, :3] @ (up or down.T_world_base[2, :3])])[1]
    assert lean < 0.02
    points = _vertices(nao, q) @ down.T_world_base[:3, :3].T + down.T_world_base[:3, 3]
    assert -3e-3 < points[:, 2].min() < 1e-4 if down.stands else abs(points[:, 2].min()) < 2e-5
    com = (down.T_world_base @ [*nao.com(q), 1.0])[:2]
    hull = ConvexHull(points[points[:, 2] < 0.005, :2])
    assert (hull.equations @ [*com, 1.0]).max() < 1e-4


def test_all_vertices_that_touch_the_floor_support_a_robot_that_lies(nao: nk.NaoModel) -> None:
    for posture in ("LyingBelly", "LyingBack"):
        q = nao.posture(posture)
        found = nk.world.balance(nao, q)
        points = _vertices(nao, q) @ found.down.T_world_base[:3, :3].T + found.down.T_world_base[:3, 3]
        hull = ConvexHull(np.concatenate([points[points[:, 2] <= 0.002, :2], found.vertices]))
        assert -(hull.equations @ [*found.com[:2], 1.0]).max() == pytest.approx(float(found.margin), abs=1e-5)


def test_feet_that_are_not_quite_level_do_not_reach_into_the_floor(nao: nk.NaoModel) -> None:
    for q in nao.random(7, 192)[[4, 164]]:
        T = nao.set_down(q).T_world_base
        assert (_vertices(nao, q) @ T[2, :3]).min() + T[2, 3] > -1e-4


def test_flat_soles_are_on_the_floor_to_rounding(each_nao: nk.NaoModel) -> None:
    for posture in ("StandInit", "StandZero"):
        q = each_nao.posture(posture)
        down = each_nao.set_down(q)
        assert down.touching.all()
        assert down.corners_touching.all()
        assert down.stands
        assert np.abs(down.corners[:, 2]).max() < 1e-9
        T_world_soles = down.T_world_base @ each_nao.fk(q, each_nao.semantics.soles)
        assert np.abs(T_world_soles[:, 2, :3] - [0.0, 0.0, 1.0]).max() < 1e-9


def test_it_rests_where_no_small_rotation_lowers_the_centre_of_mass(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(1)
    rested = 0
    for q in np.concatenate([nao.random(2, 6), nao.posture("LyingBack") + rng.normal(0, 0.05, (4, nao.nq))]):
        down = nao.set_down(q)
        if down.stands or not down.T_world_base[2, 2] < 0.99:
            continue
        rested += 1
        points, com, up = _vertices(nao, q), nao.com(q), down.T_world_base[2, :3]
        tilts = Rotation.from_rotvec(0.02 * rng.normal(size=(100, 3))).apply(up)
        heights = tilts @ com - (tilts @ points.T).min(axis=1)
        assert heights.min() > up @ com - (points @ up).min() - 2e-4
    assert rested > 4


def test_one_sole_is_enough_and_may_be_named(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LHipPitch": -0.9, "LKneePitch": 1.5, "LAnklePitch": -0.5})
    down = nao.set_down(q)
    assert down.touching.tolist() == [False, True]
    assert (down.T_world_base @ nao.fk(q, "RLeg"))[2, 2] == pytest.approx(1.0, abs=1e-12)
    named = nao.set_down(q, soles="LLeg")
    T = named.T_world_base @ nao.fk(q, "LLeg")
    assert named.soles == ("LLeg",)
    assert named.touching.tolist() == [True]
    assert (T[2, 2], T[2, 3]) == pytest.approx((1.0, 0.0), abs=1e-12)


@for_all("left, right, standing", [(0.35, -0.2, "RLeg"), (0.2, -0.35, "LLeg")])
def test_of_two_soles_under_it_the_one_that_turns_it_less_carries(
    nao: nk.NaoModel, left: float, right: float, standing: str
) -> None:
    q = nao.configuration({"LAnkleRoll": left, "RAnkleRoll": right})
    assert (nao.set_down(q).T_world_base @ nao.fk(q, standing))[2, 2] == pytest.approx(1.0, abs=1e-12)


def test_soles_that_disagree_share_the_tilt_and_the_lowest_corner_carries(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LAnkleRoll": 0.03, "RAnkleRoll": 0.03})
    down = nao.set_down(q, soles=["LLeg", "RLeg"])
    normals = (down.T_world_base @ nao.fk(q, ["LLeg", "RLeg"]))[:, :3, 2]
    assert normals.sum(axis=0)[:2] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert down.corners[:, 2].min() == pytest.approx(0.0, abs=1e-12)
    assert np.array_equal(down.corners_touching, down.corners[:, 2] <= 0.002)
    assert nao.set_down(q, soles=["LLeg", "RLeg"], tolerance=5e-3).corners_touching.sum() > down.corners_touching.sum()


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**31))
def test_gravity_is_what_is_down(seed: int) -> None:
    nao, rng = _nao(), np.random.default_rng(seed)
    q, gravity = nao.random(rng), 9.81 * rng.normal(size=3)
    down = nao.set_down(q, gravity=gravity)
    assert down.T_world_base[2, :3] == pytest.approx(-gravity / np.linalg.norm(gravity), abs=1e-12)
    assert np.linalg.det(down.T_world_base[:3, :3]) == pytest.approx(1.0)
    lowest = min(
        (_vertices(nao, q) @ down.T_world_base[2, :3]).min() + down.T_world_base[2, 3], down.corners[:, 2].min()
    )
    assert lowest == pytest.approx(0.0, abs=1e-8)


def test_neither_soles_nor_other_links_are_below_the_floor(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(4)
    standing = np.stack([nao.posture(name) for name in ("Stand", "StandInit", "StandZero", "Crouch", "Sit")])
    q = np.concatenate([nao.random(7, 192), nao.random(1, 60)])
    q = np.concatenate([q, nao.clamp(np.repeat(standing, 30, axis=0) + rng.normal(0.0, 0.05, (150, nao.nq)))])
    together = nao.set_down(q)
    assert 150 < together.stands.sum() < len(q) - 100
    assert together.corners[..., 2].min() > -1e-12
    for k in range(0, len(q), 3):
        T = together.T_world_base[k]
        # The edges of the feet that it stands on are outside the outlines of the soles.
        lowest = (_vertices(nao, q[k]) @ T[2, :3]).min() + T[2, 3]
        assert lowest > (-3e-4 if together.stands[k] else -1e-8), k
    for k in range(0, len(q), 10):
        assert np.allclose(nao.set_down(q[k]).T_world_base, together.T_world_base[k], atol=1e-12), k


def test_straight_down_is_a_half_turn_about_y(nao: nk.NaoModel) -> None:
    down = nao.set_down(nao.neutral(), gravity=[0, 0, 1.0])
    assert down.T_world_base[:3, :3] == pytest.approx(np.diag([-1.0, 1.0, -1.0]), abs=1e-12)


def test_batches_and_floating_bases_give_the_same(nao: nk.NaoModel) -> None:
    q = np.stack([nao.posture(name) for name in nao.posture_names]).reshape(2, 4, -1)
    together = nao.set_down(q)
    floating = nk.load_nao(base="floating")
    qf = np.concatenate([np.broadcast_to([1.0, 2.0, 3.0, 0.5, 0.5, 0.5, 0.5], (2, 4, 7)), q], axis=-1)
    free = floating.set_down(qf)
    for k in np.ndindex(2, 4):
        one = nao.set_down(q[k])
        for name in ("T_world_base", "touching", "corners", "corners_touching", "links", "stands"):
            assert np.allclose(getattr(together, name)[k], getattr(one, name), atol=1e-9), name
            assert np.allclose(getattr(free, name)[k], getattr(one, name), atol=1e-9), name
    gravity = np.eye(3)
    assert nao.set_down(q[0, 0], gravity=gravity).T_world_base.shape == (3, 4, 4)
    assert nao.set_down(np.empty((0, nao.nq))).T_world_base.shape == (0, 4, 4)


# --- outlines ---------------------------------------------------------------------------------------------------------


@for_all("side", ["L", "R"])
def test_the_rows_are_the_edge_of_the_flat_of_the_mesh(each_nao: nk.NaoModel, side: str) -> None:
    mesh = trimesh.load(each_nao.urdf_path.parent / f"meshes/{side.lower()}_foot_dark.obj", process=False)
    flat = mesh.vertices[mesh.vertices[:, 2] < -0.0449, :2]
    outline = each_nao.sole_outline(f"{side}Leg")[:, :2]
    assert max(np.linalg.norm(flat - corner, axis=1).min() for corner in outline) < 1e-4
    assert ConvexHull(outline).volume > 0.95 * ConvexHull(flat).volume
    assert len(ConvexHull(outline).vertices) == len(outline)
    sensors = each_nao.sole_outline(f"{side}Leg", "sensors")
    assert nk.robot.SupportPolygon.around(outline).signed_distance(sensors).min() > 0.001


@for_all("side", ["L", "R"])
def test_the_corners_of_the_sensors_are_the_four_sensors_counter_clockwise(each_nao: nk.NaoModel, side: str) -> None:
    q = each_nao.neutral()
    names = [name for name in each_nao.semantics.force_sensors if name.startswith(side)]
    places = each_nao.fk(q, names, reference=f"{side}Leg")[:, :3, 3]
    corners = each_nao.sole_outline(f"{side}Leg", "sensors")
    order = ConvexHull(places[:, :2]).vertices  # counter-clockwise
    first = int(np.argmin(np.linalg.norm(places[order] - corners[0], axis=1)))
    np.testing.assert_allclose(corners, places[np.roll(order, -first)], atol=1e-9)


def test_the_rows_are_mirror_images_and_counter_clockwise() -> None:
    left, right = (np.array(row.corners_m) for row in SOLE_OUTLINES)
    assert {tuple(p) for p in left * [1, -1]} == {tuple(p) for p in right}
    for row in (left, right):
        along = np.roll(row, -1, axis=0) - row
        assert (along[:, 0] * np.roll(along[:, 1], -1) - along[:, 1] * np.roll(along[:, 0], -1) > 0.0).all()


@pytest.mark.parametrize("name", ["romeo", *full("icub")])
def test_any_humanoid_stands_on_the_soles_of_its_semantics(name: str) -> None:
    pytest.importorskip("cmeel")
    try:
        tree = nk.load_robot(name).tree
    except nk.errors.MissingExtra:
        pytest.skip("no example-robot-data")
    robot = nk.RobotModel(tree, Semantics(soles=("l_sole", "r_sole")))
    q = robot.neutral()
    down = robot.set_down(q)
    assert down.touching.all()
    assert down.stands
    T = down.T_world_base @ robot.fk(q, ["l_sole", "r_sole"], reference=robot.tree.root)
    assert np.abs(T[:, 2, 3]).max() < 0.006
    assert np.ptp(robot.sole_outline("l_sole"), axis=0).max() > 0.14
    named = nk.RobotModel(tree, replace(robot.semantics, outlines={"l_sole": ((0, 0), (0.1, 0), (0, 0.1))}))
    assert named.sole_outline("l_sole").tolist() == [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]]


def test_outlines_are_read_and_checked(nao: nk.NaoModel, tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("soles = ['LLeg']\n[outlines]\nLLeg = [[0.1, 0.0], [0.0, 0.1], [-0.1, 0.0]]\n")
    assert nk.semantics.read_semantics(path).outlines == {"LLeg": ((0.1, 0.0), (0.0, 0.1), (-0.1, 0.0))}
    path.write_text("[outlines]\nLLeg = [[0.1, 0.0], [0.0, 0.1]]\n")
    with pytest.raises(nk.errors.BadInputFile, match="outline of LLeg must be three or more pairs"):
        nk.semantics.read_semantics(path)
    with pytest.raises(nk.errors.BadModel, match="LLegg"):
        nk.RobotModel(nao.tree, Semantics(outlines={"LLegg": ((0, 0), (1, 0), (0, 1))}))


# --- what cannot be set down ------------------------------------------------------------------------------------------


def test_what_cannot_be_set_down_is_refused(nao: nk.NaoModel, tmp_path: Path) -> None:
    q = nao.neutral()
    with pytest.raises(ZeroNorm, match="gravity"):
        nao.set_down(q, gravity=[0.0, 0.0, 0.0])
    with pytest.raises(WrongShape, match="gravity"):
        nao.set_down(q, gravity=[0.0, 1.0])
    with pytest.raises(UnknownName, match="LFot"):
        nao.set_down(q, soles=["LFot"])
    with pytest.raises(BadArgument, match="soles must name"):
        nao.set_down(q, soles=[])
    with pytest.raises(BadArgument, match="tolerance"):
        nao.set_down(q, tolerance=-1.0)
    with pytest.raises(BadArgument, match="no outline of Head"):
        nao.sole_outline("Head", "sensors")
    path = tmp_path / "bare.urdf"
    path.write_text('<robot name="bare"><link name="a"/></robot>')
    with pytest.raises(BadArgument, match="neither soles nor shapes"):
        nk.RobotModel.from_urdf(path).set_down(np.zeros(0))


@pytest.mark.full
def test_a_robot_without_soles_is_on_its_lowest_shapes() -> None:
    try:
        panda = nk.load_robot("panda")
    except nk.errors.MissingExtra:
        pytest.skip("no example-robot-data")
    down = panda.set_down(panda.neutral())
    assert down.touching.shape == (0,)
    assert [name for name, on in zip(panda.link_names, down.links, strict=True) if on] == ["panda_link0"]
    assert down.T_world_base == pytest.approx(np.eye(4), abs=1e-4)
    assert nk.world.balance(panda, panda.neutral()).margin > 0.04
