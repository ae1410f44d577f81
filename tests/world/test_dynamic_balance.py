"""The zero-moment point beside Pinocchio's centroidal momentum, a lever, edges and speeds; and motions that tip."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.world.dynamic_balance import _derivative

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
        T = nk.world.odometry(nao, np.concatenate([[-1.0], fine]), q, longest_gap=10.0).T_world_base[1:]
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
    found = nk.world.dynamic_balance(nao, TIMES, swaying(nao, TIMES))
    rows = np.array([77, 163])
    com, acceleration, rate = centroidal(nao, TIMES[rows])
    weight = nao.mass * (9.80665 + acceleration[:, 2])
    lever = nao.mass * acceleration[:, :2] * com[:, 2:] + np.stack([rate[:, 1], -rate[:, 0]], axis=1)
    # Both worlds have the x axis of the feet.
    np.testing.assert_allclose(found.zmp[rows] - found.com[rows, :2], -lever / weight[:, None], rtol=0.03, atol=5e-4)
    assert np.abs(lever / weight[:, None]).max() > 0.025


def test_a_robot_that_stands_still_has_its_zero_moment_point_below_its_centre_of_mass(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("StandInit"), (20, 1))
    found = nk.world.dynamic_balance(nao, TIMES[:20], q)
    np.testing.assert_allclose(found.zmp, found.com[:, :2], atol=1e-12)
    np.testing.assert_allclose(found.margin, nk.world.balance(nao, q[0]).margin, atol=1e-12)
    assert np.all(found.slower < 1e-6)


def test_at_the_given_speed_the_zero_moment_point_is_on_the_edge(nao: nk.NaoModel) -> None:
    found = nk.world.dynamic_balance(nao, TIMES, swaying(nao, TIMES, speed=1.3))
    inner = slice(20, -20)  # the filter has one side only at the ends
    row = 20 + int(found.slower[inner].argmax())
    factor = found.slower[row]
    longer = STEP * np.arange(math.ceil(200 * factor))
    again = nk.world.dynamic_balance(nao, longer, swaying(nao, longer, speed=1.3 / factor))
    near = round(row * factor)
    assert np.abs(again.margin[near - 3 : near + 4]).min() < 2e-3
    assert factor > 1.0
    assert found.margin[row] < 0.0


@pytest.mark.parametrize(("edge", "joint", "sign"), [("front", "Pitch", 1.0), ("back", "Pitch", -1.0)])
def test_a_robot_tips_over_the_edge_from_which_it_is_pushed(
    nao: nk.NaoModel, edge: str, joint: str, sign: float
) -> None:
    # It leans away from the edge, faster and faster: the ground pushes at the edge.
    lean = sign * 0.6 * TIMES[:40] ** 2
    q = nao.posture("Stand", LAnklePitch=lean, RAnklePitch=lean, limits="clamp")
    found = nk.world.dynamic_balance(nao, TIMES[:40], q)
    assert nk.world.EDGES[found.edge[15]] == edge
    assert found.margin[15] < found.com_margin[15]


def test_to_the_sides_the_edges_are_left_and_right(nao: nk.NaoModel) -> None:
    for side, sign in (("left", 1.0), ("right", -1.0)):
        lean = -sign * 0.25 * np.sin(0.5 * np.pi * TIMES)
        q = nao.posture("StandInit", LHipRoll=lean, RHipRoll=lean, LAnkleRoll=-lean, RAnkleRoll=-lean, limits="clamp")
        found = nk.world.dynamic_balance(nao, TIMES, q)
        assert nk.world.EDGES[found.edge[100]] == side


def test_a_foot_that_is_lifted_moves_the_robot_by_no_more_than_its_mass(nao: nk.NaoModel) -> None:
    # The foot is tilted while it is lifted and put back: it was in place once, and is not from then on.
    lift, lean = np.sin(0.5 * np.pi * TIMES) ** 4, 0.21
    rolls = {"LHipRoll": lean, "RHipRoll": lean, "LAnkleRoll": -lean, "RAnkleRoll": -lean}
    q = nao.posture("StandInit", rolls, limits="clamp")
    q = q + lift[:, None] * (nao.posture("StandInit", rolls, LKneePitch=1.4, LAnklePitch=-0.2, limits="clamp") - q)
    mirrored = nk.motion.mirror(nao, nk.Motion(TIMES, nao.joint_names, q)).configurations(nao, times=TIMES).q
    left, right = (nk.world.dynamic_balance(nao, TIMES, rows) for rows in (q, mirrored))
    assert not left.down.touching[:, 0].all()
    assert not right.down.touching[:, 1].all()
    away = [np.linalg.norm(found.zmp - found.com[:, :2], axis=1) for found in (left, right)]
    np.testing.assert_allclose(*away, atol=2e-3)
    assert away[0].max() < 0.05


def test_of_a_robot_that_lies_or_sits_nothing_is_known(nao: nk.NaoModel) -> None:
    q = np.repeat(nao.posture("LyingBack")[None], 20, axis=0)
    found = nk.world.dynamic_balance(nao, TIMES[:20], q)
    assert not found.stands.any()
    assert np.isnan(found.margin).all()
    assert (found.edge == -1).all()


@pytest.mark.parametrize("window", [5, 11])
def test_derivatives_are_those_of_scipys_filter(window: int) -> None:
    values = np.random.default_rng(1).normal(size=(40, 3))
    for order in (1, 2):
        expected = savgol_filter(values, window, 3, deriv=order, delta=0.02, axis=0)
        np.testing.assert_allclose(_derivative(values, order, window, 0.02), expected, rtol=1e-9, atol=1e-8)


def test_bad_times_are_refused_in_one_line(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("Stand"), (6, 1))
    for times in ([0.0, 0.01, 0.02, 0.03, 0.04, 0.2], [0.0, 0.01, 0.01, 0.03, 0.04, 0.05]):
        with pytest.raises(BadArgument, match="times must"):
            nk.world.dynamic_balance(nao, times, q)
    with pytest.raises(BadArgument, match="at least five"):
        nk.world.dynamic_balance(nao, TIMES[:3], q[:3])
    with pytest.raises(WrongShape, match="times"):
        nk.world.dynamic_balance(nao, TIMES[:5], q)
