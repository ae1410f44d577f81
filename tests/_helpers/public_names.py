"""The public names: those that the packages list, and the methods of their classes."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import nao_kin as nk
from nao_kin.rotations import rank_one
from nao_kin.screws import lines

TOP = (*nk.__all__, *nk._UNLISTED)
ROOMS = {name: room for name in TOP if isinstance(room := getattr(nk, name), ModuleType)}
ROOMS |= {"rotations.rank_one": rank_one, "screws.lines": lines}


def offered() -> Iterator[tuple[str, Any]]:
    """Every name that a room lists, as "room.name", and those of the package itself, with their values."""
    for room, module in ROOMS.items():
        for name in module.__all__:
            yield f"{room}.{name}", getattr(module, name)
    for name in nk.__all__:
        if not isinstance(getattr(nk, name), ModuleType):
            yield name, getattr(nk, name)


def called() -> Iterator[tuple[str, Any]]:
    """Every function and class once, and every method that is our own; exceptions without theirs."""
    seen: set[int] = set()
    for name, value in offered():
        if inspect.isclass(value) and value.__module__.startswith("nao_kin"):
            found = [(name, value)]
            if not issubclass(value, BaseException):
                found += [(f"{name}.{method}", function) for method, function in _methods(value)]
        elif inspect.isfunction(inspect.unwrap(value) if callable(value) else None):
            found = [(name, inspect.unwrap(value))]
        else:
            found = []
        for qualified, item in found:
            if id(item) not in seen:
                seen.add(id(item))
                yield qualified, item


def _methods(kind: type) -> Iterator[tuple[str, Any]]:
    for owner in kind.__mro__:
        for name, value in vars(owner).items():
            if next(vars(one)[name] for one in kind.__mro__ if name in vars(one)) is not value:  # it is overridden
                continue
            value = value.__func__ if isinstance(value, classmethod | staticmethod) else value
            # A function kept as the default of a field is no method of the class.
            ours = inspect.isfunction(value) and value.__qualname__ == f"{owner.__name__}.{name}"
            if ours and value.__module__.startswith("nao_kin") and not name.startswith("_"):
                yield name, value
