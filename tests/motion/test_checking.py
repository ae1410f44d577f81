"""Checks of motions beside what dense samples show, and by hand."""

from __future__ import annotations

import json
import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from loops import full
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin._core.arrays import COUPLING_TOLERANCE, Floats
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.motion import MotionReport, check, share_motors, slow_down
from nao_kin.motion.interpolation import INTERPOLATIONS

# Pairs of a coupled limit, both hips of one motor, and a ratio.
JOINTS = ("HeadYaw", "HeadPitch", "RAnklePitch", "RAnkleRoll", "LHipYawPitch", "RHipYawPitch", "LHand")
SAMPLES = 20_001


def _limits(nao: nk.NaoModel, joint: str) -> tuple[float, float, float]:
    column = nao.joint_names.index(nao.mimics[joint].joint if joint in nao.mimics else joint)
    return nao.lower[column], nao.upper[column], nao.velocity_limits[column]


def _motion(nao: nk.NaoModel, seed: int, interpolation: str) -> nk.Motion:
    rng = np.random.default_rng(seed)
    times, keys, handles = [], [], []
    for joint in JOINTS:
        lower, upper, _ = _limits(nao, joint)
        k = int(rng.integers(1, 7))
        column = np.sort(rng.uniform(0.0, 6.0, k))
        offsets = rng.normal(size=(k, 2, 2)) * 0.5
        offsets[:, :, 0] = 0.0
        offsets[1:, 0, 0] = -np.diff(column) * rng.uniform(0.02, 1.0, k - 1)
        offsets[:-1, 1, 0] = np.diff(column) * rng.uniform(0.02, 1.0, k - 1)
        times.append(column)
        keys.append(rng.uniform(lower - 0.2, upper + 0.2, k))
        handles.append(offsets)
    return nk.Motion(times, JOINTS, keys, interpolation, handles if interpolation == "bezier" else None)  # type: ignore[arg-type]


def _agrees(report: MotionReport, kind: str, joint: str, t: Floats, excess: Floats) -> None:
    """Compare with samples: found stretches are outside, samples outside are found, no sample exceeds the worst."""
    rows = [row for row in report.violations if (row.kind, row.joint) == (kind, joint)]
    step = 2.0 * (t[1] - t[0])
    found, inside = np.zeros(len(t), dtype=bool), np.zeros(len(t), dtype=bool)
    for row in rows:
        assert row.start <= row.time <= row.end
        found |= (t >= row.start - step) & (t <= row.end + step)
        inside |= (t >= row.start + step) & (t <= row.end - step)
    assert not (excess > 1e-6)[~found].any()
    assert not (excess < -1e-6)[inside].any()
    assert max((row.excess for row in rows), default=0.0) >= excess.max() - 1e-9


@pytest.mark.parametrize("seed", [0, 1, *full(2, 3)])
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_everything_outside_is_found_and_nothing_else(nao: nk.NaoModel, interpolation: str, seed: int) -> None:
    motion = _motion(nao, seed, interpolation)
    report = check(nao, motion)
    t = np.linspace(motion.start, motion.end, SAMPLES)
    values, speeds = (dict(zip(JOINTS, array.T, strict=True)) for array in (motion.sample(t), motion.speed(t)))
    for joint in JOINTS:
        lower, upper, fastest = _limits(nao, joint)
        _agrees(report, "limit", joint, t, np.maximum(lower - values[joint], values[joint] - upper))
        _agrees(report, "speed", joint, t, np.abs(speeds[joint]) - fastest)
    for table in nao.coupled_limits:
        if table.joint in JOINTS:
            lower, upper = table.range(values[table.of])
            _agrees(
                report,
                "coupled limit",
                table.joint,
                t,
                np.maximum(lower - values[table.joint], values[table.joint] - upper),
            )
    apart = np.abs(values["LHipYawPitch"] - values["RHipYawPitch"])
    _agrees(report, "motor", "RHipYawPitch", t, apart - COUPLING_TOLERANCE)
    assert report.sampled == (1000.0 if interpolation == "bezier" else None)


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_a_motion_through_the_postures_is_fine(nao: nk.NaoModel, interpolation: str) -> None:
    q = np.stack([nao.posture(name) for name in ("StandInit", "Crouch", "StandInit")])
    motion = nk.Motion([0.0, 5.0, 10.0], nao.body_order, nao.to_body(q), interpolation)  # type: ignore[arg-type]
    report = check(nao, motion)
    assert report.ok, report.describe()
    assert "can perform the motion: 26 joints, 0 to 10 s" in report.describe()


def test_an_overshoot_between_keys_that_are_inside_is_found_exactly(nao: nk.NaoModel) -> None:
    # Handles of a third of the segment and height h: the highest point is 3 h / 4 above the keys, in the middle.
    upper = nao.upper[nao.joint_names.index("HeadYaw")]
    handles = np.zeros((2, 2, 2))
    handles[0, 1], handles[1, 0] = (1.0, 0.4), (-1.0, 0.4)
    motion = nk.Motion([0.0, 3.0], ["HeadYaw"], [[upper - 0.1], [upper - 0.1]], "bezier", [handles])
    (row,) = (row for row in check(nao, motion).violations if row.kind == "limit")
    assert (row.time, row.excess) == (pytest.approx(1.5, abs=1e-9), pytest.approx(0.2, abs=1e-12))
    # 3 u (1 − u) 0.4 = 0.1 at the ends of the stretch.
    u = 0.5 * (1.0 - math.sqrt(1.0 - 4.0 / 12.0))
    assert (row.start, row.end) == (pytest.approx(3.0 * u, abs=1e-9), pytest.approx(3.0 * (1.0 - u), abs=1e-9))


def test_the_speed_of_a_smooth_segment_is_greatest_in_its_middle(nao: nk.NaoModel) -> None:
    limit = nao.velocity_limits[nao.joint_names.index("HeadYaw")]
    width = 1.5 / limit  # 3 s² − 2 s³ is fastest, 1.5 times the mean, at a half: a rise of 1.1 is 10 % too fast
    motion = nk.Motion([0.0, width], ["HeadYaw"], [[0.0], [1.1]], "smooth")
    (row,) = check(nao, motion).violations
    assert (row.kind, row.unit) == ("speed", "rad/s")
    assert row.time == pytest.approx(width / 2, abs=1e-9)
    assert row.value == pytest.approx(1.1 * limit, rel=1e-12)
    assert check(nao, nk.Motion([0.0, width], ["HeadYaw"], [[0.0], [1.0]], "smooth")).ok


def test_a_coupled_limit_is_left_between_keys_that_keep_it(nao: nk.NaoModel) -> None:
    # The range of HeadPitch narrows towards HeadYaw = ±87.49°, and widens again behind.
    table = next(table for table in nao.coupled_limits if table.joint == "HeadPitch")
    pitch = float(table.upper[0])
    motion = nk.Motion([0.0, 1.0], ["HeadYaw", "HeadPitch"], [[-2.08, pitch - 0.01], [-0.5, pitch - 0.01]])
    (row,) = check(nao, motion).violations
    assert row.kind == "coupled limit"
    assert row.of == "HeadYaw"
    assert row.of_value == pytest.approx(table.at[1], abs=1e-12)
    assert row.excess == pytest.approx(pitch - 0.01 - table.upper[1], abs=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_coupled_limit_is_told_on_the_side_that_is_passed(nao: nk.NaoModel, side: float) -> None:
    """HeadYaw at 1.1 leaves HeadPitch a range; half of the way between it and the box is outside the range only."""
    table = next(table for table in nao.coupled_limits if table.joint == "HeadPitch")
    lower, upper = (float(end) for end in table.range(np.array(1.1)))
    column = nao.joint_names.index("HeadPitch")
    pitch = (upper + nao.upper[column]) / 2 if side > 0 else (lower + nao.lower[column]) / 2
    motion = nk.Motion([0.0, 1.0, 2.0], ["HeadYaw", "HeadPitch"], [[1.1, 0.0], [1.1, pitch], [1.1, 0.0]])
    (row,) = check(nao, motion).violations
    assert (row.kind, row.joint, row.of) == ("coupled limit", "HeadPitch", "HeadYaw")
    assert (row.value, row.lower, row.upper) == pytest.approx((pitch, lower, upper), abs=1e-12)
    assert row.excess == pytest.approx(pitch - upper if side > 0 else lower - pitch, abs=1e-12)
    (violation,) = nao.limit_violations(nao.configuration({"HeadYaw": 1.1, "HeadPitch": pitch}, limits="ignore"))[:1]
    assert (violation.lower, violation.upper) == pytest.approx((lower, upper), abs=1e-12)


def test_a_coupled_limit_looks_at_joints_that_are_not_named(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0], ["HeadPitch"], [[0.5]])
    assert check(nao, motion).ok
    turned = nao.configuration({"HeadYaw": 1.5, "LElbowRoll": -0.1, "RElbowRoll": 0.1}, limits="ignore")
    (row,) = check(nao, motion, missing=turned).violations
    assert (row.kind, row.joint, row.of_value) == ("coupled limit", "HeadPitch", 1.5)


def test_joints_of_one_motor_must_agree_at_all_times(nao: nk.NaoModel) -> None:
    # Equal at every key, and not between them.
    motion = nk.Motion(
        [[0.0, 2.0], [0.0, 1.0, 2.0]], ["LHipYawPitch", "RHipYawPitch"], [[0.0, -0.4], [0.0, -0.25, -0.4]]
    )
    (row,) = check(nao, motion).violations
    assert (row.kind, row.joint, row.of) == ("motor", "RHipYawPitch", "LHipYawPitch")
    assert (row.time, row.value, row.of_value) == (1.0, -0.25, pytest.approx(-0.2))
    assert "0.05 rad apart" in row.describe()


def test_a_joint_outside_at_its_only_key_is_outside_all_the_time(nao: nk.NaoModel) -> None:
    motion = nk.Motion([[1.0], [0.0, 3.0]], ["LHand", "HeadYaw"], [[1.5], [0.0, 0.1]])
    (row,) = check(nao, motion).violations
    assert (row.start, row.end, row.excess) == (0.0, 3.0, 0.5)


def test_one_key_is_a_motion_of_no_time(nao: nk.NaoModel) -> None:
    (row,) = check(nao, nk.Motion([2.0], ["LHand"], [[-0.25]])).violations
    assert (row.start, row.end, row.time, row.value) == (2.0, 2.0, 2.0, -0.25)
    assert check(nao, nk.Motion([2.0], ["LHand"], [[0.25]])).ok


def test_a_joint_on_its_limit_is_inside(nao: nk.NaoModel) -> None:
    q = np.stack([nao.lower, nao.upper])
    for column, joint in enumerate(nao.joint_names):
        report = check(nao, nk.Motion([0.0, 60.0], [joint], q[:, [column]]), missing="StandInit")
        assert [row for row in report.violations if row.kind != "coupled limit"] == []


def test_neighbouring_segments_outside_are_one_stretch(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    times = np.cumsum(rng.uniform(0.1, 0.3, 50))
    for interpolation in INTERPOLATIONS:
        motion = nk.Motion(times, ["LHand"], rng.uniform(1.2, 1.5, (50, 1)), interpolation)
        (row,) = (row for row in check(nao, motion).violations if row.kind == "limit")
        assert (row.start, row.end) == (times[0], times[-1])


def test_a_vertical_curve_is_infinitely_fast_and_still_json(nao: nk.NaoModel) -> None:
    handles = np.zeros((2, 2, 2))
    handles[0, 1] = 0.0, 0.5
    report = check(nao, nk.Motion([0.0, 1.0], ["LHand"], [[0.0], [1.0]], "bezier", [handles]))
    (row,) = report.violations
    assert row.value == math.inf
    assert json.loads(json.dumps(report.as_dict(), allow_nan=False))["violations"][0]["value"] is None


def test_a_vertical_curve_under_a_coupled_limit_is_checked_without_noise(nao: nk.NaoModel) -> None:
    handles = np.zeros((2, 2, 2))
    handles[0, 1] = 0.0, 0.5
    times, names = [0.0, 1.0], ["HeadYaw", "HeadPitch"]
    motion = nk.Motion(times, names, [[0.0, 0.0], [1.2, 0.4]], "bezier", [handles, handles])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        report = check(nao, motion)
    assert {row.kind for row in report.violations} >= {"speed", "coupled limit"}


def test_a_report_is_said_in_degrees_and_as_json(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0, 10.0], ["HeadYaw"], [[0.0], [math.radians(129.5)]])
    report = check(nao, motion)
    text = report.describe(degrees=True)
    assert (
        "HeadYaw = 129.5 at 10 s, 10° outside [-119.5, 119.5]° (9.22780 to 10 s)".replace("9.22780", "9.2278") in text
    )
    document = report.as_dict()
    assert not document["ok"]
    assert document["violations"][0]["upper"] == pytest.approx(math.radians(119.5))
    assert "1 outside limits" in repr(report)


def test_many_stretches_are_all_found_on_both_sides(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    keys = np.where(np.arange(20_000) % 2, 0.5, rng.uniform(1.01, 1.2, 20_000))
    keys[4321] = 2.0  # which makes one stretch of the two beside it
    for values, extreme in ((keys, 2.0), (1.0 - keys, -1.0)):
        report = check(nao, nk.Motion(np.arange(20_000.0), ["LHand"], values[:, None]))
        assert len(report.violations) == 9999
        assert report.worst[0].value == extreme
        assert [row.start for row in report.violations] == sorted(row.start for row in report.violations)
        assert len(report.describe().splitlines()) < 10


def test_a_robot_without_speed_limits_is_never_too_fast(nao: nk.NaoModel) -> None:
    joints = tuple(replace(joint, velocity=math.inf) for joint in nao.tree.joints)
    robot = nk.RobotModel(replace(nao.tree, joints=joints))
    assert check(robot, nk.Motion([0.0, 1e-3], ["HeadYaw"], [[-1.0], [1.0]])).ok
    assert not check(nao, nk.Motion([0.0, 1e-3], ["HeadYaw"], [[-1.0], [1.0]])).ok


@pytest.mark.parametrize(
    ("arguments", "words"), [({"rate": 0.0}, "rate"), ({"missing": "Stood"}, "unknown posture 'Stood'")]
)
def test_bad_arguments_are_named(nao: nk.NaoModel, arguments: Any, words: str) -> None:
    motion = nk.Motion([0.0, 1.0], ["HeadYaw", "HeadPitch"], [[0.0, 0.0], [0.1, 0.1]], "bezier")
    with pytest.raises(nk.NaoKinError, match=words):
        check(nao, motion, **arguments)


def test_joints_of_another_robot_are_refused(nao: nk.NaoModel) -> None:
    with pytest.raises(nk.errors.UnknownName, match="HeadJaw"):
        check(nao, nk.Motion([0.0], ["HeadJaw"], [[0.0]]))


def test_two_fast_segments_beside_a_slow_one_are_two_stretches(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0, 0.1, 1.0, 1.1], ["HeadYaw"], [[0.0], [1.0], [1.1], [2.0]])
    rows = check(nao, motion).violations
    assert [(row.kind, row.start, row.end) for row in rows] == [("speed", 0.0, 0.1), ("speed", 1.0, 1.1)]


@pytest.mark.full
def test_a_million_keys_are_checked_and_sampled_in_seconds(nao: nk.NaoModel) -> None:
    times = np.arange(1_000_000) * 0.01
    keys = 0.2 * np.sin(times)
    motion = nk.Motion(times, ["HeadYaw", "HeadPitch"], np.stack([keys, keys], axis=-1))
    assert check(nao, motion).ok


@pytest.mark.parametrize("multiplier", [-2.0, -0.5, 0.5, 2.0])
def test_a_follower_is_as_fast_as_its_driver_times_the_size_of_its_multiplier(
    tmp_path: Path, multiplier: float
) -> None:
    robot = made_up(tmp_path, J("drive"), J("one", follows=("drive", multiplier, 0.1)))
    limit = 2.0 * min(1.0, abs(multiplier))  # of 2 rad/s each, the smaller confines the motor
    for sign in (-1.0, 1.0):
        keys = [[0.1], [0.1 + sign * 0.1 * limit]]
        assert check(robot, nk.Motion([0.0, 0.1001], ["one"], keys)).ok
        (row,) = check(robot, nk.Motion([0.0, 0.0999], ["one"], keys)).violations
        assert (row.kind, row.joint, row.lower, row.upper) == ("speed", "one", -limit, limit)
        slowed = slow_down(robot, nk.Motion([0.0, 0.05], ["one"], keys)).motion
        assert slowed.end == pytest.approx(0.1, rel=1e-6)


def test_a_coupled_limit_names_the_bound_that_is_passed_and_by_how_much(nao: nk.NaoModel) -> None:
    table = next(table for table in nao.coupled_limits if table.joint == "RAnkleRoll")
    of = 0.5 * float(table.at[1] + table.at[2])
    lower, upper = (float(np.interp(of, table.at, bound)) for bound in (table.lower, table.upper))
    for value, excess in ((lower - 0.02, 0.02), (upper + 0.03, 0.03)):
        motion = nk.Motion([0.0, 1.0], [table.of, table.joint], [[of, value]] * 2)
        (row,) = (row for row in check(nao, motion).violations if row.kind == "coupled limit")
        assert (row.value, row.of_value) == (pytest.approx(value), pytest.approx(of))
        assert (row.lower, row.upper) == (pytest.approx(lower), pytest.approx(upper))
        assert row.excess == pytest.approx(excess)
        assert f"{excess:.3g} rad outside [{row.lower:.6g}, {row.upper:.6g}] rad" in row.describe()


def test_two_followers_without_their_driver_are_held_against_each_other(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("drive"), J("one", follows=("drive", 2.0, 0.1)), J("two", follows=("drive", -0.5, 0.3)))
    driver = np.array([0.0, 0.2, -0.1])
    fits = nk.Motion([0.0, 5.0, 9.0], ["one", "two"], np.stack([2.0 * driver + 0.1, 0.3 - 0.5 * driver], axis=-1))
    assert not [row for row in check(robot, fits).violations if row.kind == "motor"]
    assert np.allclose(fits.configurations(robot).q[:, 0], driver, rtol=0, atol=1e-15)
    apart = nk.Motion([0.0, 5.0], ["one", "two"], [[0.1, 0.3], [0.1, 0.4]])
    (row,) = (row for row in check(robot, apart).violations if row.kind == "motor")
    assert (row.joint, row.of) == ("two", "one")
    assert row.excess == pytest.approx(0.1)
    for rule in get_args(nk.motion.Hips):
        assert not [
            row for row in check(robot, share_motors(robot, apart, rule).motion).violations if row.kind == "motor"
        ]


def test_overlapping_links_are_found_between_keys_and_only_if_asked() -> None:
    nao = nk.load_nao()
    motion = nk.Motion(
        [0.0, 1.0, 2.0, 3.0, 4.0],
        ["LShoulderRoll", "LElbowRoll"],
        [[0.2, -0.5], [-0.3, -1.4], [0.2, -0.5], [-0.3, -1.0], [0.2, -0.5]],
    )
    assert nk.motion.check(nao, motion).ok
    report = nk.motion.check(nao, motion, collisions=True, rate=100.0)
    assert not report.ok
    assert {violation.kind for violation in report.violations} == {"collision"}
    assert report.collisions_sampled == 100.0
    moves = motion.configurations(nao, rate=100.0)
    overlap = nao.clearance(moves.q).distance
    assert len(report.violations) == np.count_nonzero(np.diff((overlap < 0.0).astype(int)) == 1)
    for violation in report.violations:
        inside = (moves.times >= violation.start - 1e-9) & (moves.times <= violation.end + 1e-9)
        assert (overlap[inside] < 0.0).all()
        assert violation.excess == pytest.approx(-overlap[inside].min(), abs=1e-12)
        assert violation.describe().startswith(f"{violation.joint} and {violation.of} overlap by ")
        assert {violation.joint, violation.of} <= set(nao.link_names)
        assert violation.as_dict()["upper"] is None
    assert "with links that overlap" in report.describe()
    assert report.describe().endswith("collisions were sampled 100 times per second")
    assert nk.motion.check(nao, motion, collisions=True, missing="Crouch").violations[0].end == 4.0


# --- Recorded motions.


@pytest.mark.parametrize(("excess", "accepted"), [(0.0, 0), (np.radians(4.9), 1), (np.radians(5.1), None)])
def test_the_noise_of_sensors_is_accepted_by_name(nao: nk.NaoModel, excess: float, accepted: int | None) -> None:
    upper = nao.joints.limits("LShoulderRoll")[1]
    motion = nk.Motion([0.0, 1.0, 2.0], ["LShoulderRoll"], [[upper - 0.1], [upper + excess], [upper - 0.1]])
    strict, report = check(nao, motion), check(nao, motion, limits="measured")
    assert strict.accepted == ()
    assert strict.ok == (accepted == 0)
    assert report.ok == (accepted is not None)
    assert report.accepted == (strict.violations if accepted else ())
    assert report.as_dict()["accepted"] == [row.as_dict() for row in report.accepted]
    said = "accepted as measured: 1 joint, most LShoulderRoll"
    assert (said in report.describe(degrees=True)) == bool(accepted)


def test_only_limits_are_accepted_as_measured(nao: nk.NaoModel) -> None:
    fast = nk.Motion([0.0, 0.01], ["HeadYaw", "LHand"], [[0.0, 0.0], [1.0, 1.01]])
    report = check(nao, fast, limits="measured")
    assert {row.kind for row in report.violations} == {"speed"}
    assert [row.joint for row in report.accepted] == ["LHand"]
    # The head's pitch is limited by its yaw, too.
    yaw = 1.0
    (table,) = [table for table in nao.coupled_limits if table.joint == "HeadPitch"]
    highest = float(table.range(np.array(yaw))[1])
    for more, kinds in ((4.8, set()), (5.2, {"coupled limit"})):
        still = nk.Motion([0.0, 1.0], ["HeadYaw", "HeadPitch"], [[yaw, highest + np.radians(more)]] * 2)
        assert {row.kind for row in check(nao, still, limits="measured").violations} == kinds
    with pytest.raises(UnknownName, match="unknown limits .ignore."):
        check(nao, fast, limits="ignore")  # type: ignore[arg-type]


def test_a_motion_that_stands_on_an_edge_of_a_sole_falls_at_any_speed(nao: nk.NaoModel) -> None:
    t = 0.01 * np.arange(200)
    bent = nao.angles(nao.posture("Stand"))["LKneePitch"] - 0.2 * np.sin(0.5 * np.pi * t) ** 2
    q = nao.posture("Stand", LKneePitch=bent, limits="ignore")
    found = nk.world.dynamic_balance(nao, q, t)
    static = nk.world.balance(nao, q)
    lost = np.isnan(static.margin)
    assert 5 < lost.sum() < 50
    assert static.down.stands.all()
    assert (found.margin[lost] == -np.inf).all()
    assert (found.com_margin[lost] == -np.inf).all()
    assert (found.edge[lost] == -1).all()
    assert np.isfinite(found.margin[~lost]).all()
    motion = nk.Motion(t, nao.joint_names, q)
    report = nk.motion.check(nao, motion, balance=True)
    (fall,) = (row for row in report.violations if row.kind == "balance")
    assert fall.start == pytest.approx(t[lost][0], abs=0.02)
    assert "edge or a corner" in fall.describe()
    assert any("edge or a corner" in row.describe() for row in report.balance)
    with pytest.raises(BadArgument, match="falls at"):
        nk.motion.slow_down(nao, motion, balance=True)
