"""The state of a robot, row after row: beside that of the whole log, and beside the truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import recorded_logs as logs
from recorded_logs import Recording, Truth

import nao_kin as nk
from nao_kin.errors import BadArgument, NaoKinError, WrongShape

LYING = ("front", "back", "left", "right")


@pytest.fixture(scope="module")
def life(nao: nk.NaoModel) -> Truth:
    return logs.life(nao)


@pytest.fixture(scope="module")
def log(nao: nk.NaoModel, life: Truth) -> Recording:
    return logs.recorded(nao, life, np.random.default_rng(0))


def followed(nao: nk.NaoModel, log: Recording, *names: str, **made: object) -> list[nk.world.State]:
    estimator = nk.world.StateEstimator(nao, **made)
    rows = zip(log.times, log.q, *(getattr(log, name) for name in names), strict=True)
    buffers, found = None, []
    for time, *values in rows:  # a robot's program may write each row into the same arrays
        buffers = [np.array(value) for value in values] if buffers is None else buffers
        for buffer, value in zip(buffers, values, strict=True):
            buffer[:] = value
        found.append(estimator.update(buffers[0], time, **dict(zip(names, buffers[1:], strict=True))))
    return found


def late(mask: np.ndarray, begins: np.ndarray, within: int) -> list[int]:
    """How many rows after each beginning a mask is true."""
    return [int(np.argmax(mask[k : k + within])) if mask[k : k + within].any() else within for k in begins]


@pytest.mark.parametrize("names", [("forces", "accelerometer", "gyro"), ("forces", "angles")])
def test_it_follows_a_life_with_small_delays(
    nao: nk.NaoModel, life: Truth, log: Recording, names: tuple[str, ...]
) -> None:
    batch = nk.world.state(nao, log.q, times=log.times, **{name: getattr(log, name) for name in names})
    rows = followed(nao, log, *names)
    doing, pose = (
        np.array([part(row) for row in rows]) for part in (lambda r: r.doing[0], lambda r: r.odometry.pose[0])
    )
    # Walking is known after the second step, and its end late; the rest of the rows is that of the whole log.
    ground = ["standing" if name == "walking" else name for name in doing]
    same = np.array(ground) == np.where(batch.doing == "walking", "standing", batch.doing)
    assert same.mean() > 0.95
    # Delays: a lying robot at once, contact 0.2 s, a fall before it ends.
    first = np.append(True, life.doing[1:] != life.doing[:-1])
    assert max(late(doing == "lying", np.flatnonzero(first & np.isin(life.doing, LYING)), 100)) <= 1
    assert max(late(doing == "lifted", np.flatnonzero(first & (life.doing == "lifted")), 100)) <= 11
    falls = np.flatnonzero(first & (life.doing == "falling") & (np.roll(life.doing, 1) == "standing"))
    assert max(late(doing == "falling", falls, 100)) <= 38  # of 40, in which it tilts by 15° in the first 16
    # The support changes with the first row whose forces say so.
    walking = life.doing == "walking"
    support = np.array([row.odometry.support[0] for row in rows])
    assert np.mean(support[walking] == batch.odometry.support[walking]) == 1.0
    # The path is that of the log, but for the bias of the first second.
    end = np.flatnonzero(walking)[-1]
    away = pose[end] - batch.odometry.pose[end]
    assert np.abs(away[:2]).max() < 0.01
    assert abs(away[2]) < np.radians(3.0)
    tilts = np.array([row.roll_pitch[0] for row in rows])
    assert np.sqrt(np.mean((tilts - log.angles)[life.doing == "standing"] ** 2)) < np.radians(1.0)


def test_with_contacts_alone_it_is_the_odometry_of_the_log(nao: nk.NaoModel, life: Truth) -> None:
    truth = logs.walk(nao, 0.3, 0.1, 0.5)
    contacts = truth.share >= 0.5
    batch = nk.world.odometry(nao, truth.q, truth.times, contacts=contacts, start=truth.T[0])
    estimator = nk.world.StateEstimator(nao, start=truth.T[0])
    for k, (time, q) in enumerate(zip(truth.times, truth.q, strict=True)):
        now = estimator.update(q, time, contacts=contacts[k]).odometry
        assert np.abs(now.T_world_base[0] - batch.T_world_base[k]).max() < 1e-9
        assert np.abs(now.T_world_support[0] - batch.T_world_support[k]).max() < 1e-9
        assert now.support[0] == batch.support[k]
    # Less at rest, for it knows of a rest after half a second only.
    P, whole = now.covariance[0], batch.covariance[-1]
    assert (np.diag(P) >= np.diag(whole) - 1e-12).all()
    assert np.sqrt(np.diag(P)) == pytest.approx(np.sqrt(np.diag(whole)), rel=0.3)


def test_the_covariance_does_not_grow_at_rest_but_as_soon_as_the_robot_moves(nao: nk.NaoModel) -> None:
    rng, estimator = np.random.default_rng(0), nk.world.StateEstimator(nao)
    bend, P = nao.posture("Crouch") - nao.posture("StandInit"), []
    for k in range(500):
        q = nao.posture("StandInit") + max(0.0, k / 100.0 - 4.2) * bend + rng.normal(0.0, np.radians(0.1), nao.nq)
        now = estimator.update(q, 0.01 * k, forces=[2.7, 2.7], gyro=rng.normal(0.02, 0.01, 3))
        P.append(np.trace(now.odometry.covariance[0]))
    assert P[90] > 1.5 * P[1]  # a rest is known after two intervals
    assert max(P[110:420]) < 1.05 * min(P[110:420])
    assert P[-1] > 1.4 * P[419]


# What is done to a sensor of a robot that walks, and a word of the note on it.
LIES: dict[str, tuple[str, Callable[[np.ndarray], np.ndarray], str]] = {
    "a dead foot": (
        "forces",
        lambda F: F * np.repeat([0.0, 1.0], 4),
        "always 0, 0, 0, 0 although the robot moves; not used",
    ),
    "exchanged feet": ("forces", lambda F: np.roll(F, 4, axis=1), "in contradiction to the legs: exchanged?; not used"),
    "an offset": ("forces", lambda F: F + 0.4, "in the air, as the legs say; subtracted"),
    "a stuck gyrometer": ("gyro", lambda G: 0.0 * G + 0.2, "although the robot moves; not used"),
    "degrees": ("gyro", np.degrees, "are these deg/s? A heading such as GyroX [deg/s] says so; not used"),
    "axes exchanged": ("accelerometer", lambda A: A[:, [2, 0, 1]], "contradiction to the legs and the forces; not"),
}


@pytest.mark.parametrize("lie", list(LIES))
def test_a_sensor_that_lies_is_found_while_the_robot_walks(
    nao: nk.NaoModel, life: Truth, log: Recording, lie: str
) -> None:
    rows = slice(int(np.argmax(life.doing == "falling")))
    what, turn, word = LIES[lie]
    part = Recording(*(getattr(log, name)[rows] for name in Recording.__dataclass_fields__))
    names = tuple(dict.fromkeys(("forces", "accelerometer", what)))
    found = followed(nao, replace(part, **{what: turn(getattr(part, what))}), *names)
    assert any(word in note for note in found[-1].notes)
    last = found[-1]
    assert last.valid[0]
    assert last.odometry.support[0] == followed(nao, part, *names)[-1].odometry.support[0]
    assert np.degrees(np.arccos(last.up[0, 2])) < 6.0
    if "offset" in lie:
        assert last.forces == pytest.approx(followed(nao, part, *names)[-1].forces, abs=0.5)
    if "stuck" in lie:  # the heading is that of the legs
        assert abs(last.odometry.velocity[0, 2]) < 0.5


def test_a_sensor_that_was_found_to_lie_is_not_believed_again_at_rest(
    nao: nk.NaoModel, life: Truth, log: Recording
) -> None:
    walk, estimator = slice(int(np.argmax(life.doing == "falling"))), nk.world.StateEstimator(nao)
    forces = np.roll(log.forces, 4, axis=1)
    for time, q, force in zip(log.times[walk], log.q[walk], forces[walk], strict=True):
        now = estimator.update(q, time, forces=force)
    assert "exchanged?" in now.notes[0]
    notes = [estimator.update(q, time + 0.05 * k, forces=force).notes for k in range(1, 400)]
    assert all("exchanged?" in note[0] for note in notes)


def test_at_rest_the_heading_stays_and_nothing_is_added_to_its_covariance(nao: nk.NaoModel) -> None:
    estimator, q = nk.world.StateEstimator(nao), nao.posture("Stand")
    rng, bias = np.random.default_rng(0), np.radians([1.0, 1.0, 1.0])
    found = [
        estimator.update(q, 0.01 * k, forces=[2.7, 2.7], angles=[0.0, 0.0], gyro=bias + rng.normal(0.0, 0.01, 3))
        for k in range(1000)
    ]
    heading = np.array([row.odometry.pose[0, 2] for row in found])
    assert np.abs(heading).max() < np.radians(1.2)  # in the first second
    assert np.abs(heading[200:] - heading[200]).max() < np.radians(0.3)
    deviation = [np.degrees(np.sqrt(found[k].odometry.covariance[0, 2, 2])) for k in (200, 999)]
    assert 0.3 < deviation[0] < 1.5
    assert deviation[1] == pytest.approx(deviation[0], rel=0.2)
    assert "mean at rest, 0.01" in " ".join(found[-1].notes)


def test_signs_units_and_missing_values(nao: nk.NaoModel, log: Recording) -> None:
    part = Recording(*(getattr(log, name)[:250] for name in Recording.__dataclass_fields__))
    names = ("forces", "accelerometer", "gyro")
    plain = followed(nao, part, *names)[-1]
    lola = Recording(part.times, part.q, 9.81 * part.forces, -part.accelerometer / 9.81, part.gyro, part.angles)
    found = followed(nao, lola, *names)[-1]
    assert np.abs(found.up - plain.up).max() < 1e-9
    assert any("negative when the robot stands, as LoLA has it" in note for note in found.notes)
    heavy = followed(nao, replace(part, forces=100.0 * part.forces), *names)[-1]
    assert any("another unit, or an offset?" in note for note in heavy.notes)
    gaps = logs.without(part, nao, np.random.default_rng(1))
    rows = followed(nao, gaps, *names)
    knee = np.isnan(gaps.q[:, nao.joint_names.index("LKneePitch")])
    valid = np.array([row.valid[0] for row in rows])
    assert knee.any()
    assert not valid[knee].any()
    assert valid[~knee].mean() > 0.98
    assert np.abs(rows[-1].odometry.pose - plain.odometry.pose).max() < 0.02


def test_a_gap_begins_a_segment_and_a_row_that_repeats_its_time_changes_nothing(nao: nk.NaoModel) -> None:
    estimator, q = nk.world.StateEstimator(nao, soles=["LLeg", "RLeg"]), nao.posture("Stand")
    first = estimator.update(q, 0.0)
    assert first.valid.all()
    again = estimator.update(0.0 * q, 0.0)
    assert np.array_equal(again.odometry.T_world_base, first.odometry.T_world_base)
    assert again.doing == first.doing
    assert estimator.update(q, 0.4, contacts=[True, True]).odometry.segment.tolist() == [0]
    assert estimator.update(q, 1.0, contacts=[True, True]).odometry.segment.tolist() == [1]
    lifted = [estimator.update(q, 1.0 + 0.07 * k, contacts=[False, False]) for k in range(1, 5)]
    assert [row.valid[0].item() for row in lifted] == [True, True, True, False]
    assert np.isnan(lifted[-1].T_world_base).all()
    back = [estimator.update(q, 1.5 + 0.1 * k, contacts=[True, True]) for k in range(1, 4)]
    assert back[-1].odometry.segment.tolist() == [2]


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"time": 0.5}, BadArgument, "times must ascend: 0.5 s comes after 1.0 s"),
        ({"time": np.nan}, BadArgument, "times must ascend"),
        ({"q": np.zeros(24)}, WrongShape, "q"),
        ({"forces": np.ones(5)}, WrongShape, "forces"),
        ({"contacts": np.ones(3)}, WrongShape, "contacts"),
        ({"gyro": np.ones(2)}, WrongShape, "gyro"),
        ({"angles": np.ones(3)}, WrongShape, "angles"),
        ({"accelerometer": np.full(3, np.inf)}, NaoKinError, "accelerometer"),
        ({"contacts": np.ones(2), "forces": np.ones(2)}, BadArgument, "contacts or forces, not both"),
        ({"angles": np.ones(2), "accelerometer": np.ones(3)}, BadArgument, "angles or an accelerometer, not both"),
    ],
)
def test_wrong_rows_are_refused(
    nao: nk.NaoModel, changes: dict[str, object], error: type[Exception], message: str
) -> None:
    estimator = nk.world.StateEstimator(nao)
    estimator.update(nao.posture("Stand"), 1.0)
    given = {"time": 2.0, "q": nao.posture("Stand")} | changes
    with pytest.raises(error, match=message):
        estimator.update(given.pop("q"), given.pop("time"), **given)
