"""What a robot does: it sits, is carried, falls for less than a second, and lies, or nothing shows it."""

from __future__ import annotations

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.world.doing import Contact, decided

STEP = 0.01


def doing(nao: nk.NaoModel, posture: str, tilts: np.ndarray, load: np.ndarray, **sensors: object) -> nk.world.State:
    """The state of a stiff robot that is tilted forwards [°], with a load on its soles [kg]."""
    q = np.tile(nao.posture(posture), (len(tilts), 1))
    lean = np.arctan2(-(up := nao.fk(q[0], "LLeg")[:3, 2])[0], up[2]) if posture.startswith("Stand") else 0.0
    angles = np.column_stack([0.0 * tilts, lean + np.radians(tilts)])
    turns = np.gradient(angles[:, 1], STEP)[:, None] * [0.0, 1.0, 0.0]
    gyro = turns + np.random.default_rng(0).normal(0.0, 0.01, turns.shape)
    given = {"angles": angles, "gyro": gyro, "forces": np.repeat(load[:, None] / 8.0, 8, axis=1)} | sensors
    return nk.world.state(nao, q, times=STEP * np.arange(len(tilts)), **given)


@pytest.mark.parametrize(
    ("posture", "load", "tilt"), [("SitRelax", 1.2, -9.0), ("Sit", 0.56, -18.0), ("Sit", 0.0, -15.0)]
)
def test_a_robot_that_sits_does_not_fall_or_stand(nao: nk.NaoModel, posture: str, load: float, tilt: float) -> None:
    found = doing(nao, posture, np.full(400, tilt), np.full(400, load))
    assert found.seconds["sitting"] > 3.9
    assert set(found.doing[60:].tolist()) == {"sitting"}
    assert np.isnan(found.T_world_base).all()


def test_a_robot_on_a_chair_sits(nao: nk.NaoModel) -> None:
    """Its hips are as high as those of a crouching one, but its soles carry a third of its weight only."""
    load = np.where(np.arange(600) < 200, 5.36, 1.8)
    found = doing(nao, "StandInit", np.zeros(600), load)
    assert found.seconds["standing"] == pytest.approx(2.0, abs=0.1)
    assert found.seconds["sitting"] == pytest.approx(4.0, abs=0.1)


def carried(tilt: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """2 s of standing, and then a person who lifts and tilts the robot within a second, and sways with it."""
    t = STEP * np.arange(round(seconds / STEP))
    up = np.clip(t, 0.0, 1.0)
    tilts = tilt * up**2 * (3.0 - 2.0 * up) + 3.0 * np.sin(2.0 * np.pi * 0.9 * t) * up
    return np.concatenate([np.zeros(200), tilts]), np.concatenate([np.full(200, 5.36), np.zeros(len(t))])


@pytest.mark.parametrize("tilt", [0.0, 25.0, 40.0, 60.0, 85.0])
def test_a_robot_in_the_hands_of_a_person_neither_falls_nor_lies(nao: nk.NaoModel, tilt: float) -> None:
    found = doing(nao, "StandInit", *carried(tilt, 4.0))
    assert found.seconds["standing"] == pytest.approx(2.0, abs=0.1)
    assert found.seconds["lifted"] + found.seconds["carried"] == pytest.approx(4.0, abs=0.1)
    if tilt > 30.0:
        assert found.doing[-1] == "carried"


def test_who_is_carried_and_laid_down_lies_as_soon_as_it_is_quiet(nao: nk.NaoModel) -> None:
    tilts, load = carried(85.0, 3.0)
    found = doing(nao, "StandInit", np.append(tilts, np.full(300, tilts[-1])), np.append(load, np.zeros(300)))
    assert found.seconds["carried"] == pytest.approx(3.0, abs=0.6)
    assert found.doing[-200:].tolist() == ["lying"] * 200


def test_a_fall_lasts_less_than_a_second_and_ends_on_the_floor(nao: nk.NaoModel) -> None:
    t = STEP * np.arange(60)
    tilts = np.concatenate([np.zeros(200), 90.0 * (t / t[-1]) ** 2, np.full(300, 90.0)])
    load = np.where(np.arange(560) < 225, 5.36, 0.0)
    found = doing(nao, "StandInit", tilts, load)
    assert 0.2 < found.seconds["falling"] < 0.6
    assert found.seconds["lying"] == pytest.approx(3.0, abs=0.2)
    assert found.seconds["carried"] == found.seconds["unknown"] == 0.0
    # Who tips over its edge and stays so does not fall for ever.
    leaning = doing(nao, "StandInit", np.concatenate([np.zeros(200), np.full(400, 20.0)]), np.full(600, 5.36))
    assert leaning.seconds["falling"] == 0.0
    assert leaning.seconds["unknown"] == pytest.approx(4.0, abs=0.1)


def test_without_an_inertial_unit_only_a_load_shows_that_it_stands(nao: nk.NaoModel) -> None:
    times = STEP * np.arange(400)
    for posture, load in (("LyingBack", 0.8), ("Stand", 0.8), ("LyingBelly", 2.3)):
        q = np.tile(nao.posture(posture), (400, 1))
        found = nk.world.state(nao, q, times=times, forces=np.full((400, 8), load / 8.0))
        assert set(found.doing.tolist()) == {"unknown"}
        assert not found.valid.any()
        assert "no row counts as standing" in found.notes[0]
    # As soon as the weight is known, half of it does not stand: a robot that lies on its toes.
    forces = np.where(np.arange(400) < 100, 0.67, 0.29)[:, None] * np.ones(8)
    found = nk.world.state(nao, q * 0.0 + nao.posture("Stand"), times=times, forces=forces)
    assert found.seconds["standing"] == pytest.approx(1.0, abs=0.05)
    assert found.seconds["unknown"] == pytest.approx(3.0, abs=0.05)


def test_a_sole_on_its_edge_says_less_about_the_tilt(nao: nk.NaoModel) -> None:
    """Without inertial unit: the centre of pressure in the middle, at the toes, and not known."""
    q, times = np.tile(nao.posture("StandInit"), (50, 1)), STEP * np.arange(50)
    front = np.array(["Front" in name for name in nao.semantics.force_sensors])
    deviations = []
    for forces in (np.full(8, 0.67), np.where(front, 1.32, 0.02), np.full(2, 2.68)):
        found = nk.world.state(nao, q, times=times, forces=np.tile(forces, (50, 1)))
        deviations.append(np.degrees(np.sqrt(found.covariance[-1, 0, 0])))
    assert deviations == pytest.approx([1.4, np.hypot(1.4, 4.0), np.hypot(1.4, 4.0)])


def test_hips_are_low_by_the_vertical_and_not_by_the_soles(nao: nk.NaoModel) -> None:
    """Crouched robots stand, however their soles press; a robot in the posture of sitting that swings is held."""
    assert doing(nao, "Crouch", np.zeros(300), np.full(300, 5.36)).seconds["standing"] > 2.9
    found = doing(nao, "Sit", 12.0 * np.sin(2.0 * np.pi * STEP * np.arange(500)) - 15.0, np.zeros(500))
    assert found.seconds["lifted"] > 4.9


def test_contact_is_lost_and_found_with_delays_from_where_they_began() -> None:
    times = STEP * np.arange(200)
    loaded = np.ones(200, dtype=bool)
    loaded[20:35] = loaded[60:100] = loaded[105:130] = False  # 0.15 s; 0.65 s with 0.05 s in between
    found = decided(Contact(), loaded, times)
    assert np.flatnonzero(~found).tolist() == list(range(60, 130))


def test_a_robot_that_rocks_from_foot_to_foot_does_not_walk(nao: nk.NaoModel) -> None:
    """Unless its legs lift its soles: then it walks between the first and the last step."""
    times, side = STEP * np.arange(400), (np.arange(400) // 30) % 2
    forces = np.where(side[:, None] == np.arange(2), 5.0, 0.3)
    found = []
    for lifted in (0.0, 1.0):
        q = np.tile(nao.posture("Stand"), (400, 1))
        for k, leg in enumerate("LR"):
            swing = (
                lifted * np.sin(np.pi * (np.arange(400) % 30) / 30.0) * ((side != k) & (times > 0.9) & (times < 3.0))
            )
            for joint, share in (("HipPitch", -0.5), ("KneePitch", 1.0), ("AnklePitch", -0.5)):
                q[:, nao.joint_names.index(leg + joint)] += share * swing
        found.append(nk.world.state(nao, q, times=times, forces=forces, angles=np.zeros((400, 2))))
    assert found[0].odometry.steps.sum() == found[1].odometry.steps.sum() == 13
    assert found[0].seconds["walking"] == 0.0
    walks = np.flatnonzero(found[1].doing == "walking")
    assert walks.tolist() == list(range(walks[0], walks[-1] + 1))
    assert times[walks[[0, -1]]] == pytest.approx([0.9, 3.0], abs=0.31)
