"""The services of the virtual NAO, called as scripts call them; stepped by hand."""

from __future__ import annotations

import threading
import time
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


@pytest.fixture
def asleep(nao: nk.NaoModel) -> VirtualNao:
    with VirtualNao(nao, stepped=True) as made:
        yield made


@pytest.fixture
def virtual(asleep: VirtualNao) -> VirtualNao:
    asleep.call("ALMotion", "wakeUp")
    return asleep


def _motion(nao: VirtualNao, method: str, *arguments: Any) -> Any:
    return nao.call("ALMotion", method, *arguments)


def _angles(nao: VirtualNao, names: Any) -> list[float]:
    return _motion(nao, "getAngles", names, True)


def _refused(nao: VirtualNao, service: str, method: str, *arguments: Any) -> str:
    """The reason, where the text is NAOqi's."""
    before = nao.state()
    with pytest.raises(NaoqiError) as caught:
        nao.call(service, method, *arguments)
    text = str(caught.value)
    assert text.startswith(f"{service}::{method}\n\t")
    assert text.count("\n") == 1
    assert len(text) < 4000
    after = nao.state()
    assert after.time == before.time
    assert np.array_equal(after.command, before.command)
    assert nao.call("ALMotion", "getTaskList") == []
    return text.partition("\n\t")[2]


# --- ALMotion: joints -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("names", "count"),
    [("HeadYaw", 1), ("Head", 2), ("LArm", 6), ("Body", 26), ("Joints", 24), ("Actuators", 2), (["Head", "LHand"], 3)],
)
def test_names_are_joints_chains_groups_or_lists_of_them(virtual: VirtualNao, names: Any, count: int) -> None:
    assert len(_angles(virtual, names)) == count
    assert len(_motion(virtual, "getStiffnesses", names)) == count
    if isinstance(names, str):
        assert len(_motion(virtual, "getBodyNames", names)) == len(_motion(virtual, "getLimits", names)) == count


def test_limits_are_those_of_the_robot(virtual: VirtualNao, nao: nk.NaoModel) -> None:
    lower, upper, speed, torque = _motion(virtual, "getLimits", "HeadYaw")[0]
    assert (lower, upper, speed, torque) == (nao.lower[0], nao.upper[0], nao.velocity_limits[0], nao.effort_limits[0])
    assert _motion(virtual, "getBodyNames", "Chains") == ["Head", "LArm", "LLeg", "RLeg", "RArm"]
    assert _motion(virtual, "getJointNames", "Body") == list(nao.body_order)


@pytest.mark.full
@pytest.mark.parametrize(
    ("names", "angles", "times", "expected"),
    [
        ("HeadYaw", 0.5, 1.0, {"HeadYaw": ([1.0], [0.5])}),
        ("HeadYaw", 0, 1, {"HeadYaw": ([1.0], [0.0])}),
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
        (("HeadYaw",), (0.5,), (1.0,), {"HeadYaw": ([1.0], [0.5])}),
    ],
)
@pytest.mark.parametrize("absolute", [True, False, 1])
def test_interpolation_passes_every_key_at_its_time(
    virtual: VirtualNao, names: Any, angles: Any, times: Any, absolute: Any, expected: dict[str, Any]
) -> None:
    start = dict(zip(expected, _angles(virtual, list(expected)), strict=True))
    first = {joint: 0.0 if absolute else start[joint] for joint in expected}
    call = virtual.post("ALMotion", "angleInterpolation", names, angles, times, absolute)
    end = max(row[0][-1] for row in expected.values())
    while not call.done():
        virtual.step(0.05)
        for joint, (at, keys) in expected.items():
            values = [start[joint], *(np.array(keys) + first[joint])]
            (shown,) = _motion(virtual, "getAngles", joint, False)
            # scipy's monotone cubic has other slopes at the ends: it is compared at the keys alone.
            curve = PchipInterpolator([0.0, *at], values)
            if any(abs(virtual.clock.now - key) < 1e-9 for key in at) or virtual.clock.now > at[-1]:
                assert shown == pytest.approx(float(curve(min(virtual.clock.now, at[-1]))), abs=1e-9)
            assert min(values) - 1e-9 <= shown <= max(values) + 1e-9
    assert virtual.clock.now == pytest.approx(end, abs=1e-9)
    for joint, (_, keys) in expected.items():
        assert _angles(virtual, joint) == [keys[-1] + first[joint]]


def test_between_keys_the_curve_is_smooth(virtual: VirtualNao) -> None:
    """Three keys in one direction: a monotone cubic with Fritsch and Butland's slope in the middle."""
    virtual.post("ALMotion", "angleInterpolation", "HeadYaw", [0.2, 0.8], [1.0, 2.0], True)
    virtual.step(1.5)
    before, after = 0.2, 0.6  # slopes of the two straight lines
    slope = 2.0 / (1.0 / before + 1.0 / after)
    expected = 0.5 * (0.2 + 0.8) + slope / 8.0  # Hermite's cubic half way, at rest at the end
    assert _angles(virtual, "HeadYaw") == pytest.approx([expected], abs=1e-9)


def test_with_speed_the_longest_way_sets_the_time_and_all_arrive_together(virtual: VirtualNao) -> None:
    _motion(virtual, "angleInterpolation", "Head", 0.0, 0.5, True)
    begin = virtual.clock.now
    call = virtual.post("ALMotion", "angleInterpolationWithSpeed", ["HeadYaw", "HeadPitch"], [1.0, -0.2], 0.1)
    duration = 1.0 / (0.1 * 8.26797)
    virtual.step(0.5)
    assert _angles(virtual, "Head") == pytest.approx([0.5 / duration, -0.1 / duration], abs=1e-9)
    virtual.step(0.70)
    assert not call.done()
    virtual.step(0.01)
    assert call.done()
    assert virtual.clock.now - begin == pytest.approx(np.ceil(duration * 100) / 100, abs=1e-9)
    assert _angles(virtual, "Head") == [1.0, -0.2]
    begin = virtual.clock.now
    _motion(virtual, "angleInterpolationWithSpeed", "Head", [1.0, -0.2], 0.1)  # where it is
    assert virtual.clock.now - begin <= 0.01 + 1e-9


def test_set_angles_goes_at_a_fraction_of_each_joints_speed(virtual: VirtualNao) -> None:
    _motion(virtual, "angleInterpolation", "Head", 0.0, 0.5, True)
    assert _motion(virtual, "setAngles", "Head", [1.0, -0.3], 0.2) is None
    virtual.step(0.1)
    assert _angles(virtual, "Head") == pytest.approx([0.02 * 8.26797, -0.02 * 7.19407], abs=1e-9)
    virtual.step(1.0)
    assert _angles(virtual, "Head") == [1.0, -0.3]
    _motion(virtual, "changeAngles", "HeadYaw", -0.25, 1.0)
    virtual.step(1.0)
    assert _angles(virtual, "HeadYaw") == [0.75]


def test_changes_count_from_where_the_command_is(virtual: VirtualNao) -> None:
    _motion(virtual, "angleInterpolation", "HeadYaw", 0.0, 0.5, True)
    for _ in range(3):
        _motion(virtual, "changeAngles", "HeadYaw", 0.1, 0.01)
    virtual.step(0.1)
    assert _angles(virtual, "HeadYaw") == pytest.approx([0.001 * 8.26797], abs=1e-9)
    virtual.step(3.0)
    assert _angles(virtual, "HeadYaw") == pytest.approx([0.1], abs=1e-9)


def test_a_target_out_of_reach_ends_at_the_limit(virtual: VirtualNao, nao: nk.NaoModel) -> None:
    _motion(virtual, "setAngles", "HeadYaw", 1e300, 1.0)
    virtual.step(1.0)
    assert _angles(virtual, "HeadYaw") == [nao.upper[0]]
    assert _motion(virtual, "getTaskList") == []
    _motion(virtual, "angleInterpolation", "HeadYaw", -1e9, 1.0, True)
    virtual.step(1.0)
    assert _angles(virtual, "HeadYaw") == [nao.lower[0]]


def test_bezier_curves_follow_their_handles(virtual: VirtualNao) -> None:
    """With handles a third of a segment long in time, the value is the Bernstein polynomial of its control points."""
    _motion(virtual, "angleInterpolation", "HeadYaw", 0.0, 0.5, True)
    keys = [[0.3, [3, -0.2, 0.05], [3, 0.3, -0.1]], [0.6, [3, -0.3, -0.2], [3, 0.0, 0.0]]]
    begin = virtual.clock.now
    call = virtual.post("ALMotion", "angleInterpolationBezier", ["HeadYaw"], [[0.6, 1.5]], [keys])
    for end, first, points in ((0.6, 0.0, (0.0, 0.0, 0.35, 0.3)), (0.9, 0.6, (0.3, 0.2, 0.4, 0.6))):
        for _ in range(3):
            virtual.step(end / 3.0)
            u = (virtual.clock.now - begin - first) / end
            expected = np.dot(points, [(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
            assert _angles(virtual, "HeadYaw") == pytest.approx([expected], abs=1e-9)
    assert call.done()


@pytest.mark.parametrize("key", [0.4, [0.4]])
def test_bezier_keys_without_handles_are_reached_at_rest(virtual: VirtualNao, key: Any) -> None:
    _motion(virtual, "angleInterpolation", "HeadYaw", 0.0, 0.5, True)
    virtual.post("ALMotion", "angleInterpolationBezier", ["HeadYaw"], [[0.8]], [[key]])
    virtual.step(0.4)
    assert _angles(virtual, "HeadYaw") == pytest.approx([0.2], abs=1e-9)
    virtual.step(0.4)
    assert _angles(virtual, "HeadYaw") == [0.4]


def test_hands_open_and_close_and_let_go(virtual: VirtualNao) -> None:
    for method, opening in (("openHand", 1.0), ("closeHand", 0.0)):
        begin = virtual.clock.now
        _motion(virtual, method, "LHand")
        assert _angles(virtual, "LHand") == [opening]
        assert virtual.clock.now - begin == pytest.approx(np.ceil(100 / 8.33) / 100, abs=0.0101)
        assert _motion(virtual, "getStiffnesses", "LHand") == [0.0]
    assert "nearest: LHand" in _refused(virtual, "ALMotion", "openHand", "LHnd")


def test_a_hand_that_waits_for_itself_has_its_stiffness_when_its_turn_comes(virtual: VirtualNao) -> None:
    virtual.post("ALMotion", "openHand", "LHand")
    closing = virtual.post("ALMotion", "closeHand", "LHand")
    virtual.step(1.0)
    assert closing.done()
    assert _angles(virtual, "LHand") == [0.0]
    assert _motion(virtual, "getStiffnesses", "LHand") == [0.0]
    virtual.post("ALMotion", "openHand", "LHand")
    virtual.step(0.05)
    _motion(virtual, "killAll")
    assert _motion(virtual, "getStiffnesses", "LHand") == [0.0]


BAD_INTERPOLATIONS = [
    (("HeadYow", 0.5, 1.0, True), "nearest: HeadYaw"),
    (("", 0.5, 1.0, True), "unknown joint"),
    ((7, 0.5, 1.0, True), "names must be"),
    (([], 0.5, 1.0, True), "at least"),
    ((["HeadYaw", "Head"], 0.5, 1.0, True), "HeadYaw twice"),
    ((["HeadYaw", None], 0.5, 1.0, True), "names must be"),
    (("HeadYaw", "left", 1.0, True), "angles must be a number, got 'left'"),
    (("HeadYaw", None, 1.0, True), "angles must be a number, got None"),
    (("HeadYaw", [], 1.0, True), "must not be empty"),
    (("HeadYaw", [[[0.5]]], [[[1.0]]], True), "must be a list of numbers"),
    (("HeadYaw", float("nan"), 1.0, True), "angles must be finite, got nan"),
    (("HeadYaw", 0.5, float("nan"), True), "times must be finite, got nan"),
    (("HeadYaw", 0.5, 0.0, True), "must be above 0 s"),
    (("HeadYaw", [0.1, 0.2], [1.0, 0.5], True), "must ascend, got 1 s and then 0.5 s"),
    (("HeadYaw", [0.1, 0.2], [1.0], True), "HeadYaw has 2 angles and 1 times"),
    (("Head", [0.1, 0.2, 0.3], 1.0, True), "2 for HeadYaw, HeadPitch, got 3"),
    (("Head", [[0.1, 0.2], [0.3]], [[1.0, 2.0], [1.0, 2.0]], True), "HeadPitch has 1 angles and 2 times"),
    (("HeadYaw", 0.5, 1.0, "yes"), "isAbsolute must be True or False, got 'yes'"),
    (("HeadYaw", 0.5, 1.0), "takes (names, angleLists, timeLists, isAbsolute), got 3 arguments"),
    (("HeadYaw", 10**400, 1.0, True), "too large"),
]


@pytest.mark.parametrize(("arguments", "reason"), BAD_INTERPOLATIONS)
def test_a_bad_interpolation_is_refused_before_anything_moves(
    virtual: VirtualNao, arguments: tuple[Any, ...], reason: str
) -> None:
    assert reason in _refused(virtual, "ALMotion", "angleInterpolation", *arguments)


@pytest.mark.parametrize(
    ("method", "arguments", "reason"),
    [
        ("setAngles", ("HeadYaw", 0.5, 0.0), "fractionMaxSpeed must be above 0 and at most 1, got 0"),
        ("setAngles", ("Body", [0.5] * 25, 0.5), "26 for HeadYaw … RHand, got 25"),
        ("angleInterpolationWithSpeed", ("Head", 0.5, -1), "above 0"),
        (
            "angleInterpolationWithSpeed",
            ("Head", 0.5, 1e-30),
            "the time to the targets must be at most 86400 s",
        ),
        ("positionInterpolations", ("Head", 0, [0.0] * 6, 56, 1e30), "must be at most 86400 s (a day)"),
        ("angleInterpolationBezier", ("HeadYaw", [1.0, 2.0], [[0.1]]), "must be a list of 2, one for each time, got 1"),
        ("angleInterpolationBezier", ("HeadYaw", [1.0], 0.1), "must be 1 lists"),
        ("angleInterpolationBezier", ("HeadYaw", [1.0], [[[0.1, [3, 0]]]]), "an angle or [angle, handle, handle]"),
        ("angleInterpolationBezier", ("HeadYaw", [1.0], [[[0.1, [3, 0], [3, 0, 0]]]]), "must be [type, time, angle]"),
        ("angleInterpolationBezier", ("HeadYaw", [1.0], [[[0.1, [3, -5.0, 0], [3, 0, 0]]]]), "HeadYaw"),
        ("setStiffnesses", ("Head", 1.5), "stiffness of HeadYaw must be between 0 and 1, got 1.5"),
        ("stiffnessInterpolation", ("Head", -0.5, 1.0), "between 0 and 1, got -0.5"),
        ("getCOM", ("Boddy", 0, True), "nearest: Body"),
        ("getCOM", ("Body", 3, True), "FRAME_TORSO 0"),
        ("killTask", ("one",), "must be a number"),
        ("killTask", (1.5,), "must be a whole number"),
        ("setBreathConfig", ([["Bmp", 5]],), "valid: Bpm"),
        ("setBreathEnabled", ("Tail", True), "unknown chain"),
        ("getMethodHelp", ("fly",), "unknown method"),
    ],
)
def test_other_bad_arguments_are_named_too(
    virtual: VirtualNao, method: str, arguments: tuple[Any, ...], reason: str
) -> None:
    assert reason in _refused(virtual, "ALMotion", method, *arguments)


def test_the_time_of_a_million_keys_grows_with_their_number(virtual: VirtualNao) -> None:
    took = []
    for count in (10**5, 10**6):
        angles = np.sin(np.arange(count) * 1e-5)
        times = np.arange(1, count + 1) * 1e-3
        given = angles.tolist(), times.tolist()
        begin = time.process_time()
        call = virtual.post("ALMotion", "angleInterpolation", "HeadYaw", *given, True)
        virtual.step(2.0)
        took.append(time.process_time() - begin)
        assert _angles(virtual, "HeadYaw") == pytest.approx([angles[1999]], abs=1e-9)
        call.cancel()
    assert took[1] < 40.0 * took[0], took


def _there(virtual: VirtualNao) -> list[Service]:
    return [service for service in virtual.services.values() if not isinstance(service, Missing)]


@pytest.mark.parametrize(
    ("service", "method", "why"),
    [
        ("ALVideoDevice", "subscribeCamera", "its cameras give no pictures"),
        ("ALFaceDetection", "subscribe", "it sees no people"),
        ("ALLandMarkDetection", "subscribe", "its cameras give no pictures"),
        ("ALSpeechRecognition", "setVocabulary", "it hears nothing"),
        ("ALDialog", "loadTopic", "it hears nothing"),
        ("ALTabletService", "showWebview", "a NAO has no such part"),
        ("DCM", "set", "it has no electronics"),
        ("ALTabletService", "ping", "a NAO has no such part"),
        ("ALSegmentation3D", "subscribe", "its cameras give no pictures"),
        ("ALExtractor", "subscribe", "its cameras give no pictures"),
        ("ALMood", "currentPersonState", "it sees no people"),
        ("ALUserInfo", "get", "it sees no people"),
        ("ALExpressionWatcher", "add", "it sees no people"),
        ("ALTactileGesture", "getGestures", "nothing touches it"),
        ("ALWorldRepresentation", "getPosition", "it has no map"),
        ("ALMotionRecorder", "startInteractiveRecording", "nobody moves its joints by hand"),
        ("ALKnowledge", "getTriplets", "it is not a separate computer"),
        ("ALLauncher", "launchScript", "it is not a separate computer"),
        ("ALLogger", "info", "it is not a separate computer"),
        ("ALResourceManager", "acquireResource", "it is not a separate computer"),
        ("ALPreferences", "readPrefFile", "it is not a separate computer"),
    ],
)
def test_a_service_that_is_not_there_says_why_and_what_is(
    virtual: VirtualNao, service: str, method: str, why: str
) -> None:
    reason = _refused(virtual, service, method)
    assert reason.startswith(f"not in this virtual NAO: {why}")
    assert reason.partition("there are: ")[2].split(", ") == [there.name for there in _there(virtual)]


def test_what_naoqi_has_and_this_has_not_lists_what_there_is(virtual: VirtualNao) -> None:
    assert virtual.services["ALMotion"].absent
    for service in _there(virtual):
        for name in service.absent:
            reason = _refused(virtual, service.name, name)
            assert reason.startswith("not in this virtual NAO; it has: ")
            assert "getMethodList" in reason
    assert "nearest: setAngles" in _refused(virtual, "ALMotion", "setAngle", "HeadYaw", 0.1, 0.1)
    assert "it has: " in _refused(virtual, "ALMotion", "xyzzy")
    assert "__class__" not in virtual.services["ALMotion"].method_names
    assert "no such method" in _refused(virtual, "ALMotion", "__init__")
    with pytest.raises(UnknownName, match="ALMotion"):
        virtual.call("ALMotionProxy", "wakeUp")


def test_every_method_is_documented(virtual: VirtualNao) -> None:
    for service in _there(virtual):
        assert service.help("getMethodHelp")
        assert service.invoke("getModuleHelp")
        assert service.invoke("ping") is True
        assert service.invoke("version") == nk.__version__
        for name in service.method_names:
            assert service.invoke("getMethodHelp", name)[1], f"{service.name}::{name}"
    motion = virtual.services["ALMotion"]
    assert motion.help("walkTo") == "The same as moveTo."
    assert motion.help(motion.absent[0]) == ""


def test_scripts_are_offered_what_is_public_and_nothing_that_a_service_keeps_to_itself(virtual: VirtualNao) -> None:
    class Tools(Service):
        name = "Tools"

        def twice(self, number: Any) -> Any:
            """Twice a number."""
            return self._doubled(number)

        def _doubled(self, number: Any) -> Any:
            return 2 * number

    tools = Tools(virtual.machine)
    own = set(virtual.services["ALRobotModel"].method_names) & set(virtual.services["ALTouch"].method_names)
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
def test_masses_and_their_centres_are_the_robots(virtual: VirtualNao, nao: nk.NaoModel, space: int) -> None:
    virtual.call("ALRobotPosture", "goToPosture", "StandInit", 1.0)
    state = virtual.state()
    parts = ("Head", "LArm", "RArm", "LLeg", "RLeg", "Torso")
    masses = [_motion(virtual, "getMass", part) for part in parts]
    assert sum(masses) == pytest.approx(nao.mass, abs=1e-12)
    for whole in ("Body", "Joints", "Com"):
        assert _motion(virtual, "getMass", whole) == pytest.approx(nao.mass, abs=1e-12)
    assert _motion(virtual, "getMass", "Head") == pytest.approx(
        _motion(virtual, "getMass", "HeadYaw") + _motion(virtual, "getMass", "HeadPitch"), abs=1e-12
    )
    com = np.array(_motion(virtual, "getCOM", "Body", space, True))
    mean = np.average([_motion(virtual, "getCOM", part, space, True) for part in parts], axis=0, weights=masses)
    assert np.allclose(com, mean, atol=1e-12)
    T_world_robot = robot_frame(nao, state.q, torso_in_world=state.T_world_torso)
    T_space_torso = (np.eye(4), state.T_world_torso, np.linalg.inv(T_world_robot) @ state.T_world_torso)[space]
    assert np.allclose(com, (T_space_torso @ [*nao.com(state.q), 1.0])[:3], atol=1e-12)


def test_the_robot_describes_itself(virtual: VirtualNao) -> None:
    names, values = _motion(virtual, "getRobotConfig")
    assert dict(zip(names, values, strict=True))["Model Type"] == "naoH25"
    summary = _motion(virtual, "getSummary")
    assert "LAnkleRoll" in summary
    assert "Tasks: none" in summary
    assert {"CameraTop", "LFsrFL", "Accelerometer"} <= set(_motion(virtual, "getSensorNames"))
    assert _motion(virtual, "getMotionCycleTime") == 20


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
    virtual: VirtualNao, name: str, of: tuple[str, ...], first: bool
) -> None:
    assert _motion(virtual, f"get{name}", *of) is first
    # Aldebaran documents True for these two, and no answer for the others.
    answers = name in ("CollisionProtectionEnabled", "SmartStiffnessEnabled")
    assert _motion(virtual, f"set{name}", *of, not first) is (True if answers else None)
    assert _motion(virtual, f"get{name}", *of) is not first
    assert "not simulated" in virtual.log.lines[-1][1]


def test_other_settings_are_kept_too(virtual: VirtualNao) -> None:
    _motion(virtual, "setCollisionProtectionEnabled", "Arms", False)
    assert _motion(virtual, "getCollisionProtectionEnabled", "RArm") is False
    assert _motion(virtual, "isCollision", "Arms") == "none"
    _motion(virtual, "setBreathConfig", [["Bpm", 20.0], ["Amplitude", 0.0]])
    assert _motion(virtual, "getBreathConfig") == [["Bpm", 20.0], ["Amplitude", 0.0]]
    _motion(virtual, "setOrthogonalSecurityDistance", 0.2)
    _motion(virtual, "setTangentialSecurityDistance", 0.05)
    assert _motion(virtual, "getOrthogonalSecurityDistance") == 0.2
    assert _motion(virtual, "getTangentialSecurityDistance") == 0.05
    _motion(virtual, "setMotionConfig", [["ENABLE_FOOT_CONTACT_PROTECTION", True]])


# --- ALRobotPosture ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["Stand", "StandInit", "StandZero", "Crouch", "Sit", "SitRelax", "LyingBack"])
@pytest.mark.parametrize("method", ["goToPosture", "applyPosture"])
def test_a_posture_is_reached_in_the_time_of_its_longest_way(
    virtual: VirtualNao, nao: nk.NaoModel, name: str, method: str
) -> None:
    way = np.abs(nao.to_body(nao.clamp(nao.posture(name))) - nao.to_body(virtual.state().command))
    speeds = np.array([row[2] for row in _motion(virtual, "getLimits", "Body")])
    begin = virtual.clock.now
    assert virtual.call("ALRobotPosture", method, name, 0.5) is True
    expected = max(0.01, np.ceil((way / speeds).max() / 0.5 * 100 - 1e-6) / 100)
    assert virtual.clock.now - begin == pytest.approx(expected, abs=1e-9)
    assert np.array_equal(virtual.state().q, nao.clamp(nao.posture(name)))
    assert virtual.call("ALRobotPosture", "getPosture") == name
    family = virtual.call("ALRobotPosture", "getPostureFamily")
    assert family in virtual.call("ALRobotPosture", "getPostureFamilyList")
    assert virtual.call("ALMemory", "getData", "PostureFamilyChanged") == family


def test_a_posture_that_is_not_reached_is_false(virtual: VirtualNao, nao: nk.NaoModel) -> None:
    assert virtual.call("ALRobotPosture", "goToPosture", "StandInnit", 0.5) is False
    assert "nearest: StandInit" in virtual.log.lines[-1][1]
    call = virtual.post("ALRobotPosture", "goToPosture", "Stand", 0.5)
    virtual.step(0.1)
    virtual.call("ALRobotPosture", "stopMove")
    assert call.result(0) is False
    assert virtual.call("ALRobotPosture", "getPosture") == "Unknown"
    assert virtual.call("ALRobotPosture", "getPostureFamily") == "Crouching"
    _motion(virtual, "setStiffnesses", "LLeg", 0.0)
    assert virtual.call("ALRobotPosture", "goToPosture", "Stand", 0.5) is False
    assert "above 0" in _refused(virtual, "ALRobotPosture", "goToPosture", "Stand", 0.0)
    assert virtual.call("ALRobotPosture", "getPostureList") == list(nao.posture_names)
    virtual.call("ALRobotPosture", "setMaxTryNumber", 3)


def test_hands_that_were_let_go_do_not_keep_a_posture_from_being_reached(virtual: VirtualNao) -> None:
    for move in ("openHand", "closeHand"):
        _motion(virtual, move, "LHand")
        assert virtual.call("ALRobotPosture", "goToPosture", "StandInit", 1.0) is True
        assert virtual.call("ALRobotPosture", "getPosture") == "StandInit"
    _motion(virtual, "setStiffnesses", "LElbowYaw", 0.0)
    assert virtual.call("ALRobotPosture", "goToPosture", "Sit", 1.0) is False


@pytest.mark.parametrize("method", ["goToPosture", "applyPosture"])
def test_a_posture_at_more_than_full_speed_is_reached_at_full_speed(virtual: VirtualNao, method: str) -> None:
    took = []
    for fraction in (1.0, 2.0):
        virtual.call("ALRobotPosture", method, "StandZero", 1.0)
        begin = virtual.clock.now
        assert virtual.call("ALRobotPosture", method, "Stand", fraction) is True
        took.append(virtual.clock.now - begin)
    assert took[1] == pytest.approx(took[0], abs=1e-9)
    lines = [text for _, text in virtual.log.lines if "clipped to 1" in text]
    assert lines == [f"{method}: maxSpeedFraction = 2 is clipped to 1"]


def test_stopping_a_posture_stops_those_that_wait_for_it(virtual: VirtualNao) -> None:
    calls = [virtual.post("ALRobotPosture", "goToPosture", posture, 0.2) for posture in ("Stand", "Sit", "Stand")]
    virtual.step(0.2)
    virtual.call("ALRobotPosture", "stopMove")
    assert _motion(virtual, "getTaskList") == []
    assert [call.result(0.0) for call in calls] == [False] * 3


def test_a_battery_without_a_number_says_so(virtual: VirtualNao) -> None:
    virtual.call("ALMemory", "insertData", "Device/SubDeviceList/Battery/Charge/Sensor/Value", "full")
    assert "charge must be a number, got 'full'" in _refused(virtual, "ALBattery", "getBatteryCharge")


# --- ALMemory ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("space", [0, 1, 2])
def test_the_support_polygon_is_the_hull_of_the_soles_on_the_floor(virtual: VirtualNao, space: int) -> None:
    virtual.call("ALRobotPosture", "goToPosture", "StandInit", 1.0)
    robot = virtual.robot
    for feet, lifted in (("LR", 0.0), ("L", 0.02)):
        if lifted:
            change = [0.0, 0.0, lifted, 0.0, 0.0, 0.0]
            _motion(virtual, "positionInterpolation", "RLeg", 1, change, 63, 0.5, False)
        q, T_world_torso = virtual.joints.q(), virtual.torso_in_world()
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
        found = np.array(_motion(virtual, "getSupportPolygon", space, True))
        first = int(np.argmin(np.linalg.norm(expected - found[0], axis=1)))
        assert np.abs(found - np.roll(expected, -first, axis=0)).max() < 1e-9


def test_a_robot_that_sits_has_no_support_polygon_and_notifications_are_stored(virtual: VirtualNao) -> None:
    assert _motion(virtual, "areNotificationsEnabled") is True
    _motion(virtual, "setEnableNotifications", False)
    assert _motion(virtual, "areNotificationsEnabled") is False
    assert _motion(virtual, "getFootGaitConfig", "Max") == _motion(virtual, "getMoveConfig", "Max")
    virtual.call("ALRobotPosture", "goToPosture", "Sit", 1.0)
    assert _motion(virtual, "getSupportPolygon", 1, True) == []


def test_memory_shows_every_joint(virtual: VirtualNao, nao: nk.NaoModel) -> None:
    virtual.post("ALMotion", "angleInterpolation", "HeadYaw", 2.0, 0.1, True)
    _motion(virtual, "setStiffnesses", "LHand", 0.25)
    virtual.step(0.1)
    for what, values in (
        ("Position/Sensor", _angles(virtual, "Body")),
        ("Position/Actuator", _motion(virtual, "getAngles", "Body", False)),
        ("Hardness/Actuator", _motion(virtual, "getStiffnesses", "Body")),
    ):
        keys = [f"Device/SubDeviceList/{joint}/{what}/Value" for joint in nao.body_order]
        assert virtual.call("ALMemory", "getListData", keys) == values
        assert [virtual.call("ALMemory", "getData", key) for key in keys] == values
    assert len(virtual.call("ALMemory", "getDataList", "/Position/Sensor/Value")) == 26


def test_memory_shows_the_rest_of_the_robot(virtual: VirtualNao) -> None:
    def get(key: str) -> Any:
        return virtual.call("ALMemory", "getData", key)

    assert get("Device/SubDeviceList/Battery/Charge/Sensor/Value") == 1.0
    assert get("Device/SubDeviceList/Head/Touch/Front/Sensor/Value") == 0.0
    assert get("FrontTactilTouched") == 0.0
    assert get("robotIsWakeUp") is True
    assert get("PostureChanged") == "Crouch"
    virtual.call("ALRobotPosture", "goToPosture", "LyingBack", 1.0)
    assert get("PostureChanged") == "LyingBack"
    assert get("Device/SubDeviceList/InertialSensor/AngleY/Sensor/Value") == pytest.approx(-np.pi / 2, abs=0.05)
    up = [get(f"Device/SubDeviceList/InertialSensor/Accelerometer{axis}/Sensor/Value") for axis in "XYZ"]
    assert np.linalg.norm(up) == pytest.approx(9.81, abs=1e-9)
    assert up[0] > 9.8
    assert virtual.call("ALMemory", "getData", "Device/SubDeviceList/LFoot/FSR/TotalWeight/Sensor/Value", 0) == 0.0
    virtual.step(1.0)
    assert get("DCM/Time") == int(1000 * virtual.clock.now)


def _documented_keys() -> list[str]:
    """Keys in Aldebaran's lists of the actuators and sensors of a NAO, of all versions, without diagnosis."""
    joints = (
        "HeadYaw HeadPitch LShoulderPitch LShoulderRoll LElbowYaw LElbowRoll LWristYaw LHand LHipYawPitch LHipRoll "
        "LHipPitch LKneePitch LAnklePitch LAnkleRoll RHipRoll RHipPitch RKneePitch RAnklePitch RAnkleRoll "
        "RShoulderPitch RShoulderRoll RElbowYaw RElbowRoll RWristYaw RHand"
    ).split()
    values = [
        *(
            f"{joint}/{quantity}"
            for joint in joints
            for quantity in (
                "Position/Actuator/Value",
                "Position/Sensor/Value",
                "ElectricCurrent/Sensor/Value",
                "Temperature/Sensor/Value",
                "Hardness/Actuator/Value",
                "Temperature/Sensor/Status",
            )
        ),
        *(
            f"Face/Led/{colour}/{side}/{degrees}Deg/Actuator/Value"
            for colour in ("Red", "Green", "Blue")
            for side in ("Left", "Right")
            for degrees in range(0, 360, 45)
        ),
        *(f"Ears/Led/{side}/{deg}Deg/Actuator/Value" for side in ("Left", "Right") for deg in range(0, 360, 36)),
        *(
            f"Head/Led/{row}/{side}/{number}/Actuator/Value"
            for row, count in (("Front", 2), ("Middle", 1), ("Rear", 3))
            for side in ("Left", "Right")
            for number in range(count)
        ),
        *(
            f"{board}/Led/{colour}/Actuator/Value"
            for board in ("ChestBoard", "LFoot", "RFoot")
            for colour in ("Red", "Green", "Blue")
        ),
        *(f"US/{side}/Sensor/Value{echo}" for side in ("Left", "Right") for echo in ("", *range(1, 10))),
        *(
            f"{foot}/FSR/{place}/Sensor/Value"
            for foot in ("LFoot", "RFoot")
            for place in "FrontLeft FrontRight RearLeft RearRight TotalWeight CenterOfPressure/X".split()
        ),
        *(f"{foot}/FSR/CenterOfPressure/Y/Sensor/Value" for foot in ("LFoot", "RFoot")),
        *(f"InertialSensor/{name}/Sensor/Value" for name in "AngleX AngleY AngleZ AccX AccY AccZ".split()),
        *(f"InertialSensor/{name}/Sensor/Value" for name in "GyrX GyrY GyrRef".split()),
        *(
            f"InertialSensor/{quantity}{axis}/Sensor/Value"
            for quantity in ("Accelerometer", "Gyroscope")
            for axis in "XYZ"
        ),
        *(f"{hand}/Touch/{side}/Sensor/Value" for hand in ("LHand", "RHand") for side in ("Left", "Back", "Right")),
        *(f"Head/Touch/{place}/Sensor/Value" for place in ("Front", "Middle", "Rear")),
        *(f"{foot}/Bumper/{side}/Sensor/Value" for foot in ("LFoot", "RFoot") for side in ("Left", "Right")),
        "ChestBoard/Button/Sensor/Value",
        *(f"Battery/{quantity}/Sensor/Value" for quantity in ("Charge", "Current", "Temperature")),
        "Head/Temperature/Sensor/Value",
        "US/Actuator/Value",
    ]
    events = "footContact leftFootContact rightFootContact leftFootTotalWeight rightFootTotalWeight".split()
    return [*(f"Device/SubDeviceList/{value}" for value in values), *events]


def test_every_documented_key_has_a_value(virtual: VirtualNao) -> None:
    keys = _documented_keys()
    assert len(set(keys)) == len(keys) > 300
    values = virtual.call("ALMemory", "getListData", keys)
    assert [key for key, value in zip(keys, values, strict=True) if value is None] == []
    assert set(keys) <= set(virtual.call("ALMemory", "getDataListName"))


def test_memory_shows_lights_and_where_the_feet_are(virtual: VirtualNao) -> None:
    def get(key: str) -> Any:
        return virtual.call("ALMemory", "getData", key)

    virtual.call("ALLeds", "fadeRGB", "AllLeds", 0x800000, 0.0)
    virtual.call("ALLeds", "setIntensity", "Face/Led/Blue/Left/45Deg/Actuator/Value", 0.25)
    assert get("Device/SubDeviceList/Face/Led/Red/Left/45Deg/Actuator/Value") == pytest.approx(128 / 255)
    assert get("Device/SubDeviceList/Face/Led/Blue/Left/45Deg/Actuator/Value") == 0.25
    assert get("Device/SubDeviceList/Ears/Led/Left/36Deg/Actuator/Value") == pytest.approx(128 / 255)
    feet = ("leftFootContact", "rightFootContact", "footContact")
    virtual.call("ALRobotPosture", "goToPosture", "StandInit", 1.0)
    assert [get(foot) for foot in feet] == [True, True, True]
    _motion(virtual, "angleInterpolation", ["RHipPitch", "RKneePitch"], [[-1.2], [1.6]], [[1.0], [1.0]], True)
    assert [get(foot) for foot in feet] == [True, False, True]
    virtual.call("ALRobotPosture", "goToPosture", "LyingBack", 1.0)
    assert [get(foot) for foot in feet] == [False, False, False]


def test_a_switch_that_a_test_presses_raises_its_events(virtual: VirtualNao) -> None:
    heard: list[Any] = []
    for event in ("FrontTactilTouched", "RightBumperPressed", "TouchChanged"):
        virtual.call("ALMemory", "subscriber", event).connect(lambda value, event=event: heard.append((event, value)))
    front = "Device/SubDeviceList/Head/Touch/Front/Sensor/Value"
    left, right = (f"Device/SubDeviceList/RFoot/Bumper/{side}/Sensor/Value" for side in ("Left", "Right"))
    virtual.call("ALMemory", "insertData", front, 1.0)
    virtual.call("ALMemory", "insertData", front, 1)  # pressed already
    assert heard == [
        ("FrontTactilTouched", 1.0),
        ("TouchChanged", [["Head", True], ["Head/Touch/Front", True]]),
    ]
    assert virtual.call("ALMemory", "getData", "FrontTactilTouched") == 1.0
    assert ["Head/Touch/Front", True] in virtual.call("ALTouch", "getStatus")
    virtual.call("ALMemory", "removeData", front)
    assert heard[2:] == [("FrontTactilTouched", 0.0), ("TouchChanged", [["Head", False], ["Head/Touch/Front", False]])]
    heard.clear()
    virtual.call("ALMemory", "insertListData", [[left, 1.0], [right, 1.0]])
    virtual.call("ALMemory", "raiseEvent", left, 0.0)
    assert [value for event, value in heard if event == "RightBumperPressed"] == [1.0]
    virtual.call("ALMemory", "insertData", right, "released")
    assert [value for event, value in heard if event == "RightBumperPressed"] == [1.0, 0.0]
    assert virtual.call("ALTouch", "getStatus") == [[name, False] for name in virtual.call("ALTouch", "getSensorList")]


def test_a_sonar_hears_what_is_inserted_while_somebody_subscribes(virtual: VirtualNao) -> None:
    heard: list[Any] = []
    for event in ("SonarLeftDetected", "SonarLeftNothingDetected", "SonarRightDetected", "SonarRightNothingDetected"):
        virtual.call("ALMemory", "subscriber", event).connect(lambda value, event=event: heard.append((event, value)))
    left, right = (f"Device/SubDeviceList/US/{side}/Sensor/Value" for side in ("Left", "Right"))
    virtual.call("ALMemory", "insertData", left, 0.3)
    assert heard == []
    virtual.call("ALSonar", "subscribe", "test")
    virtual.call("ALMemory", "insertListData", [[left, 0.3], [right, 1.2]])
    assert heard == [("SonarLeftDetected", 0.3), ("SonarRightNothingDetected", 1.2)]
    assert virtual.call("ALMemory", "getListData", [left, right]) == [0.3, 1.2]
    virtual.call("ALMemory", "removeData", left)
    assert heard[2:] == [("SonarLeftNothingDetected", 2.55)]
    assert virtual.call("ALSonar", "getSubscribersInfo") == [["test", 500, 0.0]]
    virtual.call("ALSonar", "unsubscribe", "test")
    virtual.call("ALMemory", "insertData", left, 0.3)
    assert len(heard) == 3
    assert "has not subscribed" in _refused(virtual, "ALSonar", "unsubscribe", "test")


def test_what_is_inserted_stands_before_the_robots_own_until_it_is_removed(virtual: VirtualNao) -> None:
    key = "Device/SubDeviceList/Head/Touch/Front/Sensor/Value"
    virtual.call("ALMemory", "insertData", key, 1.0)
    virtual.call("ALMemory", "insertListData", [["mine", [1, "two", {"three": 3}]], ["other", None]])
    assert virtual.call("ALMemory", "getListData", [key, "mine", "none"]) == [1.0, [1, "two", {"three": 3}], None]
    assert virtual.call("ALMemory", "getDataList", "min") == ["mine"]
    assert "mine" in virtual.call("ALMemory", "getDataListName")
    virtual.call("ALMemory", "removeData", key)
    assert virtual.call("ALMemory", "getData", key) == 0.0
    virtual.call("ALMemory", "removeData", "mine")
    assert "unknown key 'mine'" in _refused(virtual, "ALMemory", "getData", "mine")
    assert "unknown key" in _refused(virtual, "ALMemory", "removeData", key)
    assert "nearest" in _refused(virtual, "ALMemory", "getData", "robotIsWakeUpp")
    assert "must not be empty" in _refused(virtual, "ALMemory", "insertData", "", 1)
    assert "[key, value]" in _refused(virtual, "ALMemory", "insertListData", [["a"]])
    assert "list of keys" in _refused(virtual, "ALMemory", "getListData", "a")
    virtual.call("ALMemory", "setDescription", "other", "another one")
    assert virtual.call("ALMemory", "getDescriptionList", ["other"]) == [["other", "NoneType", "another one"]]


def test_events_are_told_to_whoever_subscribes(virtual: VirtualNao) -> None:
    heard: list[Any] = []
    subscriber = virtual.call("ALMemory", "subscriber", "mine")
    number = subscriber.connect(heard.append)
    virtual.call("ALMemory", "insertData", "mine", 0)  # nobody is told
    virtual.call("ALMemory", "raiseEvent", "mine", 1)
    virtual.call("ALMemory", "raiseMicroEvent", "mine", [2])
    virtual.call("ALMemory", "raiseEvent", "other", 3)
    assert heard == [1, [2]]
    assert virtual.call("ALMemory", "getData", "mine") == [2]
    assert subscriber.disconnect(number)
    assert not subscriber.disconnect(number)
    virtual.call("ALMemory", "raiseEvent", "mine", 4)
    assert heard == [1, [2]]
    virtual.call("ALMemory", "declareEvent", "declared")
    assert {"mine", "other", "declared"} <= set(virtual.call("ALMemory", "getEventList"))


def test_memory_tells_when_a_value_was_stored_and_an_event_raised(virtual: VirtualNao) -> None:
    memory = "ALMemory"
    start = virtual.clock.now
    virtual.call(memory, "insertData", "Here", [1, "two"])
    virtual.step(1.25)
    assert virtual.call(memory, "getTimestamp", "Here") == [[1, "two"], int(start), round(1e6 * (start % 1.0))]
    assert virtual.call(memory, "getType", "Here") == "list"
    assert virtual.call(memory, "getTimestamp", "DCM/Time") == [1250, 1, 250000]
    virtual.call(memory, "raiseMicroEvent", "Ping", 1)
    virtual.step(0.5)
    virtual.call(memory, "raiseEvent", "Ping", 2.0)
    assert virtual.call(memory, "getEventHistory", "Ping") == [[1, 1, 250000], [2.0, 1, 750000]]
    assert virtual.call(memory, "getEventHistory", "None") == []
    heard: list[Any] = []
    virtual.call(memory, "subscriber", "Ping").connect(heard.append)
    virtual.call(memory, "removeMicroEvent", "Ping")
    assert "Ping" not in virtual.call(memory, "getEventList")
    assert virtual.call(memory, "getEventHistory", "Ping") == []
    assert "unknown key 'Ping'" in _refused(virtual, memory, "getData", "Ping")
    virtual.call(memory, "raiseEvent", "Ping", 3)
    assert heard == []
    assert "unknown event 'Pong' (nearest: Ping)" in _refused(virtual, memory, "removeMicroEvent", "Pong")


def test_old_scripts_have_a_method_of_a_service_called(virtual: VirtualNao) -> None:
    called: list[tuple[Any, ...]] = []
    memory = virtual.services["ALMemory"]
    memory.module_called = lambda *given: called.append(given)  # type: ignore[attr-defined]
    virtual.call("ALMemory", "subscribeToEvent", "mine", "Module", "onMine")
    virtual.call("ALMemory", "subscribeToEvent", "mine", "Other", "note", "onMine")
    assert virtual.call("ALMemory", "getSubscribers", "mine") == ["Module", "Other"]
    virtual.call("ALMemory", "raiseEvent", "mine", 5)
    assert called == [("Module", "onMine", "mine", 5, "Module"), ("Other", "onMine", "mine", 5, "note")]
    virtual.call("ALMemory", "unsubscribeToEvent", "mine", "Module")
    virtual.call("ALMemory", "raiseEvent", "mine", 6)
    assert len(called) == 3
    assert "has not subscribed" in _refused(virtual, "ALMemory", "unsubscribeToEvent", "mine", "Module")
    virtual.call("ALMemory", "unsubscribeToMicroEvent", "mine", "Other")
    virtual.call("ALMemory", "subscribeToMicroEvent", "mine", "Module", "small", "onMine")
    virtual.call("ALMemory", "raiseMicroEvent", "mine", 7)
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


def test_a_fade_is_a_straight_line_of_colours(virtual: VirtualNao) -> None:
    call = virtual.post("ALLeds", "fadeRGB", "FaceLeds", 0x00FF0000, 1.0)  # from white
    virtual.step(0.5)
    colours = virtual.state().leds
    assert colours["FaceLedLeft0"] == pytest.approx((1.0, 0.5, 0.5), abs=0.03)
    assert colours["ChestLeds"] == (1.0, 1.0, 1.0)
    virtual.step(0.5)
    assert call.done()
    assert {virtual.state().leds[led] for led in virtual.call("ALLeds", "listGroup", "FaceLeds")} == {(1.0, 0.0, 0.0)}
    assert len(virtual.call("ALLeds", "listGroup", "FaceLeds")) == 16


@pytest.mark.parametrize("colour", [(0x0000FF00,), ("green",), (0.0, 1.0, 0.0), (65280.0,)])
def test_a_colour_is_a_number_a_name_or_three_shares(virtual: VirtualNao, colour: tuple[Any, ...]) -> None:
    begin = virtual.clock.now
    virtual.call("ALLeds", "fadeRGB", "ChestLeds", *colour, 0.3)
    assert virtual.clock.now - begin == pytest.approx(0.3, abs=1e-9)
    assert virtual.call("ALLeds", "getIntensity", "ChestLeds") == [0.0, 1.0, 0.0]


def test_a_led_does_what_it_was_told_last(virtual: VirtualNao) -> None:
    def eyes() -> list[float]:
        return virtual.call("ALLeds", "getIntensity", "FaceLeds")

    slow = virtual.post("ALLeds", "fadeRGB", "AllLeds", "red", 2.0)
    virtual.step(0.5)
    quick = virtual.post("ALLeds", "fadeRGB", "FaceLeds", "blue", 0.5)
    virtual.step(0.6)
    assert (slow.done(), quick.done(), eyes()) == (False, True, [0.0, 0.0, 1.0])
    virtual.step(1.0)
    assert slow.done()
    assert eyes() == [0.0, 0.0, 1.0]
    assert virtual.call("ALLeds", "getIntensity", "ChestLeds") == [1.0, 0.0, 0.0]
    colours = virtual.post("ALLeds", "rasta", 2.0)
    virtual.step(0.3)
    virtual.call("ALLeds", "off", "FaceLeds")
    virtual.step(0.5)
    assert eyes() == [0.0] * 3
    virtual.step(2.0)
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
def test_leds_have_their_actuators_names_too(virtual: VirtualNao, actuator: str, led: str, lit: list[float]) -> None:
    virtual.call("ALLeds", "off", "AllLeds")
    virtual.call("ALLeds", "setIntensity", actuator, 0.8)
    assert virtual.call("ALLeds", "getIntensity", led) == lit
    assert sum(max(colour) > 0.0 for colour in virtual.state().leds.values()) == 1
    virtual.call("ALLeds", "off", "AllLeds")
    virtual.call("ALLeds", "createGroup", "mine", [actuator])
    virtual.call("ALLeds", "setIntensity", "mine", 0.8)
    assert virtual.call("ALLeds", "getIntensity", led) == lit
    assert virtual.call("ALLeds", "listGroup", "mine") == virtual.call("ALLeds", "listGroup", led)


def test_leds_are_reset_to_their_initial_colours(virtual: VirtualNao) -> None:
    initial = dict(virtual.state().leds)
    assert virtual.call("ALLeds", "listLED") == virtual.call("ALLeds", "listLEDs") == list(initial)
    virtual.call("ALLeds", "off", "AllLeds")
    virtual.call("ALLeds", "reset", "LeftEarLeds")
    changed = virtual.state().leds
    assert all((changed[led] == colour) == led.startswith("LeftEar") for led, colour in initial.items())
    virtual.call("ALLeds", "reset", "AllLeds")
    assert virtual.state().leds == initial


def test_leds_go_on_and_off_by_group_led_and_channel(virtual: VirtualNao) -> None:
    def led(name: str) -> tuple[float, float, float]:
        return virtual.state().leds[name]

    virtual.call("ALLeds", "off", "AllLeds")
    assert set(virtual.state().leds.values()) == {(0.0, 0.0, 0.0)}
    virtual.call("ALLeds", "on", "FaceLedLeft3")
    virtual.call("ALLeds", "setIntensity", "ChestLedsBlue", 0.5)
    virtual.call("ALLeds", "setIntensity", "LeftEarLed1", 0.25)
    virtual.call("ALLeds", "setIntensity", "Brain0", 0.75)
    assert led("FaceLedLeft3") == (1.0, 1.0, 1.0)
    assert led("ChestLeds") == (0.0, 0.0, 0.5)
    assert led("LeftEarLed1") == (0.0, 0.0, 0.25)
    assert led("Brain0") == (0.75, 0.75, 0.75)
    virtual.call("ALLeds", "on", "FaceLed0")
    assert led("FaceLedLeft0") == led("FaceLedRight0") == (1.0, 1.0, 1.0)
    assert virtual.call("ALLeds", "listGroup", "RightFaceLed1") == ["FaceLedRight7"]
    assert virtual.call("ALLeds", "listGroup", "LeftFaceLed1") == ["FaceLedLeft0"]
    virtual.call("ALLeds", "createGroup", "mine", ["ChestLeds", "FeetLeds"])
    virtual.call("ALLeds", "fade", "mine", 1.0, 0.2)
    assert led("LeftFootLeds") == led("ChestLeds") == (1.0, 1.0, 1.0)
    assert "mine" in virtual.call("ALLeds", "listGroups")
    assert set(virtual.call("ALLeds", "listLEDs")) == set(virtual.state().leds)
    virtual.call("ALLeds", "fadeListRGB", "ChestLeds", ["red", 0x0000FF], [0.2, 0.4])
    assert led("ChestLeds") == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("method", "arguments"), [("rasta", (1.0,)), ("randomEyes", (1.0,)), ("rotateEyes", (0xFF0000, 0.5, 1.0))]
)
def test_eye_effects_take_their_time_and_leave_the_eyes_as_they_were(
    virtual: VirtualNao, method: str, arguments: tuple[Any, ...]
) -> None:
    virtual.call("ALLeds", "fadeRGB", "FaceLeds", "yellow", 0.0)
    before, begin = dict(virtual.state().leds), virtual.clock.now
    call, seen = virtual.post("ALLeds", method, *arguments), set()
    while not call.done():
        virtual.step(0.05)
        seen.add(virtual.state().leds["FaceLedLeft0"])
    assert virtual.clock.now - begin == pytest.approx(1.0, abs=1e-9)
    assert len(seen) > 1
    assert virtual.state().leds == before


@pytest.mark.parametrize(
    ("method", "arguments", "reason"),
    [
        ("on", ("FaceLed",), "nearest: FaceLeds"),
        ("setIntensity", ("FaceLeds", 2.0), "between 0 and 1"),
        ("fadeRGB", ("FaceLeds", "purple", 1.0), "unknown colour"),
        ("fadeRGB", ("FaceLeds", -1, 1.0), "0x00RRGGBB"),
        ("fadeRGB", ("FaceLeds", 1.0), "takes name, rgb, seconds"),
        ("fadeRGB", ("FaceLeds", 0xFF, -1.0), "at least 0 s"),
        ("rasta", (0.0,), "above 0 s"),
        ("fadeListRGB", ("FaceLeds", [1, 2], [1.0]), "2 times"),
        ("createGroup", ("FaceLeds", ["ChestLeds"]), "already exists"),
    ],
)
def test_bad_lights_are_refused(virtual: VirtualNao, method: str, arguments: tuple[Any, ...], reason: str) -> None:
    assert reason in _refused(virtual, "ALLeds", method, *arguments)


def test_a_text_takes_its_length_and_texts_wait_for_each_other(virtual: VirtualNao) -> None:
    first = virtual.post("ALTextToSpeech", "say", "x" * 14)  # 0.3 s and 14/14 s
    second = virtual.post("ALTextToSpeech", "say", "y" * 7)
    virtual.step(1.29)
    assert not first.done()
    assert virtual.state().saying == "x" * 14
    virtual.step(0.01)
    assert first.done()
    assert virtual.state().saying == "y" * 7
    virtual.step(0.8)
    assert second.done()
    assert virtual.state().saying == ""
    assert [line for _, line in virtual.log.lines][-2:] == [f"says: {'x' * 14}", f"says: {'y' * 7}"]


def test_speed_and_pauses_change_how_long_it_takes(virtual: VirtualNao) -> None:
    virtual.call("ALTextToSpeech", "setParameter", "speed", 200)
    begin = virtual.clock.now
    virtual.call("ALTextToSpeech", "say", "\\vct=120\\abcdefg\\pau=500\\hijklmn")
    assert virtual.clock.now - begin == pytest.approx(0.3 + 0.5 + 0.5, abs=1e-9)
    virtual.call("ALTextToSpeech", "resetSpeed")
    assert virtual.call("ALTextToSpeech", "getParameter", "speed") == 100.0


def test_it_can_be_silenced(virtual: VirtualNao) -> None:
    calls = [virtual.post("ALTextToSpeech", "say", "a long story " * 10) for _ in range(3)]
    virtual.step(0.1)
    assert calls[1].cancel()
    assert calls[0].cancel()
    assert virtual.state().saying.startswith("a long")
    virtual.call("ALTextToSpeech", "stopAll")
    assert all(call.done() for call in calls)
    assert virtual.state().saying == ""
    virtual.step(60.0)
    virtual.call("ALTextToSpeech", "say", "again", "French")


def test_voices_are_kept(virtual: VirtualNao) -> None:
    for name, value in (("Language", "German"), ("Volume", 0.5), ("Voice", "naofrf")):
        virtual.call("ALTextToSpeech", f"set{name}", value)
        assert virtual.call("ALTextToSpeech", f"get{name}") == value
    assert "German" in virtual.call("ALTextToSpeech", "getAvailableLanguages")
    assert virtual.call("ALTextToSpeech", "getAvailableVoices") == ["naoenu"]
    assert "unknown language" in _refused(virtual, "ALTextToSpeech", "setLanguage", "Klingon")
    assert "must be a text" in _refused(virtual, "ALTextToSpeech", "say", 5)
    assert "between 0 and 1" in _refused(virtual, "ALTextToSpeech", "setVolume", 50)
    assert "from 50 to 400" in _refused(virtual, "ALTextToSpeech", "setParameter", "speed", 1)


def test_a_life_that_ends_rests(asleep: VirtualNao) -> None:
    assert asleep.call("ALAutonomousLife", "getState") == "disabled"
    asleep.call("ALAutonomousLife", "setState", "disabled")
    asleep.call("ALAutonomousLife", "setState", "solitary")
    assert _motion(asleep, "robotIsWakeUp") is True
    asleep.call("ALAutonomousLife", "setState", "disabled")
    assert _motion(asleep, "robotIsWakeUp") is False
    assert "nearest: solitary" in _refused(asleep, "ALAutonomousLife", "setState", "solitry")
    asleep.call("ALAutonomousLife", "setAutonomousAbilityEnabled", "BasicAwareness", False)
    assert asleep.call("ALAutonomousLife", "getAutonomousAbilityEnabled", "BasicAwareness") is False
    assert ["BasicAwareness", False, False] in asleep.call("ALAutonomousLife", "getAutonomousAbilitiesStatus")
    asleep.call("ALAutonomousLife", "setRobotOffsetFromFloor", 0.1)
    assert asleep.call("ALAutonomousLife", "getRobotOffsetFromFloor") == 0.1
    assert asleep.call("ALAutonomousLife", "focusedActivity") == ""
    asleep.call("ALAutonomousLife", "stopAll")


def test_the_small_services_answer(virtual: VirtualNao) -> None:
    assert virtual.call("ALSystem", "robotName") == "nao"
    assert virtual.call("ALSystem", "setRobotName", "Ada") is True
    assert virtual.call("ALSystem", "robotName") == "Ada"
    assert virtual.call("ALSystem", "systemVersion") == "2.8"
    assert virtual.call("ALSystem", "systemInfo")[0] == ["robot", "nao_v6"]
    assert virtual.call("ALSystem", "freeMemory") == virtual.call("ALSystem", "totalMemory") == 0
    assert virtual.call("ALBattery", "getBatteryCharge") == 100
    virtual.call("ALMemory", "insertData", "Device/SubDeviceList/Battery/Charge/Sensor/Value", 0.42)
    assert virtual.call("ALBattery", "getBatteryCharge") == 42


def test_abilities_are_switched_off_by_their_services_too(virtual: VirtualNao) -> None:
    names = [name for name, _, _ in virtual.call("ALAutonomousLife", "getAutonomousAbilitiesStatus")]
    assert len(names) == 5
    for name in names:
        assert virtual.call(f"AL{name}", "isEnabled") is True
        virtual.call(f"AL{name}", "setEnabled", False)
        assert virtual.call(f"AL{name}", "isEnabled") is False
        assert virtual.call("ALAutonomousLife", "getAutonomousAbilityEnabled", name) is False
        assert virtual.call(f"AL{name}", "isRunning") is False
        assert virtual.call(f"AL{name}", "isRunning", 1) is False
    virtual.call("ALBasicAwareness", "startAwareness")
    assert virtual.call("ALBasicAwareness", "isEnabled") is True
    virtual.call("ALBasicAwareness", "stopAwareness")
    assert (
        virtual.call("ALBasicAwareness", "isEnabled") is virtual.call("ALBasicAwareness", "isAwarenessRunning") is False
    )
    virtual.call("ALAutonomousMoves", "setExpressiveListeningEnabled", False)
    virtual.call("ALAutonomousMoves", "setBackgroundStrategy", "none")
    assert virtual.call("ALAutonomousMoves", "getExpressiveListeningEnabled") is False
    assert virtual.call("ALAutonomousMoves", "getBackgroundStrategy") == "none"
    assert "backToNeutral" in _refused(virtual, "ALAutonomousMoves", "setBackgroundStrategy", "all")


def test_preferences_are_kept_by_domain(virtual: VirtualNao) -> None:
    def call(method: str, *arguments: Any) -> Any:
        return virtual.call("ALPreferenceManager", method, *arguments)

    assert call("getValue", "my.domain", "colour") is None
    call("setValue", "my.domain", "colour", "red")
    call("setValue", "my.domain", "size", [1, 2])
    assert call("getValue", "my.domain", "colour") == "red"
    assert call("getValueList", "my.domain") == [["colour", "red"], ["size", [1, 2]]]
    assert call("getDomainList") == ["my.domain"]
    call("removeValue", "my.domain", "size")
    assert "nearest: colour" in _refused(virtual, "ALPreferenceManager", "removeValue", "my.domain", "color")
    call("removeDomainValues", "my.domain")
    assert call("getDomainList") == []


@pytest.mark.parametrize(
    ("method", "arguments", "kernels"),
    [
        ("setPositions", ("LArm", 0, [0.1] * 6, 0.5, 7), {"arms by pose", "arms by place"}),
        ("positionInterpolation", ("LLeg", 0, [0.1] * 6, 63, 1.0), {"damped least squares"}),
        (
            "setPositions",
            (["LArm", "Torso"], 0, [[0.1] * 6] * 2, 0.5, 7),
            {"arms by pose", "arms by place", "both legs", "bodies"},
        ),
        ("moveTo", (0.1, 0.0, 0.0), {"both legs"}),
        ("moveIsActive", (), set()),
        ("wbEnable", (True,), {"bodies"}),
        ("getPosition", ("LArm", 0, True), set()),
        ("setAngles", ("LArm", [0.0] * 6, 0.5), set()),
    ],
)
def test_what_must_be_compiled_is_so_before_the_lock_is_taken(
    virtual: VirtualNao,
    monkeypatch: pytest.MonkeyPatch,
    method: str,
    arguments: tuple[Any, ...],
    kernels: set[str],
) -> None:
    asked: list[str] = []

    def warm_up(names: list[str]) -> None:
        # Another script is served meanwhile.
        other = threading.Thread(target=lambda: asked.append(virtual.call("ALMotion", "ping")))
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
            virtual.services["ALMotion"].invoke(method, *arguments)
    else:
        virtual.services["ALMotion"].invoke(method, *arguments)
    assert set(asked) == kernels


@pytest.mark.parametrize(
    ("service", "method", "arguments"),
    [
        ("ALTracker", "lookAt", ([1.0, 0.3, 0.2], 0, 0.5, False)),
        ("ALTracker", "lookAt", ([-1.0, 2.0, 0.1], 0, 0.5, False)),  # out of reach
        ("ALMotion", "setPositions", ("Head", 0, [0.0, 0.0, 0.1, 0.0, 0.1, 0.2], 0.5, 56)),
        ("ALMotion", "setPositions", ("LLeg", 0, [0.0, 0.05, -0.3, 0.0, 0.0, 0.0], 0.5, 63)),
    ],
)
def test_a_call_that_names_no_kernel_loads_none(
    virtual: VirtualNao, monkeypatch: pytest.MonkeyPatch, service: str, method: str, arguments: tuple[Any, ...]
) -> None:
    def ready(kernel: CachedKernel) -> None:
        raise AssertionError(f"{kernel.name} is loaded while the lock is held")

    monkeypatch.setattr(CachedKernel, "in_memory", False)
    monkeypatch.setattr(CachedKernel, "ready", ready)
    monkeypatch.setattr(CachedKernel, "compile_in_background", ready)
    assert virtual.services[service].kernels_for(method, arguments) == frozenset()
    virtual.services[service].invoke(method, *arguments)


def test_robot_time_stands_still_while_a_call_waits_for_its_kernels(
    nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    times: list[float] = []

    def warm_up(_: list[str]) -> None:
        times.append(virtual.clock.now)
        time.sleep(0.1)  # a thousand ticks
        times.append(virtual.clock.now)

    monkeypatch.setattr("nao_kin.naoqi.virtual.service.warm_up", warm_up)
    monkeypatch.setattr("nao_kin.naoqi.virtual.service._ready", set())
    with VirtualNao(nao, speed=100.0) as virtual:
        virtual.call("ALMotion", "wbEnable", False)
        begun = virtual.clock.now
        later = threading.Event()
        with virtual.monitor:
            virtual.clock.after(0.1, later.set)
        assert later.wait(60.0)  # time goes on afterwards
        assert virtual.clock.now > begun
    assert times[0] == times[1]
