"""A CSV file of joint values, in blocks of whole records.

The file is cut by us and the numbers are read by pyarrow, one block at a time: its own streaming reader can neither
begin in the middle of a file nor say on which line a row stood. A block that it refuses is halved until what is left
is small, and that is read exactly: good rows beside a bad one cost nothing more.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.csv_numbers import (
    Records,
    delimiter_of,
    line_ends,
    plain_floats,
    quick_numbers,
    whole_lines,
)
from nao_kin.configuration_files import check_joint_names, finite_numbers
from nao_kin.errors import BadInputFile
from nao_kin.robot import RobotModel
from nao_kin.stream.blocks import Block, Position, Source

BYTES_AT_ONCE = 1 << 22
_LONGEST_LINE = 1 << 24
# Read exactly where the quick way refuses it.
_SMALL = 1 << 14
_BOM = b"\xef\xbb\xbf"


@dataclass(frozen=True)
class _Rows:
    """Rows of numbers, NaN where they could not be read, and why not."""

    values: Floats
    problems: dict[int, tuple[int, str]]


class CsvSource(Source):
    """Joint names in the header, in any order, and one configuration a line, as `read_configurations` reads them."""

    def __init__(self, path: str, robot: RobotModel) -> None:
        self.path = path
        self._file = _opened(path)
        # What has been read and not yet been given out: at the start, and behind the last whole line.
        self._rest, self._behind = b"", b""
        self._size = Path(path).stat().st_size if path != "-" and Path(path).is_file() else None
        try:
            self._read_header(robot)
        except BaseException:
            self.close()
            raise

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `Source`; of a pipe, only from its start."""
        offset, line = start
        rest = self._rest
        if start != self.start:
            self._file.seek(offset)
            rest = b""
        some = False
        while True:
            block, at_end = self._next_lines(rest, line)
            if not block:
                break
            used, rows = self._read(block, at_end=at_end)
            part = block[:used] if used < len(block) else block
            rest = block[used:] + self._behind
            offset, before, line = offset + used, line, line + line_ends(part)
            if len(rows.values):
                some = True
                lines = _Lines(part, self._delimiter, before)
                yield Block(rows.values, (offset, line), rows.problems, at_end and not rest, lines)
            if at_end and not rest:
                break
        if not some and start == self.start:
            raise BadInputFile(self.path, "a header and no configurations")

    def fraction(self, place: Position) -> float | None:
        """As `Source`."""
        return place[0] / max(1, self._size) if self._size is not None else None

    def close(self) -> None:
        """As `Source`."""
        if self.path != "-":
            self._file.close()

    def _read_header(self, robot: RobotModel) -> None:
        head = self._file.read(BYTES_AT_ONCE)
        mark = len(_BOM) if head.startswith(_BOM) else 0
        head = head[mark:]
        if not head.strip():
            raise BadInputFile(self.path, "empty; expected joint names and values")
        ends = len(head) < BYTES_AT_ONCE - mark
        try:
            first = head.lstrip(b"\r\n").split(b"\n", 1)[0].decode("utf-8")
        except UnicodeDecodeError as error:
            raise BadInputFile(self.path, f"not UTF-8 text (byte {mark + error.start})") from None
        self._delimiter = delimiter_of(first)
        line, fields, reason = next(iter(Records(head, self._delimiter, at_end=ends)), (0, [], ""))
        if not line:
            raise BadInputFile(self.path, "empty; expected joint names and values")
        if reason:
            raise BadInputFile(self.path, reason, line)
        self.names = tuple(name.strip() for name in fields)
        check_joint_names(self.path, self.names, robot, line)
        used = sum(map(len, head.splitlines(keepends=True)[:line]))
        self.start = mark + used, line
        self._rest = head[used:]

    def _next_lines(self, rest: bytes, line: int) -> tuple[bytes, bool]:
        """Whole lines, of about `BYTES_AT_ONCE`, and whether the file ends with them; what is behind is kept."""
        block, wanted = rest, max(0, BYTES_AT_ONCE - len(rest))
        while True:
            more = self._file.read(wanted)
            block += more
            at_end, wanted = len(more) < wanted, BYTES_AT_ONCE
            used = len(block) if at_end else whole_lines(block)
            if used or at_end:
                self._behind = block[used:]
                return block[:used], at_end
            if len(block) > _LONGEST_LINE:
                raise BadInputFile(self.path, f"a line of more than {_LONGEST_LINE >> 20} MiB", line + 1)

    def _read(self, block: bytes, *, at_end: bool) -> tuple[int, _Rows]:
        """The rows of a block, and how much of it they are."""
        if b'"' in block:
            return self._read_exactly(block, at_end=at_end)
        numbers = quick_numbers(block, len(self.names), self._delimiter)
        if numbers is not None:
            return len(block), _Rows(numbers, {})
        middle = whole_lines(block[: len(block) // 2])
        if len(block) <= _SMALL or not middle:
            return self._read_exactly(block, at_end=True)
        _, first = self._read(block[:middle], at_end=True)
        _, second = self._read(block[middle:], at_end=True)
        count = len(first.values)
        problems = first.problems | {count + row: problem for row, problem in second.problems.items()}
        return len(block), _Rows(np.concatenate([first.values, second.values]), problems)

    def _read_exactly(self, block: bytes, *, at_end: bool) -> tuple[int, _Rows]:
        """The rows of a block, field by field."""
        records = Records(block, self._delimiter, at_end=at_end)
        # Then `float` takes only decimal digits.
        plain = block.isascii() and b"_" not in block
        values: list[list[float]] = []
        problems: dict[int, tuple[int, str]] = {}
        nothing = [math.nan] * len(self.names)
        for _, fields, reason in records:
            row: list[float] | None = None
            column = 0
            if not reason and len(fields) != len(self.names):
                reason = f"{len(fields)} values, the header names {len(self.names)} joints"
            if not reason:
                row = plain_floats(fields) if plain else None
                try:
                    row = row or finite_numbers(self.path, fields, self.names, 1)
                except BadInputFile as error:
                    column, reason = error.column, error.reason
            if row is None:
                problems[len(values)] = column, reason
            values.append(row or nothing)
        return records.consumed, _Rows(np.array(values).reshape(len(values), len(self.names)), problems)


@dataclass(frozen=True)
class _Lines:
    """The line of every record of a block that begins behind `before` lines."""

    block: bytes
    delimiter: str
    before: int

    def __call__(self) -> list[int]:
        return [self.before + line for line, _, _ in Records(self.block, self.delimiter)]


def _opened(path: str) -> BinaryIO:
    if path != "-":
        return Path(path).open("rb")
    if sys.stdin is None:
        raise BadInputFile(path, "closed; there is nothing to read")
    return sys.stdin.buffer
