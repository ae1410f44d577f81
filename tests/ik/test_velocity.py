"""Joint velocities for twists: against NumPy's pseudo-inverse, finite differences and bounded least squares."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from loops import for_all
from made_up_robots import J, made_up
from scipy.optimize import lsq_linear

import nao_kin as nk
from nao_kin.errors import BadArgument, NotFinite, UnknownName, WrongShape
from nao_kin.ik import velocity

FRAMES = ("Head", "LArm", "RArm", "LLeg", "RLeg")


def moderate(robot: nk.RobotModel, frame: str, seed: int, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Configurations in the middle of their ranges, and twists that the joints can make slowly."""
    rng = np.random.default_rng(seed)
    q = robot.clamp(
        0.5 * (robot.lower + robot.upper) + 0.3 * (robot.random(rng, n) - 0.5 * (robot.lower + robot.upper))
    )
    J = robot.jacobian(q, frame)
    return q, np.einsum("nij,nj->ni", J, rng.uniform(-0.3, 0.3, (n, robot.nv)))


@for_all("frame", FRAMES)
@for_all("expressed_in", ["mixed", "frame", "root"])
@for_all("damping", [0.0, 0.1])
@for_all("rows", [6, 3])
def test_without_limits_it_is_the_pseudo_inverse_or_solves_the_damped_normal_equations(
    nao: nk.NaoModel, frame: str, expressed_in: str, damping: float, rows: int
) -> None:
    """Also of a linear velocity, which leaves the angular one free."""
    q, wanted = nao.random(1, 20), np.random.default_rng(2).normal(size=(20, rows))
    options = {"expressed_in": expressed_in, "damping": damping, "limits": "ignore", "length": 0.3}
    found = velocity(nao, q, wanted, frame, **options)  # type: ignore[arg-type]
    jacobian, scale = nao.jacobian(q, frame, expressed_in), np.repeat([1.0 / 0.3, 1.0], 3)[:rows]  # type: ignore[arg-type]
    for k in range(20):
        J, w = scale[:, None] * jacobian[k, :rows], scale * wanted[k]
        expected = np.linalg.pinv(J, rcond=1e-11) @ w
        if damping:
            expected = np.linalg.solve(J.T @ J + damping**2 * np.eye(nao.nv), J.T @ w)
        np.testing.assert_allclose(found.v[k], expected, atol=1e-9 * max(1.0, np.abs(expected).max()))
        np.testing.assert_allclose(found.twist[k], jacobian[k] @ found.v[k], atol=1e-9)
    off = np.zeros((20, 6))
    off[:, :rows] = wanted - found.twist[:, :rows]
    np.testing.assert_allclose(found.residual, np.linalg.norm(off.reshape(20, 2, 3), axis=-1), atol=1e-12)
    np.testing.assert_array_equal(found.wanted, wanted)


@pytest.mark.parametrize("frame", FRAMES)
def test_a_twist_that_can_be_made_is_what_the_frame_then_does(nao: nk.NaoModel, frame: str) -> None:
    q, twist = moderate(nao, frame, 3, 40)
    found = velocity(nao, q, twist, frame, damping=0.0)
    assert not found.limited.any()
    np.testing.assert_allclose(found.twist, twist, atol=1e-9)
    np.testing.assert_allclose(found.residual, 0.0, atol=1e-9)
    h = 1e-6
    ahead, behind = (nao.fk(q + sign * h * found.v, frame) for sign in (1.0, -1.0))
    np.testing.assert_allclose((ahead - behind)[:, :3, 3] / (2 * h), twist[:, :3], atol=1e-6)
    turned = nk.rotations.log(ahead[:, :3, :3] @ behind[:, :3, :3].swapaxes(-1, -2)) / (2 * h)
    np.testing.assert_allclose(turned, twist[:, 3:], atol=1e-6)


@pytest.mark.parametrize("choice", ["enforce", "scale"])
@pytest.mark.parametrize("frame", FRAMES)
def test_no_joint_is_too_fast_or_leaves_its_range_within_the_time(nao: nk.NaoModel, frame: str, choice: str) -> None:
    rng = np.random.default_rng(4)
    q, twist = nao.random(rng, 2000), rng.normal(size=(2000, 6)) * [0.5, 0.5, 0.5, 5.0, 5.0, 5.0]
    found = velocity(nao, q, twist, frame, limits=choice, dt=0.02)  # type: ignore[arg-type]
    assert found.limited.any()
    assert (np.abs(found.v) <= nao.velocity_limits + 1e-9).all()
    assert nao.within_limits(q + 0.02 * found.v).all()


@pytest.mark.parametrize("dt", [0.002, 0.1])
@pytest.mark.parametrize("frame", ["Head", "LLeg"])
def test_from_the_edges_of_ranges_none_is_left(nao: nk.NaoModel, frame: str, dt: float) -> None:
    rng = np.random.default_rng(1)
    q = nao.clamp(nao.random(rng, 1000) + rng.normal(size=(1000, 25)))
    twist = rng.normal(size=(1000, 6)) * [1.0, 1.0, 1.0, 8.0, 8.0, 8.0]
    for choice in ("enforce", "scale"):
        found = velocity(nao, q, twist, frame, limits=choice, dt=dt)  # type: ignore[arg-type]
        assert (np.abs(found.v) <= nao.velocity_limits + 1e-9).all()
        assert nao.within_limits(q + dt * found.v).all()
        if (frame, choice, dt) == ("LLeg", "enforce", 0.002):  # the edge of a coupled range stops no other joint
            assert np.any(found.v, axis=-1).all()
        assert np.any(found.v, axis=-1).mean() > 0.1


@pytest.mark.parametrize("fast", [1.0, 4.0])
@pytest.mark.parametrize("frame", ["LArm", "LLeg"])
@pytest.mark.parametrize("rows", [6, 3])
def test_redistribution_is_the_best_there_is(nao: nk.NaoModel, rows: int, frame: str, fast: float) -> None:
    rng = np.random.default_rng(6)
    q, twist = nao.random(rng, 60), fast * (rng.normal(size=(60, 6)) * [0.3, 0.3, 0.3, 3.0, 3.0, 3.0])[:, :rows]
    found = velocity(nao, q, twist, frame, dt=0.01, damping=0.0)
    jacobian, left = nao.jacobian(q, frame)[:, :rows], np.linalg.norm(found.wanted - found.twist[:, :rows], axis=-1)
    low = np.maximum(-nao.velocity_limits, (nao.lower - q) / 0.01)
    high = np.minimum(nao.velocity_limits, (nao.upper - q) / 0.01)
    compared = 0
    for k in range(60):
        best = lsq_linear(jacobian[k], twist[k], (low[k] - 1e-12, high[k] + 1e-12), tol=1e-12).x
        if nao.within_limits(q[k] + 0.01 * best):  # coupled limits are unknown to SciPy
            assert left[k] <= np.linalg.norm(jacobian[k] @ best - twist[k]) + 1e-6
            compared += 1
    assert compared > 48
    assert (left <= np.linalg.norm(twist, axis=-1)).all()  # never worse than standing still
    assert found.limited.sum() > 12


def test_scaling_keeps_the_direction_of_the_twist(nao: nk.NaoModel) -> None:
    q, twist = moderate(nao, "LLeg", 3, 40)
    found = velocity(nao, q, 1e3 * twist, "LLeg", limits="scale", damping=0.0)
    assert found.limited.all()
    share = np.linalg.norm(found.twist, axis=-1) / np.linalg.norm(found.wanted, axis=-1)
    assert (share > 0.0).all()
    np.testing.assert_allclose(found.twist, share[:, None] * found.wanted, atol=1e-9)


def test_scaling_stops_all_where_one_joint_stands_at_its_limit(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    knee = nao.joint_names.index("LKneePitch")
    q[knee] = nao.upper[knee]
    column = nao.jacobian(q, "LLeg")[:, knee]
    found = velocity(nao, q, 0.1 * column, "LLeg", limits="scale", damping=0.0)
    np.testing.assert_array_equal(found.v, 0.0)
    assert found.limited


def test_a_joint_outside_its_range_comes_back() -> None:
    nao = nk.load_nao("v6")
    q = nao.posture("StandInit")
    knee = nao.joint_names.index("LKneePitch")
    q[knee] = nao.upper[knee] + 0.5
    found = velocity(nao, q, np.zeros(6), "LLeg")
    assert found.v[knee] == pytest.approx(-nao.velocity_limits[knee])


def test_damping_bounds_velocities_at_a_straight_knee(nao: nk.NaoModel) -> None:
    q = np.tile(nao.neutral(), (8, 1))
    q[:, nao.joint_names.index("LKneePitch")] = np.concatenate([[0.0], np.logspace(-9, -3, 7)])
    upwards = np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
    damped = velocity(nao, q, upwards, "LLeg", limits="ignore")
    assert (np.abs(damped.v).max(axis=-1) < 10.0).all()
    assert (damped.damping[:, -1] > 0.0).all()
    np.testing.assert_array_equal(damped.damping[:, 0], 0.0)
    plain = velocity(nao, q[2], upwards, "LLeg", limits="ignore", damping=0.0)
    assert np.abs(plain.v).max() > 1e4


def test_a_linear_velocity_that_can_be_made_is_what_the_origin_then_does() -> None:
    for name, frame in (("romeo", "r_wrist"), ("panda", "panda_link8")):
        robot = nk.load_robot(name, base="floating")
        q = robot.random(1)
        q[3:7] = [0.5, -0.5, 0.5, 0.5]
        found = velocity(robot, q, [0.02, -0.03, 0.01], frame, damping=0.0, limits="ignore")
        assert not found.v[:6].any()
        h = 1e-6
        ahead, behind = (robot.position(pin.integrate(robot.model, q, s * h * found.v), frame) for s in (1.0, -1.0))
        np.testing.assert_allclose((ahead - behind) / (2 * h), [0.02, -0.03, 0.01], atol=1e-8)


def test_measures_are_those_of_the_rows_of_the_jacobian(nao: nk.NaoModel) -> None:
    q = nao.random(7, (2, 3))
    for n in (6, 3):
        found = velocity(nao, q, np.zeros(n), "RLeg", length=0.1)
        rows = nao.jacobian(q, "RLeg")[..., :n, list(found.columns)]
        rows[..., :3, :] /= 0.1
        expected = np.sqrt(np.linalg.det(rows @ rows.swapaxes(-1, -2)))
        np.testing.assert_allclose(found.map.manipulability, expected, rtol=1e-9)
        np.testing.assert_allclose(found.map.condition_number, np.linalg.cond(rows), rtol=1e-9)
        assert found.map.twists.shape == (2, 3, n, n)
        assert (found.v.shape, found.residual.shape) == ((2, 3, 25), (2, 3, 2))
    straight = velocity(nao, nao.neutral(), np.zeros(3), "LLeg")
    assert straight.map.lost_twists() == ("vz",)
    assert len(straight.map.idle_joints()) == 4  # of six joints
    head = velocity(nao, nao.neutral(), [0.1, 0.1, 0.1], "Head")  # the origin of the head is on both axes
    assert head.map.lost_twists() == ("vx", "vy", "vz")
    np.testing.assert_array_equal(head.v, 0.0)


def test_lost_twists_and_idle_joints_go_by_their_names(nao: nk.NaoModel) -> None:
    straight = velocity(nao, nao.neutral(), np.zeros(6), "LLeg").map
    assert straight.lost_twists() == ("vz",)
    (idle,) = straight.idle_joints()
    assert set(idle.split()) >= {"LHipPitch", "LKneePitch", "LAnklePitch"}
    arm = velocity(nao, nao.neutral(), np.zeros(6), "LArm").map
    assert arm.idle_joints() == ("LElbowYaw − LWristYaw",)
    assert len(arm.lost_twists()) == 2
    bent = velocity(nao, nao.posture("StandInit"), np.zeros(6), "LLeg").map
    assert bent.lost_twists() == bent.idle_joints() == ()
    several = velocity(nao, np.stack([nao.neutral(), nao.posture("StandInit")]), np.zeros(6), "LLeg").map
    assert (several.lost_twists((0,)), several.idle_joints((0,))) == (("vz",), (idle,))
    assert several.lost_twists((1,)) == several.idle_joints((1,)) == ()
    head = velocity(nao, nao.neutral(), np.zeros(6), "Head").map
    assert "ωx" in head.lost_twists()
    assert len(head.lost_twists()) == 4


def test_lost_twists_are_what_no_joint_velocity_makes(tmp_path: Path) -> None:
    # Two sliders along x and y: z and all turns are lost, and a third along x + y moves nothing new.
    robot = made_up(
        tmp_path,
        J("a", axis=(1.0, 0.0, 0.0), kind="prismatic"),
        J("b", axis=(0.0, 1.0, 0.0), kind="prismatic"),
        J("c", axis=(0.6, 0.8, 0.0), kind="prismatic"),
    )
    found = velocity(robot, robot.neutral(), [0.1, 0.2, 0.0, 0.0, 0.0, 0.0], "c_l")
    assert found.map.lost_twists() == ("vz", "ωx", "ωy", "ωz")
    assert found.map.idle_joints() == ("0.6 a + 0.8 b − c",)
    assert found.map.rank() == 2
    np.testing.assert_allclose(found.twist, [0.1, 0.2, 0.0, 0.0, 0.0, 0.0], atol=1e-12)
    plain = velocity(robot, robot.neutral(), [0.1, 0.2, 0.3, 0.0, 0.0, 0.0], "c_l", damping=0.0, limits="ignore")
    expected = np.linalg.pinv(robot.jacobian(robot.neutral(), "c_l")) @ [0.1, 0.2, 0.3, 0.0, 0.0, 0.0]
    np.testing.assert_allclose(plain.v, expected, atol=1e-12)


def test_a_direction_that_is_lost_to_rounding_only_takes_no_velocity(tmp_path: Path) -> None:
    a, b = np.array([0.1, 0.7, 0.2]), np.array([0.5, -0.3, 0.4])
    axes = [tuple((v / np.linalg.norm(v)).tolist()) for v in (a, b, a + b)]
    robot = made_up(tmp_path, *(J(name, axis=axis, kind="prismatic") for name, axis in zip("abc", axes, strict=True)))
    found = velocity(robot, robot.neutral(), [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], "c_l", damping=0.0, limits="ignore")
    assert found.map.singular_values[-1] < 1e-14
    assert np.abs(found.v).max() < 10.0


def test_a_floating_base_stands_still_and_followers_are_counted(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a"),
        J("b", xyz=(0.3, 0.0, 0.0), follows=("a", 0.5, 0.1)),
        J("c", xyz=(0.2, 0.0, 0.0)),
        base="floating",
    )
    q = robot.random(3)
    wanted = robot.jacobian(q, "c_l")[:, 6:] @ [0.4, -0.3]
    found = velocity(robot, q, wanted, "c_l", limits="ignore", damping=0.0)
    np.testing.assert_allclose(found.v, [0.0] * 6 + [0.4, -0.3], atol=1e-9)


def test_configurations_and_twists_broadcast(nao: nk.NaoModel) -> None:
    q, twist = nao.random(1, (4, 1)), np.random.default_rng(0).normal(size=(3, 6))
    found = velocity(nao, q, twist, "LLeg")
    assert found.v.shape == (4, 3, 25)
    one = velocity(nao, q[2, 0], twist[1], "LLeg")
    np.testing.assert_allclose(found.v[2, 1], one.v, atol=1e-9)
    assert velocity(nao, np.zeros((0, 25)), twist[0], "LLeg").v.shape == (0, 25)


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"frame": "LLag"}, UnknownName, "LLeg"),
        ({"expressed_in": "world"}, UnknownName, "mixed"),
        ({"damping": -1.0}, BadArgument, "damping"),
        ({"dt": 0.0}, BadArgument, "dt"),
        ({"length": np.inf}, NotFinite, "length"),
        ({"twist": [np.nan] * 6}, NotFinite, "twist"),
        ({"twist": [0.0] * 5}, WrongShape, r"\(\.\.\., 6\), or \(\.\.\., 3\) for a linear velocity, got \(5,\)"),
        ({"twist": [0.1, np.inf, 0.0]}, NotFinite, r"twist.*\[1\]"),
        ({"twist": np.zeros((3, 6)), "q": np.zeros((2, 25))}, WrongShape, "broadcast"),
    ],
)
def test_bad_input_is_named(nao: nk.NaoModel, changes: dict[str, object], error: type, words: str) -> None:
    arguments: dict[str, object] = {"q": nao.neutral(), "twist": np.zeros(6), "frame": "LLeg", **changes}
    with pytest.raises(error, match=words):
        velocity(nao, **arguments)  # type: ignore[arg-type]
