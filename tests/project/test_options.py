"""Each option of a public function is used or shown outside the tests, and given in a test; all others leave."""

from __future__ import annotations

import ast
import dataclasses
import enum
import inspect
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from public_names import called
from syntax import statements, within

ROOT = Path(__file__).resolve().parents[2]
# A call in a text that is no module: an example of a docstring, or a page.
CALL = re.compile(r"(\w+)\(((?:[^()]|\((?:[^()]|\([^()]*\))*\))*)\)")


# The function's name, the number of arguments without names, and those with.
Call = tuple[str, int, list[str]]


def calls_in(tree: ast.AST) -> Iterator[Call]:
    """Yield the calls of a module."""
    nodes = [node for node in within(tree) if isinstance(node, ast.Call | ast.Dict | ast.FunctionDef)]
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


def calls_with_options(nodes: list[ast.Call | ast.Dict | ast.FunctionDef]) -> Iterator[Call]:
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


def calls_on(text: str) -> Iterator[Call]:
    """Yield the calls on a page or in a docstring."""
    for name, inside in CALL.findall(text):
        try:
            yield from calls_in(ast.parse(f"{name}({inside})"))
        except SyntaxError:
            continue


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


def missing(files: Iterable[Path], calls_of: Callable[[Path, str], Iterable[Call]], *, by_word: bool) -> list[str]:
    """Return the options that no file gives to their function, or with `by_word` to any function."""
    left = list(options())
    for file in files:
        text = file.read_text(encoding="utf-8")
        # A file that names neither need not be parsed.
        if any(function in text or (by_word and option in text) for _, function, option, _ in left):
            names, places = set[tuple[str, str]](), dict[str, int]()
            for function, count, words in calls_of(file, text):
                names |= {("" if by_word else function, word) for word in words}
                places[function] = max(places.get(function, 0), count)
            left = [
                (name, function, option, place)
                for name, function, option, place in left
                if ("" if by_word else function, option) not in names and places.get(function, 0) <= place
            ]
    return [f"{name}({option}=)" for name, _, option, _ in left]


def modules(*places: str) -> list[Path]:
    return [path for place in places for path in sorted((ROOT / place).rglob("*.py"))]


def test_each_option_is_given_in_a_test() -> None:
    untested = missing(modules("tests"), lambda _, text: calls_in(ast.parse(text)), by_word=False)
    assert not untested, "test these options off their defaults, or delete them"


def calls_and_examples(file: Path, text: str) -> Iterator[Call]:
    """Yield the calls of a module and of its docstrings; of a page those that it shows."""
    if file.suffix != ".py":
        yield from calls_on(text)
        return
    tree = ast.parse(text)
    yield from calls_in(tree)
    for node in statements(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
            yield from calls_on(ast.get_docstring(node) or "")


def test_each_option_is_used_or_shown_outside_the_tests() -> None:
    """What counts is the word: an option such as `near` is shown once for all functions that have it."""
    pages = [*(ROOT / "docs").glob("*.md"), ROOT / "README.md", *(ROOT / "examples").rglob("*.ipynb")]
    files = [*pages, *modules("examples", "scripts", "benchmarks", "nao_kin")]
    assert not missing(files, calls_and_examples, by_word=True), "delete these options, or show them on a page"
