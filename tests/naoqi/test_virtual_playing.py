"""Behaviours that the virtual NAO plays, and points that it looks at and points at; stepped by hand."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument
from nao_kin.naoqi.virtual import NaoqiError, VirtualNao

TIMELINES = Path(__file__).parents[1] / "data" / "motions" / "timelines.xar"
NOD = nk.Motion(
    [[0.2, 0.6], [0.0, 0.5, 1.0], [0.4, 1.0]],
    ["HeadPitch", "LElbowRoll", "RHand"],
    [[0.3, -0.2], [-0.4, -0.9, -0.5], [0.8, 0.2]],
    "bezier",
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "hello" / "behavior_1").mkdir(parents=True)
    nk.motion.write_motion(NOD, tmp_path / "hello" / "behavior_1" / "behavior.xar")
    for name in ("Stand", "Sit"):
        (tmp_path / "Nao").mkdir(exist_ok=True)
        nk.motion.write_motion(NOD, tmp_path / "Nao" / f"{name}.xar")
    shutil.copy(TIMELINES, tmp_path / "several.xar")
    (tmp_path / "broken.xar").write_text("<ChoregrapheProject>")
    return tmp_path


@pytest.fixture
def virtual(nao: nk.NaoModel, folder: Path) -> Iterator[VirtualNao]:
    with VirtualNao(nao, stepped=True, posture="StandInit", behaviors=folder) as made:
        made.call("ALMotion", "wakeUp")
        yield made


def _angles(nao: VirtualNao, *names: str, sensor: bool = True) -> list[float]:
    return list(nao.call("ALMotion", "getAngles", list(names), sensor))


def _refused(nao: VirtualNao, service: str, method: str, *arguments: Any) -> str:
    with pytest.raises(NaoqiError) as caught:
        nao.call(service, method, *arguments)
    service_and_method, reason = str(caught.value).split("\n\t")
    assert service_and_method == f"{service}::{method}"
    assert nao.call("ALMotion", "getTaskList") == []
    return reason


# --- behaviours -------------------------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore:.*several.xar. keys outside of frames")
def test_behaviours_are_named_by_their_folders_and_all_of_them_can_be_played(virtual: VirtualNao) -> None:
    names = ["Nao/Sit", "Nao/Stand", "broken", "hello/behavior_1", "several"]
    assert virtual.call("ALBehaviorManager", "getInstalledBehaviors") == names
    assert virtual.call("ALBehaviorManager", "getBehaviorNames") == names
    assert virtual.call("ALBehaviorManager", "isBehaviorInstalled", "hello/behavior_1") is True
    assert virtual.call("ALBehaviorManager", "isBehaviorPresent", "hello") is False
    assert virtual.call("ALBehaviorManager", "preloadBehavior", "hello/behavior_1") is True
    for name in ("Nao/Sit", "Nao/Stand", "hello/behavior_1", "several/1", "several/2", "several/wave"):
        assert virtual.call("ALBehaviorManager", "isBehaviorInstalled", name) is True
        virtual.call("ALBehaviorManager", "runBehavior", name)
    for name, why in (("broken", "broken.xar"), ("several", "by name or number: 1: Dance/wave")):
        assert virtual.call("ALBehaviorManager", "isBehaviorInstalled", name) is False
        assert why in virtual.log.lines[-1][1]


def test_a_behaviour_is_played_along_its_curves(virtual: VirtualNao) -> None:
    (pitch,) = _angles(virtual, "HeadPitch")
    call = virtual.post("ALBehaviorManager", "runBehavior", "hello/behavior_1")
    assert virtual.call("ALBehaviorManager", "getRunningBehaviors") == ["hello/behavior_1"]
    assert virtual.call("ALBehaviorManager", "isBehaviorRunning", "hello/behavior_1") is True
    with pytest.raises(NaoqiError, match="running already"):
        virtual.call("ALBehaviorManager", "runBehavior", "hello/behavior_1")
    virtual.step(0.1)
    # Halfway to the first key, along level handles.
    assert _angles(virtual, "HeadPitch", sensor=False) == pytest.approx([0.5 * (pitch + 0.3)], abs=1e-6)
    for time in (0.2, 0.35, 0.5, 0.8):
        virtual.step(time - virtual.clock.now)
        assert _angles(virtual, *NOD.joint_names, sensor=False)[:2] == pytest.approx(NOD.sample(time)[:2], abs=1e-6)
    virtual.step(0.3)
    assert call.done()
    assert virtual.clock.now == pytest.approx(1.1)
    assert _angles(virtual, *NOD.joint_names) == pytest.approx([-0.2, -0.5, 0.2], abs=1e-6)
    assert virtual.call("ALBehaviorManager", "isBehaviorRunning", "hello/behavior_1") is False


def test_a_behaviour_is_stopped_where_it_is(virtual: VirtualNao) -> None:
    for stop in (("stopBehavior", "hello/behavior_1"), ("stopAllBehaviors",)):
        assert virtual.call("ALBehaviorManager", "startBehavior", "hello/behavior_1") is None
        virtual.step(0.3)
        at = _angles(virtual, "LElbowRoll")
        virtual.call("ALBehaviorManager", *stop)
        virtual.step(0.3)
        assert virtual.call("ALBehaviorManager", "getLoadedBehaviors") == []
        assert _angles(virtual, "LElbowRoll") == pytest.approx(at, abs=0.05)
    virtual.call("ALBehaviorManager", "stopBehavior", "none")


@pytest.mark.parametrize("name", ["several/1", "several/wave", "several/Dance/wave"])
def test_one_of_several_timelines_is_played_by_name_or_number(virtual: VirtualNao, name: str) -> None:
    virtual.call("ALBehaviorManager", "runBehavior", name)
    last = nk.motion.read_motion(TIMELINES, timeline="wave")
    joints = [joint for joint in last.joint_names if joint != "RHipYawPitch"]
    expected = dict(zip(last.joint_names, last.sample(last.end), strict=True))
    assert _angles(virtual, *joints) == pytest.approx([expected[joint] for joint in joints], abs=1e-6)


def test_an_animation_knows_robot_and_posture(virtual: VirtualNao) -> None:
    for posture in ("Stand", "Sit"):
        virtual.call("ALRobotPosture", "goToPosture", posture, 1.0)
        virtual.call("ALAnimationPlayer", "run", "[robot]/[posture]")
        assert _angles(virtual, "HeadPitch") == pytest.approx([-0.2], abs=1e-6)
    virtual.call("ALRobotPosture", "goToPosture", "LyingBack", 1.0)
    assert "family of postures is LyingBack" in _refused(virtual, "ALAnimationPlayer", "run", "[robot]/[posture]")


def test_what_cannot_be_played_says_why(virtual: VirtualNao, nao: nk.NaoModel, tmp_path: Path) -> None:
    assert "nearest: hello/behavior_1" in _refused(virtual, "ALBehaviorManager", "runBehavior", "hello/behavior_2")
    assert "broken.xar" in _refused(virtual, "ALBehaviorManager", "startBehavior", "broken")
    assert "2 timelines" in _refused(virtual, "ALBehaviorManager", "startBehavior", "several")
    assert "no timeline '3'" in _refused(virtual, "ALBehaviorManager", "startBehavior", "several/3")
    assert "'hello'" in _refused(virtual, "ALBehaviorManager", "startBehavior", "hello")
    assert "unknown behaviour" in _refused(virtual, "ALBehaviorManager", "runBehavior", "../secret")
    with VirtualNao(nao, stepped=True) as bare:
        assert bare.call("ALBehaviorManager", "getInstalledBehaviors") == []
        assert "--behaviors" in _refused(bare, "ALAnimationPlayer", "run", "animations/Stand/Gestures/Hey_1")
    with pytest.raises(BadArgument, match=r"behaviors must be a folder, got '.*nowhere'"):
        VirtualNao(nao, stepped=True, behaviors=tmp_path / "nowhere")


def test_a_folder_of_behaviours_that_is_not_there_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("qi")
    assert run(["serve", "--behaviors", "/nowhere"]) == 2
    assert capsys.readouterr().err == "nao-kin: behaviors must be a folder, got '/nowhere'\n"


# --- points -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("space", [nk.naoqi.FRAME_TORSO, nk.naoqi.FRAME_WORLD, nk.naoqi.FRAME_ROBOT])
def test_the_head_looks_at_a_point_in_each_space(virtual: VirtualNao, nao: nk.NaoModel, space: int) -> None:
    virtual.call("ALMotion", "angleInterpolation", ["LHipPitch", "RHipPitch"], -0.3, 0.5, True)  # leans
    rng = np.random.default_rng(2)
    for _ in range(5):
        point = np.array([rng.uniform(0.6, 3.0), rng.uniform(-1.0, 1.0), 0.3 + rng.uniform(-0.2, 0.2)])
        virtual.call("ALTracker", "lookAt", point.tolist(), space, 0.8, False)
        state = virtual.state()
        T = nk.naoqi.pose_in(nao, state.q, "CameraTop", space, torso_in_world=state.T_world_torso)
        way = T[:3, :3].T @ (point - T[:3, 3])
        assert way / np.linalg.norm(way) == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)


def test_old_scripts_leave_the_space_out(virtual: VirtualNao) -> None:
    virtual.call("ALTracker", "lookAt", [1.0, 0.3, 0.2], 0, 0.5, False)
    looked = _angles(virtual, "Head")
    virtual.call("ALTracker", "lookAt", [1.0, -0.3, 0.2], 0.5, False)
    assert _angles(virtual, "Head") == pytest.approx([-looked[0], looked[1]], abs=1e-6)


@pytest.mark.parametrize("arm", ["LArm", "RArm"])
def test_shoulder_hand_and_point_are_in_a_line(virtual: VirtualNao, nao: nk.NaoModel, arm: str) -> None:
    rng = np.random.default_rng(3)
    side = 1.0 if arm == "LArm" else -1.0
    for _ in range(4):
        point = np.array([rng.uniform(0.3, 2.0), side * rng.uniform(0.0, 1.0), rng.uniform(-0.6, 0.6)])
        virtual.call("ALTracker", "pointAt", arm if rng.random() < 0.5 else "Arms", point.tolist(), 0, 1.0)
        q = virtual.state().q
        shoulder = nao.position(q, f"{arm[0]}ShoulderPitch")
        hand = nao.position(q, arm) - shoulder
        cosine = hand @ (point - shoulder) / np.linalg.norm(hand) / np.linalg.norm(point - shoulder)
        assert cosine == pytest.approx(1.0, abs=1e-9)
        assert abs(q[nao.joint_names.index(f"{arm[0]}ElbowRoll")]) < 0.08  # stretched


def test_what_is_out_of_the_heads_reach_is_looked_at_as_far_as_limits_allow(virtual: VirtualNao) -> None:
    virtual.call("ALTracker", "lookAt", [-1.0, 0.2, 0.1], 0, 1.0, True)
    yaw, _ = _angles(virtual, "Head")
    assert yaw > 1.5
    lines = [text for _, text in virtual.log.lines if text.startswith("lookAt")]
    assert any("without the whole body" in line for line in lines)
    assert any("turns as far as it can" in line for line in lines)


def test_stopping_the_tracker_stops_the_head(virtual: VirtualNao) -> None:
    call = virtual.post("ALTracker", "lookAt", [1.0, 2.0, 0.2], 0, 0.05, False)
    virtual.step(0.1)
    virtual.call("ALTracker", "stopTracker")
    assert call.done()
    assert virtual.call("ALMotion", "getTaskList") == []
