"""Sensors that lie, in logs whose truth is known; honest logs, about which nothing is odd; rows that repeat a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument

pytest.importorskip("mujoco")
import simulated_robot as simulated
from simulated_robot import Recording, Truth

LEFT = slice(0, 4)
# What honest logs are told as well.
USUAL = ("mean at rest", "bias is not known", "no row counts as standing", "never stands upright")


@pytest.fixture(scope="module")
def walk(nao: nk.NaoModel) -> Truth:
    scene = simulated.Scene(nao).hold(1.0).walk(simulated.walk(nao, 8, 0.04, 0.005, 0.05))
    return scene.truth()


def measured(nao: nk.NaoModel, truth: Truth, seed: int = 0, **errors: float) -> tuple[Recording, np.ndarray]:
    """Rows of 12 ± 3 ms with noise, backlash and biases; and the share of the weight on each foot."""
    log = simulated.recorded(nao, truth, np.random.default_rng(seed), jitter=0.003, **({"delay": 0.01} | errors))
    return log, log.truth.share


def found_in(nao: nk.NaoModel, log: Recording, **sensors: np.ndarray) -> nk.world.State:
    if not {"angles", "accelerometer", "gyro"} & set(sensors):
        sensors["angles"] = log.angles
    return nk.world.state(nao, log.q, times=log.times, **sensors)


def wrong_support(found: nk.world.State, share: np.ndarray) -> float:
    single = found.valid & (share.max(axis=1) > 0.6)
    assert single.any()
    return float(np.mean(found.odometry.support[single] != share.argmax(axis=1)[single]))


def changed(forces: np.ndarray, columns: slice | int, value: object) -> np.ndarray:
    found = forces.copy()
    found[:, columns] = value
    return found


# --- Forces and contacts.

# What is done to the forces, how the note on it begins, a word of it, and whether the legs replace the forces.
LIES: dict[str, tuple[Callable[[np.ndarray], np.ndarray], str, str, bool]] = {
    "a cell is never known": (lambda F: changed(F, 5, np.nan), "forces of RFoot/FSR/FrontRight:", "never known", False),
    "a cell is stuck": (lambda F: changed(F, 5, 2.65), "forces of RFoot/FSR/FrontRight:", "always 2.65", False),
    "a cell is negative": (lambda F: changed(F, 5, -F[:, 5]), "forces of RFoot/FSR/FrontRight:", "negative", False),
    "all are negative": (lambda F: -F, "forces:", "sign is changed", False),
    "an offset": (lambda F: F + 0.4, "forces:", "subtracted", False),
    "a negative offset": (lambda F: F - 0.4, "forces:", "0 there", False),
    "a foot is never known": (
        lambda F: changed(F, LEFT, np.nan),
        "forces of LFoot/FSR/FrontLeft, LFoot",
        "never",
        True,
    ),
    "a foot is stuck": (lambda F: changed(F, LEFT, 0.66), "forces of LFoot/FSR/FrontLeft, LFoot", "always", True),
    "a foot is dead": (lambda F: changed(F, LEFT, F[:, LEFT] % 0.02), "forces of LLeg:", "contradiction", True),
    "a foot is negative": (lambda F: changed(F, LEFT, -F[:, LEFT]), "forces of LFoot/FSR", "negative", True),
    "the feet are exchanged": (lambda F: F[:, [4, 5, 6, 7, 0, 1, 2, 3]], "forces:", "exchanged", True),
    "nothing is known": (lambda F: np.full_like(F, np.nan), "forces:", "never known", True),
}


@pytest.mark.parametrize("lie", list(LIES))
def test_a_force_that_lies_is_not_believed(nao: nk.NaoModel, walk: Truth, lie: str) -> None:
    log, share = measured(nao, walk)
    turn, names, word, by_legs = LIES[lie]
    found = found_in(nao, log, forces=turn(log.forces))
    honest = found_in(nao, log, forces=log.forces)
    assert honest.notes == ()
    assert found.notes[0].startswith(names)
    assert word in found.notes[0]
    assert ("the legs say which sole carries, and not the forces" in found.notes) == by_legs
    assert found.valid.all()
    assert found.seconds["lifted"] == 0.0
    ends, truth = (pose[-1, :2] - pose[0, :2] for pose in (found.odometry.pose, walk.T[:, :2, 3]))
    assert np.linalg.norm(ends - truth) < 0.02
    if not by_legs:
        assert max(wrong_support(found, share), wrong_support(honest, share)) < 0.07
        assert np.abs(found.forces - honest.forces).mean() < 0.3
    path = nk.world.odometry(nao, log.q, log.times, forces=turn(log.forces))
    assert path.notes == found.odometry.notes


def test_what_a_foot_carries_and_where_is_not_known_without_its_sensors(nao: nk.NaoModel, walk: Truth) -> None:
    log, _ = measured(nao, walk)
    honest = found_in(nao, log, forces=log.forces)
    cell = found_in(nao, log, forces=changed(log.forces, 5, np.nan))
    assert np.isnan(cell.sole_pressure[:, 1]).all()
    np.testing.assert_array_equal(cell.sole_pressure[:, 0], honest.sole_pressure[:, 0])
    np.testing.assert_allclose(cell.forces[:, 1], log.forces[:, [4, 6, 7]].mean(axis=1) * 4.0)  # the others count
    foot = found_in(nao, log, forces=changed(log.forces, LEFT, np.nan))
    assert np.isnan(foot.forces[:, 0]).all()
    np.testing.assert_allclose(foot.forces[:, 1], honest.forces[:, 1])
    assert np.isnan(foot.centre_of_pressure).all()


@pytest.mark.parametrize(
    ("lie", "word"),
    [
        (lambda C: C[:, ::-1], "contacts: in contradiction to the legs: exchanged?"),
        (lambda C: C * np.nan, "contacts: never known"),
        (lambda C: C * [0.0, 1.0], "contacts of LLeg: in contradiction"),
        (lambda C: np.maximum(C, [1.0, 0.0]), "contacts of LLeg: in contradiction"),
    ],
    ids=["exchanged", "never known", "never touches", "always touches"],
)
def test_a_contact_that_lies_is_not_believed(
    nao: nk.NaoModel, walk: Truth, lie: Callable[[np.ndarray], np.ndarray], word: str
) -> None:
    log, share = measured(nao, walk)
    contacts = (share > 0.3).astype(np.float64)
    assert nk.world.odometry(nao, log.q, log.times, contacts=contacts).notes == ()
    path = nk.world.odometry(nao, log.q, log.times, contacts=lie(contacts))
    assert path.notes[0].startswith(word)
    by_joints = nk.world.odometry(nao, log.q, log.times)
    np.testing.assert_array_equal(path.T_world_base, by_joints.T_world_base)


@pytest.mark.parametrize("forces", [np.r_[np.ones(5), np.nan, 1, 1] * 0.67, [2.7, np.nan], [-2.7, -2.7], [0.0, 2.7]])
def test_a_broken_sensor_does_not_lift_a_standing_robot(nao: nk.NaoModel, forces: list[float]) -> None:
    q, times = np.tile(nao.posture("StandInit"), (300, 1)), 0.01 * np.arange(300)
    found = nk.world.state(nao, q, times=times, forces=np.tile(forces, (300, 1)), angles=np.zeros((300, 2)))
    assert found.seconds["standing"] == pytest.approx(2.99)
    assert found.notes


def test_a_robot_whose_soles_never_carry_half_of_its_weight_does_not_stand(nao: nk.NaoModel) -> None:
    q, times, angles = np.tile(nao.posture("Sit"), (400, 1)), 0.01 * np.arange(400), np.tile([0.0, -0.3], (400, 1))
    forces = np.random.default_rng(0).normal(0.07, 0.002, (400, 8))
    found = nk.world.state(nao, q, times=times, forces=forces, angles=angles)
    assert not found.valid.any()
    assert found.seconds["standing"] == 0.0
    assert "5.36 kg" in found.notes[0]
    # With 1 s of standing at the beginning the weight is known, although more than 95 % of the log is sitting.
    q, times = np.tile(q, (6, 1)), 0.01 * np.arange(2400)
    q[:100], forces = nao.posture("StandInit"), np.tile(forces, (6, 1))
    forces[:100] *= 0.67 / 0.07
    found = nk.world.state(nao, q, times=times, forces=forces, angles=np.zeros((2400, 2)))
    assert found.notes == ()
    assert found.seconds["standing"] == pytest.approx(1.0, abs=0.02)


def test_other_units_are_used_and_noted(nao: nk.NaoModel) -> None:
    q, times = np.tile(nao.posture("Stand"), (100, 1)), 0.01 * np.arange(100)
    notes = {}
    for total in (5.36, 52.6, 1.0, 3.9, 7.0, 8.6, 900.0):
        found = nk.world.state(nao, q, times=times, forces=np.full((100, 2), total / 2.0))
        assert found.valid.all()
        notes[total] = " ".join(found.notes)
    assert {total for total, note in notes.items() if note} == {1.0, 8.6, 900.0}
    assert "shares" in notes[1.0]
    assert "52.6 N" in notes[8.6]


# --- The inertial unit.

INERTIAL: dict[str, tuple[str, Callable[[Recording], np.ndarray], str]] = {
    "gyro of zeros": ("gyro", lambda log: 0.0 * log.gyro, "gyro: always 0, 0, 0"),
    "gyro unknown": ("gyro", lambda log: np.nan * log.gyro, "gyro: never known"),
    "gyro without z": ("gyro", lambda log: log.gyro * [1.0, 1.0, np.nan], "gyro: never known"),
    "gyro in degrees": ("gyro", lambda log: np.degrees(log.gyro), "deg/s"),
    "angles stuck": ("angles", lambda log: 0.0 * log.angles + 0.01, "angles: always 0.01, 0.01"),
    "angles in degrees": ("angles", lambda log: np.degrees(log.angles), "degrees"),
    "angles unknown": ("angles", lambda log: np.nan * log.angles, "angles: never known"),
    "angles of other axes": (
        "angles",
        lambda log: log.angles + np.array([1.5, 0.0]),
        "angles: in contradiction to the legs",
    ),
    "axes exchanged": ("accelerometer", lambda log: log.accelerometer[:, [2, 0, 1]], "contradiction to the legs"),
    "accelerometer of zeros": ("accelerometer", lambda log: 0.0 * log.accelerometer, "accelerometer: never known"),
}


@pytest.mark.parametrize("lie", list(INERTIAL))
def test_an_inertial_sensor_that_lies_is_not_used(nao: nk.NaoModel, walk: Truth, lie: str) -> None:
    log, _ = measured(nao, walk)
    name, turn, word = INERTIAL[lie]
    found = found_in(nao, log, forces=log.forces, **{name: turn(log)})
    assert any(word in note and note.endswith("not used") for note in found.notes)
    without = nk.world.state(nao, log.q, times=log.times, forces=log.forces)
    for attribute in ("T_world_base", "doing", "covariance"):
        np.testing.assert_array_equal(getattr(found, attribute), getattr(without, attribute))


def test_a_spike_is_left_out_and_the_gyrometer_used(nao: nk.NaoModel, walk: Truth) -> None:
    log, _ = measured(nao, walk)
    gyro = log.gyro.copy()
    gyro[100, 2] = 300.0
    heading, smooth = (
        nk.world.odometry(nao, log.q, log.times, forces=log.forces, gyro=g).pose[-1, 2] for g in (gyro, log.gyro)
    )
    assert abs(heading - smooth) < np.radians(0.5)  # as it is, 100 rows later it would be 200° off


# --- Honest logs.


def honest(nao: nk.NaoModel, walk: Truth) -> dict[str, Truth]:
    lifted = simulated.Scene(nao).hold(1.5).carry(1.5).truth()
    air = lifted.at(lifted.doing == "carried")
    way = simulated.kick(nao)[: round(2.1 / simulated.STEP)]  # the right foot is 30 mm above the floor
    return {
        "walking": walk,
        "standing": simulated.Scene(nao).hold(3.0).truth(),
        "lifted": lifted,
        "always lifted": replace(air, times=air.times - air.times[0]),
        "walking in the air": replace(walk, loads=0.0 * walk.loads),
        "one foot lifted": simulated.Scene(nao).go(way[0], 0.5).play(way).hold(5.0).truth(),
        "sitting": simulated.Scene(nao, "Sit").hold(3.0).truth(),
    }


def test_nothing_is_odd_about_honest_logs(nao: nk.NaoModel, walk: Truth) -> None:
    said, count = [], 0
    for name, truth in honest(nao, walk).items():
        for seed, delay, zeros in ((0, 0.0, 0.0), (1, 0.03, 0.0), (2, 0.01, 0.5)):
            log, _ = measured(nao, truth, seed, delay=delay, zeros=zeros)
            feet = log.forces.reshape(-1, 2, 4).sum(axis=2)
            for sensors in (
                {"forces": log.forces, "accelerometer": log.accelerometer, "gyro": log.gyro},
                {"forces": 9.81 * feet, "angles": log.angles},
                {"forces": feet * [0.75, 1.25], "angles": log.angles},
                {"contacts": feet > 0.5, "angles": log.angles},
            ):
                found = nk.world.state(nao, log.q, times=log.times, **sensors)
                said += [(name, note) for note in found.notes if not any(usual in note for usual in USUAL)]
                count += 1
    assert count == 84
    assert said == []


# --- Rows that repeat a time.


def test_a_row_that_repeats_a_time_gets_the_result_of_its_twin(nao: nk.NaoModel, walk: Truth) -> None:
    log, _ = measured(nao, walk)
    again = np.sort(np.append(np.arange(len(log.times)), [50, 120, 120, 200]))
    twice = {name: getattr(log, name)[again] for name in ("times", "q", "forces", "accelerometer", "gyro")}
    twin = np.append(False, np.diff(again) == 0)
    twice["q"][twin] += 0.3  # only the first of them counts,
    twice["forces"][np.flatnonzero(twin)[0] - 1] = np.nan  # or the first one that is known
    once = nk.world.state(
        nao, log.q, times=log.times, forces=log.forces, accelerometer=log.accelerometer, gyro=log.gyro
    )
    found = nk.world.state(nao, twice.pop("q"), **twice)
    for name in ("times", "doing", "support", "T_world_base", "covariance", "centre_of_pressure", "up"):
        np.testing.assert_array_equal(getattr(found, name), getattr(once, name)[again])
    for name in ("T_world_support", "velocity", "covariance", "segment"):
        np.testing.assert_array_equal(getattr(found.odometry, name), getattr(once.odometry, name)[again])
    assert found.seconds == pytest.approx(once.seconds)
    assert found.odometry.distance == pytest.approx(once.odometry.distance)
    assert "4 rows repeat a time" in found.notes[0]


def test_rounded_times_are_refused_and_those_that_go_back_shown_in_full(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("Stand"), (300, 1))
    for call in (
        lambda times: nk.world.odometry(nao, q, times),
        lambda times: nk.world.state(nao, q, times=times),
        lambda times: nk.world.dynamic_balance(nao, q, times),
        lambda times: nk.world.configurations_at(nao, q, times, 0.0),
    ):
        with pytest.raises(BadArgument, match="297 of 300 rows repeat a time"):
            call(np.floor(0.01 * np.arange(300)) + 1.6e9)
        times = 1.6e9 + 0.01 * np.arange(300)
        times[51] -= 0.015
        with pytest.raises(BadArgument) as error:
            call(times)
        assert f"{times[51].item()!r} s, row 50 at {times[50].item()!r} s" in str(error.value)
        assert str(times[51].item()) != str(times[50].item())


def test_a_log_with_a_repeated_time_has_configurations_at_others(nao: nk.NaoModel) -> None:
    q = np.linspace(nao.posture("StandInit"), nao.posture("Crouch"), 4)
    found = nk.world.configurations_at(nao, q, [0.0, 0.02, 0.02, 0.04], [0.01, 0.02, 0.03])
    np.testing.assert_allclose(found, [(q[0] + q[1]) / 2.0, q[1], (q[1] + q[3]) / 2.0])
