"""The description of a planted fault."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

_TESTS = Path(__file__).resolve().parents[1] / "tests"


@dataclass(frozen=True)
class Mutation:
    """A fault.

    Attributes:
        name: the fault in words joined by hyphens.
        file: the source file, from the root of the project.
        old: text that occurs in it exactly once.
        new: the text that replaces it.
        tests: arguments for pytest, files or single tests; or files of `web/tests`, which node runs.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]


def is_for_node(test: str) -> bool:
    """Return whether a test is one of the page's modules."""
    return test.endswith(".test.js")


def found(test: str) -> str:
    """Return a test with its folder: "test_pairs.py::test_name" as "tests/joints/test_pairs.py::test_name"."""
    file, sign, name = test.partition("::")
    (path,) = _TESTS.rglob(file)
    return f"tests/{path.relative_to(_TESTS)}{sign}{name}"


def faults(file: str, tests: str, *texts: tuple[str, str, str]) -> tuple[Mutation, ...]:
    """Return faults of one file that the same tests detect.

    Args:
        file: the source file, under `nao_kin` or in `web`.
        tests: separated by blanks and without their folder, arguments for pytest, and files of `web/tests`.
        texts: name, old text and new text of each fault.
    """
    arguments = tuple(f"web/tests/{test}" if is_for_node(test) else found(test) for test in tests.split())
    path = file if file.startswith("web/") else f"nao_kin/{file}"
    return tuple(Mutation(name, path, old, new, arguments) for name, old, new in texts)
