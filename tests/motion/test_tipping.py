"""Motions that tip the robot: the check, the report, slower motions, diagrams, and the command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument

TIMES = np.linspace(0.0, 2.0, 101)


def rocking(nao: nk.NaoModel, size: float) -> nk.Motion:
    """Rock about the ankles, from rest to rest."""
    pitch = -size * np.sin(3.5 * np.pi * TIMES) * np.sin(0.5 * np.pi * TIMES) ** 2
    q = nao.posture("Stand", LAnklePitch=pitch, RAnklePitch=pitch, limits="clamp")
    return nk.Motion(TIMES, nao.joint_names, q, interpolation="smooth")


def test_a_slow_gesture_is_safe_and_a_fast_one_tips(nao: nk.NaoModel) -> None:
    safe = nk.motion.check(nao, rocking(nao, 0.02), balance=True)
    assert safe.ok
    (part,) = safe.balance
    assert part.soles == ("LLeg", "RLeg")
    assert 0.0 < part.margin < part.com_margin
    assert part.rocking == 0.0
    tips = nk.motion.check(nao, rocking(nao, 0.15), balance=True)
    assert {row.kind for row in tips.violations} == {"balance"}
    assert {row.of for row in tips.violations} <= {"front", "back"}
    worst = max(tips.violations, key=lambda row: row.excess)
    assert worst.of_value == pytest.approx(tips.balance[0].margin)
    assert worst.value == tips.balance[0].rocking > worst.upper == pytest.approx(np.radians(5.0))
    assert worst.start < worst.time <= worst.end
    assert "falls over the" in tips.describe()
    rocks = nk.motion.check(nao, rocking(nao, 0.07), balance=True)
    assert rocks.ok
    assert rocks.balance[0].margin < 0.0
    assert "rocks by" in rocks.describe()
    assert not nk.motion.check(nao, rocking(nao, 0.15)).balance


def test_a_motion_that_is_slowed_down_for_balance_does_not_tip(nao: nk.NaoModel) -> None:
    motion = rocking(nao, 0.15)
    mended = nk.motion.slow_down(nao, motion, balance=True)
    assert nk.motion.check(nao, mended.motion, balance=True).ok
    (change,) = mended.changes
    longer = mended.motion.duration - motion.duration
    assert longer == pytest.approx((change.amount - 1.0) * (change.end - change.start), rel=1e-6)
    assert 0.0 < longer < motion.duration
    assert change.start > motion.start  # time is stretched where it tips
    safe = rocking(nao, 0.02)
    assert nk.motion.slow_down(nao, safe, balance=True).motion is safe


def test_a_motion_that_falls_at_any_speed_says_so(nao: nk.NaoModel) -> None:
    bow = nk.Motion([0.0, 3.0], ["LAnklePitch", "RAnklePitch"], [[0.0, 0.0], [0.6, 0.6]])
    report = nk.motion.check(nao, bow, missing="Stand", balance=True)
    assert report.violations[0].of == "back"
    assert report.as_dict()["balance"][0]["rocking"] == pytest.approx(0.5)
    with pytest.raises(BadArgument, match="falls at .* slowly: .* mm outside"):
        nk.motion.slow_down(nao, bow, balance=True, missing="Stand")


def test_intervals_follow_the_soles(nao: nk.NaoModel) -> None:
    lift = nk.motion.complete(nao, nk.Motion([0.0, 1.0, 2.0], ["RKneePitch"], [[0.2], [1.2], [0.2]]), "Stand")
    report = nk.motion.check(nao, lift, balance=True)
    assert any(part.soles != ("LLeg", "RLeg") for part in report.balance)
    assert report.balance[0].start == 0.0
    assert report.balance[-1].end == pytest.approx(2.0)


def test_the_balance_of_at_most_an_hour_is_sampled(nao: nk.NaoModel) -> None:
    with pytest.raises(BadArgument, match="hour"):
        nk.motion.time_warp(rocking(nao, 0.15), 1e5).balance(nao)


def test_the_command_tells_tips_and_slows_down(nao: nk.NaoModel, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    path, slower = str(tmp_path / "rock.json"), str(tmp_path / "slower.json")
    nk.motion.write_motion(rocking(nao, 0.15), path)
    assert run(["motion", "check", path, "--balance"]) == 1
    assert "falls over the" in capsys.readouterr().out
    assert run(["motion", "check", path, "--balance", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["balance"][0]["soles"] == ["LLeg", "RLeg"]
    assert run(["motion", "convert", path, slower, "--slow-down", "--balance"]) == 0
    assert run(["motion", "check", slower, "--balance"]) == 0
    assert "balance: 0 to" in capsys.readouterr().out
    assert run(["motion", "convert", path, slower, "--balance", "--force"]) == 2
    assert "--slow-down" in capsys.readouterr().err


def test_margins_are_drawn(nao: nk.NaoModel) -> None:
    figure = nk.motion.plot(nao, rocking(nao, 0.15), joints=["LAnklePitch"], balance=True)
    axes = figure.axes[1]
    assert axes.get_title() == "balance: margin [mm]"
    assert min(axes.lines[1].get_ydata()) < 0.0
    assert axes.patches


def test_the_balance_of_a_motion_is_that_of_the_joints_it_does_not_name(nao: nk.NaoModel) -> None:
    nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
    found = nod.balance(nao, missing="Crouch")
    heights = [nk.world.balance(nao, nao.posture(name)).com[2] for name in ("Crouch", "StandZero")]
    assert found.com[0, 2] == pytest.approx(heights[0], abs=1e-3)
    assert abs(heights[0] - heights[1]) > 0.01
    later = nk.Motion([3.0, 3.5, 4.0], ["HeadPitch"], [[0.0], [0.3], [0.0]]).balance(nao, missing="Crouch")
    np.testing.assert_allclose(later.times, found.times + 3.0)
    np.testing.assert_allclose(later.margin, found.margin, atol=1e-9)
    pytest.importorskip("matplotlib")
    drawn = nk.motion.plot(nao, nod, balance=True, missing="Crouch").axes[-1].get_lines()
    assert any(np.allclose(np.nanmin(line.get_ydata()), 1e3 * np.nanmin(found.margin), atol=1e-6) for line in drawn)


def test_speeds_are_drawn_in_degrees_per_second(nao: nk.NaoModel) -> None:
    pytest.importorskip("matplotlib")
    turn = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
    (axes,) = nk.motion.plot(nao, turn, speed=True).axes
    np.testing.assert_allclose(axes.get_lines()[0].get_ydata(), np.degrees(0.5), atol=1e-9)
    assert axes.get_title() == "HeadYaw [°/s]"
