"""The mathematical packages are used through their `__init__` modules, which list all public names."""

from __future__ import annotations

import dataclasses
import inspect
from pathlib import Path
from types import ModuleType

import pytest

from nao_kin import lines, rotations, screws
from nao_kin.rotations import rank_one

ROOMS = [pytest.param(room, id=room.__name__) for room in (rotations, lines, screws)]


def kind_then_name(name: str) -> tuple[int, str]:
    """Constants, classes, functions, each by name."""
    return (0 if name.isupper() else 1 if name[0].isupper() else 2, name)


@pytest.mark.parametrize("room", ROOMS)
def test_a_face_lists_all_that_it_offers_in_order(room: ModuleType) -> None:
    offered = {
        name
        for name, value in vars(room).items()
        if not name.startswith("_") and name != "annotations" and not isinstance(value, ModuleType)
    }
    assert set(room.__all__) == offered
    assert room.__all__ == sorted(room.__all__, key=kind_then_name)


@pytest.mark.parametrize("room", ROOMS)
def test_what_a_face_offers_is_documented_and_of_this_room(room: ModuleType) -> None:
    for name in room.__all__:
        if not name.isupper():
            thing = getattr(room, name)
            assert inspect.getdoc(thing), name
            assert thing.__module__.startswith(f"{room.__name__}._"), name


@pytest.mark.parametrize("room", ROOMS)
def test_behind_the_face_every_module_is_private(room: ModuleType) -> None:
    modules = {path.stem for path in Path(room.__path__[0]).glob("*.py")}
    assert {name for name in modules if not name.startswith("_")} <= {"rank_one"}


@pytest.mark.parametrize("room", [lines, rank_one, screws], ids=lambda room: room.__name__)
def test_everything_that_a_user_calls_has_an_example(room: ModuleType) -> None:
    without = []
    for name in room.__all__:
        thing = getattr(room, name)
        # Results, which functions make, show their fields instead.
        parts = {} if dataclasses.is_dataclass(thing) else {name: thing}
        if inspect.isclass(thing):
            methods = {n: v for n, v in vars(thing).items() if not n.startswith("_") and not isinstance(v, property)}
            parts |= {
                f"{name}.{n}": getattr(thing, n) for n, v in methods.items() if callable(v) or hasattr(v, "__func__")
            }
        without += [n for n, part in parts.items() if "Examples:\n" not in (inspect.getdoc(part) or "")]
    assert not without
