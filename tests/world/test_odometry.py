"""Odometry beside the walks of the virtual NAO, whose trunk is known, and walks made up of random steps."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.errors import BadArgument, NaoKinError, WrongShape

LEGS = ("LLeg", "RLeg")


class Walk(NamedTuple):
    times: np.ndarray
    q: np.ndarray
    T: np.ndarray
    support: np.ndarray


@pytest.fixture(scope="module")
def walk(nao: nk.NaoModel) -> Walk:
    """A walk of the virtual NAO to the front left, with a turn."""
    rows = []
    with nk.naoqi.VirtualNao(nao, stepped=True, posture="StandInit") as virtual:
        virtual.call("ALMotion", "wakeUp")
        call = virtual.post("ALMotion", "moveTo", 0.3, 0.1, 0.8)
        while not call.done():
            state = virtual.state()
            rows.append((state.time, state.q, state.T_world_torso, LEGS.index(virtual.base.support)))
            virtual.step(0.01)
    return Walk(*(np.array(part) for part in zip(*rows, strict=True)))


def _off(found: nk.world.Odometry, T: np.ndarray) -> tuple[float, float]:
    """Return the final error of position [m] and of heading [rad]."""
    turn = Rotation.from_matrix(found.T_world_base[-1, :3, :3] @ T[-1, :3, :3].T)
    return float(np.linalg.norm(found.T_world_base[-1, :3, 3] - T[-1, :3, 3])), abs(float(turn.as_rotvec()[2]))


def test_with_the_true_contacts_a_walk_is_exact(nao: nk.NaoModel, walk: Walk) -> None:
    contacts = np.arange(2) == walk.support[:, None]
    found = nk.world.odometry(nao, walk.q, walk.times, contacts=contacts, start=walk.T[0])
    assert np.array_equal(found.support, walk.support)
    assert np.abs(found.T_world_base - walk.T).max() < 1e-9
    feet = found.T_world_base @ np.take_along_axis(nao.fk(walk.q, LEGS), found.support[:, None, None, None], 1)[:, 0]
    assert np.abs(feet - found.T_world_support).max() < 1e-9


def test_from_the_joints_alone_it_drifts_by_a_thousandth(nao: nk.NaoModel, walk: Walk) -> None:
    found = nk.world.odometry(nao, walk.q, walk.times, start=walk.T[0])
    away, turned = _off(found, walk.T)
    assert away < 1.5e-3
    assert turned < 1e-3
    steps = np.count_nonzero(np.diff(walk.support))
    assert np.count_nonzero(np.diff(found.support)) == steps > 6


def test_noisy_encoders_do_not_make_the_support_switch_back_and_forth(nao: nk.NaoModel, walk: Walk) -> None:
    noisy = walk.q + np.random.default_rng(3).normal(0.0, np.radians(0.1), walk.q.shape)
    found = nk.world.odometry(nao, noisy, walk.times, start=walk.T[0])
    assert np.count_nonzero(np.diff(found.support)) < 1.5 * np.count_nonzero(np.diff(walk.support))
    assert _off(found, walk.T)[0] < 0.02


def test_forces_choose_the_support_with_hysteresis(nao: nk.NaoModel, walk: Walk) -> None:
    left = np.where(walk.support == 0, 30.0, 20.0)[:, None]  # 60 and 40 %: not yet enough to change
    standing = np.tile(walk.q[0], (len(walk.q), 1))
    still = nk.world.odometry(nao, standing, walk.times, forces=np.hstack([left, 50.0 - left]))
    assert (still.support == still.support[0]).all()
    sensors = np.where(np.repeat(walk.support[:, None] == np.arange(2), 4, axis=1), 10.0, 1.0)
    names = nao.semantics.force_sensors
    order = np.argsort([name.startswith("R") for name in names], kind="stable")
    found = nk.world.odometry(nao, walk.q, walk.times, forces=sensors[:, np.argsort(order)], start=walk.T[0])
    assert np.array_equal(found.support, walk.support)
    assert _off(found, walk.T)[0] < 1e-9


def test_a_foot_that_turns_on_the_floor_is_seen_by_the_gyrometer(nao: nk.NaoModel, walk: Walk) -> None:
    contacts = np.arange(2) == walk.support[:, None]
    # The support turns about its origin by half a degree in each step, so the true walk differs from that of the legs.
    changes = np.concatenate([[0], np.cumsum(np.diff(walk.support) != 0)])
    true = walk.T.copy()
    step = np.zeros(len(true))
    for k in range(1, len(true)):
        step[k] = np.radians(0.5) / np.count_nonzero(changes == changes[k])
        sole = nao.fk(walk.q[k - 1], LEGS)[walk.support[k]]
        about = np.eye(4)
        about[:3, 3] = (true[k - 1] @ sole)[:3, 3]
        spin = np.eye(4)
        spin[:3, :3] = Rotation.from_rotvec([0, 0, step[k]]).as_matrix()
        true[k] = about @ spin @ np.linalg.inv(about) @ true[k - 1] @ np.linalg.inv(walk.T[k - 1]) @ walk.T[k]
    turns = Rotation.from_matrix(true[:-1, :3, :3].swapaxes(1, 2) @ true[1:, :3, :3]).as_rotvec()
    rates = turns / np.diff(walk.times)[:, None]
    gyro = np.concatenate([rates[:1], 0.5 * (rates[:-1] + rates[1:]), rates[-1:]])
    blind = nk.world.odometry(nao, walk.q, walk.times, contacts=contacts, start=true[0])
    seeing = nk.world.odometry(nao, walk.q, walk.times, contacts=contacts, start=true[0], gyro=gyro)
    assert _off(blind, true)[1] > np.radians(4.0)
    assert _off(seeing, true)[1] < np.radians(0.2)
    assert _off(seeing, true)[0] < 0.3 * _off(blind, true)[0]


def test_no_path_leads_through_rows_that_do_not_stand(nao: nk.NaoModel, walk: Walk) -> None:
    """Lifted by its contacts or forces, by the caller's word, or without contact at all: no pose, and new segments."""
    n = len(walk.times)
    contacts = np.arange(2) == walk.support[:, None]
    air = contacts & ~((np.arange(n) > 200) & (np.arange(n) < 230))[:, None]
    valid = air.any(axis=1)
    for given in ({"contacts": air}, {"contacts": contacts, "valid": valid}, {"forces": 50.0 * air}):
        found = nk.world.odometry(nao, walk.q, walk.times, start=walk.T[0], **given)
        assert np.array_equal(found.valid, valid)
        assert found.segments == 2
        assert np.isnan(found.T_world_base[~valid]).all()
        assert (found.support[~valid] == -1).all()
        assert np.abs(found.T_world_base[:200] - walk.T[:200]).max() < 1e-9
        # The second part is the same walk from another place.
        moves = [np.linalg.inv(T[230]) @ T[-1] for T in (found.T_world_base, walk.T)]
        assert np.abs(moves[0] - moves[1]).max() < 1e-9
    never = nk.world.odometry(nao, walk.q, walk.times, contacts=np.zeros((n, 2)))
    assert never.segments == 0
    assert never.pose.shape == (n, 3)


def test_without_a_start_it_begins_between_the_feet(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("Stand"), (3, 1))
    found = nk.world.odometry(nao, q, [0.0, 0.1, 0.2])
    feet = nk.world.feet_frame(found.T_world_base[0] @ nao.fk(q[0], LEGS))
    assert np.abs(feet - np.eye(4)).max() < 1e-3
    assert np.abs(feet[:2, 3]).max() < 1e-12
    floating = nk.load_nao(base="floating")
    moved = np.hstack([np.tile([5.0, 6.0, 7.0, 0.0, 0.0, 0.0, 1.0], (3, 1)), q])
    assert np.allclose(nk.world.odometry(floating, moved, [0.0, 0.1, 0.2]).T_world_base, found.T_world_base, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"times": [0.0, 0.2, 0.1]}, BadArgument, "times must ascend: row 2 is at 0.1 s, row 1 at 0.2 s"),
        (
            {"times": [1.6e9, 1.6e9 + 0.02, 1.6e9 + 0.01]},
            BadArgument,
            "row 2 is at 1600000000.01 s, row 1 at 1600000000.02",
        ),
        ({"times": [0.1, 0.1, 0.1]}, BadArgument, "2 of 3 rows repeat a time"),
        ({"longest_gap": -1.0}, BadArgument, "longest_gap"),
        ({"valid": [True, True]}, WrongShape, "valid"),
        ({"times": [0.0, 0.1]}, WrongShape, "times"),
        ({"times": [0.0, np.nan, 0.1]}, NaoKinError, "times"),
        ({"q": np.zeros(25)}, WrongShape, "one configuration at least"),
        ({"contacts": np.ones((3, 3))}, WrongShape, "contacts"),
        ({"contacts": np.ones((3, 2)), "forces": np.ones((3, 2))}, BadArgument, "not both"),
        ({"forces": np.ones((3, 5))}, WrongShape, r"forces must have shape \(3, 2\) or \(3, 8\)"),
        ({"gyro": np.zeros((2, 3))}, WrongShape, "gyro"),
        ({"soles": []}, BadArgument, "soles must name at least one frame"),
        ({"start": np.zeros((4, 4))}, NaoKinError, "start: not a rotation matrix"),
        ({"start": np.tile(np.eye(4), (2, 1, 1))}, WrongShape, "start"),
    ],
)
def test_logs_that_cannot_be_followed_are_refused(
    nao: nk.NaoModel, changes: dict[str, object], error: type[Exception], message: str
) -> None:
    given = {"times": [0.0, 0.1, 0.2], "q": np.tile(nao.posture("Stand"), (3, 1))} | changes
    with pytest.raises(error, match=message):
        nk.world.odometry(nao, given.pop("q"), given.pop("times"), **given)


def test_the_distance_counts_the_way_after_the_last_step_too(nao: nk.NaoModel) -> None:
    found = nk.world.odometry(nao, np.tile(nao.posture("Stand"), (3, 1)), [0.0, 0.1, 0.2])
    T = found.T_world_base.copy()
    T[:, 0, 3] = 0.0, 0.1, 0.3
    assert replace(found, T_world_base=T).distance == pytest.approx(0.3)
    assert replace(found, T_world_base=T, segment=np.array([0, 1, 1])).distance == pytest.approx(0.2)


def test_a_robot_that_sways_gets_nowhere(nao: nk.NaoModel) -> None:
    """Its support changes to and fro, and its root link moves by 6 cm; a walk of 0.1 m sways beside its way."""
    found = nk.world.odometry(nao, np.tile(nao.posture("Stand"), (22, 1)), 0.1 * np.arange(22))
    support = np.repeat(np.arange(11) % 2, 2)
    T = np.tile(np.eye(4), (22, 1, 1))
    T[:, 1, 3] = np.where(support == 0, 0.03, -0.03)
    rocks = replace(found, T_world_base=T, support=support)
    assert rocks.steps.sum() == 10
    assert rocks.distance < 0.07  # to the side at first, and at the end
    T[:, 0, 3] = 0.1 * np.arange(22) / 21.0
    assert rocks.distance == pytest.approx(0.1, abs=0.05)


def test_the_support_is_that_with_contact_until_it_loses_it(nao: nk.NaoModel) -> None:
    q, contacts = np.tile(nao.posture("Stand"), (6, 1)), [[0, 1], [0, 1], [1, 1], [1, 1], [1, 0], [1, 1]]
    found = nk.world.odometry(nao, q, 0.01 * np.arange(6), contacts=contacts)
    assert found.support.tolist() == [1, 1, 1, 1, 0, 0]
