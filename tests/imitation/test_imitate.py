"""A person's skeleton becomes a motion of arms and head that the robot can play."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pytest
from people import MOVED, columns_of, orientations_of, points_of

import nao_kin as nk
from nao_kin._core.arrays import Floats
from nao_kin.errors import BadArgument, DegeneratePoints, UnknownName
from nao_kin.imitation import Skeleton, imitate

EXACT = {"speed": 0.0}


def swing(nao: nk.NaoModel, times: Floats) -> Floats:
    """Configurations of a slow swing of arms and head, away from stretched arms."""
    q = np.tile(nao.posture("StandInit"), (len(times), 1))
    for k, name in enumerate(MOVED):
        q[:, nao.joint_names.index(name)] += 0.25 * np.sin(times + k)
    return nao.clamp(q)


def person(nao: nk.NaoModel, times: Floats, q: Floats, noise: float = 0.0) -> Skeleton:
    """The robot's own points, 2.5 times as large, on the way somewhere."""
    rng = np.random.default_rng(0)
    place = np.stack([0.3 * times, -0.1 * times, np.ones(len(times))], axis=1)
    points = {name: 2.5 * p + place + rng.normal(0.0, noise, p.shape) for name, p in points_of(nao, q).items()}
    return Skeleton(times, points, orientations_of(nao, q))


@pytest.mark.parametrize("rate", [10.0, 30.0])
def test_the_robot_s_own_motion_comes_back_at_any_rate(nao: nk.NaoModel, rate: float) -> None:
    times = np.arange(0.0, 6.0, 1.0 / rate)
    q = swing(nao, times)
    made = imitate(nao, person(nao, times, q), legs="ignore", cutoff=0.0, weights=EXACT, collisions=False)
    assert np.abs(made.q - q)[:, columns_of(nao)].max() < 1e-9
    assert set(made.motion.joint_names) == set(MOVED)
    at = [nao.joint_names.index(name) for name in made.motion.joint_names]
    np.testing.assert_allclose(made.motion.sample(times), q[:, at], atol=1e-9)
    assert not made.changes
    assert not made.notes
    assert all((codes == 0).all() for codes in made.clamped.values())
    # A filter and the cost of speeds change little.
    filtered = imitate(nao, person(nao, times, q), legs="ignore", collisions=False)
    assert np.abs(filtered.q - q)[:, columns_of(nao)].max() < 0.03


def test_noise_and_gaps_leave_directions_near_and_no_joint_too_fast(nao: nk.NaoModel) -> None:
    times = np.arange(0.0, 6.0, 1.0 / 30.0)
    q = swing(nao, times)
    noisy = person(nao, times, q, noise=0.02)
    rng, points = np.random.default_rng(1), {}
    for name, p in noisy.points.items():
        points[name] = np.where(rng.random(len(times))[:, None] < 0.1, np.nan, p)
    made = imitate(nao, Skeleton(times, points, noisy.orientations))
    assert made.ok, made.describe()
    clean = nk.imitation.imitate(nao, person(nao, times, q), cutoff=0.0)
    for side in "LR":
        for start, end, most in (("Shoulder", "Elbow", 0.08), ("Elbow", "WristYaw", 0.15)):
            lines = [
                nao.fk(each.q, side + end)[:, :3, 3] - nao.fk(each.q, side + start)[:, :3, 3] for each in (made, clean)
            ]
            units = [line / np.linalg.norm(line, axis=1, keepdims=True) for line in lines]
            assert np.linalg.norm(units[0] - units[1], axis=1).mean() < most
    assert any(note.startswith("left elbow is unknown in ") for note in made.notes)


@pytest.mark.parametrize("count", [1, 2])
def test_a_rest_pose_in_front_is_left_out(nao: nk.NaoModel, count: int) -> None:
    """Arms out to the sides, then the motion: a filter would make a stroke of it, for which time is stretched."""
    times = np.arange(0.0, 2.0, 1.0 / 30.0)
    whole = person(nao, times, swing(nao, times))
    points = {name: places.copy() for name, places in whole.points.items()}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for part, out in (("elbow", 0.3), ("wrist", 0.55)):
            points[f"{side}_{part}"][:count] = points[f"{side}_shoulder"][:count] + np.array([0.0, sign * out, 0.0])
    with_rest = Skeleton(times, points, whole.orientations)
    made, truth = (
        imitate(nao, each, legs="ignore", collisions=False) for each in (with_rest, whole.between(float(times[count])))
    )
    assert any("a rest pose, far from the next one, and left out" in note for note in made.notes)
    np.testing.assert_allclose(made.times, truth.times)
    np.testing.assert_allclose(made.q, truth.q, atol=1e-9)
    assert not any("rest pose" in note for note in imitate(nao, whole, legs="ignore", collisions=False).notes)


def test_points_that_jump_away_and_back_are_bridged_before_the_filter(nao: nk.NaoModel) -> None:
    times = np.arange(0.0, 3.0, 1.0 / 30.0)
    whole = person(nao, times, swing(nao, times), noise=0.01)
    points = {name: places.copy() for name, places in whole.points.items()}
    for name, rows in (("left_wrist", [20, 21]), ("right_elbow", [50])):
        points[name][rows] += (0.0, 0.9, -0.5)
    jumping = imitate(nao, Skeleton(times, points, whole.orientations), legs="ignore", collisions=False)
    truth = imitate(nao, whole, legs="ignore", collisions=False)
    note = "points jump away and back in up to 2 of 90 frames, which are bridged: right elbow, left wrist"
    assert note in jumping.notes
    assert not any("jump" in other for other in truth.notes)
    assert np.abs(jumping.q - truth.q).max() < 0.06
    kept = imitate(nao, Skeleton(times, points, whole.orientations), legs="ignore", collisions=False, cutoff=0.0)
    assert not any("jump" in other for other in kept.notes)


def test_points_of_low_confidence_are_bridged(nao: nk.NaoModel) -> None:
    times = np.arange(0.0, 3.0, 0.1)
    known = person(nao, times, swing(nao, times))
    points = {name: np.array(p) for name, p in known.points.items()}
    points["right_wrist"][10:13] += 5.0
    doubt = np.ones(len(times))
    doubt[10:13] = 0.2
    made = imitate(nao, Skeleton(times, points, known.orientations, {"right_wrist": doubt}), cutoff=0.0)
    assert made.notes == ("right wrist is unknown in 3 of 30 frames",)
    straight = imitate(nao, known, cutoff=0.0)
    assert np.abs(made.q - straight.q).max() < 0.1


def test_a_motion_too_fast_is_slowed_down_and_said_so(nao: nk.NaoModel) -> None:
    times = np.arange(0.0, 6.0, 0.05)
    fast = person(nao, times / 40.0, swing(nao, times))
    made = imitate(nao, fast, cutoff=0.0)
    assert made.motion.end > 1.1 * times[-1] / 40.0
    assert nk.motion.check(nao, made.motion).ok
    assert {change.kind for change in made.changes} == {"slower"}
    assert "times as long" in made.describe()


def test_a_mirror_exchanges_the_arms(nao: nk.NaoModel) -> None:
    times = np.arange(0.0, 3.0, 0.1)
    seen = person(nao, times, swing(nao, times))
    own, mirrored = (imitate(nao, seen, mirror=mirror, legs="ignore", cutoff=0.0) for mirror in (False, True))
    image = nk.motion.mirror(nao, own.motion)
    seen_there = image.sample(times)[:, [image.joint_names.index(name) for name in MOVED]]
    assert np.abs(mirrored.q[:, columns_of(nao)] - seen_there).max() < 1e-9


def test_arms_or_head_may_stay(nao: nk.NaoModel) -> None:
    times = np.arange(0.0, 3.0, 0.1)
    seen, stand = person(nao, times, swing(nao, times)), nao.posture("StandInit")
    without_arms, without_head = imitate(nao, seen, arms=False, cutoff=0.0), imitate(nao, seen, head=False, cutoff=0.0)
    for q, part in ((without_arms.q, columns_of(nao)[:10]), (without_head.q, columns_of(nao)[10:])):
        others = [k for k in columns_of(nao) if k not in part]
        np.testing.assert_allclose(q[:, part], np.tile(stand[part], (len(times), 1)), atol=1e-12)
        assert np.ptp(q[:, others], axis=0).min() > 0.1


def test_uneven_frames_become_even(nao: nk.NaoModel) -> None:
    times = np.sort(np.random.default_rng(2).uniform(0.0, 6.0, 200))
    q = swing(nao, times)
    made = imitate(nao, person(nao, times, q), legs="ignore", collisions=False)
    assert np.ptp(np.diff(made.times)) < 1e-9
    assert np.abs(made.q - swing(nao, made.times))[:, columns_of(nao)].max() < 0.05


def test_a_lead_begins_and_ends_in_the_posture(nao: nk.NaoModel) -> None:
    times = np.arange(10) / 20.0
    q = np.tile(nao.posture("StandInit", LShoulderPitch=-1.0, HeadYaw=1.5), (10, 1))
    seen = person(nao, times, q)
    options: Any = {"legs": "ignore", "cutoff": 0.0, "collisions": False}
    made, led = (imitate(nao, seen, lead=lead, **options) for lead in (0.0, 0.75))
    # The first keys are those of the first frame, after the time that the robot has from wherever it is.
    assert led.motion.start == led.played[0] == 0.75
    np.testing.assert_allclose(led.motion.sample(led.played), made.motion.sample(made.played), atol=1e-12)
    joints = [nao.joint_names.index(name) for name in led.motion.joint_names]
    np.testing.assert_allclose(led.motion.sample(led.motion.end), nao.posture("StandInit")[joints], atol=1e-12)
    assert led.motion.end - led.played[-1] == pytest.approx(0.75)
    assert led.report.as_dict()["start"] == 0.0  # the way there is checked too
    # A shoulder that turns by 2.4 rad takes longer than the time given.
    assert imitate(nao, seen, lead=0.1, **options).motion.start > 0.25


@pytest.mark.parametrize("name", nk.imitation.SAMPLES)
def test_the_samples_can_be_played(nao: nk.NaoModel, name: str) -> None:
    made = imitate(nao, nk.imitation.read_skeleton(nk.imitation.SAMPLES[name]))
    assert made.ok, made.describe()
    assert nk.motion.check(nao, made.motion, collisions=True, balance=True, rate=200.0).ok
    assert max(np.nanmean(made.errors[f"{side}_upper_arm"]) for side in ("left", "right")) < 0.1


def test_one_frame_is_a_posture(nao: nk.NaoModel) -> None:
    q = swing(nao, np.array([0.7]))
    made = imitate(nao, person(nao, np.array([0.7]), q), collisions=False)
    assert np.abs(made.q - q)[:, columns_of(nao)].max() < 1e-9


def test_wrong_input_is_refused(nao: nk.NaoModel) -> None:
    times = np.array([0.0, 1.0])
    seen = person(nao, times, swing(nao, times))
    with pytest.raises(BadArgument, match="cutoff must be a number ≥ 0"):
        imitate(nao, seen, cutoff=-1.0)
    with pytest.raises(BadArgument, match="lead"):
        imitate(nao, seen, lead=-1.0)
    with pytest.raises(UnknownName, match="unknown weight 'hands'"):
        imitate(nao, seen, weights={"hands": 1.0})
    with pytest.raises(UnknownName, match="unknown treatment of legs 'walk'"):
        imitate(nao, seen, legs="walk")  # type: ignore[arg-type]
    with pytest.raises(BadArgument, match=r'legs="follow" needs hips and ankles.*no left_ankle, no right_ankle'):
        imitate(nao, seen, legs="follow")
    with pytest.raises(BadArgument, match="mirror must be True or False"):
        imitate(nao, seen, mirror="left")  # type: ignore[arg-type]


def test_frames_far_apart_are_not_joined(nao: nk.NaoModel) -> None:
    wave = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
    times = wave.times + np.where(wave.times > 2.0, 3600.0, 0.0)
    paused = Skeleton(times, wave.points)
    for cutoff in (0.0, 4.0):
        with pytest.raises(BadArgument, match=r"no frames between 2 and 3602\.05 s"):
            imitate(nao, paused, cutoff=cutoff, legs="ignore", collisions=False)
    part = imitate(nao, paused.between(0.0, 2.0), legs="ignore", collisions=False)
    assert part.times[-1] == pytest.approx(2.0)


def test_notes_say_for_how_long_points_are_unknown(nao: nk.NaoModel) -> None:
    wave = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
    points = {name: values.copy() for name, values in wave.points.items()}
    points["left_wrist"][10:50] = np.nan
    points["left_elbow"][[3, 7]] = np.nan
    points["right_wrist"][40:] = np.nan
    made = imitate(nao, Skeleton(wave.times, points), legs="ignore", collisions=False)
    assert "left wrist is unknown in 40 of 65 frames, for up to 2 s" in made.notes
    assert "left elbow is unknown in 2 of 65 frames" in made.notes
    assert "right wrist is unknown in 25 of 65 frames, for up to 1.2 s" in made.notes


@pytest.mark.parametrize("legs", ["stand", "ignore"])
def test_a_person_whom_nothing_shows_is_refused(nao: nk.NaoModel, legs: Literal["stand", "ignore"]) -> None:
    wave = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
    unsure = {name: np.full(len(wave), 0.1) for name in wave.names}
    with pytest.raises(DegeneratePoints, match="no frame has shoulders or hips"):
        imitate(nao, Skeleton(wave.times, wave.points, confidence=unsure), legs=legs)
