"""A function that is given a wrong kind of object refuses it quickly with an error of this package."""

from __future__ import annotations

import inspect
import signal
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import meshcat
import numpy as np
import pytest
from loops import for_all
from public_names import called

import nao_kin as nk


class Anything:
    """An object that no function takes."""


WRONG = {
    "None": None,
    "text with a NUL": "no\0such",
    "object": Anything(),
    "array": np.zeros((2, 2)),
    "huge": 10**30,
    "list": [Anything()],
    "mapping": {},
    "NaN": float("nan"),
}
# Rooms whose functions are swept; `motion` has a sweep of its own, as has every method of a robot below.
ROOMS = (
    "calibration",
    "crosscheck",
    "export",
    "ik",
    "imitation",
    "joints",
    "lines",
    "naoqi",
    "parameters",
    "reach",
    "robot",
    "rotations",
    "screws",
    "stream",
    "urdf",
)
# Parts of programs that serve robots and files, which have been given what they take when they are called.
INNER = {
    "crosscheck.run",
    "crosscheck.steps_of_nao",
}
# Methods of a robot with an argument that is true or false, for which NumPy has no answer to an array.
FLAGS = {"degrees", "per_joint", "download"}
# Arguments that are callbacks, and arguments that NumPy checks.
CALLBACKS = ("progress", "stop", "shape")
# Functions that wait for ever, as they should.
ENDLESS = {
    ("wait", "timeout", "None"),
    ("naoqi.readings", "rate", "huge"),
    ("naoqi.readings", "on_state", "None"),
    ("naoqi.readings", "missing", "None"),
    ("naoqi.readings", "missing", "huge"),
}
_SECONDS = 120


def functions() -> Iterator[tuple[str, Any]]:
    for name, function in called():
        room, _, rest = name.partition(".")
        if room in ROOMS and "." not in rest and inspect.isfunction(function) and name not in INNER:
            yield name, function


def right(robot: nk.NaoModel) -> dict[str, Any]:
    """Arguments by the names that they have everywhere."""
    q = robot.neutral()
    return {
        "robot": robot, "nao": robot, "q": q, "frame": "LArm", "side": "L", "sequence": "zyx", "axes": "moving",
        "rng": 0, "R": np.eye(3), "T": np.eye(4), "target": robot.fk(robot.posture("StandInit"), "LArm"), "samples": 10,
        "v": np.zeros(25), "angles": np.zeros(3), "names": None, "space": "FRAME_ROBOT", "name": "LArm",
    }  # fmt: skip


@pytest.mark.parametrize(("name", "function"), [pytest.param(*pair, id=pair[0]) for pair in functions()])
def test_wrong_kinds_of_objects_are_refused_in_one_line(
    name: str, function: Any, nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    nk.motion.write_motion(nk.Motion([0.0, 1.0], nao.joint_names, np.zeros((2, 25))), "log.csv")
    room = name.partition(".")[0]
    assert unrefused(name, function, right(nao) | IN_ROOMS.get(room, {})) == []


NAO = nk.load_nao()
OBSERVED = nk.calibration.Poses(NAO.random(0, 5), "LArm", NAO.fk(NAO.random(0, 5), "LArm"))
FOUND = nk.calibration.calibrate(NAO, [OBSERVED], joints=["LElbowYaw"])
# Arguments by the names that they have in one room.
IN_ROOMS: dict[str, dict[str, Any]] = {
    "calibration": {"observations": [OBSERVED], "joints": ["LElbowYaw"], "frames": ["LArm"], "start": {},
        "path": "no_such.json", "calibration": FOUND, "photos": "no_such", "log": "log.csv", "board": (9, 6),
        "square": 0.03,
    },
    "naoqi": {"source": nk.naoqi.LolaSource("no_such"), "names": "Head"},
    "stream": {
        "columns": ["x"], "rows": np.array([0]), "frames": ["LArm"], "numbers": np.zeros((1, 1, 2)),
        "path": "log.csv", "name": "log.csv", "headings": nk.load_nao().joint_names, "hips": "average",
    },
    "urdf": {"path": nk.load_nao().urdf_path, "folder": ".", "tree": nk.load_nao().tree, "notes": []},
}  # fmt: skip


METHODS = [name for name, _ in inspect.getmembers(nk.NaoModel, inspect.isroutine) if not name.startswith("_")]


@pytest.mark.parametrize("name", METHODS)
def test_methods_of_a_robot_refuse_wrong_kinds_of_objects(
    name: str, nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert unrefused(name, getattr(nao, name), right(nao)) == []


SHOWN = {
    "qs": np.zeros((2, 25)), "configurations": np.zeros(25), "values": {"Head": 0.5}, "targets": {"LArm": np.eye(4)},
    "colours": {}, "reach": None, "points": np.eye(3), "vertices": np.eye(3), "faces": [[0, 1, 2]], "text": "Hello",
    "path": "shown.html", "posture": "Stand", "callback": print,
}  # fmt: skip
# A page in a browser is opened by these.
BROWSER = ("open", "save_png", "save_video")


class Unconnected(meshcat.Visualizer):
    """A scene that nobody serves."""

    def __init__(self) -> None:
        self.window, self.path = SimpleNamespace(send=lambda command: None), meshcat.path.Path(("meshcat",))


MADE: dict[str, Callable[[nk.NaoModel], Any]] = {
    "Viewer": nk.Viewer,
    "ShownRobot": lambda nao: nk.Viewer(nao).add_robot(nao),
    "MeshcatRobot": lambda nao: nk.viewer.MeshcatRobot(nao, Unconnected()),
    "VirtualNao": lambda nao: nk.naoqi.VirtualNao(nao, stepped=True),
    "Packages": lambda nao: nao.tree.packages,
}
# Only for callers that hold the lock.
WITH_THE_LOCK = ("start_task",)


@pytest.mark.full
@pytest.mark.parametrize("kind", MADE)
def test_what_shows_a_robot_or_plays_one_refuses_wrong_kinds_of_objects(
    kind: str, nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    thing = MADE[kind](nao)
    names = [name for name, _ in inspect.getmembers(type(thing), inspect.isroutine) if not name.startswith("_")]
    known = right(nao) | SHOWN | {"service": "ALMotion", "method": "ping"}
    found = [
        line
        for name in names
        if name not in (*BROWSER, *WITH_THE_LOCK, "close", "delete")
        for line in unrefused(name, getattr(thing, name), known)
    ]
    assert found == []


STARTED = ("Viewer", "MeshcatRobot", "VirtualNao", "QiServer", "NaoqiSource", "LolaSource", "Packages")


@pytest.mark.full
@for_all("made", STARTED)
def test_wrong_kinds_of_objects_are_refused_before_anything_starts(made: str, nao: nk.NaoModel) -> None:
    kind = next(getattr(room, made) for room in (nk.viewer, nk.naoqi, nk.urdf) if hasattr(room, made))
    with nk.naoqi.VirtualNao(nao, stepped=True) as virtual:
        known = right(nao) | {"nao": virtual, "visualizer": Unconnected(), "file": nao.urdf_path}
        assert unrefused(made, kind, known) == []


def unrefused(name: str, function: Any, known: dict[str, Any]) -> list[str]:
    """A line for each wrong argument that is answered by another error than one of this package."""
    found = []
    parameters = [
        p for p in inspect.signature(function).parameters.values() if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
    ]
    for wrong in parameters:
        if wrong.name in CALLBACKS:
            continue
        for kind, value in WRONG.items():
            if wrong.name in FLAGS and kind == "array":
                continue
            if (name, wrong.name, kind) in ENDLESS:
                continue
            arguments = {
                p.name: value if p is wrong else known.get(p.name, value)
                for p in parameters
                if p is wrong or p.default is p.empty
            }
            first = [arguments.pop(p.name) for p in parameters if p.kind is p.POSITIONAL_ONLY and p.name in arguments]
            signal.alarm(_SECONDS)
            try:
                result = function(*first, **arguments)
                if inspect.isgenerator(result):
                    next(result, None)
                with result if hasattr(result, "__exit__") else nullcontext():  # it starts, and ends
                    pass
            except (nk.NaoKinError, nk.errors.FormerNameWarning, nk.errors.OtherRobotWarning):
                pass
            except Exception as error:
                found.append(f"{name}({wrong.name}={kind}) raised {type(error).__name__}: {error}")
            finally:
                signal.alarm(0)
    return found


@pytest.mark.parametrize(
    ("name", "shape", "kind"),
    [("count", (1 << 27,), np.int8), ("settings", (), f"U{1 << 23}"), ("more", (1, 1 << 27), np.int8)],
)
def test_a_reach_map_that_would_unpack_to_gigabytes_is_refused_before(
    tmp_path: Path, nao: nk.NaoModel, name: str, shape: tuple[int, ...], kind: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = nk.reach.workspace(nao, "LArm", 500, voxel=0.05).save(tmp_path / "map.npz")
    assert nk.reach.load(path).samples == 500
    with np.load(path) as archive:
        parts = dict(archive)
    np.savez_compressed(path, **{**parts, name: np.zeros(shape, kind)})
    monkeypatch.setattr(np, "load", lambda *_, **__: pytest.fail("unpacked"))
    with pytest.raises(nk.errors.BadInputFile, match="no reach map"):
        nk.reach.load(path)
