"""Tests with many values: all values in one case, or some of the values in `make test-all` only."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any

import pytest

from nao_kin.robot.nao import VERSIONS

Test = Callable[..., None]


def for_all(names: str | tuple[str, ...], values: Iterable[Any]) -> Callable[[Test], Test]:
    """Return a decorator like `pytest.mark.parametrize` that calls the test with all values in one case.

    The test fails with a list of all values that fail.

    Args:
        names: the argument, or arguments, of the test.
        values: a value for each call, or a tuple with one for each argument.
    """
    several = [name.strip() for name in names.split(",")] if isinstance(names, str) else list(names)
    calls = [dict(zip(several, value if len(several) > 1 else (value,), strict=True)) for value in values]

    def decorate(test: Test) -> Test:
        @functools.wraps(test)
        def every(**fixtures: Any) -> None:
            failed: list[str] = []
            for call in calls:
                try:
                    test(**fixtures, **call)
                except Exception as error:  # a failed assertion among others
                    given = ", ".join(f"{name}={value!r:.120}" for name, value in call.items())
                    failed.append(f"{given}: {type(error).__name__}: {error}")
                    last = error
            if failed:
                raise AssertionError("\n".join([f"{len(failed)} of {len(calls)} fail:", *failed])) from last

        signature = inspect.signature(test)
        kept = [p for name, p in signature.parameters.items() if name not in several]
        every.__signature__ = signature.replace(parameters=kept)  # type: ignore[attr-defined]
        return every

    return decorate


def full(*values: Any) -> list[Any]:
    """Return values for `pytest.mark.parametrize` that only `make test-all` runs."""
    return [*map(_marked, values)]


def every_value(first: Iterable[Any], second: Iterable[Any]) -> list[tuple[Any, Any]]:
    """Return pairs for `pytest.mark.parametrize` in which each value occurs: the first of one side with all others."""
    (a, *others), seconds = first, [*second]
    return [*((a, b) for b in seconds), *((other, seconds[0]) for other in others)]


def _marked(value: Any) -> Any:
    if hasattr(value, "marks"):  # of pytest.param
        return pytest.param(*value.values, marks=[*value.marks, pytest.mark.full], id=value.id)
    return pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.full)


# The newest version of the NAO in `make test`, the others in `make test-all`.
EACH_VERSION = [VERSIONS[-1], *full(*reversed(VERSIONS[:-1]))]
