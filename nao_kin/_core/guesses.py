"""What is meant by an attribute that does not exist: the public name elsewhere, or the nearest valid ones."""

from __future__ import annotations

import ast
import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nao_kin._core.text import nearest_names

_PACKAGE = Path(__file__).parents[1]
# The command line, and modules of NAOqi's names for scripts.
_NOT_FOR_CALLERS = ("cli", "compat")
# Classes whose methods and properties are found, and what an object of them is called.
_OBJECTS = {"RobotModel": "robot", "KinematicRobot": "robot", "NaoModel": "nao", "Motion": "motion", "Viewer": "viewer"}


@cache
def public_index() -> dict[str, tuple[str, ...]]:
    """Return where each public name is: "slerp" → ("nk.rotations.slerp",), "fk" → ("robot.fk", "nk.stream.fk").

    The sources are read, not imported: an error must not load what the program does not use.
    """
    inside = {module: name for name, module in vars(sys.modules[_PACKAGE.name])["_INSIDE"].items()}
    found: dict[str, list[str]] = defaultdict(list)
    for file in sorted(_PACKAGE.rglob("*.py")):
        parts = [part for part in file.relative_to(_PACKAGE.parent).with_suffix("").parts if part != "__init__"]
        text = file.read_text(encoding="utf-8")
        offers = "\n__all__ = [" in text and not any(part.startswith("_") or part in _NOT_FOR_CALLERS for part in parts)
        classes = re.findall(rf"^class ({'|'.join(_OBJECTS)})\b", text, re.MULTILINE)
        if not offers and not classes:
            continue
        module = ".".join(parts)
        owner = f"nk.{inside.get(module, module.partition('.')[2])}" if len(parts) > 1 else "nk"
        for node in ast.parse(text).body:
            if offers and isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
                for entry in ast.walk(node.value):
                    if isinstance(entry, ast.Constant) and isinstance(entry.value, str):
                        found[entry.value].append(f"{owner}.{entry.value}")
            elif isinstance(node, ast.ClassDef) and node.name in classes:
                for name, one in _members(node):
                    if not name.startswith("_"):
                        found[name].append(f"{one}.{name}")
    return {name: tuple(dict.fromkeys(sorted(places, key=len))) for name, places in found.items()}


def _members(kind: ast.ClassDef) -> Iterator[tuple[str, str]]:
    """Yield the methods and attributes of a class, each with what it is asked of."""
    for node in ast.walk(kind):
        if isinstance(node, ast.FunctionDef):
            made = any(ast.unparse(decorator) == "classmethod" for decorator in node.decorator_list)
            yield node.name, f"nk.{kind.name}" if made else _OBJECTS[kind.name]
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and ast.unparse(node.value) == "self":
            yield node.attr, _OBJECTS[kind.name]


def unknown_attribute(owner: str, name: str, valid: Iterable[str]) -> AttributeError:
    """Return the error for an attribute `name` that `owner`, as Python's own message has it, lacks among `valid`."""
    message = f"{owner} has no attribute {name!r}"
    if name.startswith("_"):
        return AttributeError(message)
    first, to, second = name.partition("_to_")  # rpy_to_matrix is matrix_from_rpy
    index = public_index()
    elsewhere = (index.get(name) or index.get(f"{second}_from_{first}" if to else "", ()))[:3]
    if elsewhere:
        return AttributeError(f"{message}; see {', '.join(elsewhere)}")
    near = nearest_names(name, (one for one in valid if not one.startswith("_")), similar=0.75)
    return AttributeError(f"{message}; nearest: {', '.join(near)}" if near else message)


def public_attributes(module: str) -> dict[str, Any]:
    """Return a module's `__dir__`, which lists public names, and `__getattr__`, whose errors name what was meant.

    A module updates its globals with them, so that type checkers, for which every name would exist, do not see them.
    """

    def missing(name: str) -> Any:
        raise unknown_attribute(f"module {module!r}", name, sys.modules[module].__all__)

    return {"__dir__": lambda: sorted(sys.modules[module].__all__), "__getattr__": missing}


class _GuessingType(type):
    if not TYPE_CHECKING:  # otherwise type checkers would believe that every attribute exists

        def __getattr__(cls, name: str) -> Any:
            raise unknown_attribute(f"type object {cls.__name__!r}", name, dir(cls))


class Guessing(metaclass=_GuessingType):
    """A class whose errors name what was meant by an attribute that does not exist."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            raise unknown_attribute(f"{type(self).__name__!r} object", name, dir(self))
