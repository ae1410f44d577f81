"""Which soles carry a robot: known contacts, resting poses by linear programs, and polygons by Shapely."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from loops import for_all, full
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation
from standing_truth import Standing, feet_on_the_floor, gestures, walk, with_backlash

import nao_kin as nk
from nao_kin._kernels.settling import settle
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot.semantics import Semantics

shapely = pytest.importorskip("shapely")


@pytest.fixture(scope="module")
def steps(nao: nk.NaoModel) -> Standing:
    return walk(nao)


@pytest.fixture(scope="module")
def one_leg(nao: nk.NaoModel) -> Standing:
    return gestures(nao)


def _wrong(found: nk.world.Balance, truth: Standing) -> int:
    """Return the number of rows whose margin has the wrong sign, or none."""
    return int(np.count_nonzero(~(found.margin * truth.margin > 0.0)))


def _rest(points: np.ndarray, centre: np.ndarray, down: np.ndarray) -> np.ndarray | None:
    """Return the direction down of a body at rest: the facet below its centre of mass, until it stays the same.

    None if no point is below the centre, which then tips farther.

    In coordinates with z down, the facet is the plane z = a x + b y + h over all points with the least height at the
    centre: a linear program.
    """
    for _ in range(50):
        R = Rotation.align_vectors([[0.0, 0.0, 1.0]], [down])[0].as_matrix()
        x, y, z = ((points - centre) @ R.T).T
        plane = linprog([0.0, 0.0, 1.0], -np.column_stack([x, y, np.ones(len(x))]), -z, bounds=[(None, None)] * 3)
        if plane.x is None:
            return None
        normal = R.T @ [-plane.x[0], -plane.x[1], 1.0] / np.linalg.norm([*plane.x[:2], 1.0])
        if normal @ down > 1.0 - 1e-14:
            return normal
        down = normal
    raise AssertionError("no resting pose")


def test_bodies_settle_where_a_linear_program_says() -> None:
    rng = np.random.default_rng(2)
    points = rng.normal(size=(60, 12, 3)) * [0.1, 0.1, 0.01]
    centres = rng.uniform(-0.02, 0.02, (60, 3)) + np.array([0.0, 0.0, 0.05])
    start = -np.array([0.0, 0.0, 1.0]) + rng.normal(0.0, 0.02, (60, 3))
    start /= np.linalg.norm(start, axis=1, keepdims=True)
    down, away, chosen = settle(points, centres, start[:, None], np.full((60, 1), np.pi))
    assert (away == 0.0).all()
    assert (chosen == 0).all()
    same = 0
    for k in range(60):
        # It rests: the plane of the contacts is that of the linear program from there.
        assert _rest(points[k], centres[k], down[k]) == pytest.approx(down[k], abs=1e-3)
        other = _rest(points[k], centres[k], start[k])
        same += other is not None and np.allclose(other, down[k], atol=1e-3)
    assert same > 30  # bodies with several resting poses may find another one


def test_a_body_that_would_turn_too_far_stays_and_says_how_far_its_centre_is_outside() -> None:
    box = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (0.0, 0.3)])
    centre, start = np.array([[0.06, 0.0, 0.15]]), np.array([[[0.0, 0.0, -1.0]]])
    down, away, _ = settle(box[None], centre, start, np.radians([[5.0]]))
    assert down[0].tolist() == [0.0, 0.0, -1.0]
    assert away[0] == pytest.approx(0.01)
    down, away, _ = settle(box[None], centre, start, np.array([[np.pi]]))
    assert down[0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert away[0] == 0.0
    nothing = settle(box[None], centre, np.full((1, 1, 3), np.nan), np.array([[np.pi]]))
    assert nothing[2].tolist() == [-1]


def test_on_one_leg_a_toe_on_the_floor_does_not_make_it_fall(nao: nk.NaoModel, one_leg: Standing) -> None:
    inside = one_leg.margin > 0.0
    assert inside.sum() > 25
    for q in (one_leg.q[inside], with_backlash(nao, one_leg.q[inside])):
        truth = Standing(q, one_leg.contacts[inside], one_leg.margin[inside])
        found = nk.world.balance(nao, q)
        assert _wrong(found, truth) <= (0 if q is not truth.q else 1)
        assert found.down.stands.all()
        assert found.down.touching[:, 0].all()


def test_a_foot_in_the_air_does_not_carry(nao: nk.NaoModel, steps: Standing) -> None:
    found = nk.world.balance(nao, steps.q)
    in_air = np.abs(np.ptp(nao.fk(steps.q, ["LLeg", "RLeg"])[:, :, 2, 3], axis=1))
    single = steps.contacts.sum(axis=1) == 1
    # A foot less than 3 mm in the air may be on the floor, by the backlash of the joints.
    clear = single & (in_air > 0.003)
    assert clear.sum() > 200
    assert np.array_equal(found.down.touching[clear], steps.contacts[clear])
    assert found.margin[clear] == pytest.approx(steps.margin[clear], abs=1e-9)
    assert (found.margin[clear] < -0.01).all()
    assert found.margin[~single] == pytest.approx(steps.margin[~single], abs=1e-9)


def test_contacts_and_forces_decide_in_each_row(nao: nk.NaoModel, steps: Standing) -> None:
    q = with_backlash(nao, steps.q)
    found = nk.world.balance(nao, q, contacts=steps.contacts)
    assert np.array_equal(found.down.touching, steps.contacts)
    assert found.down.stands.all()
    assert np.abs(found.margin - steps.margin).max() < 0.006
    noise = np.random.default_rng(0).uniform(0.0, 0.5, steps.contacts.shape)
    by_force = nk.world.balance(nao, q, forces=steps.contacts * 20.0 + noise)
    assert np.array_equal(by_force.margin, found.margin)
    sensors = np.repeat(steps.contacts * 5.0, 4, axis=1)  # the four of the left foot, then those of the right foot
    assert nao.semantics.force_sensors[0].startswith("L")
    assert np.array_equal(nao.set_down(q, forces=sensors).T_world_base, found.down.T_world_base)
    exact = nao.set_down(steps.q, contacts=steps.contacts)
    feet = exact.T_world_base[:, None] @ nao.fk(steps.q, ["LLeg", "RLeg"])
    assert np.abs(feet[steps.contacts][:, 2, 3]).max() < 1e-9
    one = nk.world.balance(nao, q[0], contacts=steps.contacts[0])
    assert float(one.margin) == pytest.approx(found.margin[0], abs=1e-12)
    aloft = nao.set_down(q[:3], contacts=np.zeros((3, 2)))
    assert np.array_equal(aloft.T_world_base, nao.set_down(q[:3]).T_world_base)


def test_both_feet_with_backlash_keep_the_sign_of_the_margin(nao: nk.NaoModel) -> None:
    truth = feet_on_the_floor(nao)
    clear = np.abs(truth.margin) > 0.003
    assert np.count_nonzero(truth.margin < 0.0) > 8
    found = nk.world.balance(nao, with_backlash(nao, truth.q)[clear])
    # One that is 6 mm inside falls from a foot tilted by the backlash; none that falls is said to stand.
    assert _wrong(found, Standing(truth.q[clear], truth.contacts[clear], truth.margin[clear])) <= 1
    assert (found.margin[truth.margin[clear] < 0.0] < 0.0).all()


def _near_standing(nao: nk.NaoModel) -> np.ndarray:
    """Return noise around each posture that stands, and all changes of one joint."""
    rng, rows = np.random.default_rng(1), []
    for q in (nao.posture(name) for name in ("Stand", "StandInit", "StandZero", "Crouch")):
        rows += [nao.clamp(q + rng.normal(0.0, sigma, (40, nao.nq))) for sigma in (0.01, 0.03, 0.1)]
        rows += [q + change * np.eye(nao.nq) for change in (-0.2, -0.1, -0.03, 0.03, 0.1, 0.2)]
    return np.concatenate(rows)


@for_all("outline", ["sole", "sensors"])
def test_near_postures_no_corner_in_the_air_carries_a_robot_that_falls(nao: nk.NaoModel, outline: str) -> None:
    q = _near_standing(nao)
    found = nk.world.balance(nao, q, outline=outline)  # type: ignore[arg-type]
    down = found.down
    assert np.array_equal(down.corners_touching, down.corners[..., 2] <= 0.002)
    assert down.touching[down.stands].any(axis=1).all()
    assert down.stands.sum() > len(q) - 5
    assert 40 < np.isnan(found.margin).sum() < 200
    # The same soles have an area if they are known to carry.
    assert np.isfinite(nk.world.balance(nao, q, contacts=down.touching).margin[down.stands]).all()


def test_a_robot_on_the_tip_of_its_foot_has_no_support(nao: nk.NaoModel) -> None:
    q = nao.posture("Stand")
    q[nao.joint_names.index("LKneePitch")] -= 0.2
    down = nao.set_down(q)
    assert down.stands
    assert down.corners[:, 2].max() > 0.018
    assert down.corners[down.corners_touching][:, 2].max() <= 0.002
    with pytest.raises(BadArgument, match="no support polygon"):
        nk.world.balance(nao, q)
    assert np.isnan(nk.world.balance(nao, [q]).margin).all()
    assert nk.world.balance(nao, q, contacts=[True, True]).margin > 0.06


def test_a_robot_whose_soles_are_all_in_the_air_does_not_stand_on_them(nao: nk.NaoModel) -> None:
    down = nao.set_down(nao.random(5, 1500))
    assert 500 < down.stands.sum() < 1000
    assert down.touching[down.stands].any(axis=1).all()
    assert (down.corners[..., 2] > 0.002)[~down.corners_touching].all()
    # Without soles below everything else its root is upright, or it rests as in a posture that lies or sits.
    aloft = ~down.stands & ~down.touching.any(axis=1)
    assert np.count_nonzero(down.T_world_base[aloft, 2, 2] > 1.0 - 1e-12) > 20


def test_the_polygon_is_that_of_the_corners_that_touch(nao: nk.NaoModel, one_leg: Standing) -> None:
    found = nk.world.balance(nao, one_leg.q)
    for k in range(0, len(one_leg.q), 5):
        corners = found.down.corners[k][found.down.corners_touching[k]]
        assert corners[:, 2].max() <= 0.002
        own = found.vertices[k][np.isfinite(found.vertices[k, :, 0])]
        hull = shapely.MultiPoint(corners[:, :2]).convex_hull
        assert shapely.Polygon(own).symmetric_difference(hull).area < 1e-12
        at = shapely.Point(found.com[k, :2])
        away = hull.exterior.distance(at)
        assert found.margin[k] == pytest.approx(away if hull.contains(at) else -away, abs=1e-9)


def test_corners_that_hang_five_millimetres_in_the_air_do_not_carry(nao: nk.NaoModel) -> None:
    # Feet on their inner edges: the outer ones hang 81 mm · sin(3.6°) = 5 mm in the air.
    q = nao.configuration({"LAnkleRoll": 0.063, "RAnkleRoll": -0.063})
    found = nk.world.balance(nao, q)
    heights = found.down.corners[:, 2]
    assert heights.max() > 0.0045
    assert found.down.touching.all()
    assert np.array_equal(found.down.corners_touching, heights <= 0.002)
    polygon = nk.robot.SupportPolygon(found.vertices)
    assert polygon.signed_distance(found.down.corners[heights > 0.0045]).max() < -0.04


# --- soles below their frames -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "soles", "height", "drop"),
    [
        *full(("g1_29dof_rev_1_0", ["left_ankle_roll_link", "right_ankle_roll_link"], 0.792, 0.035)),
        ("romeo", ["l_ankle", "r_ankle"], None, 0.068),
    ],
)
def test_soles_below_their_frame_do_not_sink_the_robot(
    name: str, soles: list[str], height: float | None, drop: float
) -> None:
    try:
        robot = nk.load_robot(name)
    except nk.errors.MissingExtra:
        pytest.skip("no example-robot-data")
    q = robot.neutral()
    down = robot.set_down(q, soles=soles)
    assert robot.sole_outline(soles[0])[:, 2] == pytest.approx(-drop, abs=2e-3)
    assert down.corners[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    frames = down.T_world_base @ robot.fk(q, soles, reference=robot.tree.root)
    assert frames[:, 2, 3] == pytest.approx(drop, abs=2e-3)
    if height is not None:
        assert down.T_world_base[2, 3] == pytest.approx(height, abs=2e-3)
    path = nk.world.odometry(robot, [q, q], [0.0, 0.02], soles=soles)
    assert path.T_world_base[0, 2, 3] == pytest.approx(down.T_world_base[2, 3], abs=2e-3)
    assert path.T_world_support[0, 2, 3] == pytest.approx(drop, abs=2e-3)


def test_the_ankles_of_a_nao_are_above_its_soles(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    down = nao.set_down(q, soles=["l_ankle", "r_ankle"])
    assert nao.sole_outline("l_ankle")[:, 2] == pytest.approx(-0.0452, abs=5e-4)
    assert down.T_world_base[2, 3] == pytest.approx(nao.set_down(q).T_world_base[2, 3], abs=5e-4)


def test_an_outline_may_have_heights(nao: nk.NaoModel, tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("soles = ['LLeg']\n[outlines]\nLLeg = [[0.1, 0, -0.01], [0, 0.1, -0.01], [-0.1, 0, -0.01]]\n")
    read = nk.semantics.read_semantics(path)
    assert read.outlines["LLeg"][0] == (0.1, 0.0, -0.01)
    robot = nk.RobotModel(nao.tree, replace(Semantics(soles=("LLeg",)), outlines=read.outlines))
    assert robot.sole_outline("LLeg")[:, 2].tolist() == [-0.01] * 3
    q = nao.posture("StandInit")
    lifted = robot.set_down(q, soles="LLeg").T_world_base[2, 3] - nao.set_down(q, soles="LLeg").T_world_base[2, 3]
    assert lifted == pytest.approx(0.01, abs=1e-9)
    for wrong in ("[[1, 2, 3, 4], [0, 1], [1, 0]]", "[[1], [0, 1], [1, 0]]"):
        path.write_text(f"[outlines]\nLLeg = {wrong}\n")
        with pytest.raises(nk.errors.BadInputFile, match="three or more pairs or triples"):
            nk.semantics.read_semantics(path)


def test_contacts_that_do_not_fit_are_refused(nao: nk.NaoModel) -> None:
    q = np.stack([nao.posture("Stand")] * 3)
    with pytest.raises(BadArgument, match="contacts or forces, not both"):
        nao.set_down(q, contacts=np.ones((3, 2)), forces=np.ones((3, 2)))
    with pytest.raises(WrongShape, match="contacts"):
        nao.set_down(q, contacts=np.ones((2, 2)))
    with pytest.raises(WrongShape, match=r"\(3, 2\) or \(3, 8\)"):
        nk.world.balance(nao, q, forces=np.ones((3, 5)))
