"""Rest of a robot, and the bias of its gyrometer: known, drifting, and not known."""

from __future__ import annotations

import numpy as np
import pytest
import recorded_logs as logs

import nao_kin as nk
from nao_kin.world.rest import RestLog

BIAS = np.radians([1.0, -1.0, 1.0])


def looking_around(nao: nk.NaoModel, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and joints of a robot that stands and turns its head, as a player does at any time."""
    times = 0.02 * np.arange(round(seconds / 0.02))
    return times, nao.posture("StandInit", HeadYaw=np.sin(1.3 * times), HeadPitch=0.3 * np.sin(2.1 * times))


def test_a_robot_that_turns_its_head_shows_the_bias_of_its_gyrometer(nao: nk.NaoModel) -> None:
    times, q = looking_around(nao, 50.0)
    rng = np.random.default_rng(0)
    gyro = BIAS + rng.normal(0.0, 0.01, (len(times), 3))
    q = q + rng.normal(0.0, np.radians(0.1), q.shape)
    forces = np.full((len(times), 2), 2.7)
    by_odometry = nk.world.odometry(nao, q, times, forces=forces, gyro=gyro)
    by_state = nk.world.state(nao, q, times=times, forces=forces, angles=np.zeros((len(times), 2)), gyro=gyro).odometry
    for path in (by_odometry, by_state):
        assert path.pose[-1, 2] == pytest.approx(0.0, abs=np.radians(0.5))
        assert np.sqrt(path.covariance[-1, 2, 2]) < np.radians(1.0)
        assert "mean at rest, 0.017" in " ".join(path.notes)


def test_a_bias_that_is_not_known_is_in_the_covariance_of_the_heading(nao: nk.NaoModel) -> None:
    """It grows with the time, and with the lever: the derivative of the integrated path by the bias."""
    truth = logs.walk(nao, 0.4)
    rows = np.flatnonzero(truth.doing == "walking")
    times, q = truth.times[rows], truth.q[rows]
    contacts = truth.share[rows] > 0.5
    noise = np.random.default_rng(0).normal(0.0, 1e-4, (len(rows), 3))
    still = nk.world.odometry(nao, q, times, contacts=contacts, gyro=noise)
    path = nk.world.odometry(nao, q, times, contacts=contacts, gyro=noise + BIAS)
    turned = path.pose[-1] - still.pose[-1]
    deviations = np.sqrt(np.diag(path.covariance[-1]))
    seconds = times[-1] - times[0]
    assert turned[2] == pytest.approx(np.radians(seconds), rel=0.05)
    assert 1.0 < deviations[2] / np.radians(seconds) < 1.2
    assert 0.3 < abs(turned[1]) / deviations[1] < 1.0
    assert any("bias is not known, as the robot is never at rest on its soles" in note for note in path.notes)


def test_a_bias_that_drifts_is_followed_between_rests(nao: nk.NaoModel) -> None:
    """Walks of a minute between two seconds of rest: beside the rests the bias is interpolated, and less sure."""
    times = 0.02 * np.arange(6000)
    stands = (times % 40.0) < 3.0
    bias = np.radians(0.5) * times / times[-1]
    legs = np.where(stands, 0.0, np.sin(9.0 * times))[:, None]
    rates = bias[:, None] + np.where(stands, 0.0, np.sin(8.0 * times))[:, None] * np.ones(3)
    used = np.ones(len(times), dtype=bool)
    rest = RestLog.of(times, legs, used, used, rates, "gyro")
    assert not rest.rest[~stands].any()
    assert rest.rest[stands].mean() > 0.8
    between = (times > 1.0) & (times < 82.0)
    assert np.abs(rest.bias[between, 2] - bias[between]).max() < np.radians(0.06)
    far, near = rest.deviation[np.abs(times - 20.0) < 1.0].mean(), rest.deviation[np.abs(times - 41.5) < 1.0].mean()
    assert near < 0.7 * far < np.radians(0.1)


def test_the_bias_is_the_least_squares_estimate_of_a_random_walk() -> None:
    """Forwards and backwards: mean and variance of a Gaussian process, by one solution of all of its equations."""
    rng, count = np.random.default_rng(1), 12
    times = 0.05 * np.arange(10 * count)
    level = np.repeat(rng.normal(0.0, 0.01, count), 10)
    moving = np.repeat(np.arange(count) % 5 == 3, 10)
    rates = level[:, None] * [1.0, 2.0, -1.0] + np.where(moving, rng.normal(0.0, 0.5, len(times)), 0.0)[:, None]
    used = np.ones(len(times), dtype=bool)
    rest = RestLog.of(times, np.zeros((len(times), 1)), used, used, rates, "gyro")
    seen = [k for k in range(1, count) if not moving[10 * k] and not moving[10 * (k - 1)]]
    drift = np.radians(0.02) ** 2 * 0.5
    prior = np.radians(1.0) ** 2 + drift * (np.minimum.outer(np.arange(count), np.arange(count)) + 1.0)
    measured = prior[np.ix_(seen, seen)] + np.radians(0.1) ** 2 * np.eye(len(seen))
    gain = prior[:, seen] @ np.linalg.inv(measured)
    means = np.array([rates[10 * k : 10 * k + 10].mean(axis=0) for k in seen])
    np.testing.assert_allclose(rest.bias[::10], gain @ means, atol=1e-12)
    variance = np.diag(prior - gain @ prior[seen])
    np.testing.assert_allclose(rest.deviation[::10] ** 2, variance, rtol=1e-9)


def test_a_robot_on_a_turntable_is_not_at_rest(nao: nk.NaoModel) -> None:
    """Nor one whose legs move slowly, nor one that is held in the air."""
    times, q = looking_around(nao, 6.0)
    rates = np.random.default_rng(2).normal(0.0, 0.01, (len(times), 3))
    used, legs = np.ones(len(times), dtype=bool), q[:, :2] * 0.0
    assert RestLog.of(times, legs, used, used, rates, "gyro").rest.all()
    assert not RestLog.of(times, legs, used, used, rates + 0.2, "gyro").rest.any()
    assert not RestLog.of(times, legs + 0.02 * times[:, None], used, used, rates, "gyro").rest.any()
    assert not RestLog.of(times, legs, ~used, used, rates, "gyro").rest.any()
    assert RestLog.of(times, legs, ~used, used, rates, "gyro").quiet.all()
