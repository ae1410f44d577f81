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
# Words by which names of other libraries begin, or which join their words.
_IN_MANY_NAMES = ("as", "calculate", "compute", "get", "is", "of", "set", "the", "to")


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


def _by_words(name: str, own: Iterable[str]) -> list[str]:
    """Return the places of a public name, or of those with its words in its order: getPosition, quaternion_multiply.

    Those of the `own` names of what is asked come first.
    """
    index = public_index()
    turned = "_from_".join(reversed(re.split("_to_|2", name, maxsplit=1)))  # rpy_to_matrix is matrix_from_rpy
    name = name if name in index else turned
    if name in index:
        return list(index[name])
    asked = [word for word in _words(name) if word not in _IN_MANY_NAMES]
    others = []
    for one in index if asked else ():
        rest = iter(words := _words(one))
        if all(any(_alike(word, other) for other in rest) for word in asked):
            others.append((one not in own, len(words), one[0].isupper(), len(one), one))
    return [place for *_, one in sorted(others) for place in index[one] if not place.startswith("nk.errors.")]


def _words(name: str) -> list[str]:
    return [word.lower() for word in re.findall("[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)]


def _alike(one: str, other: str) -> bool:
    """Return whether two words are equal, or one abbreviates the other: quat, quaternion."""
    short, long = sorted((one, other), key=len)
    return one == other or (len(short) > 3 and long.startswith(short))


def _share_a_word(one: str, other: str) -> bool:
    return any(_alike(first, second) for first in _words(one) for second in _words(other))


def unknown_attribute(owner: str, name: str, valid: Iterable[str]) -> AttributeError:
    """Return the error for an attribute `name` that `owner`, as Python's own message has it, lacks among `valid`."""
    message = f"{owner} has no attribute {name!r}"
    if name.startswith("_"):
        return AttributeError(message)
    own = dict.fromkeys(one for one in valid if not one.startswith("_"))
    near = nearest_names(name, own, similar=0.75)
    near = tuple(one for one in near if one[0].lower() == name[0].lower() or _share_a_word(one, name))
    is_misspelt = any(abs(len(one) - len(name)) < 2 for one in nearest_names(name, near, similar=0.9))
    elsewhere = [] if is_misspelt and name not in public_index() else _by_words(name, own)[:3]
    advice = f"; see {', '.join(elsewhere)}" if elsewhere else f"; nearest: {', '.join(near)}" if near else ""
    return AttributeError(message + advice)


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
