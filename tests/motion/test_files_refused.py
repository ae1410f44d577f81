"""Motion files that are refused: one line that names the file, the line and the column, and says what is wrong."""

from __future__ import annotations

import contextlib
import io
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_motion_files import _refused

import nao_kin as nk
from nao_kin import load_nao
from nao_kin.errors import BadInputFile, BadModel
from nao_kin.motion import Motion, read_motion, write_motion
from nao_kin.stream.tables import read_log


class _Evil:
    """Makes a folder when it is unpickled."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(self._path),)


LIMBS = "armsAngles = []; legsAngles = []; duration = 5;"

# File, text, words of the message, line and column.
LIBRARY = "<x a='ChoregraphePositionLibrary'><position>"
YAW = '{"joint_names": ["HeadYaw"], '
PY = "names = ['HeadYaw']\ntimes = [[1]]\n"
WRONG: list[tuple[str, str, str, tuple[int, int]]] = [
    ("a.csv", "time,HeadYaw\n0,1e308\n", "HeadYaw has numbers too large", (1, 2)),
    ("a.csv", "time,HeadYow\n0,1\n", "unknown joint 'HeadYow' (nearest: HeadYaw", (1, 2)),
    ("a.csv", "time,HeadYaw,HeadYaw\n0,1,1\n", "joint 'HeadYaw' is given twice", (1, 3)),
    ("a.csv", "time,HeadYaw\n0,1\n\n0,2\n", "time 0 s is the same as", (4, 1)),
    ("a.csv", "time,HeadYaw\n1,1\n0.5,2\n", "time 0.5 s is before", (3, 1)),
    ("a.csv", "time,HeadYaw\n0,1,2\n", "3 values, the header names 2", (2, 0)),
    ("a.csv", "time,HeadYaw\n0,nan\n", "HeadYaw is 'nan'", (2, 2)),
    ("a.csv", "time,HeadYaw\n,1\n", "a row without a time", (2, 1)),
    ("a.csv", "time,HeadYaw\n", "a header and no keys", (1, 0)),
    ("a.csv", "time,HeadYaw\n0,\n", "HeadYaw has no keys", (1, 2)),
    ("a.csv", "time,HeadYaw [furlong]\n0,1\n", "unit 'furlong' of HeadYaw, expected one of rad, deg", (1, 2)),
    ("a.csv", "time,LHand [deg]\n0,1\n", "unit 'deg' of LHand", (1, 2)),
    ("a.csv", "time,t,HeadYaw\n0,0,1\n", "2 columns of times", (1, 0)),
    ("a.csv", 'time,HeadYaw\n0,"1\n', "malformed CSV", (2, 0)),
    ("a.json", YAW + '\n "times": [[0, 1]], "keys": [[0,\n  "1"]]}', "keys[0][1]: key is '1'", (0, 0)),
    ("a.json", YAW + '"times": [[0,\n0]], "keys": [[0,1]]}', "times[0][1]: time 0 s is the", (0, 0)),
    ("a.json", YAW + '"times": [0], "keys": [[NaN]]}', "keys[0][0]: key is NaN", (0, 0)),
    ("a.json", YAW + '"times": [0],\n "keyz": [[0]]}', "keyz: unknown field (nearest: keys", (0, 0)),
    ("a.json", '{"joint_names": ["HeadYaw", "HeadYaw"], "times": [0], "keys": [[0, 1]]}', "given twice", (0, 0)),
    ("a.json", YAW + '"times": [0, 1], "keys": [[0]]}', "keys: 1 rows for 2 times", (0, 0)),
    ("a.json", '{"joint_names": [], "times": [], "keys": []}', "joint_names: no joints", (0, 0)),
    ("a.json", YAW + '"times": [[]], "keys": [[]]}', "joint_names[0]: HeadYaw has no keys", (0, 0)),
    ("a.json", YAW + '"times": [[0, 1]], "keys": [[0]]}', "has 2 times and 1 keys", (0, 0)),
    ("a.json", YAW + '\n "joint_names": []}', "'joint_names' is given twice", (0, 0)),
    ("a.json", YAW + '"times": [0], "keys": [[0]]', "malformed JSON", (1, 57)),
    ("a.json", YAW + '"times": [0], "keys": [[0]], "interpolation": "cubic"}', "'cubic'", (0, 0)),
    ("a.motion", "#WEBOTS_MOTION,V1.0,HeadYaw\n00:00:000,a\n", "2 fields, expected a time, a pose name and 1", (2, 0)),
    ("a.motion", "#WEBOTS_MOTION,V1.0,HeadYaw\n00:00:000,a,x\n", "HeadYaw is 'x'", (2, 3)),
    ("a.motion", "#WEBOTS_MOTION,V1.0,HeadYaw\n0:0:0:0,a,1\n", "time '0:0:0:0'", (2, 1)),
    ("a.motion", "#WEBOTS_MOTION,V1.0,HeadYaw\n5,a,1\n4,b,1\n", "time 0.004 s is before", (3, 1)),
    ("a.motion", "#WEBOTS_MOTION,V1.0,HeadYaw,Headyaw\n5,a,1,1\n", "unknown joint 'Headyaw'", (1, 4)),
    ("a.motion", "#WEBOTS_MOTION,V2.0,HeadYaw\n5,a,1\n", "expected version V1.0", (1, 2)),
    ("a.motion", "#WEBOTS_MOTION,V1.0,HeadYaw\n5,a,1\n\n6,a,1\n", "after an empty line", (4, 0)),
    ("a.motion", "#WEBOTS_MOTION,V1.0\n5,a\n", "names no joints", (1, 0)),
    ("a.motion", "#WEBOTS_MOTION,V1.0,HeadYaw\n5,a,*\n", "no pose has a value", (0, 0)),
    ("a.pos", f"! {'0 ' * 25}\n", "25 numbers, expected 25 values and a duration", (1, 0)),
    ("a.pos", f"! {'0 ' * 25}1.5\n", "DUR is 1.5 ms", (1, 53)),
    ("a.pos", f"! {'0 ' * 25}5\n! {'0 ' * 25}0\n", "DUR is 0 ms", (2, 53)),
    ("a.pos", f"$ {'2 ' * 25}\n! {'0 ' * 25}5\n", "stiffness 2, expected 0 to 1, or -1", (1, 0)),
    ("a.pos", f"HY HP {'LSP ' * 24}\n! {'0 ' * 25}5\n", "joint LSP is given twice", (1, 0)),
    ("a.json", '{"initial_positions": {"head": {"yaw": 0, "pitsch": 0}}, "motion": []}', "nearest: pitch", (0, 0)),
    ("a.json", '{"initial_positions": {"head": {"yaw": 0}}}', "expected either motion or frames", (0, 0)),
    (
        "a.json",
        '{"initial_positions": {"head": {"yaw": 0}}, "motion": [{"keyframes": [\n'
        '{"duration": -1, "positions": {"head": {"yaw": 1}}}]}]}',
        "motion[0].keyframes[0].duration: time -1 s is before",
        (0, 0),
    ),
    (
        "a.json",
        '{"initial_positions": {"head": {"yaw": 0}}, "frames": [\n'
        '{"duration": 1, "positions": {"head": {"yaw": null}}}]}',
        "frames[0].positions.head.yaw: angle is null",
        (0, 0),
    ),
    (
        "a.json",
        '{"initial_positions": {"head": {"yaw": 0}},\n'
        '"frames": [{"duration": 1, "positions": {"head": {"pitch": 1}}}]}',
        "names other joints than initial_positions: HeadPitch, HeadYaw",
        (0, 0),
    ),
    ("a.motion2", '{"header": {"version": "2.0", "time": 9, "joints": [0, 26]}, "position": []}', "0 to 25", (0, 0)),
    ("a.motion2", '{"header": {"version": "1.0"}, "position": []}', "version '1.0', expected '2.0'", (0, 0)),
    (
        "a.motion2",
        '{"header": {"version": "2.0", "time": 9, "joints": [0]}, "position": [\n{"time": 1, "parameters": [1, 2]}]}',
        "position[0].parameters: 2 values for 1 joints",
        (0, 0),
    ),
    (
        "a.motion2",
        '{"header": {"version": "2.0", "time": 9, "joints": [0]}, "position": [{"time": 1, "parameters": [1]},\n'
        '{"time": 0, "parameters": [1]}]}',
        "position[1].time: time 0.009 s is the same",
        (0, 0),
    ),
    ("a.py", "names = ['HeadYaw']\ntimes = [[1, 1]]\nkeys = [[0, 0]]\n", "times[0][1]: time 1 s is the same", (2, 9)),
    ("a.py", PY + "keys = [[0, 0]]\n", "HeadYaw has 1 times and 2 keys", (3, 8)),
    ("a.py", PY + "keys = [[0]]\nif 1:\n  keys[0] *= 2\n", "'keys[0] *= 2' changes a list in an unknown way", (5, 3)),
    ("a.py", PY + "", "1 names, 1 times, 0 keys", (1, 0)),
    ("a.py", "names = list()\nnames.append('Nose')\ntimes = [[1]]\nkeys = [[0]]", "unknown joint 'Nose'", (2, 14)),
    ("a.py", PY + "keys = [[[1, [3, 0, 0]]]]", "expected [value, [type", (3, 8)),
    ("a.py", PY + "keys = [[[1, [0, 0, 0], [3, 0, 0]]]]", "constant, and so jumps", (3, 8)),
    (
        "a.py",
        "names = ['HeadYaw']\ntimes = [[1, 2]]\nkeys = [[[1, [3, 0, 0], [3, 1.5, 0]], [1, [3, 0, 0], [3, 0, 0]]]]",
        "the handle after key 0 of HeadYaw is 1.5 s from it",
        (3, 8),
    ),
    (
        "a.py",
        # Until Python 3.12 the parser refuses it; later ones read it, and then it is no list of names.
        f"names = {'[' * 999}{']' * 999}\ntimes = [[1]]\nkeys = [[0]]\n",
        "too many nested parentheses|expected a joint name, got a list",
        (1, 9),
    ),
    ("a.py", f"names = [{'-' * 999}1]\n", "more than 200 characters", (1, 9)),
    ("a.json", "[" * 99999 + "]" * 99999, "too deep|no motion file|", (0, 0)),
    ("a.json", '["HeadYaw", 1, 1, 2]', "isAbsolute is 2", (0, 0)),
    ("a.json", '["HeadYaw", [1, 2], [1], true]', "HeadYaw has 1 times and 2 keys", (0, 0)),
    ("a.json", '["HeadYaw", 1, -1, true]', "time -1 s is negative", (0, 0)),
    ("a.json", '[["HeadYaw", "HeadYaw"], [1, 1], 1, true]', "joint HeadYaw is given twice", (0, 0)),
    (
        "a.xar",
        "<Timeline fps='25'>\n<ActuatorCurve actuator='HeadYaw'><Key frame='x' value='1'/>",
        "frame is 'x'",
        (2, 35),
    ),
    ("a.xar", "<Timeline fps='25'>", "malformed XML: no element found", (1, 20)),
    ("a.xar", f"<Timeline fps='25'>{'<a>' * 300}", "more than 200 deep", (1, 617)),
    ("a.xap", "<ChoregraphePositionLibrary/>", "no pose", (0, 0)),
    ("a.xap", f"{LIBRARY}<version>3</version></position></x>", "version '3' of a pose, expected 2 (radians)", (0, 0)),
    ("a.xap", f"{LIBRARY}<Motor><name>HeadYow</name>\n<value>1</value></Motor></position></x>", "'HeadYow'", (2, 17)),
    (
        "a.xap",
        f"{LIBRARY}<Motor><name>HeadYaw</name>\n<value>x</value></Motor></position></x>",
        "value is 'x'",
        (2, 17),
    ),
    ("a.xap", f"<!DOCTYPE x>{LIBRARY}</position></x>", "a document type or an entity", (1, 12)),
    ("a.xap", f"{LIBRARY}</x>", "malformed XML: mismatched tag", (1, 47)),
    ("a.kfm", "keyFrames = [\n  {duration = 5}\n];", "'}', expected ;", (2, 16)),
    ("a.kfm", "keyFrames = [{duration = 5;}];", "headAngles is nothing, expected a list […]", (1, 14)),
    (
        "a.kfm",
        f"keyFrames = [{{headAngles = [0, 5mm]; {LIMBS}}}];",
        "an angle is '5mm', expected a number in rad or",
        (1, 32),
    ),
    ("a.kfm", f"keyFrames = [{{headAngles = [0]; {LIMBS}}}];", "1 angles, expected 2", (1, 28)),
    ("a.kfm", "keyFrames = [5];", "expected an object {…} for a key frame", (1, 14)),
    ("a.kfm", "keyFrames = [];", "no key frames", (0, 0)),
    ("a.kfm", "keyFrames = [", "the end of the file, expected a word or { or [", (1, 14)),
    ("kick.kmc", "kpx = 1;\nphaseParameters = [{duration = 5;}];", "joint values depend on the running", (0, 0)),
    ("a.cfg", "motions = {up = {keyframes = [a];};};\nkeyframeBlock = {b = {};};", "no block 'a' of key", (1, 31)),
    ("a.cfg", "keyframeBlock = {b = {keyframes = [];};};", "no key frames", (0, 0)),
]


@pytest.mark.parametrize(("name", "text", "words", "place"), WRONG, ids=[f"{w[0]}-{w[2][:30]}" for w in WRONG])
def test_what_is_wrong_is_named_with_its_place(
    tmp_path: Path, name: str, text: str, words: str, place: tuple[int, int]
) -> None:
    error = _refused(tmp_path, text, name)
    assert any(word in str(error) for word in words.split("|") if word), str(error)
    assert (error.line, error.column) == place, str(error)


XAR_CURVE = (
    "<Timeline fps='25' start_frame='1' end_frame='-1'>\n<ActuatorCurve actuator='{joint}' unit='{unit}'>\n"
    "<Key frame='1' value='0'/>\n<Key frame='{frame}' value='0'>{tangent}</Key></ActuatorCurve></Timeline>"
)


@pytest.mark.parametrize(
    ("changes", "words", "line"),
    [
        ({"joint": "HeadYow"}, "unknown joint 'HeadYow'", 2),
        ({"unit": "7"}, "unit '7'", 2),
        ({"frame": "1"}, "frame 1 does not come after frame 1", 4),
        ({"tangent": "<Tangent side='up' interpType='linear'/>"}, "expected left or right", 4),
        ({"tangent": "<Tangent side='left' interpType='constant'/>"}, "interpType is 'constant'", 4),
        (
            {"tangent": "<Tangent side='left' interpType='bezier' abscissaParam='-99' ordinateParam='0'/>"},
            "the handle before key 1 of HeadYaw",
            4,
        ),
    ],
)
def test_what_is_wrong_in_a_timeline_is_named_with_its_line(
    tmp_path: Path, changes: dict[str, str], words: str, line: int
) -> None:
    text = XAR_CURVE.format(**{"joint": "HeadYaw", "unit": "0", "frame": "11", "tangent": "", **changes})
    error = _refused(tmp_path, text, "a.xar")
    assert words in str(error)
    assert error.line == line


def test_npz_with_pickles_or_wrong_arrays_is_refused(tmp_path: Path) -> None:
    motion = Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [1.0]])
    write_motion(motion, tmp_path / "good.npz")
    good = dict(np.load(tmp_path / "good.npz"))
    for name, value, words in [
        ("keys", np.array([_Evil(tmp_path / "run"), None], dtype=object), "Object arrays cannot be loaded"),
        ("keys", np.array([0.0, np.nan]), "keys[1] is nan"),
        ("keys", np.zeros(3), "keys must be numbers (2,)"),
        ("counts", np.array([-1]), "counts must be whole numbers"),
        ("times", np.array([1.0, 0.0]), "times[1]: time 0 s is before"),
        ("joint_names", np.array(["Nose"]), "unknown joint 'Nose'"),
        ("interpolation", np.array("cubic"), "interpolation must be one of"),
        ("interpolation", np.array("bezier"), "no array 'handles'"),
    ]:
        file = io.BytesIO()
        np.savez(file, **{**good, name: value})
        assert words in str(_refused(tmp_path, file.getvalue(), "a.npz"))
    assert not (tmp_path / "run").exists()
    assert "not an npz file" in str(_refused(tmp_path, (tmp_path / "good.npz").read_bytes()[:200], "a.npz"))


def test_an_npz_file_holds_the_arrays_of_a_motion_and_no_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: dict[str, Any] = {}

    def savez_of_numpy_2_0(file: Any, *args: Any, **kwds: Any) -> None:
        """Save every keyword as an array: `allow_pickle` is one since NumPy 2.1."""
        written.update(kwds)

    monkeypatch.setattr(np, "savez_compressed", savez_of_numpy_2_0)
    write_motion(nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.1]]), tmp_path / "a.npz")
    assert sorted(written) == ["counts", "interpolation", "joint_names", "keys", "times"]


READERS: dict[str, Callable[[str], Any]] = {
    "motion": read_motion,
    "configurations": lambda name: read_log(load_nao(), name),
    "robot": nk.RobotModel.from_urdf,
    "semantics": nk.semantics.read_semantics,
    "reach map": nk.reach.load,
}


@pytest.mark.parametrize("reads", READERS)
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_input_without_an_end_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, reads: str
) -> None:
    monkeypatch.setattr("nao_kin._core.files.MAX_BYTES", 1 << 20)
    name, writer = "/dev/zero", None
    if kind == "pipe":
        name = str(tmp_path / "endless.csv")
        os.mkfifo(name)
        writer = threading.Thread(target=_write_on, args=(name,), daemon=True)
        writer.start()
    with pytest.raises((BadInputFile, BadModel), match="more than 1048576 bytes"):
        READERS[reads](name)
    if writer is not None:
        writer.join(300.0)
        assert not writer.is_alive()


def _write_on(name: str) -> None:
    """Write rows to a pipe until nobody reads it."""
    with contextlib.suppress(BrokenPipeError), open(name, "wb", buffering=0) as file:
        while True:
            file.write(b"0,0\n" * 1000)
