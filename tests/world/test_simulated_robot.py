"""Simulated logs: their truth is that of a robot on a floor, and their sensors have the errors that are asked for."""

from __future__ import annotations

import numpy as np
import pytest

import nao_kin as nk

pytest.importorskip("mujoco")
import simulated_robot as simulated

# Recorded without any error.
EXACT = dict.fromkeys(
    ("encoder", "backlash", "forces", "acceleration", "acceleration_bias", "gyro", "gyro_bias", "angle"), 0.0
)


@pytest.fixture(scope="module")
def truth(nao: nk.NaoModel) -> simulated.Truth:
    """1 s of standing, carrying tilted by 60°, and standing."""
    return simulated.Scene(nao).hold(1.0).carry(0.5, np.radians(60.0)).hold(0.5).truth()


def test_a_robot_that_stands_carries_its_weight_and_one_that_is_carried_does_not(
    nao: nk.NaoModel, truth: simulated.Truth
) -> None:
    stands, carried = (truth.doing == name for name in ("standing", "carried"))
    rest = stands & (truth.times > 0.5) & (truth.times < 1.0)
    assert truth.loads[rest].sum(axis=1) == pytest.approx(nao.mass, rel=0.01)
    assert truth.loads[carried].sum(axis=1).max() < 0.05 * nao.mass
    # At rest the centre of pressure is below the centre of mass, and the accelerometer shows the vertical.
    com = np.einsum("nij,nj->ni", truth.T[rest, :3, :3], nao.com(truth.q[rest])) + truth.T[rest, :3, 3]
    assert np.abs(truth.centre_of_pressure[rest] - com[:, :2]).max() < 0.002
    assert np.abs(truth.specific[rest] - simulated.GRAVITY * truth.T[rest, 2, :3]).max() < 0.1
    assert np.degrees(np.arccos(truth.T[carried, 2, 2].min())) == pytest.approx(60.0, abs=10.0)


def test_sensors_without_errors_show_the_truth(nao: nk.NaoModel, truth: simulated.Truth) -> None:
    log = simulated.recorded(nao, truth, np.random.default_rng(0), every=0.01, **EXACT)
    seen = log.truth
    assert np.diff(log.times) == pytest.approx(0.01)
    assert np.abs(log.q - seen.q).max() <= np.pi / 4096.0 + 1e-12
    np.testing.assert_array_equal(log.gyro, seen.rates)
    np.testing.assert_array_equal(log.accelerometer, seen.specific)
    still = (log.times > 0.5) & (log.times < 1.0)
    assert np.abs(log.angles - seen.roll_pitch)[still].max() < np.radians(0.2)
    cells = log.forces.reshape(-1, 2, 4)
    assert np.abs(cells.sum(axis=2) - seen.loads).max() < 0.2  # 0.02 kg of noise at each of four cells
    found = nk.world.state(nao, log.q, times=log.times, forces=log.forces, angles=log.angles)
    away = found.centre_of_pressure - found.T_world_base[:, :2, 3] - seen.centre_of_pressure + seen.T[:, :2, 3]
    assert np.abs(away[still & found.valid]).max() < 0.005


def test_sensors_have_the_errors_that_are_asked_for(nao: nk.NaoModel, truth: simulated.Truth) -> None:
    def recorded(**errors: object) -> simulated.Recording:
        return simulated.recorded(nao, truth, np.random.default_rng(0), **(EXACT | errors))

    plain, tick = recorded(), 2.0 * np.pi / 4096.0
    bias = recorded(gyro_bias=1.0, acceleration_bias=0.2)
    assert np.abs(np.degrees(bias.gyro - plain.gyro)) == pytest.approx(1.0)
    assert np.abs(bias.accelerometer - plain.accelerometer) == pytest.approx(0.2)
    assert recorded(encoder=0.1).q.ravel() / tick == pytest.approx(np.round(recorded(encoder=0.1).q.ravel() / tick))
    assert np.degrees((recorded(encoder=0.3).q - plain.q).std()) == pytest.approx(0.3, rel=0.05)
    backlash = np.degrees(np.abs(recorded(backlash=0.5).q - plain.q))
    assert 0.2 < backlash.max() < 0.25 + np.degrees(tick)
    late = recorded(delay=0.024)
    np.testing.assert_array_equal(late.gyro[2:], plain.gyro[:-2])
    np.testing.assert_array_equal(late.q, plain.q)
    zeros = np.degrees(recorded(zeros=1.0).q - plain.q).std(axis=0)
    assert zeros.max() < np.degrees(tick)  # constant,
    shifted = np.abs(recorded(zeros=1.0).q - plain.q).max(axis=0) > 2.0 * tick
    assert {name[1:4] for name in np.array(nao.joint_names)[shifted]} <= {"Hip", "Kne", "Ank"}  # of the legs only
    assert shifted.sum() >= 8
    assert (recorded(dead=[5]).forces[:, 5] == 0.0).all()
    assert 0.1 < (recorded(offset=0.3).forces - plain.forces).max() <= 0.3
    steps = np.diff(recorded(jitter=0.003).times)
    assert steps.std() == pytest.approx(0.003, rel=0.2)


@pytest.mark.full
def test_each_kind_of_scene_shows_what_it_is_named_after(nao: nk.NaoModel) -> None:
    expected = {
        "standing": {"standing"},
        "standing for 50 s": {"standing"},
        "gesturing": {"standing"},
        "walking": {"standing", "walking"},
        "slipping": {"standing", "walking"},
        "kicking": {"standing"},
        "falling": {"standing", "falling", "lying"},
        "pushed": {"standing"},
        "falling as it walks": {"standing", "walking", "falling", "lying"},
        "carried": {"standing", "carried"},
        "sitting": {"sitting"},
        "put on a chair": {"standing", "carried", "sitting"},
    }
    for number in range(len(simulated.KINDS)):
        kind, found = simulated.scene(nao, number, 1)
        does = set(np.where(np.isin(found.doing, simulated.LYING), "lying", found.doing).tolist()) - {""}
        assert does == expected.get(kind, does), kind
        assert np.isfinite(found.q).all()
        assert "carried" in does or not kind.startswith("put")
