"""The calls that examples in docstrings make of what they explain: arguments and results."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from contextlib import suppress
from types import FrameType
from typing import Any, NamedTuple

import numpy as np
from fuzz import Case, code_of


class Call(NamedTuple):
    """One call: the values of its parameters, among them `self`, its result, and which parameters it changed."""

    given: dict[str, Any]
    result: Any
    changed: list[str]


def calls_of(case: Case) -> list[Call]:
    """Run examples, and return the calls of the function that they make themselves, not through other functions."""
    code, made, waiting = code_of(case.function), list[Call](), dict[FrameType, tuple[dict[str, Any], Any]]()
    kinds = inspect.signature(case.function).parameters.items()
    wanted = {name for name, kind in kinds if kind.kind is not kind.VAR_KEYWORD} | {"self"}

    def seen(frame: FrameType, event: str, value: Any) -> None:
        if frame.f_code is not code or frame.f_back is None or frame.f_back.f_code.co_filename != "<example>":
            return
        if event == "call":
            given = {name: one for name, one in frame.f_locals.items() if name in wanted}
            waiting[frame] = given, {name: contents(one) for name, one in given.items()}
        elif event == "return" and frame in waiting:
            given, before = waiting.pop(frame)
            changed = [name for name, one in given.items() if not before[name].items() <= contents(one).items()]
            made.append(Call(given, given["self"] if inspect.isclass(case.function) else value, changed))

    names = dict(case.names)
    sys.setprofile(seen)
    try:
        for example in case.examples:
            with suppress(Exception, SystemExit):
                exec(compile(example, "<example>", "single"), names)
    finally:
        sys.setprofile(None)
    return made


def contents(value: Any) -> dict[str, bytes]:
    """Return the numbers of the arrays in a value."""
    return {path: array.tobytes() for path, array in arrays(value, private=False) if array.dtype.kind != "O"}


def arrays(value: Any, *, private: bool, path: str = "", depth: int = 4) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the arrays in a value, with where they are: in tuples, lists, dictionaries and attributes."""
    if isinstance(value, np.ndarray):
        yield path, value
    elif depth == 0 or isinstance(value, (str, bytes, int, float, type(None), type)):
        return
    elif isinstance(value, (list, tuple)) and not hasattr(value, "_fields"):
        for k, one in enumerate(value[:20]):
            yield from arrays(one, private=private, path=f"{path}[{k}]", depth=depth - 1)
    elif isinstance(value, dict):
        for k, one in list(value.items())[:20]:
            yield from arrays(one, private=private, path=f"{path}[{k!r}]", depth=depth - 1)
    elif type(value).__module__.startswith("nao_kin"):
        names = (*getattr(value, "_fields", ()), *getattr(value, "__slots__", ()))
        slots = {name: getattr(value, name) for name in names if hasattr(value, name)}
        held = getattr(value, "__dict__", None) or slots
        for name, one in held.items():
            if private or not name.startswith("_"):
                yield from arrays(one, private=private, path=f"{path}.{name}", depth=depth - 1)
