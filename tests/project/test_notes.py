"""Each note and warning that the code can write is asked for in a test."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from syntax import within

ROOT = Path(__file__).resolve().parents[2]
# A note of fewer words, or of short words, could stand in a test by accident.
WORDS, LETTERS = 3, 8
# Where a value is filled in.
FILLED = "\N{REPLACEMENT CHARACTER}"


def texts(node: ast.AST) -> Iterator[list[str]]:
    """Yield the words of each text in an expression, without what is filled in, in pieces."""
    inside = {id(part) for text in ast.walk(node) if isinstance(text, ast.JoinedStr) for part in text.values}
    for part in ast.walk(node):
        if isinstance(part, ast.JoinedStr):
            yield [str(piece.value) for piece in part.values if isinstance(piece, ast.Constant)]
        elif isinstance(part, ast.Constant) and isinstance(part.value, str) and id(part) not in inside:
            yield [part.value]


def notes(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield the texts of a module that become notes or warnings, with their lines."""
    source = path.read_text(encoding="utf-8")
    for node in within(ast.parse(source)) if re.search("note|warn", source) else ():
        written: list[ast.expr] = []
        if isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            if re.search(r"notes\.(append|add|extend)$|(^|[._])(note|warn)$", name):
                written = node.args[:1]
        elif isinstance(node, (ast.Assign, ast.AugAssign, ast.AnnAssign)):
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            written = [node.value] if node.value is not None and "note" in ast.unparse(target) else []
        for expression in written:
            for pieces in texts(expression):
                if sum(len(re.findall(r"[^\W\d]+", piece)) for piece in pieces) >= WORDS:
                    yield node.lineno, pieces


def said(pieces: list[str], tests: str) -> bool:
    """Return whether two or three words of a text, beside each other, stand in the tests, with anything filled in."""
    words = FILLED.join(pieces).split()
    for count in (2, 3):
        for k in range(len(words) - count + 1):
            part = " ".join(words[k : k + count]).strip(".,;:()")
            enough = len(re.sub(r"\W", "", part)) >= LETTERS and (part in tests or FILLED in part)
            if enough and re.search(re.escape(part).replace(FILLED, r"\S{0,40}"), tests):
                return True
    return False


def test_each_note_is_asked_for() -> None:
    tests = " ".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py"))
    tests = re.sub(r"[\"'\\\s]+", " ", tests)
    modules = sorted((ROOT / "nao_kin").rglob("*.py"))
    missing = {
        f"{path.relative_to(ROOT)}:{line}: {'…'.join(pieces)}"
        for path in modules
        for line, pieces in notes(path)
        if not said(pieces, tests)
    }
    assert not missing
