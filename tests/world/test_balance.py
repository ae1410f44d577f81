"""Balance beside SciPy's hulls, rotations about the edges of the support polygon, and NAOqi's FRAME_ROBOT."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from loops import for_all, full
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin._kernels.hulls import hulls, rows_of_hulls
from nao_kin.errors import BadArgument, UnknownName, WrongShape, ZeroNorm
from nao_kin.robot import SupportPolygon
from nao_kin.robot.semantics import Semantics


def _signed_distance(points: np.ndarray, centre: np.ndarray) -> float:
    hull = ConvexHull(points)
    inside = -(hull.equations @ [*centre, 1.0]).max()
    if inside >= 0.0:
        return float(inside)
    corners = points[hull.vertices]
    edges = zip(corners, np.roll(corners, -1, 0), strict=True)
    dense = np.concatenate([a + np.linspace(0, 1, 20001)[:, None] * (b - a) for a, b in edges])
    return -float(np.linalg.norm(dense - centre, axis=1).min())


@settings(max_examples=25, deadline=None)
# Powers of two: products of the rounded corners are exact, so collinear ones are.
@given(st.integers(0, 2**31), st.sampled_from([2.0**-7, 0.25, 4.0]))
def test_margins_are_distances_from_scipys_hull(seed: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    points = spread * rng.normal(size=(3, rng.integers(3, 20), 2))
    points[0, ::2] = points[0, :1]  # repeated corners
    points[1] = np.round(points[1] / spread) * spread  # collinear ones
    points[2, 4:] = np.nan
    centres = spread * rng.normal(size=(3, 2))
    interpreted = np.full(points.shape, np.nan), np.full(points.shape[:2], np.nan), np.full(3, np.nan), np.full(3, -1)
    rows_of_hulls(points, centres, *interpreted)
    compiled = hulls(points, centres)
    for one, other in zip(compiled, interpreted, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14, atol=1e-15)
    for own, centre, vertices, distances, margin, nearest in zip(points, centres, *compiled, strict=True):
        own = own[np.isfinite(own[:, 0])]
        rank = np.linalg.matrix_rank(own - own[0], tol=1e-9)
        if rank < 2:
            assert np.isnan(margin)
            assert nearest == -1
            continue
        assert margin == pytest.approx(_signed_distance(own, centre), abs=1e-6 * spread)
        corners = vertices[np.isfinite(vertices[:, 0])]
        assert margin == pytest.approx(SupportPolygon.around(own).signed_distance(centre), rel=1e-14, abs=1e-15)
        np.testing.assert_array_equal(corners, SupportPolygon.around(own).vertices)
        assert distances[nearest] == pytest.approx(np.nanmin(distances)) or margin < 0.0
        assert ConvexHull(corners).volume == pytest.approx(ConvexHull(own).volume)
        assert len(ConvexHull(corners).vertices) == len(corners)


@for_all("posture", ["Stand", "StandInit", "StandZero", "Crouch"])
def test_a_standing_posture_is_inside_its_soles(each_nao: nk.NaoModel, posture: str) -> None:
    q = each_nao.posture(posture)
    found = nk.world.balance(each_nao, q)
    corners = found.down.corners[found.down.corners_touching]
    assert found.margin == pytest.approx(_signed_distance(corners[:, :2], found.com[:2]), abs=1e-9)
    assert found.margin == pytest.approx(found.distances.min())
    assert found.distances[found.nearest] == found.margin
    # The published values of Stand and Crouch set the feet down on their edges.
    flat = posture in ("StandInit", "StandZero")
    assert nk.world.margin(each_nao, q) == pytest.approx(float(found.margin), abs=1e-9 if flat else 2e-3)
    T = found.down.T_world_base
    assert found.com == pytest.approx(T[:3, :3] @ each_nao.com(q) + T[:3, 3], abs=1e-12)


@for_all("posture", ["Sit", "SitRelax", "LyingBelly", "LyingBack"])
def test_a_posture_on_the_floor_rests_on_all_that_touches(nao: nk.NaoModel, posture: str) -> None:
    found = nk.world.balance(nao, nao.posture(posture))
    assert found.margin > 0.02
    on_soles = nk.world.balance(nao, nao.posture("Sit"), soles=["LLeg", "RLeg"])
    assert on_soles.margin < 0.0 < nk.world.balance(nao, nao.posture("Sit")).margin


def test_tilting_by_the_angle_brings_the_centre_of_mass_above_the_edge(nao: nk.NaoModel) -> None:
    for q in (nao.posture("Stand"), nao.posture("Crouch"), nao.posture("LyingBack")):
        found = nk.world.balance(nao, q)
        for k, (corner, tilt) in enumerate(zip(found.vertices, found.tilts, strict=True)):
            along = np.roll(found.vertices, -1, axis=0)[k] - corner
            axis = np.append(along, 0.0) / np.linalg.norm(along)
            lever = found.com - np.append(corner, 0.0)
            # Over the edge is outwards: with the inside on its left, a positive rotation about it.
            tipped = Rotation.from_rotvec(tilt * axis).apply(lever)
            assert axis[0] * tipped[1] - axis[1] * tipped[0] == pytest.approx(0.0, abs=1e-12)
            assert tipped[2] > 0.0


def test_the_torso_is_in_the_soles_and_between_the_feet(nao: nk.NaoModel) -> None:
    q = nao.posture("Crouch")
    found = nk.world.balance(nao, q)
    assert found.T_sole_base == pytest.approx(np.linalg.inv(nao.fk(q, ["LLeg", "RLeg"])), abs=1e-12)
    T_world_base = found.down.T_world_base
    naoqi = nk.naoqi.pose_in(nao, q, "Torso", "FRAME_ROBOT", torso_in_world=T_world_base)
    assert found.T_robot_base == pytest.approx(naoqi, abs=1e-12)
    feet = T_world_base @ nao.fk(q, ["LLeg", "RLeg"])
    frame = nk.world.feet_frame(feet)
    yaws = np.arctan2(feet[:, 1, 0], feet[:, 0, 0])
    assert np.arctan2(frame[1, 0], frame[0, 0]) == pytest.approx(yaws.mean(), abs=1e-12)
    assert frame[:3, 3] == pytest.approx([*feet[:, :2, 3].mean(axis=0), feet[:, 2, 3].min()])


def test_a_frame_between_feet_on_both_sides_of_half_a_turn() -> None:
    feet = np.stack([np.eye(4), np.eye(4)])
    for k, yaw in enumerate((np.pi - 0.1, -np.pi + 0.3)):
        feet[k, :3, :3] = nk.rotations.rot_z(yaw)
    feet[1, :3, 3] = [0.2, 0.4, 0.1]
    frame = nk.world.feet_frame(feet)
    assert np.allclose(frame[:3, :3], nk.rotations.rot_z(np.pi + 0.1), atol=1e-12)
    assert frame[:3, 3] == pytest.approx([0.1, 0.2, 0.0])


def test_batches_are_the_configurations_one_by_one(nao: nk.NaoModel) -> None:
    q = np.stack([nao.posture(name) for name in nao.posture_names]).reshape(4, 2, -1)
    together = nk.world.balance(nao, q)
    for k in np.ndindex(4, 2):
        one = nk.world.balance(nao, q[k])
        count = len(one.vertices)
        assert np.allclose(together.vertices[k][:count], one.vertices, atol=1e-9)
        assert np.isnan(together.vertices[k][count:]).all()
        assert np.allclose(together.tilts[k][:count], one.tilts, atol=1e-9)
        assert np.isnan(together.tilts[k][count:]).all()
        for name in ("com", "margin", "nearest", "T_sole_base", "T_robot_base"):
            assert np.allclose(getattr(together, name)[k], getattr(one, name), atol=1e-9), name
    soles = nk.world.margin(nao, np.broadcast_to(q, (3, 4, 2, nao.nq)))
    assert soles.shape == (3, 4, 2)
    assert np.allclose(soles[:, 0, 1], together.margin[0, 1])


def test_margins_follow_gravity_and_the_outline(nao: nk.NaoModel) -> None:
    q = nao.posture("StandZero")
    level = nk.world.margin(nao, q, gravity=[0, 0, -9.81])
    assert level == pytest.approx(float(nk.world.margin(nao, q)), abs=1e-9)
    tilts = np.radians([0.0, 5.0, 40.0])
    gravity = np.stack([np.sin(tilts), 0 * tilts, -np.cos(tilts)], axis=-1)
    margins = nk.world.margin(nao, q, gravity=gravity)
    assert margins.shape == (3,)
    assert margins[2] < 0.0 < margins[0]
    assert nk.world.margin(nao, q, outline="sensors") < level
    assert nk.world.balance(nao, q, outline="sensors").margin == pytest.approx(
        float(nk.world.margin(nao, q, outline="sensors"))
    )
    floating = nk.load_nao(base="floating")
    assert nk.world.margin(floating, floating.posture("StandZero")) == pytest.approx(float(level), abs=1e-9)


@pytest.mark.full
@pytest.mark.parametrize("name", ["romeo", *full("icub")])
def test_any_humanoid_has_a_margin(name: str) -> None:
    try:
        tree = nk.load_robot(name).tree
    except nk.errors.MissingExtra:
        pytest.skip("no example-robot-data")
    robot = nk.RobotModel(tree, Semantics(soles=("l_sole", "r_sole")))
    found = nk.world.balance(robot, robot.neutral())
    assert found.margin == pytest.approx(float(nk.world.margin(robot, robot.neutral())), abs=2e-3)
    one = nk.world.balance(robot, robot.neutral(), soles="l_sole")
    assert one.margin < found.margin


def test_what_has_no_balance_is_refused(nao: nk.NaoModel) -> None:
    q = nao.posture("Stand")
    with pytest.raises(ZeroNorm, match="gravity"):
        nk.world.balance(nao, q, gravity=np.zeros(3))
    # On its toes, it touches the floor in a corner.
    tip = {"soles": "LLeg", "gravity": [-0.5, -0.3, -1.0]}
    with pytest.raises(BadArgument, match="no support polygon"):
        nk.world.balance(nao, q, **tip)
    batch = nk.world.balance(nao, [q, q], **tip)
    assert np.isnan(batch.margin).all()
    assert (batch.nearest == -1).all()
    line = nk.RobotModel(nao.tree, replace(nao.semantics, outlines={"LLeg": ((0, 0), (0.1, 0), (0.2, 0))}))
    assert np.isnan(nk.world.margin(line, q, soles="LLeg"))
    nobody = nk.RobotModel(nao.tree, Semantics())
    with pytest.raises(BadArgument, match="no soles"):
        nk.world.margin(nobody, q)
    with pytest.raises(BadArgument, match="one foot"):
        nk.world.feet_frame(np.eye(4))
    with pytest.raises(BadArgument, match="soles must name at least one frame"):
        nk.world.margin(nao, q, soles=[])
    for outline in ("shoe", None):
        with pytest.raises(UnknownName, match="kind of outline"):
            nk.world.balance(nao, q, outline=outline)  # type: ignore[arg-type]
    for ask in (nk.world.margin, nk.world.balance):
        with pytest.raises(WrongShape, match="configurations and gravity"):
            ask(nao, [q, q], gravity=[[0.0, 0.0, -1.0]] * 3)  # type: ignore[operator]


def test_a_foot_a_little_above_the_floor_touches_it_with_a_larger_tolerance(nao: nk.NaoModel) -> None:
    q, lift = nao.posture("StandInit"), 0.03
    for joint, turn in (("RHipPitch", -lift), ("RKneePitch", 2.0 * lift), ("RAnklePitch", -lift)):
        q[nao.joint_names.index(joint)] += turn
    left, right = nao.position(q, ["LLeg", "RLeg"])[:, 2]
    assert 0.001 < right - left < 0.005
    strict, usual, wide = (nk.world.balance(nao, q, tolerance=tolerance) for tolerance in (0.0005, 0.001, 0.005))
    assert len(strict.vertices) < len(wide.vertices) or strict.margin < wide.margin
    assert strict.margin < usual.margin < wide.margin
    assert wide.margin == pytest.approx(nk.world.balance(nao, nao.posture("StandInit")).margin, abs=1e-3)
