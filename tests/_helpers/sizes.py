"""Count the lines of the project's parts; run as a program, print those of each room.

Lines of code are those of Python and TypeScript without blank lines, comments and docstrings; of the documentation, all
lines of Markdown count that are not blank.
"""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Iterable
from pathlib import Path

from syntax import statements

ROOT = Path(__file__).resolve().parents[2]
GENERATED = {"_build", "_generated", "node_modules", "__pycache__", "gallery", "lecture"}


@functools.cache
def python_lines(text: str) -> int:
    """Return the number of lines of code of a module."""
    told = set[int]()
    for node in statements(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            first = node.body[0] if node.body else None
            if ast.get_docstring(node) is not None and first is not None:
                told.update(range(first.lineno, (first.end_lineno or first.lineno) + 1))
    lines = enumerate(map(str.strip, text.splitlines()), 1)
    return sum(bool(line) and not line.startswith("#") and number not in told for number, line in lines)


def script_lines(text: str) -> int:
    """Return the number of lines of code of a module in TypeScript."""
    without = re.sub(r"^\s*/\*.*?\*/\s*$", "", text, flags=re.MULTILINE | re.DOTALL)
    return sum(bool(line) and not line.startswith("//") for line in map(str.strip, without.splitlines()))


def text_lines(text: str) -> int:
    """Return the number of lines that are not blank."""
    return sum(bool(line.strip()) for line in text.splitlines())


COUNTS = {".py": python_lines, ".ts": script_lines, ".md": text_lines}


def size(places: Iterable[str], root: Path = ROOT) -> int:
    """Return the lines of files and folders below `root`, such as "tests" or "nao_kin/errors.py"."""
    total = 0
    for place in places:
        path = root / place
        for file in [path] if path.is_file() else path.rglob("*"):
            if file.suffix in COUNTS and not GENERATED & set(file.relative_to(root).parts):
                total += COUNTS[file.suffix](file.read_text(encoding="utf-8"))
    return total


if __name__ == "__main__":
    for folder in sorted(path for path in (ROOT / "nao_kin").iterdir() if path.is_dir() and path.name not in GENERATED):
        print(f"{folder.name:12} {size([f'nao_kin/{folder.name}']):6}")
    for place in ("nao_kin", "web/src", "web/tests", "tests", "scripts", "benchmarks", "examples", "docs"):
        print(f"{place:12} {size([place]):6}")
