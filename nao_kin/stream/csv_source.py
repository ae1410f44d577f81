"""A CSV file of joint values, in blocks of whole records.

The file is cut by us and the numbers are read by pyarrow, one block at a time: its own streaming reader can neither
begin in the middle of a file nor say on which line a row stood. A block that it refuses is halved until what is left
is small, and that is read exactly: good rows beside a bad one cost nothing more.
"""

from __future__ import annotations

import gzip
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, cast

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.csv_numbers import (
    Records,
    csv_head,
    line_ends,
    plain_floats,
    quick_numbers,
    whole_lines,
)
from nao_kin.configuration_files import finite_numbers
from nao_kin.errors import BadInputFile
from nao_kin.robot import RobotModel
from nao_kin.stream.blocks import Block, Position, Source, TableOptions

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
    """Joint names in the header, in any order, and one configuration a line, as `read_log` reads them.

    A file whose name ends in .gz is unpacked; a place in it is one of what is unpacked.
    """

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path = path
        self._file = _opened(path)
        # What has been read and not yet been given out: at the start, and behind the last whole line.
        self._rest, self._behind = b"", b""
        packed = path == "-" or path.lower().endswith(".gz") or not Path(path).is_file()
        self._size = None if packed else Path(path).stat().st_size
        try:
            self._read_header(robot, options)
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
                joints = len(self.table.names)
                times = rows.values[:, joints] if self.table.timed else None
                values = rows.values[:, :joints]
                yield Block(values, (offset, line), times, rows.problems, at_end and not rest, lines)
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

    def _read_header(self, robot: RobotModel, options: TableOptions) -> None:
        head = self._file.read(BYTES_AT_ONCE)
        mark = len(_BOM) if head.startswith(_BOM) else 0
        head = head[mark:]
        if not head.strip():
            raise BadInputFile(self.path, "empty; expected joint names and values")
        ends = len(head) < BYTES_AT_ONCE - mark
        beginning = csv_head(head, at_end=ends)
        if beginning.problem:
            raise BadInputFile(self.path, beginning.problem, beginning.line)
        if not beginning.fields:
            raise BadInputFile(self.path, "empty; expected joint names and values")
        self._delimiter, self._mark = beginning.delimiter, beginning.mark
        try:
            head[: beginning.size].decode("utf-8")
        except UnicodeDecodeError as error:
            raise BadInputFile(self.path, f"not UTF-8 text (byte {mark + error.start})") from None
        self.start = mark + beginning.size, beginning.lines
        self._rest = head[beginning.size :]
        table = options.table(self.path, beginning.fields, robot, beginning.line)
        self.table = table.with_times_of(self._rest, self._delimiter)

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
        table = self.table
        numbers = quick_numbers(block, table.all, self._delimiter, table.places, self._mark, table.iso_times)
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
        plain = self._mark == "." and block.isascii() and b"_" not in block and self.table.iso_times is None
        values: list[list[float]] = []
        problems: dict[int, tuple[int, str]] = {}
        table = self.table
        nothing = [math.nan] * len(table.places)
        for _, fields, reason in records:
            row: list[float] | None = None
            column = 0
            reason = reason or table.count(len(fields))
            if not reason:
                row = plain_floats([fields[place] for place in table.places]) if plain else None
                try:
                    row = row or finite_numbers(self.path, fields, table.headings, 1, table=table, mark=self._mark)
                except BadInputFile as error:
                    column, reason = error.column, error.reason
            if row is None:
                problems[len(values)] = column, reason
            values.append(row or nothing)
        return records.consumed, _Rows(np.array(values).reshape(len(values), len(nothing)), problems)


@dataclass(frozen=True)
class _Lines:
    """The line of every record of a block that begins behind `before` lines."""

    block: bytes
    delimiter: str
    before: int

    def __call__(self) -> list[int]:
        return [self.before + line for line, _, _ in Records(self.block, self.delimiter)]


def _opened(path: str) -> BinaryIO:
    if path.lower().endswith(".gz"):
        return cast(BinaryIO, gzip.open(path))
    if path != "-":
        return Path(path).open("rb")
    if sys.stdin is None:
        raise BadInputFile(path, "closed; there is nothing to read")
    return sys.stdin.buffer
