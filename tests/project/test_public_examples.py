"""Every public function, class and method shows how it is called, and what is in its result."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterable, Iterator
from typing import Any, get_args, get_type_hints

from public_names import called, offered

NEEDS_A_ROBOT = "reads a robot, or a server of qi, on the network"
WITHOUT = {
    "distributed.connect": "starts processes of its own",
    "naoqi.JointSource.connect": NEEDS_A_ROBOT,
    "naoqi.JointSource.read": NEEDS_A_ROBOT,
    "naoqi.JointSource.close": NEEDS_A_ROBOT,
    "naoqi.LolaSource.read": NEEDS_A_ROBOT,
    "naoqi.LolaSource.close": NEEDS_A_ROBOT,
    "naoqi.NaoqiSource": NEEDS_A_ROBOT,
    "naoqi.NaoqiSource.connect": NEEDS_A_ROBOT,
    "naoqi.NaoqiSource.read": NEEDS_A_ROBOT,
    "naoqi.NaoqiSource.close": NEEDS_A_ROBOT,
    "naoqi.QiServer": NEEDS_A_ROBOT,
    "naoqi.QiServer.close": NEEDS_A_ROBOT,
    "naoqi.readings": NEEDS_A_ROBOT,
    "viewer.Viewer.open": "opens a browser window",
    "viewer.Viewer.save_png": "starts a browser",
    "viewer.Viewer.save_video": "starts a browser",
}
# The mathematical packages have their own tests.
APART = ("lines.", "rank_one.", "rotations.")
CALLED = {name: value for name, value in called() if not name.startswith(APART)}


def _is_called(name: str) -> bool:
    """Return whether a user calls it; results, rows and exceptions, which functions make, show their fields instead."""
    owner = CALLED.get(name.rpartition(".")[0], CALLED[name])
    return not (dataclasses.is_dataclass(owner) or (inspect.isclass(owner) and issubclass(owner, BaseException)))


def test_everything_that_a_user_calls_has_an_example() -> None:
    without = {name for name in CALLED if ">>> " not in (CALLED[name].__doc__ or "").partition("Examples:\n")[2]}
    assert {name for name in without if _is_called(name)} - set(WITHOUT) == set()


def test_what_has_none_for_a_reason_is_there_and_has_none() -> None:
    assert not [name for name in WITHOUT if ">>> " in (CALLED[name].__doc__ or "")]


LISTED = {id(value) for _, value in offered()}
# Types that only type checkers import.
UNIMPORTED = {"Array": Any, "Client": Any, "Figure": Any, "Iterable": Iterable, "ArrayLike": Any}


def _unlisted_rows(kind: Any) -> Iterator[type]:
    """Yield the dataclasses of this package within a type, such as tuple[Row, ...], that no room lists."""
    if dataclasses.is_dataclass(kind) and kind.__module__.startswith("nao_kin") and id(kind) not in LISTED:
        yield kind  # type: ignore[misc]
    for part in get_args(kind):
        yield from _unlisted_rows(part)


def test_the_fields_of_rows_that_no_room_lists_are_described_by_what_contains_them() -> None:
    described, missing = 0, []
    values = dict(called())
    for name, value in values.items():
        hints = get_type_hints(value, localns=UNIMPORTED)
        if not inspect.isclass(value):
            hints = {"return": hints.get("return")}
        owner = values.get(name.rpartition(".")[0])
        words = f"{value.__doc__} {owner.__doc__ if owner else ''}"
        for attribute, kind in hints.items():
            for row in () if attribute.startswith("_") else _unlisted_rows(kind):
                described += 1
                missing += [
                    f"{name} does not describe {row.__name__}.{field.name}"
                    for field in dataclasses.fields(row)
                    if f"`{field.name}`" not in words and not field.name.startswith("_")
                ]
    assert described > 20
    assert not missing
