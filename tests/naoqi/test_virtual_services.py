"""The services of the virtual NAO, called as scripts call them; stepped by hand."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest
from loops import full
from scipy.interpolate import PchipInterpolator
from scipy.spatial import ConvexHull

import nao_kin as nk
from nao_kin._kernels import cache
from nao_kin._kernels.cache import CachedKernel
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.naoqi.conventions import robot_frame
from nao_kin.naoqi.virtual import NaoqiError, Service, VirtualNao
from nao_kin.naoqi.virtual.virtual_nao import Missing


def _motion(nao: VirtualNao, method: str, *arguments: Any) -> Any:
    return nao.call("ALMotion", method, *arguments)


def _angles(nao: VirtualNao, names: Any) -> list[float]:
    return _motion(nao, "getAngles", names, True)


# --- ALMotion: joints -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("names", "count"),
    [("HeadYaw", 1), ("Head", 2), ("LArm", 6), ("Body", 26), ("Joints", 24), ("Actuators", 2), (["Head", "LHand"], 3)],
)
def test_names_are_joints_chains_groups_or_lists_of_them(awake: VirtualNao, names: Any, count: int) -> None:
    assert len(_angles(awake, names)) == count
    assert len(_motion(awake, "getStiffnesses", names)) == count
    if isinstance(names, str):
        assert len(_motion(awake, "getBodyNames", names)) == len(_motion(awake, "getLimits", names)) == count


def test_limits_are_those_of_the_robot(awake: VirtualNao, nao: nk.NaoModel) -> None:
    lower, upper, speed, torque = _motion(awake, "getLimits", "HeadYaw")[0]
    assert (lower, upper, speed, torque) == (nao.lower[0], nao.upper[0], nao.velocity_limits[0], nao.effort_limits[0])
    assert _motion(awake, "getBodyNames", "Chains") == ["Head", "LArm", "LLeg", "RLeg", "RArm"]
    assert _motion(awake, "getJointNames", "Body") == list(nao.body_order)


@pytest.mark.full
@pytest.mark.parametrize(
    ("names", "angles", "times", "expected"),
    [
        ("HeadYaw", 0.5, 1.0, {"HeadYaw": ([1.0], [0.5])}),
        ("HeadYaw", [0.5], [1.0], {"HeadYaw": ([1.0], [0.5])}),
        ("HeadYaw", [0.5, -0.2, 0.1], [0.5, 1.0, 2.0], {"HeadYaw": ([0.5, 1.0, 2.0], [0.5, -0.2, 0.1])}),
        (["HeadYaw"], [[0.5, -0.2]], [[0.5, 1.0]], {"HeadYaw": ([0.5, 1.0], [0.5, -0.2])}),
        ("Head", [0.5, -0.2], [1.0, 1.5], {"HeadYaw": ([1.0], [0.5]), "HeadPitch": ([1.5], [-0.2])}),
        (["HeadYaw", "HeadPitch"], [0.5, -0.2], 2, {"HeadYaw": ([2.0], [0.5]), "HeadPitch": ([2.0], [-0.2])}),
        ("Head", 0.25, 1.0, {"HeadYaw": ([1.0], [0.25]), "HeadPitch": ([1.0], [0.25])}),
        (
            ["HeadYaw", "LWristYaw"],
            [[0.5, 0.0], [-0.3, 0.3, 1.0]],
            [[0.4, 0.8], [0.3, 0.6, 1.2]],
            {"HeadYaw": ([0.4, 0.8], [0.5, 0.0]), "LWristYaw": ([0.3, 0.6, 1.2], [-0.3, 0.3, 1.0])},
        ),
    ],
)
@pytest.mark.parametrize("absolute", [True, False, 1])
def test_interpolation_passes_every_key_at_its_time(
    awake: VirtualNao, names: Any, angles: Any, times: Any, absolute: Any, expected: dict[str, Any]
) -> None:
    start = dict(zip(expected, _angles(awake, list(expected)), strict=True))
    first = {joint: 0.0 if absolute else start[joint] for joint in expected}
    call = awake.post("ALMotion", "angleInterpolation", names, angles, times, absolute)
    end = max(row[0][-1] for row in expected.values())
    while not call.done():
        awake.step(0.05)
        for joint, (at, keys) in expected.items():
            values = [start[joint], *(np.array(keys) + first[joint])]
            (shown,) = _motion(awake, "getAngles", joint, False)
            # scipy's monotone cubic has other slopes at the ends: it is compared at the keys alone.
            curve = PchipInterpolator([0.0, *at], values)
            if any(abs(awake.clock.now - key) < 1e-9 for key in at) or awake.clock.now > at[-1]:
                assert shown == pytest.approx(float(curve(min(awake.clock.now, at[-1]))), abs=1e-9)
            assert min(values) - 1e-9 <= shown <= max(values) + 1e-9
    assert awake.clock.now == pytest.approx(end, abs=1e-9)
    for joint, (_, keys) in expected.items():
        assert _angles(awake, joint) == [keys[-1] + first[joint]]


def test_between_keys_the_curve_is_smooth(awake: VirtualNao) -> None:
    """Three keys in one direction: a monotone cubic with Fritsch and Butland's slope in the middle."""
    awake.post("ALMotion", "angleInterpolation", "HeadYaw", [0.2, 0.8], [1.0, 2.0], True)
    awake.step(1.5)
    before, after = 0.2, 0.6  # slopes of the two straight lines
    slope = 2.0 / (1.0 / before + 1.0 / after)
    expected = 0.5 * (0.2 + 0.8) + slope / 8.0  # Hermite's cubic half way, at rest at the end
    assert _angles(awake, "HeadYaw") == pytest.approx([expected], abs=1e-9)


def test_with_speed_the_longest_way_sets_the_time_and_all_arrive_together(awake: VirtualNao) -> None:
    _motion(awake, "angleInterpolation", "Head", 0.0, 0.5, True)
    begin = awake.clock.now
    call = awake.post("ALMotion", "angleInterpolationWithSpeed", ["HeadYaw", "HeadPitch"], [1.0, -0.2], 0.1)
    duration = 1.0 / (0.1 * 8.26797)
    awake.step(0.5)
    assert _angles(awake, "Head") == pytest.approx([0.5 / duration, -0.1 / duration], abs=1e-9)
    awake.step(0.70)
    assert not call.done()
    awake.step(0.01)
    assert call.done()
    assert awake.clock.now - begin == pytest.approx(np.ceil(duration * 100) / 100, abs=1e-9)
    assert _angles(awake, "Head") == [1.0, -0.2]
    begin = awake.clock.now
    _motion(awake, "angleInterpolationWithSpeed", "Head", [1.0, -0.2], 0.1)  # where it is
    assert awake.clock.now - begin <= 0.01 + 1e-9


def test_set_angles_goes_at_a_fraction_of_each_joints_speed(awake: VirtualNao) -> None:
    _motion(awake, "angleInterpolation", "Head", 0.0, 0.5, True)
    assert _motion(awake, "setAngles", "Head", [1.0, -0.3], 0.2) is None
    awake.step(0.1)
    assert _angles(awake, "Head") == pytest.approx([0.02 * 8.26797, -0.02 * 7.19407], abs=1e-9)
    awake.step(1.0)
    assert _angles(awake, "Head") == [1.0, -0.3]
    _motion(awake, "changeAngles", "HeadYaw", -0.25, 1.0)
    awake.step(1.0)
    assert _angles(awake, "HeadYaw") == [0.75]


def test_changes_count_from_where_the_command_is(awake: VirtualNao) -> None:
    _motion(awake, "angleInterpolation", "HeadYaw", 0.0, 0.5, True)
    for _ in range(3):
        _motion(awake, "changeAngles", "HeadYaw", 0.1, 0.01)
    awake.step(0.1)
    assert _angles(awake, "HeadYaw") == pytest.approx([0.001 * 8.26797], abs=1e-9)
    awake.step(3.0)
    assert _angles(awake, "HeadYaw") == pytest.approx([0.1], abs=1e-9)


def test_a_target_out_of_reach_ends_at_the_limit(awake: VirtualNao, nao: nk.NaoModel) -> None:
    _motion(awake, "setAngles", "HeadYaw", 1e300, 1.0)
    awake.step(1.0)
    assert _angles(awake, "HeadYaw") == [nao.upper[0]]
    assert _motion(awake, "getTaskList") == []
    _motion(awake, "angleInterpolation", "HeadYaw", -1e9, 1.0, True)
    awake.step(1.0)
    assert _angles(awake, "HeadYaw") == [nao.lower[0]]


def test_bezier_curves_follow_their_handles(awake: VirtualNao) -> None:
    """With handles a third of a segment long in time, the value is the Bernstein polynomial of its control points."""
    _motion(awake, "angleInterpolation", "HeadYaw", 0.0, 0.5, True)
    keys = [[0.3, [3, -0.2, 0.05], [3, 0.3, -0.1]], [0.6, [3, -0.3, -0.2], [3, 0.0, 0.0]]]
    begin = awake.clock.now
    call = awake.post("ALMotion", "angleInterpolationBezier", ["HeadYaw"], [[0.6, 1.5]], [keys])
    for end, first, points in ((0.6, 0.0, (0.0, 0.0, 0.35, 0.3)), (0.9, 0.6, (0.3, 0.2, 0.4, 0.6))):
        for _ in range(3):
            awake.step(end / 3.0)
            u = (awake.clock.now - begin - first) / end
            expected = np.dot(points, [(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
            assert _angles(awake, "HeadYaw") == pytest.approx([expected], abs=1e-9)
    assert call.done()


@pytest.mark.parametrize("key", [0.4, [0.4]])
def test_bezier_keys_without_handles_are_reached_at_rest(awake: VirtualNao, key: Any) -> None:
    _motion(awake, "angleInterpolation", "HeadYaw", 0.0, 0.5, True)
    awake.post("ALMotion", "angleInterpolationBezier", ["HeadYaw"], [[0.8]], [[key]])
    awake.step(0.4)
    assert _angles(awake, "HeadYaw") == pytest.approx([0.2], abs=1e-9)
    awake.step(0.4)
    assert _angles(awake, "HeadYaw") == [0.4]


def test_hands_open_and_close_and_let_go(awake: VirtualNao) -> None:
    for method, opening in (("openHand", 1.0), ("closeHand", 0.0)):
        begin = awake.clock.now
        _motion(awake, method, "LHand")
        assert _angles(awake, "LHand") == [opening]
        assert awake.clock.now - begin == pytest.approx(np.ceil(100 / 8.33) / 100, abs=0.0101)
        assert _motion(awake, "getStiffnesses", "LHand") == [0.0]


def test_a_hand_that_waits_for_itself_has_its_stiffness_when_its_turn_comes(awake: VirtualNao) -> None:
    awake.post("ALMotion", "openHand", "LHand")
    closing = awake.post("ALMotion", "closeHand", "LHand")
    awake.step(1.0)
    assert closing.done()
    assert _angles(awake, "LHand") == [0.0]
    assert _motion(awake, "getStiffnesses", "LHand") == [0.0]
    awake.post("ALMotion", "openHand", "LHand")
    awake.step(0.05)
    _motion(awake, "killAll")
    assert _motion(awake, "getStiffnesses", "LHand") == [0.0]


def _there(awake: VirtualNao) -> list[Service]:
    return [service for service in awake.services.values() if not isinstance(service, Missing)]


def test_what_naoqi_has_and_this_has_not_lists_what_there_is(awake: VirtualNao) -> None:
    assert awake.services["ALMotion"].absent
    for service in _there(awake):
        for name in service.absent:
            with pytest.raises(NaoqiError, match="not in this virtual NAO; it has: .*getM"):
                awake.call(service.name, name)
    with pytest.raises(NaoqiError, match="there are: ") as error:
        awake.call("DCM", "set")
    assert error.value.reason.partition("there are: ")[2].split(", ") == [service.name for service in _there(awake)]
    assert "__class__" not in awake.services["ALMotion"].method_names
    with pytest.raises(UnknownName, match="ALMotion"):
        awake.call("ALMotionProxy", "wakeUp")


def test_every_method_is_documented(awake: VirtualNao) -> None:
    for service in _there(awake):
        assert service.help("getMethodHelp")
        assert service.invoke("getModuleHelp")
        assert service.invoke("ping") is True
        assert service.invoke("version") == nk.__version__
        for name in service.method_names:
            assert service.invoke("getMethodHelp", name)[1], f"{service.name}::{name}"
    motion = awake.services["ALMotion"]
    assert motion.help("walkTo") == "The same as moveTo."
    assert motion.help(motion.absent[0]) == ""


def test_scripts_are_offered_what_is_public_and_nothing_that_a_service_keeps_to_itself(awake: VirtualNao) -> None:
    class Tools(Service):
        name = "Tools"

        def twice(self, number: Any) -> Any:
            """Twice a number."""
            return self._doubled(number)

        def _doubled(self, number: Any) -> Any:
            return 2 * number

    tools = Tools(awake.machine)
    own = set(awake.services["ALSonar"].method_names) & set(awake.services["ALTouch"].method_names)
    assert set(tools.method_names) == own | {"twice"}
    assert tools.invoke("twice", 3) == 6
    for name in ("_doubled", "invoke", "joints", "help", "kernels_for", "nao", "name"):
        with pytest.raises(NaoqiError, match="no such method"):
            tools.invoke(name)


# --- ALMotion: stiffness, tools ---------------------------------------------------------------------------------------


def test_it_wakes_up_where_it_is_and_rests_in_crouch(asleep: VirtualNao, nao: nk.NaoModel) -> None:
    assert _motion(asleep, "robotIsWakeUp") is False
    q = asleep.state().q
    _motion(asleep, "setAngles", "HeadYaw", 1.0, 1.0)  # a command without stiffness, forgotten on waking
    asleep.step(0.5)
    _motion(asleep, "wakeUp")
    asleep.step(0.5)
    assert np.array_equal(asleep.state().q, q)
    assert _motion(asleep, "robotIsWakeUp") is True
    asleep.call("ALRobotPosture", "goToPosture", "StandInit", 1.0)
    running = asleep.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 100.0, True)
    asleep.step(0.5)
    begin, way = asleep.clock.now, np.abs(nao.to_body(asleep.state().command) - nao.to_body(nao.posture("Crouch")))
    _motion(asleep, "rest")
    assert running.done()
    speeds = np.array([row[2] for row in _motion(asleep, "getLimits", "Body")])
    assert asleep.clock.now - begin == pytest.approx(np.ceil((way / speeds).max() / 0.3 * 100) / 100, abs=1e-9)
    assert asleep.call("ALRobotPosture", "getPosture") == "Crouch"
    assert set(_motion(asleep, "getStiffnesses", "Body")) == {0.0}
    begin = asleep.clock.now
    _motion(asleep, "rest")
    assert asleep.clock.now - begin <= 0.01


def test_only_the_legs_make_it_awake(asleep: VirtualNao) -> None:
    _motion(asleep, "setStiffnesses", "Arms", 1.0)
    assert _motion(asleep, "robotIsWakeUp") is False
    _motion(asleep, "setStiffnesses", "Legs", 0.1)
    assert _motion(asleep, "robotIsWakeUp") is True


def test_stiffness_rises_on_a_straight_line(asleep: VirtualNao) -> None:
    call = asleep.post("ALMotion", "stiffnessInterpolation", "Head", [[0.8, 0.2], [1.0]], [[1.0, 2.0], [1.0]])
    assert _motion(asleep, "areResourcesAvailable", ["HeadYaw"])  # angles are free
    asleep.step(0.5)
    assert _motion(asleep, "getStiffnesses", "Head") == pytest.approx([0.4, 0.5], abs=1e-9)
    asleep.step(1.0)
    assert _motion(asleep, "getStiffnesses", "Head") == pytest.approx([0.5, 1.0], abs=1e-9)
    asleep.step(0.5)
    assert call.done()
    assert _motion(asleep, "getStiffnesses", "Head") == [0.2, 1.0]
    call = asleep.post("ALMotion", "stiffnessInterpolation", "Body", 1.0, 1.0)
    _motion(asleep, "killTasksUsingResources", ["HeadYaw"])
    assert call.done()


@pytest.mark.parametrize("space", [0, 1, 2])
def test_masses_and_their_centres_are_the_robots(awake: VirtualNao, nao: nk.NaoModel, space: int) -> None:
    awake.call("ALRobotPosture", "goToPosture", "StandInit", 1.0)
    state = awake.state()
    parts = ("Head", "LArm", "RArm", "LLeg", "RLeg", "Torso")
    masses = [_motion(awake, "getMass", part) for part in parts]
    assert sum(masses) == pytest.approx(nao.mass, abs=1e-12)
    for whole in ("Body", "Joints", "Com"):
        assert _motion(awake, "getMass", whole) == pytest.approx(nao.mass, abs=1e-12)
    assert _motion(awake, "getMass", "Head") == pytest.approx(
        _motion(awake, "getMass", "HeadYaw") + _motion(awake, "getMass", "HeadPitch"), abs=1e-12
    )
    com = np.array(_motion(awake, "getCOM", "Body", space, True))
    mean = np.average([_motion(awake, "getCOM", part, space, True) for part in parts], axis=0, weights=masses)
    assert np.allclose(com, mean, atol=1e-12)
    T_world_robot = robot_frame(nao, state.q, torso_in_world=state.T_world_torso)
    T_space_torso = (np.eye(4), state.T_world_torso, np.linalg.inv(T_world_robot) @ state.T_world_torso)[space]
    assert np.allclose(com, (T_space_torso @ [*nao.com(state.q), 1.0])[:3], atol=1e-12)


def test_the_robot_describes_itself(awake: VirtualNao) -> None:
    names, values = _motion(awake, "getRobotConfig")
    assert dict(zip(names, values, strict=True))["Model Type"] == "naoH25"
    summary = _motion(awake, "getSummary")
    assert "LAnkleRoll" in summary
    assert "Tasks: none" in summary
    assert {"CameraTop", "LFsrFL", "Accelerometer"} <= set(_motion(awake, "getSensorNames"))
    assert _motion(awake, "getMotionCycleTime") == 20


@pytest.mark.parametrize(
    ("version", "named"),
    [("v6", "VERSION_60"), *full(("v3.2", "VERSION_32"), ("v3.3", "VERSION_33"), ("v4", "VERSION_40"))],
)
def test_versions_are_written_as_naoqi_writes_them(version: str, named: str) -> None:
    with VirtualNao(nk.load_nao(version), stepped=True) as robot:
        config = dict(zip(*robot.call("ALMotion", "getRobotConfig"), strict=True))
    assert {config[f"{part} Version"] for part in ("Head", "Body", "Arm")} == {named}


@pytest.mark.parametrize(
    ("name", "of", "first"),
    [
        ("FallManagerEnabled", (), True),
        ("SmartStiffnessEnabled", (), True),
        ("DiagnosisEffectEnabled", (), True),
        ("PushRecoveryEnabled", (), True),
        ("CollisionProtectionEnabled", ("LArm",), True),
        ("ExternalCollisionProtectionEnabled", ("All",), True),
        ("BreathEnabled", ("Body",), False),
        ("IdlePostureEnabled", ("Head",), False),
    ],
)
def test_switches_of_what_is_not_simulated_are_kept(
    awake: VirtualNao, name: str, of: tuple[str, ...], first: bool
) -> None:
    assert _motion(awake, f"get{name}", *of) is first
    # Aldebaran documents True for these two, and no answer for the others.
    answers = name in ("CollisionProtectionEnabled", "SmartStiffnessEnabled")
    assert _motion(awake, f"set{name}", *of, not first) is (True if answers else None)
    assert _motion(awake, f"get{name}", *of) is not first
    assert "stored, without effect" in awake.log.lines[-1][1]


def test_other_settings_are_kept_too(awake: VirtualNao) -> None:
    _motion(awake, "setCollisionProtectionEnabled", "Arms", False)
    assert _motion(awake, "getCollisionProtectionEnabled", "RArm") is False
    assert _motion(awake, "isCollision", "Arms") == "none"
    _motion(awake, "setBreathConfig", [["Bpm", 20.0], ["Amplitude", 0.0]])
    assert _motion(awake, "getBreathConfig") == [["Bpm", 20.0], ["Amplitude", 0.0]]
    _motion(awake, "setOrthogonalSecurityDistance", 0.2)
    _motion(awake, "setTangentialSecurityDistance", 0.05)
    assert _motion(awake, "getOrthogonalSecurityDistance") == 0.2
    assert _motion(awake, "getTangentialSecurityDistance") == 0.05
    _motion(awake, "setMotionConfig", [["ENABLE_FOOT_CONTACT_PROTECTION", True]])


# --- ALRobotPosture ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["Stand", "StandInit", "StandZero", "Crouch", "Sit", "SitRelax", "LyingBack"])
def test_a_posture_is_reached_in_the_time_of_its_longest_way(awake: VirtualNao, nao: nk.NaoModel, name: str) -> None:
    way = np.abs(nao.to_body(nao.clamp(nao.posture(name))) - nao.to_body(awake.state().command))
    speeds = np.array([row[2] for row in _motion(awake, "getLimits", "Body")])
    begin = awake.clock.now
    assert awake.call("ALRobotPosture", "goToPosture", name, 0.5) is True
    expected = max(0.01, np.ceil((way / speeds).max() / 0.5 * 100 - 1e-6) / 100)
    assert awake.clock.now - begin == pytest.approx(expected, abs=1e-9)
    assert np.array_equal(awake.state().q, nao.clamp(nao.posture(name)))
    assert awake.call("ALRobotPosture", "getPosture") == name
    family = awake.call("ALRobotPosture", "getPostureFamily")
    assert family in awake.call("ALRobotPosture", "getPostureFamilyList")
    assert awake.call("ALMemory", "getData", "PostureFamilyChanged") == family


def test_a_posture_that_is_not_reached_is_false(awake: VirtualNao, nao: nk.NaoModel) -> None:
    assert awake.call("ALRobotPosture", "goToPosture", "StandInnit", 0.5) is False
    assert "nearest: StandInit" in awake.log.lines[-1][1]
    call = awake.post("ALRobotPosture", "goToPosture", "Stand", 0.5)
    awake.step(0.1)
    awake.call("ALRobotPosture", "stopMove")
    assert call.result(0) is False
    assert awake.call("ALRobotPosture", "getPosture") == "Unknown"
    assert awake.call("ALRobotPosture", "getPostureFamily") == "Crouching"
    _motion(awake, "setStiffnesses", "LLeg", 0.0)
    assert awake.call("ALRobotPosture", "goToPosture", "Stand", 0.5) is False
    assert awake.call("ALRobotPosture", "getPostureList") == list(nao.posture_names)
    awake.call("ALRobotPosture", "setMaxTryNumber", 3)


def test_hands_that_were_let_go_do_not_keep_a_posture_from_being_reached(awake: VirtualNao) -> None:
    for move in ("openHand", "closeHand"):
        _motion(awake, move, "LHand")
        assert awake.call("ALRobotPosture", "goToPosture", "StandInit", 1.0) is True
        assert awake.call("ALRobotPosture", "getPosture") == "StandInit"
    _motion(awake, "setStiffnesses", "LElbowYaw", 0.0)
    assert awake.call("ALRobotPosture", "goToPosture", "Sit", 1.0) is False


def test_a_posture_at_more_than_full_speed_is_reached_at_full_speed(awake: VirtualNao) -> None:
    took = []
    for fraction in (1.0, 2.0):
        awake.call("ALRobotPosture", "applyPosture", "StandZero", 1.0)
        begin = awake.clock.now
        assert awake.call("ALRobotPosture", "applyPosture", "Stand", fraction) is True
        took.append(awake.clock.now - begin)
    assert took[1] == pytest.approx(took[0], abs=1e-9)
    assert len([text for _, text in awake.log.lines if "2 is clipped to 1" in text]) == 1


def test_stopping_a_posture_stops_those_that_wait_for_it(awake: VirtualNao) -> None:
    calls = [awake.post("ALRobotPosture", "goToPosture", posture, 0.2) for posture in ("Stand", "Sit", "Stand")]
    awake.step(0.2)
    awake.call("ALRobotPosture", "stopMove")
    assert _motion(awake, "getTaskList") == []
    assert [call.result(0.0) for call in calls] == [False] * 3


# --- ALMemory ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("space", [0, 1, 2])
def test_the_support_polygon_is_the_hull_of_the_soles_on_the_floor(awake: VirtualNao, space: int) -> None:
    awake.call("ALRobotPosture", "goToPosture", "StandInit", 1.0)
    robot = awake.robot
    for feet, lifted in (("LR", 0.0), ("L", 0.02)):
        if lifted:
            change = [0.0, 0.0, lifted, 0.0, 0.0, 0.0]
            _motion(awake, "positionInterpolation", "RLeg", 1, change, 63, 0.5, False)
        q, T_world_torso = awake.joints.q(), awake.state().T_world_torso
        names = [
            f"{foot}Foot/FSR/{end}{side}" for foot in feet for end in ("Front", "Rear") for side in ("Left", "Right")
        ]
        T_space_torso = (
            np.eye(4),
            T_world_torso,
            np.linalg.inv(robot_frame(robot, q, torso_in_world=T_world_torso)) @ T_world_torso,
        )
        hull = ConvexHull((T_world_torso @ robot.fk(q, names))[:, :2, 3])
        expected = (T_space_torso[space] @ robot.fk(q, names))[hull.vertices, :2, 3]
        found = np.array(_motion(awake, "getSupportPolygon", space, True))
        first = int(np.argmin(np.linalg.norm(expected - found[0], axis=1)))
        assert np.abs(found - np.roll(expected, -first, axis=0)).max() < 1e-9


def test_a_robot_that_sits_has_no_support_polygon_and_notifications_are_stored(awake: VirtualNao) -> None:
    assert _motion(awake, "areNotificationsEnabled") is True
    _motion(awake, "setEnableNotifications", False)
    assert _motion(awake, "areNotificationsEnabled") is False
    assert _motion(awake, "getFootGaitConfig", "Max") == _motion(awake, "getMoveConfig", "Max")
    awake.call("ALRobotPosture", "goToPosture", "Sit", 1.0)
    assert _motion(awake, "getSupportPolygon", 1, True) == []


def test_memory_shows_every_joint(awake: VirtualNao, nao: nk.NaoModel) -> None:
    awake.post("ALMotion", "angleInterpolation", "HeadYaw", 2.0, 0.1, True)
    _motion(awake, "setStiffnesses", "LHand", 0.25)
    awake.step(0.1)
    for what, values in (
        ("Position/Sensor", _angles(awake, "Body")),
        ("Position/Actuator", _motion(awake, "getAngles", "Body", False)),
        ("Hardness/Actuator", _motion(awake, "getStiffnesses", "Body")),
    ):
        keys = [f"Device/SubDeviceList/{joint}/{what}/Value" for joint in nao.body_order]
        assert awake.call("ALMemory", "getListData", keys) == values
        assert [awake.call("ALMemory", "getData", key) for key in keys] == values
    assert len(awake.call("ALMemory", "getDataList", "/Position/Sensor/Value")) == 26


def test_memory_shows_the_rest_of_the_robot(awake: VirtualNao) -> None:
    def get(key: str) -> Any:
        return awake.call("ALMemory", "getData", key)

    assert get("Device/SubDeviceList/Battery/Charge/Sensor/Value") == 1.0
    assert get("Device/SubDeviceList/Head/Touch/Front/Sensor/Value") == 0.0
    assert get("FrontTactilTouched") == 0.0
    assert get("robotIsWakeUp") is True
    assert get("PostureChanged") == "Crouch"
    awake.call("ALRobotPosture", "goToPosture", "LyingBack", 1.0)
    assert get("PostureChanged") == "LyingBack"
    assert get("Device/SubDeviceList/InertialSensor/AngleY/Sensor/Value") == pytest.approx(-np.pi / 2, abs=0.05)
    up = [get(f"Device/SubDeviceList/InertialSensor/Accelerometer{axis}/Sensor/Value") for axis in "XYZ"]
    assert np.linalg.norm(up) == pytest.approx(9.81, abs=1e-9)
    assert up[0] > 9.8
    assert awake.call("ALMemory", "getData", "Device/SubDeviceList/LFoot/FSR/TotalWeight/Sensor/Value", 0) == 0.0
    awake.step(1.0)
    assert get("DCM/Time") == int(1000 * awake.clock.now)


# Keys in Aldebaran's lists of the actuators and sensors of a NAO, of all versions, without diagnosis.
DOCUMENTED = """
{joint}/{Position,Hardness}/Actuator/Value {joint}/{Position,ElectricCurrent,Temperature}/Sensor/Value
{joint}/Temperature/Sensor/Status
US/{Left,Right}/Sensor/Value{,1,2,3,4,5,6,7,8,9} US/Actuator/Value
{LFoot,RFoot}/FSR/{FrontLeft,FrontRight,RearLeft,RearRight,TotalWeight,CenterOfPressure/X,CenterOfPressure/Y}/Sensor/Value
InertialSensor/{Angle,Acc,Accelerometer,Gyroscope}{X,Y,Z}/Sensor/Value InertialSensor/{GyrX,GyrY,GyrRef}/Sensor/Value
{LHand,RHand}/Touch/{Left,Back,Right}/Sensor/Value Head/Touch/{Front,Middle,Rear}/Sensor/Value
{LFoot,RFoot}/Bumper/{Left,Right}/Sensor/Value ChestBoard/Button/Sensor/Value Head/Temperature/Sensor/Value
Battery/{Charge,Current,Temperature}/Sensor/Value
""".split()


def _expanded(text: str) -> list[str]:
    """The texts for each choice in braces, as a shell writes them."""
    head, brace, rest = text.partition("{")
    choices, _, tail = rest.partition("}")
    return [text for choice in choices.split(",") for text in _expanded(head + choice + tail)] if brace else [text]


def test_every_documented_key_has_a_value(awake: VirtualNao) -> None:
    joints = "{" + ",".join(joint for joint in awake.robot.body_order if joint != "RHipYawPitch") + "}"
    keys = [f"Device/SubDeviceList/{key}" for text in DOCUMENTED for key in _expanded(text.replace("{joint}", joints))]
    keys += "footContact leftFootContact rightFootContact leftFootTotalWeight rightFootTotalWeight".split()
    assert len(set(keys)) == len(keys) > 200
    values = awake.call("ALMemory", "getListData", keys)
    assert [key for key, value in zip(keys, values, strict=True) if value is None] == []
    assert set(keys) <= set(awake.call("ALMemory", "getDataListName"))


def test_memory_shows_where_the_feet_are(awake: VirtualNao) -> None:
    def get(key: str) -> Any:
        return awake.call("ALMemory", "getData", key)

    feet = ("leftFootContact", "rightFootContact", "footContact")
    awake.call("ALRobotPosture", "goToPosture", "StandInit", 1.0)
    assert [get(foot) for foot in feet] == [True, True, True]
    _motion(awake, "angleInterpolation", ["RHipPitch", "RKneePitch"], [[-1.2], [1.6]], [[1.0], [1.0]], True)
    assert [get(foot) for foot in feet] == [True, False, True]
    awake.call("ALRobotPosture", "goToPosture", "LyingBack", 1.0)
    assert [get(foot) for foot in feet] == [False, False, False]


def test_a_switch_that_a_test_presses_raises_its_events(awake: VirtualNao) -> None:
    heard: list[Any] = []
    for event in ("FrontTactilTouched", "RightBumperPressed", "TouchChanged"):
        awake.call("ALMemory", "subscriber", event).connect(lambda value, event=event: heard.append((event, value)))
    front = "Device/SubDeviceList/Head/Touch/Front/Sensor/Value"
    left, right = (f"Device/SubDeviceList/RFoot/Bumper/{side}/Sensor/Value" for side in ("Left", "Right"))
    awake.call("ALMemory", "insertData", front, 1.0)
    awake.call("ALMemory", "insertData", front, 1)  # pressed already
    assert heard == [("FrontTactilTouched", 1.0), ("TouchChanged", [["Head", True], ["Head/Touch/Front", True]])]
    assert awake.call("ALMemory", "getData", "FrontTactilTouched") == 1.0
    assert ["Head/Touch/Front", True] in awake.call("ALTouch", "getStatus")
    awake.call("ALMemory", "removeData", front)
    assert heard[2:] == [("FrontTactilTouched", 0.0), ("TouchChanged", [["Head", False], ["Head/Touch/Front", False]])]
    heard.clear()
    awake.call("ALMemory", "insertListData", [[left, 1.0], [right, 1.0]])
    awake.call("ALMemory", "raiseEvent", left, 0.0)
    assert [value for event, value in heard if event == "RightBumperPressed"] == [1.0]
    awake.call("ALMemory", "insertData", right, "released")
    assert [value for event, value in heard if event == "RightBumperPressed"] == [1.0, 0.0]
    assert awake.call("ALTouch", "getStatus") == [[name, False] for name in awake.call("ALTouch", "getSensorList")]


def test_a_sonar_hears_what_is_inserted_while_somebody_subscribes(awake: VirtualNao) -> None:
    heard: list[Any] = []
    for event in ("SonarLeftDetected", "SonarLeftNothingDetected", "SonarRightDetected", "SonarRightNothingDetected"):
        awake.call("ALMemory", "subscriber", event).connect(lambda value, event=event: heard.append((event, value)))
    left, right = (f"Device/SubDeviceList/US/{side}/Sensor/Value" for side in ("Left", "Right"))
    awake.call("ALMemory", "insertData", left, 0.3)
    assert heard == []
    awake.call("ALSonar", "subscribe", "test")
    awake.call("ALMemory", "insertListData", [[left, 0.3], [right, 1.2]])
    assert heard == [("SonarLeftDetected", 0.3), ("SonarRightNothingDetected", 1.2)]
    assert awake.call("ALMemory", "getListData", [left, right]) == [0.3, 1.2]
    awake.call("ALMemory", "removeData", left)
    assert heard[2:] == [("SonarLeftNothingDetected", 2.55)]
    assert awake.call("ALSonar", "getSubscribersInfo") == [["test", 500, 0.0]]
    awake.call("ALSonar", "unsubscribe", "test")
    awake.call("ALMemory", "insertData", left, 0.3)
    assert len(heard) == 3


def test_what_is_inserted_stands_before_the_robots_own_until_it_is_removed(awake: VirtualNao) -> None:
    key = "Device/SubDeviceList/Head/Touch/Front/Sensor/Value"
    awake.call("ALMemory", "insertData", key, 1.0)
    awake.call("ALMemory", "insertListData", [["mine", [1, "two", {"three": 3}]], ["other", None]])
    assert awake.call("ALMemory", "getListData", [key, "mine", "none"]) == [1.0, [1, "two", {"three": 3}], None]
    assert awake.call("ALMemory", "getDataList", "min") == ["mine"]
    assert "mine" in awake.call("ALMemory", "getDataListName")
    awake.call("ALMemory", "removeData", key)
    assert awake.call("ALMemory", "getData", key) == 0.0
    awake.call("ALMemory", "removeData", "mine")


def test_events_are_told_to_whoever_subscribes(awake: VirtualNao) -> None:
    heard: list[Any] = []
    subscriber = awake.call("ALMemory", "subscriber", "mine")
    number = subscriber.connect(heard.append)
    awake.call("ALMemory", "insertData", "mine", 0)  # nobody is told
    awake.call("ALMemory", "raiseEvent", "mine", 1)
    awake.call("ALMemory", "raiseMicroEvent", "mine", [2])
    awake.call("ALMemory", "raiseEvent", "other", 3)
    assert heard == [1, [2]]
    assert awake.call("ALMemory", "getData", "mine") == [2]
    assert subscriber.disconnect(number)
    assert not subscriber.disconnect(number)
    awake.call("ALMemory", "raiseEvent", "mine", 4)
    assert heard == [1, [2]]
    awake.call("ALMemory", "declareEvent", "declared")
    assert {"mine", "other", "declared"} <= set(awake.call("ALMemory", "getEventList"))


def test_memory_tells_when_a_value_was_stored(awake: VirtualNao) -> None:
    start = awake.clock.now
    awake.call("ALMemory", "insertData", "Here", [1, "two"])
    awake.step(1.25)
    assert awake.call("ALMemory", "getTimestamp", "Here") == [[1, "two"], int(start), round(1e6 * (start % 1.0))]
    assert awake.call("ALMemory", "getTimestamp", "DCM/Time") == [1250, 1, 250000]


def test_old_scripts_have_a_method_of_a_service_called(awake: VirtualNao) -> None:
    called: list[tuple[Any, ...]] = []
    memory = awake.services["ALMemory"]
    memory.module_called = lambda *given: called.append(given)  # type: ignore[attr-defined]
    awake.call("ALMemory", "subscribeToEvent", "mine", "Module", "onMine")
    awake.call("ALMemory", "subscribeToEvent", "mine", "Other", "note", "onMine")
    awake.call("ALMemory", "raiseEvent", "mine", 5)
    assert called == [("Module", "onMine", "mine", 5, "Module"), ("Other", "onMine", "mine", 5, "note")]
    awake.call("ALMemory", "unsubscribeToEvent", "mine", "Module")
    awake.call("ALMemory", "raiseEvent", "mine", 6)
    assert len(called) == 3
    awake.call("ALMemory", "unsubscribeToMicroEvent", "mine", "Other")
    awake.call("ALMemory", "subscribeToMicroEvent", "mine", "Module", "small", "onMine")
    awake.call("ALMemory", "raiseMicroEvent", "mine", 7)
    assert called[3:] == [("Module", "onMine", "mine", 7, "small")]


def test_the_robot_raises_events_of_its_own(asleep: VirtualNao) -> None:
    heard: list[tuple[str, Any]] = []
    for key in ("robotIsWakeUp", "PostureChanged", "ALTextToSpeech/TextDone", "AutonomousLife/State"):
        asleep.call("ALMemory", "subscriber", key).connect(lambda value, key=key: heard.append((key, value)))
    _motion(asleep, "wakeUp")
    asleep.call("ALRobotPosture", "goToPosture", "Stand", 1.0)
    asleep.call("ALTextToSpeech", "say", "hi")
    asleep.call("ALAutonomousLife", "setState", "solitary")
    assert heard == [
        ("robotIsWakeUp", True),
        ("PostureChanged", "Stand"),
        ("ALTextToSpeech/TextDone", 0),
        ("ALTextToSpeech/TextDone", 1),
        ("AutonomousLife/State", "solitary"),
        ("robotIsWakeUp", True),
    ]


# --- ALLeds, ALTextToSpeech and the small ones ------------------------------------------------------------------------


def test_a_fade_is_a_straight_line_of_colours(awake: VirtualNao) -> None:
    call = awake.post("ALLeds", "fadeRGB", "FaceLeds", 0x00FF0000, 1.0)  # from white
    awake.step(0.5)
    colours = awake.state().leds
    assert colours["FaceLedLeft0"] == pytest.approx((1.0, 0.5, 0.5), abs=0.03)
    assert colours["ChestLeds"] == (1.0, 1.0, 1.0)
    awake.step(0.5)
    assert call.done()
    lit = [led for led, colour in awake.state().leds.items() if colour == (1.0, 0.0, 0.0)]
    assert lit == [f"FaceLed{side}{number}" for side in ("Left", "Right") for number in range(8)]


@pytest.mark.parametrize("colour", [(0x0000FF00,), ("green",), (0.0, 1.0, 0.0), (65280.0,)])
def test_a_colour_is_a_number_a_name_or_three_shares(awake: VirtualNao, colour: tuple[Any, ...]) -> None:
    begin = awake.clock.now
    awake.call("ALLeds", "fadeRGB", "ChestLeds", *colour, 0.3)
    assert awake.clock.now - begin == pytest.approx(0.3, abs=1e-9)
    assert awake.call("ALLeds", "getIntensity", "ChestLeds") == [0.0, 1.0, 0.0]


def test_a_led_does_what_it_was_told_last(awake: VirtualNao) -> None:
    def eyes() -> list[float]:
        return awake.call("ALLeds", "getIntensity", "FaceLeds")

    slow = awake.post("ALLeds", "fadeRGB", "AllLeds", "red", 2.0)
    awake.step(0.5)
    quick = awake.post("ALLeds", "fadeRGB", "FaceLeds", "blue", 0.5)
    awake.step(0.6)
    assert (slow.done(), quick.done(), eyes()) == (False, True, [0.0, 0.0, 1.0])
    awake.step(1.0)
    assert slow.done()
    assert eyes() == [0.0, 0.0, 1.0]
    assert awake.call("ALLeds", "getIntensity", "ChestLeds") == [1.0, 0.0, 0.0]
    colours = awake.post("ALLeds", "rasta", 2.0)
    awake.step(0.3)
    awake.call("ALLeds", "off", "FaceLeds")
    awake.step(0.5)
    assert eyes() == [0.0] * 3
    awake.step(2.0)
    assert colours.done()
    assert eyes() == [0.0] * 3


@pytest.mark.parametrize(
    ("actuator", "led", "lit"),
    [
        ("Face/Led/Red/Left/0Deg/Actuator/Value", "FaceLedLeft1", [0.8, 0.0, 0.0]),
        ("Face/Led/Blue/Left/90Deg/Actuator/Value", "LeftFaceLed8", [0.0, 0.0, 0.8]),
        ("Face/Led/Green/Right/0Deg/Actuator/Value", "RightFaceLed1", [0.0, 0.8, 0.0]),
        ("Device/SubDeviceList/ChestBoard/Led/Green/Actuator/Value", "ChestLeds", [0.0, 0.8, 0.0]),
        ("LFoot/Led/Red/Actuator/Value", "LeftFootLeds", [0.8, 0.0, 0.0]),
        ("Ears/Led/Right/36Deg/Actuator/Value", "RightEarLed2", [0.0, 0.0, 0.8]),
        ("Head/Led/Rear/Left/2/Actuator/Value", "Brain6", [0.8, 0.8, 0.8]),
    ],
)
def test_leds_have_their_actuators_names_too(awake: VirtualNao, actuator: str, led: str, lit: list[float]) -> None:
    awake.call("ALLeds", "off", "AllLeds")
    awake.call("ALLeds", "setIntensity", actuator, 0.8)
    assert awake.call("ALLeds", "getIntensity", led) == lit
    assert sum(max(colour) > 0.0 for colour in awake.state().leds.values()) == 1
    awake.call("ALLeds", "off", "AllLeds")
    awake.call("ALLeds", "createGroup", "mine", [actuator])
    awake.call("ALLeds", "setIntensity", "mine", 0.8)
    assert awake.call("ALLeds", "getIntensity", led) == lit


def test_leds_are_reset_to_their_initial_colours(awake: VirtualNao) -> None:
    initial = dict(awake.state().leds)
    awake.call("ALLeds", "off", "AllLeds")
    awake.call("ALLeds", "reset", "LeftEarLeds")
    changed = awake.state().leds
    assert all((changed[led] == colour) == led.startswith("LeftEar") for led, colour in initial.items())
    awake.call("ALLeds", "reset", "AllLeds")
    assert awake.state().leds == initial


def test_leds_go_on_and_off_by_group_led_and_channel(awake: VirtualNao) -> None:
    def led(name: str) -> tuple[float, float, float]:
        return awake.state().leds[name]

    awake.call("ALLeds", "off", "AllLeds")
    assert set(awake.state().leds.values()) == {(0.0, 0.0, 0.0)}
    awake.call("ALLeds", "on", "FaceLedLeft3")
    awake.call("ALLeds", "setIntensity", "ChestLedsBlue", 0.5)
    awake.call("ALLeds", "setIntensity", "LeftEarLed1", 0.25)
    awake.call("ALLeds", "setIntensity", "Brain0", 0.75)
    assert led("FaceLedLeft3") == (1.0, 1.0, 1.0)
    assert led("ChestLeds") == (0.0, 0.0, 0.5)
    assert led("LeftEarLed1") == (0.0, 0.0, 0.25)
    assert led("Brain0") == (0.75, 0.75, 0.75)
    awake.call("ALLeds", "on", "FaceLed0")
    assert led("FaceLedLeft0") == led("FaceLedRight0") == (1.0, 1.0, 1.0)
    awake.call("ALLeds", "on", "RightFaceLed1")
    awake.call("ALLeds", "on", "LeftFaceLed3")
    assert led("FaceLedRight7") == led("FaceLedLeft2") == (1.0, 1.0, 1.0)
    awake.call("ALLeds", "createGroup", "mine", ["ChestLeds", "FeetLeds"])
    awake.call("ALLeds", "fade", "mine", 1.0, 0.2)
    assert led("LeftFootLeds") == led("ChestLeds") == (1.0, 1.0, 1.0)
    assert "mine" in awake.call("ALLeds", "listGroups")
    awake.call("ALLeds", "fadeListRGB", "ChestLeds", ["red", 0x0000FF], [0.2, 0.4])
    assert led("ChestLeds") == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("method", "arguments"), [("rasta", (1.0,)), ("randomEyes", (1.0,)), ("rotateEyes", (0xFF0000, 0.5, 1.0))]
)
def test_eye_effects_take_their_time_and_leave_the_eyes_as_they_were(
    awake: VirtualNao, method: str, arguments: tuple[Any, ...]
) -> None:
    awake.call("ALLeds", "fadeRGB", "FaceLeds", "yellow", 0.0)
    before, begin = dict(awake.state().leds), awake.clock.now
    call, seen = awake.post("ALLeds", method, *arguments), set()
    while not call.done():
        awake.step(0.05)
        seen.add(awake.state().leds["FaceLedLeft0"])
    assert awake.clock.now - begin == pytest.approx(1.0, abs=1e-9)
    assert len(seen) > 1
    assert awake.state().leds == before


def test_a_text_takes_its_length_and_texts_wait_for_each_other(awake: VirtualNao) -> None:
    first = awake.post("ALTextToSpeech", "say", "x" * 14)  # 0.3 s and 14/14 s
    second = awake.post("ALTextToSpeech", "say", "y" * 7)
    awake.step(1.29)
    assert not first.done()
    assert awake.state().saying == "x" * 14
    awake.step(0.01)
    assert first.done()
    assert awake.state().saying == "y" * 7
    awake.step(0.8)
    assert second.done()
    assert awake.state().saying == ""
    assert [line for _, line in awake.log.lines][-2:] == [f"says: {'x' * 14}", f"says: {'y' * 7}"]


def test_speed_and_pauses_change_how_long_it_takes(awake: VirtualNao) -> None:
    awake.call("ALTextToSpeech", "setParameter", "speed", 200)
    begin = awake.clock.now
    awake.call("ALTextToSpeech", "say", "\\vct=120\\abcdefg\\pau=500\\hijklmn")
    assert awake.clock.now - begin == pytest.approx(0.3 + 0.5 + 0.5, abs=1e-9)
    awake.call("ALTextToSpeech", "resetSpeed")
    assert awake.call("ALTextToSpeech", "getParameter", "speed") == 100.0


def test_it_can_be_silenced(awake: VirtualNao) -> None:
    calls = [awake.post("ALTextToSpeech", "say", "a long story " * 10) for _ in range(3)]
    awake.step(0.1)
    assert calls[1].cancel()
    assert calls[0].cancel()
    assert awake.state().saying.startswith("a long")
    awake.call("ALTextToSpeech", "stopAll")
    assert all(call.done() for call in calls)
    assert awake.state().saying == ""
    awake.step(60.0)
    awake.call("ALTextToSpeech", "say", "again", "French")


def test_voices_are_kept(awake: VirtualNao) -> None:
    for name, value in (("Language", "German"), ("Volume", 0.5), ("Voice", "naofrf")):
        awake.call("ALTextToSpeech", f"set{name}", value)
        assert awake.call("ALTextToSpeech", f"get{name}") == value
    assert "German" in awake.call("ALTextToSpeech", "getAvailableLanguages")
    assert awake.call("ALTextToSpeech", "getAvailableVoices") == ["naoenu"]


def test_a_life_that_ends_rests(asleep: VirtualNao) -> None:
    assert asleep.call("ALAutonomousLife", "getState") == "disabled"
    asleep.call("ALAutonomousLife", "setState", "disabled")
    asleep.call("ALAutonomousLife", "setState", "solitary")
    assert _motion(asleep, "robotIsWakeUp") is True
    asleep.call("ALAutonomousLife", "setState", "disabled")
    assert _motion(asleep, "robotIsWakeUp") is False
    asleep.call("ALAutonomousLife", "setAutonomousAbilityEnabled", "BasicAwareness", False)
    assert asleep.call("ALAutonomousLife", "getAutonomousAbilityEnabled", "BasicAwareness") is False
    assert ["BasicAwareness", False, False] in asleep.call("ALAutonomousLife", "getAutonomousAbilitiesStatus")
    asleep.call("ALAutonomousLife", "setRobotOffsetFromFloor", 0.1)
    assert asleep.call("ALAutonomousLife", "getRobotOffsetFromFloor") == 0.1
    assert asleep.call("ALAutonomousLife", "focusedActivity") == ""
    asleep.call("ALAutonomousLife", "stopAll")


def test_the_small_services_answer(awake: VirtualNao) -> None:
    assert awake.call("ALBattery", "getBatteryCharge") == 100
    awake.call("ALMemory", "insertData", "Device/SubDeviceList/Battery/Charge/Sensor/Value", 0.42)
    assert awake.call("ALBattery", "getBatteryCharge") == 42


def test_what_animated_speech_says_and_players_play_is_in_the_log(awake: VirtualNao) -> None:
    words = awake.post(
        "ALAnimatedSpeech", "say", "^start(animations/Stand/Hey_1) Hello", {"bodyLanguageMode": "random"}
    )
    awake.step(0.1)
    assert "Hello" in awake.services["ALTextToSpeech"].saying
    awake.step(2.0)
    assert words.done()
    number = awake.call("ALAudioPlayer", "loadFile", "/home/nao/bark.wav")
    awake.call("ALAudioPlayer", "play", number)
    awake.call("ALAudioPlayer", "playFile", "purr.wav", 0.5, 0.0)
    awake.call("ALAudioPlayer", "stopAll")
    awake.call("ALTracker", "registerTarget", "Face", 0.1)
    log = "\n".join(line for _, line in awake.log.lines)
    assert all(part in log for part in ("bark.wav", "purr.wav", "Face would need vision"))


def test_abilities_are_switched_off_by_their_services_too(awake: VirtualNao) -> None:
    names = [name for name, _, _ in awake.call("ALAutonomousLife", "getAutonomousAbilitiesStatus")]
    assert len(names) == 5
    for name in names:
        assert awake.call(f"AL{name}", "isEnabled") is True
        awake.call(f"AL{name}", "setEnabled", False)
        assert awake.call(f"AL{name}", "isEnabled") is False
        assert awake.call("ALAutonomousLife", "getAutonomousAbilityEnabled", name) is False
        assert awake.call(f"AL{name}", "isRunning") is False
        assert awake.call(f"AL{name}", "isRunning", 1) is False
    awake.call("ALBasicAwareness", "startAwareness")
    assert awake.call("ALBasicAwareness", "isEnabled") is True
    awake.call("ALBasicAwareness", "stopAwareness")
    assert awake.call("ALBasicAwareness", "isEnabled") is awake.call("ALBasicAwareness", "isAwarenessRunning") is False


@pytest.mark.parametrize(
    ("method", "arguments", "kernels"),
    [
        ("setPositions", ("LArm", 0, [0.1] * 6, 0.5, 7), {"damped least squares"}),
        ("positionInterpolation", ("LLeg", 1, [0.1] * 6, 63, 1.0), {"damped least squares", "bodies"}),
        ("moveTo", (0.1, 0.0, 0.0), {"both legs"}),
        ("moveIsActive", (), set()),
        ("wbEnable", (True,), {"bodies"}),
        ("getPosition", ("LArm", 0, True), set()),
        ("setAngles", ("LArm", [0.0] * 6, 0.5), set()),
    ],
)
def test_what_must_be_compiled_is_so_before_the_lock_is_taken(
    awake: VirtualNao, monkeypatch: pytest.MonkeyPatch, method: str, arguments: tuple[Any, ...], kernels: set[str]
) -> None:
    asked: list[str] = []

    def warm_up(names: list[str]) -> None:
        # Another script is served meanwhile.
        other = threading.Thread(target=lambda: asked.append(awake.call("ALMotion", "ping")))
        other.start()
        other.join(10.0)
        assert asked == [True]
        asked[:] = [name.removeprefix("ik kernel, ") for name in names]
        raise BadArgument("enough")

    monkeypatch.setattr("nao_kin.naoqi.virtual.service.warm_up", warm_up)
    monkeypatch.setattr("nao_kin.naoqi.virtual.service._ready", set())
    assert {f"ik kernel, {kernel}" for kernel in kernels} <= set(cache.KERNELS)
    if kernels:
        with pytest.raises(BadArgument, match="enough"):
            awake.services["ALMotion"].invoke(method, *arguments)
    else:
        awake.services["ALMotion"].invoke(method, *arguments)
    assert set(asked) == kernels


@pytest.mark.parametrize(
    ("service", "method", "arguments"),
    [
        ("ALTracker", "lookAt", ([1.0, 0.3, 0.2], 0, 0.5, False)),
        ("ALTracker", "lookAt", ([-1.0, 2.0, 0.1], 0, 0.5, False)),  # out of reach
    ],
)
def test_a_call_that_names_no_kernel_loads_none(
    awake: VirtualNao, monkeypatch: pytest.MonkeyPatch, service: str, method: str, arguments: tuple[Any, ...]
) -> None:
    def ready(kernel: CachedKernel) -> None:
        raise AssertionError(f"{kernel.name} is loaded while the lock is held")

    monkeypatch.setattr(CachedKernel, "in_memory", False)
    monkeypatch.setattr(CachedKernel, "ready", ready)
    monkeypatch.setattr(CachedKernel, "compile_in_background", ready)
    assert awake.services[service].kernels_for(method, arguments) == frozenset()
    awake.services[service].invoke(method, *arguments)


def test_commands_to_limp_joints_are_not_what_the_sensors_show() -> None:
    with VirtualNao(stepped=True, posture="Stand") as nao:
        nao.call("ALMotion", "setAngles", ["HeadYaw", "LHipRoll", "LAnkleRoll"], [0.3, 0.1, -0.1], 0.5)
        nao.step(1.0)
        state, head = nao.state(), nao.robot.joint_names.index("HeadYaw")
        assert (state.command[head], state.q[head]) == (0.3, 0.0)
        places = [np.array(nao.call("ALMotion", "getSupportPolygon", 0, sensors)) for sensors in (True, False)]
        for q, corners in zip((state.q, state.command), places, strict=True):
            feet = [nao.robot.fk(q, f"{side}Leg") for side in "LR"]
            outlines = [nao.robot.sole_outline(f"{side}Leg", "sensors") for side in "LR"]
            flat = [o[:, :2] @ T[:2, :2].T + T[:2, 3] for o, T in zip(outlines, feet, strict=True)]
            assert np.abs(corners.mean(axis=0) - np.concatenate(flat).mean(axis=0)).max() < 0.02
        assert places[0].shape != places[1].shape or np.abs(places[0] - places[1]).max() > 1e-3
