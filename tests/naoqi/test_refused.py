"""What the services refuse: in NAOqi's two lines, before anything moves, with the reason and the nearest names."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from naoqi_script import TORSO, Script

from nao_kin.naoqi.virtual import NaoqiError

NAN = float("nan")
PLACE, OTHER = [0.15, 0.12, 0.06, 0.0, 0.0, 0.0], [0.16, 0.11, 0.02, 0.0, 0.0, 0.0]
EYE = np.eye(4).ravel().tolist()
# Method of ALMotion, arguments, words of the reason.
ALMOTION: list[tuple[str, tuple[Any, ...], str]] = [
    ("angleInterpolation", ("HeadYow", 0.5, 1.0, True), "nearest: HeadYaw"),
    ("angleInterpolation", ([], 0.5, 1.0, True), "at least one"),
    ("angleInterpolation", (["HeadYaw", "Head"], 0.5, 1.0, True), "HeadYaw twice"),
    ("angleInterpolation", ("HeadYaw", "left", 1.0, True), "got 'left'"),
    ("angleInterpolation", ("HeadYaw", [], 1.0, True), "empty"),
    ("angleInterpolation", ("HeadYaw", [[[0.5]]], [[[1.0]]], True), "list of numbers"),
    ("angleInterpolation", ("HeadYaw", NAN, 1.0, True), "angles must be finite"),
    ("angleInterpolation", ("HeadYaw", 0.5, 0.0, True), "above 0 s"),
    ("angleInterpolation", ("HeadYaw", [0.1, 0.2], [1.0, 0.5], True), "got 1 s and then 0.5 s"),
    ("angleInterpolation", ("HeadYaw", [0.1, 0.2], [1.0], True), "2 angles and 1 times"),
    ("angleInterpolation", ("Head", [0.1, 0.2, 0.3], 1.0, True), "2 for HeadYaw, HeadPitch, got 3"),
    ("angleInterpolation", ("Head", [[0.1, 0.2], [0.3]], [[1.0, 2.0], [1.0, 2.0]], True), "HeadPitch has 1 angles"),
    ("angleInterpolation", ("HeadYaw", 0.5, 1.0, "yes"), "True or False"),
    ("angleInterpolation", ("HeadYaw", 0.5, 1.0), "takes (names, angleLists, timeLists, isAbsolute), got 3"),
    ("setAngles", ("HeadYaw", 0.5, 0.0), "above 0 and at most 1, got 0"),
    ("angleInterpolationBezier", ("HeadYaw", [1.0, 2.0], [[0.1]]), "list of 2, got 1"),
    ("angleInterpolationBezier", ("HeadYaw", [1.0], [[[0.1, [3, 0]]]]), "[angle, handle, handle]"),
    ("angleInterpolationBezier", ("HeadYaw", [1.0], [[[0.1, [3, 0], [3, 0, 0]]]]), "handle of entry 0"),
    ("angleInterpolationBezier", ("HeadYaw", [1.0], [[[0.1, [3, -5.0, 0], [3, 0, 0]]]]), "HeadYaw"),
    ("setStiffnesses", ("Head", 1.5), "HeadYaw must be between 0 and 1, got 1.5"),
    ("setBreathConfig", ([["Bmp", 5]],), "valid: Bpm"),
    ("getMethodHelp", ("fly",), "unknown method"),
    ("getPosition", ("larm", TORSO, True), "nearest: LArm"),
    ("positionInterpolations", ("LHand", TORSO, PLACE, 7, 1.0), "unknown effector 'LHand'"),
    ("positionInterpolations", (["LArm", "LArm"], TORSO, [PLACE, PLACE], 7, [1.0, 1.0]), "twice"),
    ("positionInterpolations", ([], TORSO, [], 7, []), "at least one effector"),
    ("positionInterpolations", ("LArm", TORSO, PLACE, 64, 1.0), "from 0 to 63"),
    ("positionInterpolations", ("LArm", TORSO, PLACE[:5], 7, 1.0), "shape (..., 6)"),
    ("positionInterpolations", ("LArm", TORSO, [PLACE, OTHER], 7, 1.0), "2 poses and 1 times"),
    ("positionInterpolations", (["LArm", "RArm"], TORSO, [PLACE], 7, 1.0), "list of 2"),
    ("positionInterpolations", (["LArm", "RArm"], TORSO, [PLACE, PLACE], [7], 1.0), "axis masks"),
    ("positionInterpolations", ("Torso", TORSO, PLACE, 63, 1.0), "the torso itself"),
    ("transformInterpolations", ("LArm", TORSO, [*EYE[:15], 2.0], 7, 1.0), "last row"),
    ("transformInterpolations", ("LArm", TORSO, [2.0, *[0.0] * 11], 7, 1.0), "rotation"),
    ("positionInterpolation", (["LArm"], TORSO, PLACE, 7, 1.0, True), "effectorName must be a text"),
    ("setPositions", ("LArm", TORSO, [PLACE, OTHER], 0.5, 7), "one pose, got 2"),
    ("moveTo", (0.1, 0.0), "theta"),
    ("moveTo", ([[0.1, 0.0]],), "shape (..., 3)"),
    ("moveTo", (0.1, 0.0, 0.0, [["StepX", 0.1]]), "nearest: MaxStepX"),
    ("moveToward", (1.5, 0.0, 0.0), "from -1 to 1, got 1.5"),
    ("setFootSteps", (["LFoot"], [[0, 0.1, 0]], [1.0], False), "unknown leg 'LFoot'"),
    ("setFootSteps", (["LLeg"], [[0, 0.1, 0]], [1.0, 2.0], False), "1, got 1 and 2"),
    ("setFootSteps", (["LLeg", "RLeg"], [[0, 0.1, 0]] * 2, [1.0, 1.0], False), "ascend"),
    ("wbFootState", ("Loose", "Legs"), "unknown foot state 'Loose'"),
    ("wbSetEffectorControl", ("Head", [0.0, 0.0]), "shape (3,)"),
    ("wbSetEffectorControl", ("LArm", [0.0, 0.0, 0.0]), "LArm is not held"),
]
OTHERS: list[tuple[str, str, tuple[Any, ...], str]] = [
    ("ALMemory", "getData", ("robotIsWakeUpp",), "nearest"),
    ("ALMemory", "removeData", ("mine",), "unknown key 'mine'"),
    ("ALMemory", "insertData", ("", 1), "empty"),
    ("ALMemory", "insertListData", ([["a"]],), "pairs"),
    ("ALMemory", "unsubscribeToEvent", ("mine", "Module"), "has not subscribed"),
    ("ALLeds", "on", ("FaceLed",), "nearest: FaceLeds"),
    ("ALLeds", "fadeRGB", ("FaceLeds", "purple", 1.0), "unknown colour"),
    ("ALLeds", "fadeRGB", ("FaceLeds", -1, 1.0), "0x00RRGGBB"),
    ("ALLeds", "fadeRGB", ("FaceLeds", 1.0), "takes name, rgb, seconds"),
    ("ALLeds", "fadeListRGB", ("FaceLeds", [1, 2], [1.0]), "list of 2, got 1"),
    ("ALLeds", "createGroup", ("FaceLeds", ["ChestLeds"]), "already exists"),
    ("ALTextToSpeech", "say", (5,), "text"),
    ("ALAudioPlayer", "play", (1,), "no such file is loaded"),
    ("ALTextToSpeech", "setParameter", ("speed", 1), "from 50 to 400"),
    ("ALTracker", "lookAt", ([1.0, 0.0], 0, 0.5, False), "pPosition"),
    ("ALTracker", "pointAt", ("LArm", [0.0, 0.098, 0.1], 0, 0.5), "in the shoulder"),
    ("ALTracker", "track", ("Face",), "not in this virtual NAO; it has: "),
    ("ALMotion", "setAngle", ("HeadYaw", 0.1, 0.1), "nearest: setAngles"),
    ("ALMotion", "__init__", (), "no such method"),
    ("ALPhotoCapture", "takePicture", (), "it neither stores nor analyses pictures; there are: ALMotion, "),
]
ROWS = [("ALMotion", *row) for row in ALMOTION] + OTHERS


@pytest.fixture(scope="module")
def standing() -> Iterator[Script]:
    with Script() as made:
        yield made


@pytest.mark.parametrize(("service", "method", "given", "words"), ROWS, ids=range(len(ROWS)))
def test_what_makes_no_sense_is_refused_before_anything_moves(
    standing: Script, service: str, method: str, given: tuple[Any, ...], words: str
) -> None:
    command = standing.nao.joints.command
    with pytest.raises(NaoqiError) as error:
        standing.nao.call(service, method, *given)
    head, reason = str(error.value).split("\n\t")
    assert head == f"{service}::{method}"
    assert words in reason
    assert len(reason) < 4000
    assert standing.nao.clock.now == 0.0
    assert np.array_equal(standing.nao.joints.command, command)
    assert standing("getTaskList") == []
