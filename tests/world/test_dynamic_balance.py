"""The zero-moment point beside Pinocchio's centroidal momentum; edges, tilts and noise; motions that tip."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.world.dynamic_balance import _derivative
from nao_kin.world.momenta import momenta, momentum_jacobians
from nao_kin.world.rocking import Edges, rocking

STEP = 0.01
TIMES = STEP * np.arange(200)


def swaying(nao: nk.NaoModel, times: np.ndarray, speed: float = 1.0, size: float = 1.0) -> np.ndarray:
    s = speed * times
    pitch, roll = -0.1 * size * np.sin(5.0 * s), 0.05 * size * np.sin(3.0 * s)
    return nao.posture(
        "Stand", LAnklePitch=pitch, RAnklePitch=pitch, LHipRoll=roll, RHipRoll=roll, LAnkleRoll=-roll, RAnkleRoll=-roll,
        LShoulderPitch=1.0 + 0.8 * np.sin(6.0 * s), RShoulderRoll=-0.5 + 0.3 * np.cos(4.0 * s), limits="clamp",
    )  # fmt: skip


def centroidal(nao: nk.NaoModel, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return centre of mass, acceleration and rate of the angular momentum by Pinocchio, a hundred steps finer."""
    floating = nk.load_nao(base="floating")
    data, h = floating.model.createData(), 1e-4
    com, rates, acceleration = [], [], []
    for time in times:
        fine = time + h * np.arange(-2, 3)
        q = swaying(nao, np.concatenate([[0.0], fine]))
        T = nk.world.odometry(nao, q, np.concatenate([[-1.0], fine]), longest_gap=10.0).T_world_base[1:]
        q, momenta, centres = q[1:], [], []
        for k in (1, 2, 3):
            R = T[k, :3, :3]
            turn = Rotation.from_matrix(T[k - 1, :3, :3].T @ T[k + 1, :3, :3]).as_rotvec()
            move = R.T @ (T[k + 1, :3, 3] - T[k - 1, :3, 3])
            rate = np.concatenate([move, turn, q[k + 1] - q[k - 1]]) / (2.0 * h)
            row = np.concatenate([T[k, :3, 3], Rotation.from_matrix(R).as_quat(), q[k]])
            momenta.append(np.array(pin.computeCentroidalMomentum(floating.model, data, row, rate).angular))
            centres.append(np.array(data.com[0]))
        com.append(centres[1])
        rates.append((momenta[2] - momenta[0]) / (2.0 * h))
        acceleration.append((centres[2] - 2.0 * centres[1] + centres[0]) / h**2)
    return np.array(com), np.array(acceleration), np.array(rates)


def test_the_zero_moment_point_is_that_of_pinocchios_momentum(nao: nk.NaoModel) -> None:
    found = nk.world.dynamic_balance(nao, swaying(nao, TIMES), TIMES)
    rows = np.array([77, 163])
    com, acceleration, rate = centroidal(nao, TIMES[rows])
    weight = nao.mass * (9.80665 + acceleration[:, 2])
    lever = nao.mass * acceleration[:, :2] * com[:, 2:] + np.stack([rate[:, 1], -rate[:, 0]], axis=1)
    # Both worlds have the x axis of the feet.
    np.testing.assert_allclose(found.zmp[rows] - found.com[rows, :2], -lever / weight[:, None], rtol=0.03, atol=5e-4)
    assert np.abs(lever / weight[:, None]).max() > 0.025


def test_a_robot_that_stands_still_has_its_zero_moment_point_below_its_centre_of_mass(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("StandInit"), (20, 1))
    found = nk.world.dynamic_balance(nao, q, TIMES[:20])
    np.testing.assert_allclose(found.zmp, found.com[:, :2], atol=1e-12)
    np.testing.assert_allclose(found.margin, nk.world.balance(nao, q[0]).margin, atol=1e-12)
    assert np.all(found.rocking == 0.0)
    assert np.all(found.deviation == 0.0)


def pendulum(moment: float, seconds: float, arm: float, height: float) -> float:
    """Return the largest tilt of a rigid pendulum that is tipped over an edge for some time, by SciPy."""
    inertia = height**2 + arm**2

    def rates(t: float, state: np.ndarray) -> list[float]:
        return [state[1], (9.80665 * height * state[0] - (moment if t < seconds else 9.80665 * arm)) / inertia]

    back = lambda _, state: state[1] + 1e-9  # noqa: E731
    back.terminal, back.direction = True, -1.0  # type: ignore[attr-defined]
    return float(solve_ivp(rates, (0.0, 3.0), [0.0, 0.0], events=back, max_step=1e-3).y[0].max())


@pytest.mark.parametrize("seconds", [0.05, 0.1])
def test_a_robot_rocks_as_a_pendulum_and_comes_back(seconds: float) -> None:
    times, mass, height = 0.005 * np.arange(400), 5.0, 0.26
    weight = np.full(400, mass * 9.80665)
    arm, moment = np.full((400, 8), 0.05), np.full((400, 8), 0.05 * weight[0])
    begins = (times > 0.0) & (times <= seconds + 1e-9)
    moment[begins, 2] = -0.03 * weight[0]
    never = np.full((400, 8), np.inf)
    found = rocking(times, Edges(moment, arm, np.zeros((400, 8)), never), weight, np.full(400, height), mass)
    assert found.max() == pytest.approx(pendulum(-0.03 * 9.80665, seconds, 0.05, height), rel=0.1)
    assert found[-1] == 0.0
    assert 0.005 < found.max() < 0.1
    # Longer, it falls; and a foot that hovers beyond the edge catches it.
    moment[times <= 0.6, 2] = -0.03 * weight[0]
    falls = rocking(times, Edges(moment, arm, np.zeros((400, 8)), never), weight, np.full(400, height), mass)
    assert falls[-1] == pytest.approx(0.5)
    landing = np.where(np.arange(8) == 2, 0.03, never)
    caught = rocking(times, Edges(moment, arm, np.full((400, 8), 0.1), landing), weight, np.full(400, height), mass)
    assert 0.03 <= caught.max() < 0.06
    # Rows in which nothing is known begin anew.
    weight[60] = np.nan
    gap = rocking(times, Edges(moment, arm, np.zeros((400, 8)), never), weight, np.full(400, height), mass)
    assert np.isnan(gap[60])
    assert gap[61] < 0.01 * gap[59]


def test_a_brief_push_rocks_and_a_long_one_falls(nao: nk.NaoModel) -> None:
    rocks, falls = (nk.world.dynamic_balance(nao, swaying(nao, TIMES, speed=s), TIMES) for s in (1.3, 2.5))
    assert rocks.margin.min() < 0.0 < rocks.rocking.max() < rocks.FALLS
    assert not rocks.falls.any()
    assert falls.falls.any()
    first = int((rocks.rocking > 0.0).argmax())
    assert (rocks.margin[first - 2 : first + 1] < 0.0).any()


def test_what_happens_after_the_motion_is_that_of_the_last_row(nao: nk.NaoModel) -> None:
    # It stops with its centre of mass outside of the toes.
    lean = -0.35 * np.minimum(TIMES[:60] / 0.5, 1.0)
    found = nk.world.dynamic_balance(nao, nao.posture("Stand", LAnklePitch=lean, RAnklePitch=lean), TIMES[:60])
    assert found.com_margin[-1] < 0.0
    assert found.rocking[-2] < found.rocking[-1] == pytest.approx(0.5)


def test_noise_of_the_joints_moves_the_zero_moment_point_as_told(nao: nk.NaoModel) -> None:
    noise, rng = np.radians(0.1), np.random.default_rng(0)
    times, q = 0.012 * np.arange(300), np.tile(nao.posture("Crouch"), (300, 1))
    options = {"contacts": np.ones((300, 2)), "joint_noise": noise}
    exact = nk.world.dynamic_balance(nao, q, times, **options)
    found = nk.world.dynamic_balance(nao, q + rng.normal(0.0, noise, q.shape), times, **options)
    z = (found.margin - exact.margin)[20:-20] / found.deviation[20:-20]
    assert 0.7 < np.sqrt(np.mean(z**2)) < 1.3
    assert 0.002 < found.deviation[150] <= 0.0055
    # It is the sum of what each joint does alone in the middle row, by differences.
    short, change, still = times[:61], 1e-4, q[:61]
    options["contacts"] = np.ones((61, 2))
    moved = [still + change * (np.arange(61) == 30)[:, None] * np.eye(nao.nq)[joint] for joint in range(nao.nq)]
    margins = [nk.world.dynamic_balance(nao, rows, short, **options).margin - exact.margin[:61] for rows in moved]
    alone = noise * np.linalg.norm(margins) / change
    assert exact.deviation[30] == pytest.approx(alone, rel=0.05)
    options["contacts"] = np.ones((300, 2))
    without = nk.world.dynamic_balance(nao, q + rng.normal(0.0, noise, q.shape), times, contacts=options["contacts"])
    assert np.std(without.margin[20:-20]) > 1.5 * found.deviation[150]
    with pytest.raises(BadArgument, match="joint_noise"):
        nk.world.dynamic_balance(nao, q, times, joint_noise=-1.0)


@pytest.mark.parametrize("sole", ["LLeg", "RLeg", "Torso"])
def test_jacobians_of_the_momenta_are_those_of_differences(nao: nk.NaoModel, sole: str) -> None:
    q, h = nao.random(rng=1, n=1), 1e-6
    of_centre, of_momentum = momentum_jacobians(nao, q, placed(nao, q, sole), sole)
    np.testing.assert_allclose(of_centre[0], nao.com_jacobian(q[0], reference=sole), atol=1e-12)
    for joint in range(nao.nv):
        rows = q + h * np.array([-1.0, 0.0, 1.0])[:, None] * np.eye(nao.nq)[joint]
        com, about_origin = momenta(nao, rows, placed(nao, rows, sole), h)
        rate = (com[2] - com[0]) / (2.0 * h)
        expected = about_origin[1] - nao.mass * np.cross(com[1], rate)
        np.testing.assert_allclose(of_momentum[0, :, joint], expected, atol=1e-8)


def placed(nao: nk.NaoModel, q: np.ndarray, sole: str) -> np.ndarray:
    return np.linalg.inv(nao.fk(q, sole, reference=nao.tree.root))


@pytest.mark.parametrize(("edge", "joint", "sign"), [("front", "Pitch", 1.0), ("back", "Pitch", -1.0)])
def test_a_robot_tips_over_the_edge_from_which_it_is_pushed(
    nao: nk.NaoModel, edge: str, joint: str, sign: float
) -> None:
    # It leans away from the edge, faster and faster: the ground pushes at the edge.
    lean = sign * 0.6 * TIMES[:40] ** 2
    q = nao.posture("Stand", LAnklePitch=lean, RAnklePitch=lean, limits="clamp")
    found = nk.world.dynamic_balance(nao, q, TIMES[:40])
    assert nk.world.EDGES[found.edge[15]] == edge
    assert found.margin[15] < found.com_margin[15]


def test_to_the_sides_the_edges_are_left_and_right(nao: nk.NaoModel) -> None:
    for side, sign in (("left", 1.0), ("right", -1.0)):
        lean = -sign * 0.25 * np.sin(0.5 * np.pi * TIMES)
        q = nao.posture("StandInit", LHipRoll=lean, RHipRoll=lean, LAnkleRoll=-lean, RAnkleRoll=-lean, limits="clamp")
        found = nk.world.dynamic_balance(nao, q, TIMES)
        assert nk.world.EDGES[found.edge[100]] == side


def test_a_foot_that_is_lifted_moves_the_robot_by_no_more_than_its_mass(nao: nk.NaoModel) -> None:
    # The foot is tilted while it is lifted and put back: it was in place once, and is not from then on.
    lift, lean = np.sin(0.5 * np.pi * TIMES) ** 4, 0.21
    rolls = {"LHipRoll": lean, "RHipRoll": lean, "LAnkleRoll": -lean, "RAnkleRoll": -lean}
    q = nao.posture("StandInit", rolls, limits="clamp")
    lifted = nao.posture("StandInit", rolls, LHipPitch=-0.9, LKneePitch=1.4, LAnklePitch=-0.2, limits="clamp")
    q = q + lift[:, None] * (lifted - q)
    mirrored = nk.motion.mirror(nao, nk.Motion(TIMES, nao.joint_names, q)).configurations(nao, times=TIMES).q
    left, right = (nk.world.dynamic_balance(nao, rows, TIMES) for rows in (q, mirrored))
    assert not left.down.touching[:, 0].all()
    assert not right.down.touching[:, 1].all()
    away = [np.linalg.norm(found.zmp - found.com[:, :2], axis=1) for found in (left, right)]
    np.testing.assert_allclose(*away, atol=2e-3)
    assert away[0].max() < 0.05


def test_of_a_robot_that_lies_or_sits_nothing_is_known(nao: nk.NaoModel) -> None:
    q = np.repeat(nao.posture("LyingBack")[None], 20, axis=0)
    found = nk.world.dynamic_balance(nao, q, TIMES[:20])
    assert not found.stands.any()
    assert np.isnan(found.margin).all()
    assert (found.edge == -1).all()


@pytest.mark.parametrize("window", [5, 11])
def test_derivatives_are_those_of_scipys_filter(window: int) -> None:
    from scipy.signal import savgol_filter  # takes a second

    values = np.random.default_rng(1).normal(size=(40, 3))
    for order in (1, 2):
        expected = savgol_filter(values, window, 3, deriv=order, delta=0.02, axis=0)
        np.testing.assert_allclose(
            _derivative(values, order, window, 0.02, np.arange(40.0)), expected, rtol=1e-9, atol=1e-8
        )


def test_bad_times_are_refused_in_one_line(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("Stand"), (6, 1))
    with pytest.raises(BadArgument, match="row 2 is at 0.01 s, row 1 at 0.02 s"):
        nk.world.dynamic_balance(nao, q, [0.0, 0.02, 0.01, 0.03, 0.04, 0.05])
    for times in (TIMES[:3], [0.0, 0.01, 0.02, 0.5, 0.51, 0.52]):
        with pytest.raises(BadArgument, match="at least five"):
            nk.world.dynamic_balance(nao, q[: len(times)], times)
    with pytest.raises(WrongShape, match="times"):
        nk.world.dynamic_balance(nao, q, TIMES[:5])


def test_samples_of_a_motion_have_a_balance_although_the_last_step_is_shorter(nao: nk.NaoModel) -> None:
    keys = 0.1 * np.arange(18)
    motion = nk.Motion([*keys, 1.795], nao.joint_names, swaying(nao, np.array([*keys, 1.795])), "smooth")
    samples = motion.configurations(nao, rate=100.0)
    assert np.diff(samples.times)[-1] < 0.006
    found = nk.world.dynamic_balance(nao, samples.q, samples.times)
    even = nk.world.dynamic_balance(nao, samples.q[:-1], samples.times[:-1])
    assert found.notes == ()
    np.testing.assert_allclose(found.zmp[:160], even.zmp[:160], atol=1e-9)
    assert found.stands.all()


def test_rows_with_jitter_have_the_balance_of_even_ones(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    times = np.cumsum(np.clip(rng.normal(0.012, 0.003, 150), 0.002, None))
    found = nk.world.dynamic_balance(nao, swaying(nao, times), times)
    even = 0.004 * np.arange(round(times[-1] / 0.004) + 2)
    exact = nk.world.dynamic_balance(nao, swaying(nao, even), even)
    shift, expected = found.zmp - found.com[:, :2], exact.zmp - exact.com[:, :2]
    wanted = np.column_stack([np.interp(times, even, column) for column in expected.T])
    assert np.abs(shift - wanted)[15:-15].max() < 1.5e-3  # filters over 9 and 25 samples
    assert np.abs(wanted).max() > 0.025
    assert "uneven" in found.notes[0]


def test_a_gap_is_bridged_by_nothing(nao: nk.NaoModel) -> None:
    cut = np.flatnonzero((TIMES < 0.8) | (TIMES > 1.2))
    cut = np.insert(cut, np.searchsorted(TIMES[cut], 1.0), 100)  # a single sample in the gap
    found = nk.world.dynamic_balance(nao, swaying(nao, TIMES)[cut], TIMES[cut])
    assert np.flatnonzero(~found.stands).tolist() == [80]
    assert np.isnan(found.margin[80])
    alone = nk.world.dynamic_balance(nao, swaying(nao, TIMES)[:80], TIMES[:80])
    np.testing.assert_allclose(found.zmp[:80], alone.zmp, atol=1e-9)
    assert "2 gaps" in found.notes[0]


def test_a_row_that_repeats_a_time_has_the_balance_of_its_twin(nao: nk.NaoModel) -> None:
    times, q = np.insert(TIMES, 50, TIMES[50]), np.insert(swaying(nao, TIMES), 51, nao.posture("Crouch"), axis=0)
    found, wanted = nk.world.dynamic_balance(nao, q, times), nk.world.dynamic_balance(nao, swaying(nao, TIMES), TIMES)
    own = np.insert(np.arange(200), 50, 50)
    np.testing.assert_allclose(found.margin, wanted.margin[own], atol=1e-9)
    np.testing.assert_allclose(found.down.corners, wanted.down.corners[own], atol=1e-12)
    assert "repeat" in found.notes[0]


def test_where_the_floor_would_have_to_pull_the_margin_is_least(nao: nk.NaoModel) -> None:
    stand, crouch = nao.posture("Stand"), nao.posture("Crouch")
    q = stand + (0.5 + 0.5 * np.sin(16.0 * TIMES))[:, None] * (crouch - stand)
    found = nk.world.dynamic_balance(nao, q, TIMES)
    flies = np.isneginf(found.margin)
    # The centre of mass, seen from the soles, is pulled down faster than it falls.
    height = found.com[:, 2]
    acceleration = np.gradient(np.gradient(height, STEP), STEP)
    inner = np.abs(TIMES - TIMES.mean()) < 0.9  # the filter has one side only at the ends
    assert flies[inner & (acceleration < -12.0)].all()
    assert not flies[inner & (acceleration > -8.0)].any()
    assert 10 < flies.sum() < 100
    assert found.margin.min() == -np.inf
    assert found.stands.all()
    assert np.isnan(found.zmp[flies]).all()
    assert (found.edge >= 0).all()


def test_forces_that_cannot_be_used_are_not(nao: nk.NaoModel) -> None:
    forces = np.tile([2.7, np.nan], (200, 1))
    found = nk.world.dynamic_balance(nao, swaying(nao, TIMES), TIMES, forces=forces)
    np.testing.assert_array_equal(found.margin, nk.world.dynamic_balance(nao, swaying(nao, TIMES), TIMES).margin)
    assert "never known" in found.notes[0]
    forces = np.full((200, 2), 2.7)
    forces[50:100] = 0.0
    lifted = nk.world.dynamic_balance(nao, swaying(nao, TIMES), TIMES, forces=forces)
    assert np.flatnonzero(~lifted.stands).tolist() == list(range(50, 100))


def test_the_zero_moment_point_is_where_the_sensors_feel_it(nao: nk.NaoModel) -> None:
    rng, q = np.random.default_rng(0), np.tile(nao.posture("StandInit"), (200, 1))
    noisy = q + rng.normal(0.0, np.radians(0.1), q.shape)
    shares = np.tile([2.0, 1.0, 0.5, 0.5, 0.3, 0.3, 0.3, 0.3], (200, 1))  # more on the left, and on its toes
    found = nk.world.dynamic_balance(nao, noisy, TIMES, forces=shares, joint_noise=0.0017)
    T = nao.set_down(q[0]).T_world_base
    places = nao.fk(q[0], nao.semantics.force_sensors)[:, :3, 3] @ T[:2, :3].T + T[:2, 3]
    np.testing.assert_allclose(found.zmp, np.tile(shares[0] @ places / shares[0].sum(), (200, 1)), atol=1.5e-3)
    assert np.ptp(found.margin) < 2e-3
    assert np.all(found.deviation == 0.0)
    assert "centre of pressure" in found.notes[-1]


def test_contacts_and_soles_say_on_what_the_robot_stands(nao: nk.NaoModel) -> None:
    q, left = np.tile(nao.posture("StandInit"), (50, 1)), np.tile([True, False], (50, 1))
    expected = nk.world.balance(nao, q[0], soles="LLeg").margin
    found = nk.world.dynamic_balance(nao, q, TIMES[:50], contacts=left)
    assert expected < 0.0 < nk.world.dynamic_balance(nao, q, TIMES[:50]).com_margin.min()
    np.testing.assert_allclose(found.com_margin, expected, atol=1e-9)
    # The other foot touches the floor, and is no sole any more; on one foot it does not matter.
    assert not nk.world.dynamic_balance(nao, q, TIMES[:50], soles="LLeg").stands.any()
    one = np.tile(nao.posture("StandInit", RHipPitch=-0.9, RKneePitch=1.4, RAnklePitch=-0.5), (50, 1))
    by_sole, by_joints = (nk.world.dynamic_balance(nao, one, TIMES[:50], soles=soles) for soles in ("LLeg", None))
    assert by_sole.down.soles == ("LLeg",)
    np.testing.assert_allclose(by_sole.margin, by_joints.margin, atol=1e-9)
    assert by_sole.stands.all()
