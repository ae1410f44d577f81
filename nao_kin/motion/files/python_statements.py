"""Python text cut into statements, of Python 2 as well as 3, without running or even parsing it.

Choregraphe's exports end in `except BaseException, err:` and `print err`, which today's parser refuses.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

_TOKEN = re.compile(
    r"'''|\"\"\"|'(?:[^\\']|\\.)*'|\"(?:[^\\\"]|\\.)*\"|#.*|[()\[\]{};]|\\$",
)
# A line without any of these is only looked at for its brackets.
_SPECIAL = re.compile(r"['\"#\\;]")
_DEFINITION = re.compile(r"(?P<indent>[ \t]*)def[ \t]+(?P<name>\w+)")
_INDENT = re.compile(r"[ \t]*")


@dataclass(frozen=True)
class Statement:
    """A statement on a line of its own, or between semicolons; what ends in a colon counts as one.

    Attributes:
        text: as it stands in the file, comments replaced by blanks.
        line: 1-based line that it begins on.
        column: 1-based column that it begins at.
        function: the innermost function that it stands in, by indentation; "" for none.
    """

    text: str
    line: int
    column: int
    function: str


class _Reader:
    """Where in brackets and long strings the reading is."""

    def __init__(self) -> None:
        self.depth = 0
        self.quote = ""
        self.continued = False

    def split(self, line: str) -> list[str]:
        """The line without comment, cut where statements end inside of it."""
        self.continued = False
        if not self.quote and not _SPECIAL.search(line):
            self._count(line)
            return [line]
        pieces, begin, at = [], 0, 0
        while at <= len(line):
            if self.quote:
                end = line.find(self.quote, at)
                if end < 0:
                    break
                at, self.quote = end + 3, ""
            token = _TOKEN.search(line, at)
            if token is None:
                break
            at = token.end()
            mark = token[0]
            if mark in ("'''", '"""'):
                self.quote = mark
            elif mark[0] == "#":
                line = line[: token.start()] + " " * len(mark)
            elif mark == "\\":
                line, self.continued = line[: token.start()] + " ", True
            elif mark == ";" and self.depth == 0:
                pieces.append(line[begin : token.start()])
                begin = at
            else:
                self._count(mark if len(mark) == 1 else "")
        return [*pieces, line[begin:]]

    def _count(self, text: str) -> None:
        opened = text.count("(") + text.count("[") + text.count("{")
        self.depth = max(self.depth + opened - text.count(")") - text.count("]") - text.count("}"), 0)


def statements(lines: list[str]) -> Iterator[Statement]:
    """The statements of a text."""
    reader = _Reader()
    functions: list[tuple[int, str]] = []
    parts: list[str] = []
    begin, column = 1, 1
    for number, line in enumerate(lines, start=1):
        if not parts:
            begin, column = number, 1
            _enter(functions, line)
        for index, piece in enumerate(reader.split(line)):
            if index:
                yield Statement("\n".join(parts), begin, column, functions[-1][1] if functions else "")
                column = len("\n".join(parts)) + 1 + column if begin == number else 1
                parts, begin = [], number
            parts.append(piece)
        if reader.depth == 0 and not reader.quote and not reader.continued:
            yield Statement("\n".join(parts), begin, column, functions[-1][1] if functions else "")
            parts = []
    if parts:
        yield Statement("\n".join(parts), begin, column, functions[-1][1] if functions else "")


def _enter(functions: list[tuple[int, str]], line: str) -> None:
    """Leave the functions that end before a line, and enter the one that it defines."""
    if not line.strip() or line.lstrip().startswith("#"):
        return
    indent = _INDENT.match(line)
    depth = len(indent[0].expandtabs(8)) if indent else 0
    while functions and functions[-1][0] >= depth:
        functions.pop()
    found = _DEFINITION.match(line)
    if found:
        functions.append((depth, found["name"]))
