"""The virtual NAO's time, joints and tasks; stepped by hand."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument, NotFinite, UnknownName
from nao_kin.naoqi.conventions import robot_frame
from nao_kin.naoqi.virtual import Call, Event, Machine, MotionTask, NaoqiError, VirtualNao
from nao_kin.naoqi.virtual.engine import Clock

FAST_YAW = 8.26797  # rad/s, the maximum speed of HeadYaw in the published URDF


def _angle(nao: VirtualNao, joint: str, *, sensor: bool = True) -> float:
    (value,) = nao.call("ALMotion", "getAngles", joint, sensor)
    return value


def _smooth(share: float) -> float:
    """The cubic from 0 to 1 that is at rest at both ends."""
    return 3.0 * share**2 - 2.0 * share**3


def _log(nao: VirtualNao) -> list[str]:
    return [line for _, line in nao.log.lines]


# --- time -------------------------------------------------------------------------------------------------------------


def test_time_stands_still_until_it_is_stepped(asleep: VirtualNao) -> None:
    assert asleep.clock.now == 0.0
    time.sleep(0.03)
    assert asleep.clock.now == 0.0
    asleep.step(0.25)
    assert asleep.clock.now == 0.25


def test_parts_of_a_tick_add_up(asleep: VirtualNao) -> None:
    for _ in range(30):
        asleep.step(0.001)
    assert asleep.clock.ticks == 3
    asleep.step(0.0)
    assert asleep.clock.ticks == 3
    for _ in range(7):
        asleep.step(0.01 / 7)
    assert asleep.clock.ticks == 4


@pytest.mark.parametrize(
    ("step", "error"), [(-0.01, BadArgument), (1e30, BadArgument), (float("nan"), NotFinite), ("1", BadArgument)]
)
def test_no_other_step_is_taken(asleep: VirtualNao, step: object, error: type[Exception]) -> None:
    with pytest.raises(error, match="step"):
        asleep.step(step)  # type: ignore[arg-type]
    assert asleep.clock.now == 0.0


def test_a_running_clock_is_not_stepped(nao: nk.NaoModel) -> None:
    with VirtualNao(nao) as asleep, pytest.raises(BadArgument, match="stepped=True"):
        asleep.step(1.0)


@pytest.mark.parametrize("speed", [0.0, -1.0, float("inf"), "fast", None])
def test_a_speed_is_a_positive_number(speed: object) -> None:
    with pytest.raises((BadArgument, NotFinite), match="speed"):
        Clock(speed)  # type: ignore[arg-type]


def test_a_clock_keeps_up_with_the_wall_at_its_speed() -> None:
    clock = Clock(10.0)
    assert clock.due(100.0) == 0
    assert clock.due(100.0105) == 10
    assert clock.due(100.0105) == 0
    assert clock.due(100.02) == 10
    # After a sleep of the machine a second is made up for, and no more.
    assert clock.due(500.0) == 1000
    assert clock.due(500.01) == 10


def test_timers_go_off_in_their_order_and_may_be_cancelled() -> None:
    clock, done = Clock(), []
    clock.after(0.02, lambda: done.append("b"))
    clock.after(0.015, lambda: done.append("c"))
    clock.after(0.01, lambda: done.append("a"))
    clock.after(0.02, lambda: done.append("never")).cancel()
    for _ in range(3):
        for action in clock.tick():
            action()
    assert done == ["a", "b", "c"]


def test_scaled_time_runs_by_itself(nao: nk.NaoModel) -> None:
    with VirtualNao(nao, speed=20.0) as asleep:
        asleep.call("ALMotion", "wakeUp")
        begin = time.monotonic()
        asleep.call("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 4.0, True)
        took = time.monotonic() - begin
        assert _angle(asleep, "HeadYaw") == pytest.approx(0.5, abs=1e-9)
    assert took > 0.19


def test_the_same_calls_and_steps_give_the_same_angles_to_the_last_bit(nao: nk.NaoModel) -> None:
    def run() -> np.ndarray:
        found = []
        with VirtualNao(nao, stepped=True) as asleep:
            asleep.call("ALMotion", "wakeUp")
            asleep.post("ALRobotPosture", "goToPosture", "Stand", 0.4)
            for step in range(60):
                if step == 20:
                    asleep.call("ALMotion", "killAll")
                    asleep.call("ALMotion", "setAngles", "Head", [0.9, 0.4], 0.3)
                asleep.step(0.017)
                state = asleep.state()
                found.append(np.concatenate([state.q, state.command, state.T_world_torso.ravel()]))
        return np.array(found)

    assert np.array_equal(run(), run())


# --- joints -----------------------------------------------------------------------------------------------------------


def test_it_begins_in_crouch_without_stiffness(asleep: VirtualNao, nao: nk.NaoModel) -> None:
    state = asleep.state()
    assert np.array_equal(state.q, nao.clamp(nao.posture("Crouch")))
    assert np.array_equal(state.command, state.q)
    assert not state.stiffness.any()
    with pytest.raises(UnknownName, match="nearest: StandInit"):
        VirtualNao(nao, stepped=True, posture="StandInnit")


def test_only_a_nao_with_a_fixed_base_will_do() -> None:
    with pytest.raises(BadArgument, match="fixed base"):
        VirtualNao(nk.load_nao(base="floating"), stepped=True)


def test_without_stiffness_the_command_moves_and_the_joint_does_not(asleep: VirtualNao) -> None:
    asleep.call("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
    assert _angle(asleep, "HeadYaw", sensor=False) == pytest.approx(0.5, abs=1e-9)
    assert _angle(asleep, "HeadYaw") == 0.0
    assert [line for line in _log(asleep) if "HeadYaw without stiffness" in line]
    # When it gets some, it follows at its maximum speed.
    asleep.call("ALMotion", "setStiffnesses", "HeadYaw", 0.3)
    asleep.step(0.02)
    assert _angle(asleep, "HeadYaw") == pytest.approx(0.02 * FAST_YAW, abs=1e-9)
    asleep.step(0.05)
    assert _angle(asleep, "HeadYaw") == pytest.approx(0.5, abs=1e-9)


def test_watchers_are_told_once_of_each_chain_that_a_command_does_not_move(nao: nk.NaoModel) -> None:
    told: list[str] = []

    def watch(change: Event) -> None:
        if change.kind == "limp":
            told.append(change.value.partition(" without stiffness")[0].partition(": ")[2])

    with VirtualNao(nao, stepped=True, on_change=watch) as asleep:
        asleep.call("ALMotion", "setAngles", "HeadYaw", 0.1, 1.0)
        asleep.call("ALMotion", "setAngles", "HeadPitch", 0.1, 1.0)
        asleep.call("ALMotion", "angleInterpolation", ["Head", "LHand"], 0.1, 1.0, True)
        assert told == ["HeadYaw", "HeadYaw, HeadPitch, LHand"]
        asleep.call("ALMotion", "setStiffnesses", ["Head", "LShoulderPitch"], 1.0)
        asleep.call("ALMotion", "setAngles", ["Head", "LArm"], 0.1, 1.0)  # some of each chain moves
        asleep.call("ALMotion", "setStiffnesses", "Body", 0.0)
        assert len(told) == 2
        asleep.call("ALMotion", "setAngles", "HeadYaw", 0.1, 1.0)
        asleep.call("ALMotion", "moveTo", 0.1, 0.0, 0.0)
        assert [line.partition(",")[0] for line in told[2:]] == ["HeadYaw", "12 joints"]


def test_a_joint_asked_for_too_much_comes_late_and_the_log_says_so_once(awake: VirtualNao) -> None:
    call = awake.post("ALMotion", "angleInterpolation", "HeadYaw", 2.0, 0.1, True)
    awake.step(0.1)
    assert call.done()
    assert _angle(awake, "HeadYaw", sensor=False) == pytest.approx(2.0, abs=1e-9)
    late = [line for line in _log(awake) if "comes late" in line]
    assert len(late) == 1
    assert "HeadYaw" in late[0]
    assert _angle(awake, "HeadYaw") < 0.1 * FAST_YAW
    before = _angle(awake, "HeadYaw")
    awake.step(0.01)
    assert _angle(awake, "HeadYaw") - before == pytest.approx(0.01 * FAST_YAW, abs=1e-9)
    awake.step(0.3)
    assert _angle(awake, "HeadYaw") == 2.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_command_outside_its_box_is_clipped_and_the_log_says_so_once(
    awake: VirtualNao, nao: nk.NaoModel, side: float
) -> None:
    awake.call("ALMotion", "angleInterpolation", "HeadYaw", side * 3.0, 2.0, True)
    limit = nao.upper[0] if side > 0 else nao.lower[0]
    assert _angle(awake, "HeadYaw") == _angle(awake, "HeadYaw", sensor=False) == limit
    lines = [line for line in _log(awake) if "clipped" in line]
    assert len(lines) == 1
    assert f"HeadYaw = {side * 3:g}" in lines[0]


def test_a_coupled_limit_narrows_with_the_joint_it_depends_on(awake: VirtualNao, nao: nk.NaoModel) -> None:
    awake.call("ALMotion", "angleInterpolation", "HeadPitch", 0.51, 1.0, True)
    assert _angle(awake, "HeadPitch") == pytest.approx(0.51, abs=1e-9)
    awake.call("ALMotion", "angleInterpolation", "HeadYaw", 1.2, 1.0, True)
    table = next(table for table in nao.coupled_limits if table.joint == "HeadPitch")
    # On the way the range was narrower still at times; the joint has stayed where it was clipped to last.
    ways = np.linspace(0.0, 1.2, 2001)
    narrowest = min(float(table.range(np.array(yaw))[1]) for yaw in ways)
    assert narrowest - 1e-3 < _angle(awake, "HeadPitch") < narrowest + 5e-3
    assert len([line for line in _log(awake) if "HeadYaw narrows its range" in line]) == 1


def test_every_tick_stays_inside_all_limits(awake: VirtualNao, nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(5)
    for _ in range(12):
        body = (nao.to_body(nao.random(rng)) * rng.uniform(0.5, 2.0)).tolist()
        awake.call("ALMotion", "setAngles", "Body", body, float(rng.uniform(0.1, 1.0)))
        for _ in range(15):
            awake.step(0.01)
            assert nao.within_limits(awake.state().command)


def test_both_hips_are_one_motor_and_the_left_command_counts(awake: VirtualNao) -> None:
    both = ["LHipYawPitch", "RHipYawPitch"]
    awake.call("ALMotion", "angleInterpolation", both, [-0.4, -0.1], 1.0, True)
    assert awake.call("ALMotion", "getAngles", both, True) == pytest.approx([-0.4, -0.4], abs=1e-9)
    assert len([line for line in _log(awake) if "one motor" in line]) == 1
    awake.call("ALMotion", "angleInterpolation", "RHipYawPitch", -0.2, 1.0, True)
    assert awake.call("ALMotion", "getAngles", both, True) == pytest.approx([-0.2, -0.2], abs=1e-9)
    awake.call("ALMotion", "setStiffnesses", "RHipYawPitch", 0.0)
    assert awake.call("ALMotion", "getStiffnesses", both) == [0.0, 0.0]


def test_what_is_read_is_a_copy(awake: VirtualNao) -> None:
    awake.joints.sensor[:] = 7.0
    awake.joints.command[:] = 7.0
    awake.joints.stiffness[:] = 7.0
    awake.state().q[:] = 7.0
    assert max(awake.call("ALMotion", "getAngles", "Body", True)) < 7.0
    assert set(awake.call("ALMotion", "getStiffnesses", "Body")) == {1.0}


# --- tasks ------------------------------------------------------------------------------------------------------------


def test_a_later_interpolation_of_a_booked_joint_waits_until_it_is_free(awake: VirtualNao) -> None:
    first = awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
    later = awake.post("ALMotion", "angleInterpolation", ["HeadYaw", "HeadPitch"], [0.1, -0.2], [0.5, 0.25], True)
    assert awake.call("ALMotion", "getTaskList") == [["angleInterpolation", 1], ["angleInterpolation", 2]]
    awake.step(0.99)
    assert not first.done()
    assert _angle(awake, "HeadPitch") == pytest.approx(0.1, abs=1e-6)  # that of Crouch
    awake.step(0.01)
    assert first.done()
    assert _angle(awake, "HeadYaw") == pytest.approx(0.5, abs=1e-9)
    assert not later.done()
    awake.step(0.25)
    assert _angle(awake, "HeadYaw") == pytest.approx(0.5 - 0.4 * _smooth(0.5), abs=1e-9)
    assert _angle(awake, "HeadPitch") == pytest.approx(-0.2, abs=1e-9)
    awake.step(0.24)
    assert not later.done()
    awake.step(0.01)
    assert later.done()
    assert awake.call("ALMotion", "getTaskList") == []
    assert [line for line in _log(awake) if "waits for HeadYaw" in line]


def test_who_waits_is_not_overtaken_by_who_came_later(awake: VirtualNao) -> None:
    awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
    both = awake.post("ALMotion", "angleInterpolation", "Head", 0.2, 1.0, True)
    pitch = awake.post("ALMotion", "angleInterpolation", "HeadPitch", -0.1, 1.0, True)
    awake.step(2.0)
    assert both.done()
    assert not pitch.done()
    awake.step(1.0)
    assert pitch.done()
    assert awake.call("ALMotion", "getAngles", "Head", True) == pytest.approx([0.2, -0.1], abs=1e-9)


def test_a_killed_task_stays_where_it_is_and_its_call_ends_without_an_error(awake: VirtualNao) -> None:
    call = awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
    waiting = awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.0, 1.0, True)
    awake.step(0.5)
    (first, _) = awake.call("ALMotion", "getTaskList")
    assert awake.call("ALMotion", "isRunning", first[1])
    assert awake.call("ALMotion", "killTask", first[1]) is True
    assert awake.call("ALMotion", "killTask", first[1]) is False
    assert not awake.call("ALMotion", "isRunning", first[1])
    assert call.done()
    assert call.result() is None
    assert _angle(awake, "HeadYaw") == pytest.approx(0.25, abs=1e-9)
    awake.step(1.0)  # which begins where the first was left
    assert waiting.done()
    assert _angle(awake, "HeadYaw") == pytest.approx(0.0, abs=1e-9)


def test_killing_by_joint_takes_those_that_wait_too(awake: VirtualNao) -> None:
    calls = [awake.post("ALMotion", "angleInterpolation", "Head", 0.1, 1.0, True) for _ in range(3)]
    other = awake.post("ALMotion", "angleInterpolation", "LWristYaw", 0.1, 1.0, True)
    assert not awake.call("ALMotion", "areResourcesAvailable", ["HeadPitch"])
    assert awake.call("ALMotion", "areResourcesAvailable", ["RWristYaw"])
    awake.call("ALMotion", "killTasksUsingResources", ["HeadPitch"])
    assert all(call.done() for call in calls)
    assert not other.done()
    assert awake.call("ALMotion", "areResourcesAvailable", ["HeadPitch"])
    awake.call("ALMotion", "killAll")
    assert other.done()


def test_cancelling_a_call_kills_its_task(awake: VirtualNao) -> None:
    call = awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
    assert call.cancel()
    assert call.done()
    assert not call.cancel()
    assert awake.call("ALMotion", "getTaskList") == []


def test_reactive_commands_replace_each_other_joint_by_joint(awake: VirtualNao) -> None:
    awake.call("ALMotion", "setAngles", "Head", [1.0, -0.3], 0.1)
    awake.step(0.1)
    assert _angle(awake, "HeadYaw") == pytest.approx(0.01 * FAST_YAW, abs=1e-9)
    awake.call("ALMotion", "setAngles", "HeadYaw", 0.0, 0.1)
    awake.step(0.1)
    assert _angle(awake, "HeadYaw") == pytest.approx(0.0, abs=1e-9)
    pitch = _angle(awake, "HeadPitch")
    assert pitch == pytest.approx(0.1 - 0.2 * 0.1 * 7.19407, abs=1e-6)
    awake.step(1.0)
    assert _angle(awake, "HeadPitch") == pytest.approx(-0.3, abs=1e-9)
    assert awake.call("ALMotion", "getTaskList") == []


def test_reactive_commands_book_nothing_and_wait_for_who_did(awake: VirtualNao) -> None:
    awake.call("ALMotion", "setAngles", "HeadYaw", 1.0, 0.01)
    assert awake.call("ALMotion", "areResourcesAvailable", ["HeadYaw"])
    call = awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)  # takes the joint at once
    awake.step(0.5)
    awake.call("ALMotion", "setAngles", "HeadYaw", -0.5, 1.0)  # waits
    awake.call("ALMotion", "setAngles", "HeadYaw", 0.4, 1.0)  # in its place
    awake.step(0.5)
    assert call.done()
    assert _angle(awake, "HeadYaw") == pytest.approx(0.5, abs=1e-9)
    awake.step(0.1)
    assert _angle(awake, "HeadYaw") == pytest.approx(0.4, abs=1e-9)
    assert awake.call("ALMotion", "getTaskList") == []


def test_killing_by_joint_spares_what_has_booked_nothing(awake: VirtualNao) -> None:
    awake.call("ALMotion", "setAngles", "HeadYaw", 1.0, 0.1)
    awake.call("ALMotion", "killTasksUsingResources", ["HeadYaw"])
    assert [task[0] for task in awake.call("ALMotion", "getTaskList")] == ["setAngles"]
    awake.call("ALMotion", "killAll")
    assert awake.call("ALMotion", "getTaskList") == []


def test_waiting_for_a_task_ends_with_it_or_with_the_time(awake: VirtualNao) -> None:
    awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
    assert awake.call("ALMotion", "wait", 1, 200) is True
    assert awake.clock.now == 0.2
    assert awake.call("ALMotion", "wait", 1, 0) is False
    assert awake.clock.now == 1.0
    assert awake.call("ALMotion", "wait", 1, 0) is False
    awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.0, 1.0, True)
    awake.call("ALMotion", "stop", 2)
    assert awake.call("ALMotion", "getTaskList") == []


class _Broken(MotionTask):
    ended = 0

    def advance(self, nao: Machine, time: float) -> bool:
        raise RuntimeError("broken on purpose")

    def end(self, nao: VirtualNao, *, killed: bool) -> None:
        self.ended += 1
        raise RuntimeError("broken here too")


def test_a_broken_task_fails_alone(awake: VirtualNao) -> None:
    with awake.monitor:
        broken = _Broken("nod", ["HeadPitch"])
        call = awake.tasks.add(broken)
    other = awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
    awake.step(1.0)
    assert other.done()
    with pytest.raises(NaoqiError, match=r"ALMotion::nod\n\tbroken on purpose"):
        call.result()
    assert awake.call("ALMotion", "areResourcesAvailable", ["HeadPitch"])
    assert broken.ended == 1


def test_a_broken_timer_does_not_stop_time(awake: VirtualNao) -> None:
    awake.clock.after(0.1, lambda: 1 / 0)
    waiting = awake.post("ALTextToSpeech", "say", "on")
    awake.step(1.0)
    assert waiting.done()
    assert any("internal error: ZeroDivisionError" in line for _, line in awake.log.lines)


# --- watching, threads, the end ---------------------------------------------------------------------------------------


def test_whoever_watches_may_call_back_and_may_fail(nao: nk.NaoModel, caplog: pytest.LogCaptureFixture) -> None:
    seen: list[Event] = []

    def watch(change: Event) -> None:
        assert not asleep.monitor._lock._is_owned()  # type: ignore[attr-defined]
        asleep.call("ALMotion", "getAngles", "Body", True)
        seen.append(change)
        if change.kind == "speech":
            raise RuntimeError("on purpose")

    with VirtualNao(nao, stepped=True, on_change=watch) as asleep:
        asleep.call("ALMotion", "wakeUp")
        asleep.call("ALTextToSpeech", "say", "hello")
        asleep.call("ALLeds", "fadeRGB", "ChestLeds", "red", 0.0)
    kinds = [change.kind for change in seen]
    assert kinds == ["awake", "speech", "log", "speech", "leds"]
    assert seen[-1].value == {"ChestLeds": (1.0, 0.0, 0.0)}
    assert "a callback of the virtual NAO failed" in caplog.text


def test_states_are_of_one_moment(nao: nk.NaoModel) -> None:
    with VirtualNao(nao, speed=50.0) as asleep:
        asleep.call("ALMotion", "wakeUp")
        asleep.post("ALMotion", "angleInterpolation", ["HeadYaw", "LWristYaw"], [1.0, 1.0], 20.0, True)
        wrist = nao.joint_names.index("LWristYaw")
        start = float(nao.posture("Crouch")[wrist])
        for _ in range(50):
            q = asleep.state().q
            share = q[0]  # of the way from 0 to 1
            assert q[wrist] == pytest.approx(start + share * (1.0 - start), abs=1e-9)


def test_many_threads_may_call(nao: nk.NaoModel) -> None:
    failures: list[BaseException] = []

    def work(joint: str) -> None:
        try:
            for step in range(20):
                asleep.call("ALMotion", "angleInterpolation", joint, 0.01 * step, 0.05, True)
                assert _angle(asleep, joint) == pytest.approx(0.01 * step, abs=1e-9)
        except BaseException as error:
            failures.append(error)

    with VirtualNao(nao, speed=50.0) as asleep:
        asleep.call("ALMotion", "wakeUp")
        threads = [threading.Thread(target=work, args=(joint,)) for joint in ("HeadYaw", "HeadPitch", "LWristYaw")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert not failures


def test_closing_answers_whoever_waits(nao: nk.NaoModel) -> None:
    asleep = VirtualNao(nao)
    asleep.call("ALMotion", "wakeUp")
    calls: list[Call] = [
        asleep.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 100.0, True),
        asleep.post("ALTextToSpeech", "say", "a long story " * 100),
    ]
    threads = threading.active_count()
    asleep.close()
    asleep.close()
    assert threading.active_count() == threads - 1
    for call in calls:
        with pytest.raises(BadArgument, match="closed"):
            call.result(timeout=1.0)
    with pytest.raises(NaoqiError, match="closed"):
        asleep.call("ALMotion", "getAngles", "Body", True)


def test_a_stepped_call_without_an_end_says_so(awake: VirtualNao, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nao_kin.naoqi.virtual.virtual_nao.MAX_SECONDS", 1.0)
    with pytest.raises(NaoqiError, match="no answer within 1 s"):
        awake.call("ALMemory", "getDataOnChange", "never")
    with pytest.raises(UnknownName, match="nearest: ALMotion"):
        awake.call("ALMotionn", "wakeUp")


# --- where the torso is -----------------------------------------------------------------------------------------------


def test_it_begins_with_frame_robot_at_the_worlds_origin(nao: nk.NaoModel) -> None:
    for posture in ("Stand", "Crouch", "StandInit"):
        with VirtualNao(nao, stepped=True, posture=posture) as asleep:
            T_world_torso = asleep.state().T_world_torso
            T_world_robot = robot_frame(nao, asleep.state().q, torso_in_world=T_world_torso)
            T_world_robot[2, 3] = 0.0  # the lower of the two soles, which need not be the one that stands
            assert np.allclose(T_world_robot, np.eye(4), atol=1e-12)
            T_world_sole = T_world_torso @ nao.fk(asleep.state().q, "LLeg")
            assert T_world_sole[2, 3] == pytest.approx(0.0, abs=1e-12)
            assert np.allclose(T_world_sole[2, :3], [0.0, 0.0, 1.0], atol=1e-12)


STANDING = ("Crouch", "Stand", "StandInit", "StandZero")


@pytest.mark.parametrize(("target", "overshoot"), [(0.9, 0.0), (2.0, 0.0), (0.0, 0.05), (0.5, 0.05)])
def test_an_interpolation_after_a_killed_one_begins_with_its_velocity(
    awake: VirtualNao, target: float, overshoot: float
) -> None:
    awake.post("ALMotion", "angleInterpolation", "HeadYaw", 1.0, 2.0, True)
    awake.step(1.0)
    assert _angle(awake, "HeadYaw") == pytest.approx(0.5)
    (task,) = awake.call("ALMotion", "getTaskList")
    awake.call("ALMotion", "killTask", task[1])
    call = awake.post("ALMotion", "angleInterpolation", "HeadYaw", target, 1.5, True)
    way = []
    while not call.done():
        awake.step(0.01)
        way.append(_angle(awake, "HeadYaw"))
    # A smooth movement by 1 rad in 2 s has 1.5 times its mean velocity in the middle; the joint may brake at once.
    assert (0.3 if overshoot else 0.7) < (way[0] - 0.5) / 0.01 < 0.76
    assert way[-1] == pytest.approx(target, abs=1e-9)
    assert len(way) == 150
    assert max(way) <= max(target, 0.5) + overshoot
    # One tick later, the joint stands.
    awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
    awake.step(0.5)
    awake.call("ALMotion", "killAll")
    awake.step(0.01)
    stands = _angle(awake, "HeadYaw")
    awake.post("ALMotion", "angleInterpolation", "HeadYaw", 0.0, 1.0, True)
    awake.step(0.01)
    assert _angle(awake, "HeadYaw") == pytest.approx(stands, abs=1e-3)


@pytest.mark.parametrize("rest", ["Sit", "SitRelax", "LyingBelly", "LyingBack"])
def test_a_robot_stands_up_where_it_stood(nao: nk.NaoModel, rest: str) -> None:
    with VirtualNao(nao, stepped=True) as asleep:
        asleep.call("ALMotion", "wakeUp")
        for standing in ("Stand", "Crouch", "StandInit"):
            asleep.call("ALRobotPosture", "goToPosture", rest, 1.0)
            asleep.call("ALRobotPosture", "goToPosture", standing, 1.0)
            assert np.abs(asleep.call("ALMotion", "getRobotPosition", True)).max() < 1e-9


@pytest.mark.parametrize("posture", STANDING)
def test_a_posture_does_not_turn_the_robot_while_both_soles_are_down(nao: nk.NaoModel, posture: str) -> None:
    with VirtualNao(nao, stepped=True, posture=posture) as asleep:
        asleep.call("ALMotion", "wakeUp")
        for other in STANDING[STANDING.index(posture) :]:
            for wanted in (other, posture):
                call = asleep.post("ALRobotPosture", "goToPosture", wanted, 1.0)
                while not call.done():
                    asleep.step(0.03)
                    assert np.abs(asleep.call("ALMotion", "getRobotPosition", True)).max() < 1e-9
                assert call.result() is True
        asleep.call("ALMotion", "rest")
        assert np.abs(asleep.call("ALMotion", "getRobotPosition", True)).max() < 1e-9


def test_arms_and_head_leave_the_feet_where_they_are_to_the_last_bit(awake: VirtualNao) -> None:
    before = awake.state().T_world_torso
    awake.call("ALMotion", "angleInterpolation", ["HeadYaw", "LShoulderPitch"], [1.0, 0.3], 1.0, True)
    assert np.array_equal(awake.state().T_world_torso, before)


def test_the_standing_foot_stays_where_it_is_while_the_other_is_lifted(awake: VirtualNao, nao: nk.NaoModel) -> None:
    lifted = {"RHipPitch": -0.9, "RKneePitch": 1.4}
    awake.call("ALRobotPosture", "goToPosture", "StandInit", 1.0)
    awake.call("ALMotion", "angleInterpolation", list(lifted), list(lifted.values()), 0.5, True)
    foot = awake.base.support
    assert foot == "LLeg"
    T_world_foot = awake.state().T_world_torso @ nao.fk(awake.state().q, foot)
    awake.post(
        "ALMotion", "angleInterpolation", ["RHipPitch", "RHipRoll", "LHipYawPitch"], [-1.2, -0.3, -0.1], 1.0, True
    )
    for _ in range(20):
        awake.step(0.04)
        state = awake.state()
        assert np.allclose(state.T_world_torso @ nao.fk(state.q, foot), T_world_foot, atol=1e-12)
        assert awake.base.support == foot


def test_feet_inclined_to_each_other_do_not_take_turns(nao: nk.NaoModel) -> None:
    with VirtualNao(nao, stepped=True, posture="Crouch") as asleep:
        q = asleep.state().q
        T_left_right = np.linalg.inv(nao.fk(q, "LLeg")) @ nao.fk(q, "RLeg")
        assert T_left_right[2, 3] < -1e-3
        assert np.linalg.inv(T_left_right)[2, 3] < -1e-3
        assert asleep.base.standing_foot(q, "LLeg") == "LLeg"
        assert asleep.base.standing_foot(q, "RLeg") == "RLeg"


def test_the_other_foot_takes_over_where_its_sole_is_lower(awake: VirtualNao, nao: nk.NaoModel) -> None:
    awake.call("ALRobotPosture", "goToPosture", "StandInit", 1.0)
    awake.call("ALMotion", "angleInterpolation", ["LHipPitch", "LKneePitch"], [-1.0, 1.6], 1.0, True)  # lift the left
    assert awake.base.support == "RLeg"
    state = awake.state()
    T_world_right, T_world_left = (state.T_world_torso @ nao.fk(state.q, foot) for foot in ("RLeg", "LLeg"))
    assert T_world_right[2, 3] == pytest.approx(0.0, abs=1e-12)
    assert np.allclose(T_world_right[2, :3], [0.0, 0.0, 1.0], atol=1e-12)
    assert T_world_left[2, 3] > 0.05


@pytest.mark.parametrize("posture", ["Sit", "SitRelax", "LyingBack", "LyingBelly"])
def test_a_posture_on_the_floor_has_its_own_vertical_and_leads_back_to_the_feet(
    awake: VirtualNao, nao: nk.NaoModel, posture: str
) -> None:
    heading = awake.state().T_world_torso
    call = awake.post("ALRobotPosture", "goToPosture", posture, 0.5)
    heights = [awake.state().T_world_torso[2, 3]]
    while not call.done():
        awake.step(0.01)
        heights.append(awake.state().T_world_torso[2, 3])
    assert call.result() is True
    assert np.abs(np.diff(heights)).max() < 0.02  # no leap
    T_world_torso = awake.state().T_world_torso
    up = np.array(nao.semantics.postures[posture].up)
    assert np.allclose(T_world_torso[2, :3], up / np.linalg.norm(up), atol=1e-9)
    assert np.allclose(T_world_torso[:2, 3], heading[:2, 3], atol=1e-9)
    joints = T_world_torso @ nao.fk(awake.state().q, list(nao.body_order))
    assert 0.02 < joints[:, 2, 3].min() < 0.06  # inside the shapes that are on the floor
    assert awake.call("ALRobotPosture", "goToPosture", "StandInit", 0.5) is True
    state = awake.state()
    T_world_sole = state.T_world_torso @ nao.fk(state.q, awake.base.support)
    assert T_world_sole[2, 3] == pytest.approx(0.0, abs=1e-9)
    assert np.allclose(T_world_sole[2, :3], [0.0, 0.0, 1.0], atol=1e-9)


def test_who_is_stopped_while_getting_up_is_not_on_its_feet(awake: VirtualNao) -> None:
    awake.call("ALRobotPosture", "goToPosture", "LyingBack", 1.0)
    lying = awake.state().T_world_torso[2, 0]
    call = awake.post("ALRobotPosture", "goToPosture", "StandInit", 0.2)
    awake.step(0.3)
    awake.call("ALRobotPosture", "stopMove")
    assert call.result(0) is False
    assert awake.base.support is None
    assert 0.1 < awake.state().T_world_torso[2, 0] < lying
    awake.step(0.5)
    assert awake.base.support is None


def test_it_may_begin_on_its_back(nao: nk.NaoModel) -> None:
    with VirtualNao(nao, stepped=True, posture="LyingBack") as asleep:
        assert asleep.state().T_world_torso[2, 0] > 0.99
        assert asleep.call("ALRobotPosture", "getPostureFamily") == "LyingBack"
