"""Each option of a public function is used or shown outside the tests, and given in a test; all others leave."""

from __future__ import annotations

import ast
import dataclasses
import enum
import inspect
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from public_names import called
from syntax import statements, within

ROOT = Path(__file__).resolve().parents[2]
# A call in a text that is no module: an example of a docstring, or a page.
CALL = re.compile(r"(\w+)\(((?:[^()]|\((?:[^()]|\([^()]*\))*\))*)\)")


def calls_in(text: str) -> Iterator[tuple[str, int, list[str]]]:
    """Yield the calls of a module: the function's name, the number of arguments without names, and those with."""
    nodes = [node for node in within(ast.parse(text)) if isinstance(node, ast.Call | ast.Dict | ast.FunctionDef)]
    yield from calls_with_options(nodes)
    for node in nodes:
        if isinstance(node, ast.Call):
            named = [keyword.arg for keyword in node.keywords if keyword.arg]
            # Of `partial(function, …)` and `pytest.raises(error, function, …)` the names count.
            for place, function in enumerate((node.func, *node.args)):
                name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
                yield name, 0 if place else len(node.args), named
        elif isinstance(node, ast.Dict):  # options of a case
            yield (
                "",
                0,
                [key.value for key in node.keys if isinstance(key, ast.Constant) and isinstance(key.value, str)],
            )


def calls_with_options(nodes: list[ast.Call | ast.Dict | ast.FunctionDef]) -> Iterator[tuple[str, int, list[str]]]:
    """Yield the functions called with `**options`, with the options in the module's dictionaries and wrappers."""
    wrappers, options, functions = {"dict"}, set[str](), set[str]()
    for node in nodes:
        if isinstance(node, ast.FunctionDef) and node.args.kwarg:
            wrappers.add(node.name)
    for node in nodes:
        if isinstance(node, ast.Dict):
            options |= {key.value for key in node.keys if isinstance(key, ast.Constant) and isinstance(key.value, str)}
        elif isinstance(node, ast.Call):
            named = {keyword.arg for keyword in node.keywords if keyword.arg}
            options |= named if isinstance(node.func, ast.Name) and node.func.id in wrappers else set()
            if len(named) < len(node.keywords) and isinstance(node.func, ast.Attribute | ast.Name):
                functions.add(node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id)
    for function in functions:
        yield function, 0, [*options]


def calls_on(text: str) -> Iterator[tuple[str, int, list[str]]]:
    """Yield the calls on a page or in a docstring."""
    for name, inside in CALL.findall(text):
        try:
            yield from calls_in(f"{name}({inside})")
        except SyntaxError:
            continue


def given(calls: Iterable[tuple[str, int, list[str]]]) -> tuple[set[tuple[str, str]], dict[str, int]]:
    """Return the options that calls name, and function → the largest number of arguments without names."""
    names, places = set[tuple[str, str]](), dict[str, int]()
    for function, count, options in calls:
        names |= {(function, option) for option in options}
        places[function] = max(places.get(function, 0), count)
    return names, places


def options() -> Iterator[tuple[str, str, str, int]]:
    """Yield the options of public functions and methods: room.function, function, option, and its place in a call."""
    for name, function in called():
        if inspect.isclass(function) and (
            issubclass(function, (BaseException, enum.Enum)) or dataclasses.is_dataclass(function)
        ):
            continue
        parameters = list(inspect.signature(function).parameters.values())
        parameters = [one for one in parameters if one.name not in ("self", "cls")]
        for place, one in enumerate(parameters):
            if one.default is not one.empty and not one.name.startswith("_"):
                positional = one.kind is not one.KEYWORD_ONLY
                yield name, name.rpartition(".")[2], one.name, place if positional else 10**6


def missing(calls: Iterable[tuple[str, int, list[str]]]) -> set[str]:
    """Return the options that no call gives."""
    names, places = given(calls)
    return {
        f"{name}({option}=)"
        for name, function, option, place in options()
        if (function, option) not in names and places.get(function, 0) <= place
    }


def modules(*places: str) -> list[str]:
    return [path.read_text(encoding="utf-8") for place in places for path in sorted((ROOT / place).rglob("*.py"))]


def test_each_option_is_given_in_a_test() -> None:
    untested = missing(call for text in modules("tests") for call in calls_in(text))
    assert not untested, "test these options off their defaults, or delete them"


def test_each_option_is_used_or_shown_outside_the_tests() -> None:
    """What counts is the word: an option such as `near` is shown once for all functions that have it."""
    code = modules("nao_kin", "examples", "scripts", "benchmarks")
    pages = [*(ROOT / "docs").glob("*.md"), ROOT / "README.md", *(ROOT / "examples").rglob("*.ipynb")]
    told = (statements(ast.parse(text)) for text in code)
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
    docstrings = [ast.get_docstring(node) or "" for nodes in told for node in nodes if isinstance(node, kinds)]
    texts = [*docstrings, *(path.read_text(encoding="utf-8") for path in pages)]
    names, places = given(
        [*(c for text in code for c in calls_in(text)), *(c for text in texts for c in calls_on(text))]
    )
    words = {word for _, word in names}
    unused = {
        f"{name}({option}=)"
        for name, function, option, place in options()
        if option not in words and places.get(function, 0) <= place
    }
    assert not unused, "delete these options, or show them on a page"
