"""Whatever kind of object a function is given, it refuses with an error of this package, and soon."""

from __future__ import annotations

import inspect
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
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
}
# Rooms whose functions are swept; `motion` has a sweep of its own, as has every method of a robot below.
ROOMS = (
    "crosscheck",
    "export",
    "ik",
    "joints",
    "lines",
    "naoqi",
    "parameters",
    "reach",
    "robot",
    "rotations",
    "screws",
)
# Parts of programs that serve robots and files, which have been given what they take when they are called.
INNER = {
    "naoqi.NaoqiSource",
    "joints.joint_table",
    "crosscheck.run",
    "crosscheck.steps_of",
    "crosscheck.steps_of_nao",
    "crosscheck.steps_of_tree",
    "robot.polygon_below",
    "robot.shape_geometry",
    "robot.sole_corners",
}
# Methods of a robot with an argument that is true or false, for which NumPy has no answer to an array.
FLAGS = {"degrees", "per_joint", "download", "typed"}
# What a program passes to be called back with, and what NumPy limits.
CALLBACKS = ("progress", "stop", "shape")
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
    assert unrefused(name, function, right(nao)) == []


METHODS = [name for name, _ in inspect.getmembers(nk.NaoModel, inspect.isroutine) if not name.startswith("_")]


@pytest.mark.parametrize("name", METHODS)
def test_methods_of_a_robot_refuse_wrong_kinds_of_objects(
    name: str, nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert unrefused(name, getattr(nao, name), right(nao)) == []


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
            arguments = {
                p.name: value if p is wrong else known.get(p.name, value)
                for p in parameters
                if p is wrong or p.default is p.empty
            }
            first = [arguments.pop(p.name) for p in parameters if p.kind is p.POSITIONAL_ONLY and p.name in arguments]
            signal.alarm(_SECONDS)
            try:
                function(*first, **arguments)
            except nk.NaoKinError:
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
