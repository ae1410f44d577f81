"""Sources of configurations: CSV, NumPy, Parquet and Arrow files, read block by block."""

from __future__ import annotations

import glob
import math
import zipfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats
from nao_kin._core.csv_numbers import (
    Records,
    RowLines,
    TableColumns,
    csv_head,
    has_pyarrow,
    line_ends,
    quick_numbers,
    whole_lines,
)
from nao_kin._core.files import numpy_errors, opened
from nao_kin._core.headings import FIRST_TIMES, guessed_time_unit
from nao_kin._core.text import abbreviated, one_line_repr, quoted
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadInputFile, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.stream.tables import TableOptions

# --- Tables of joint values, read block by block from the beginning of any block.

# Beginning of a block: bytes, lines or rows before it, depending on the format.
Position = tuple[int, ...]
# Unreadable rows, by their index in a block: column, from 1 or 0 for none, and reason.
Problems = dict[int, tuple[int, str]]


@dataclass(frozen=True)
class Block:
    """Some rows of a table, n of them."""

    values: Floats  # shape (n, columns); NaN in rows that could not be read
    end: Position  # beginning of the next block
    times: Floats | None = None  # in the unit of the file
    problems: Problems = field(default_factory=dict)  # rows that could not be read
    last: bool = False  # whether no block follows
    lines: Sequence[int] | None = None  # line of each row, found on demand; None in files without lines
    file: int = 0  # index of the file, if there are several


class TableSource(ABC):
    """A table of joint values in a file."""

    path: str
    table: TableColumns
    whole: bool = False  # whether the columns are those of q, a floating base included
    start: Position  # beginning of the first block
    size: int | None = None  # length of the file, in the unit of number `counted` of a position
    counted: int = 0
    time_note: str = ""  # on the unit of the times, if it is not stated but determined by their size
    guessed: bool = False  # whether it is

    @property
    def files(self) -> tuple[TableSource, ...]:
        """The source itself, or the sources that it joins."""
        return (self,)

    @abstractmethod
    def blocks(self, start: Position) -> Iterator[Block]:
        """Yield the blocks from a position on; they do not depend on earlier blocks."""

    def first_times(self) -> Floats | None:
        """Return the times of some rows at the beginning; None without rows or times."""
        found = list[Floats]()
        for block in self.blocks(self.start):
            if block.times is None or sum(map(len, found)) >= FIRST_TIMES:
                break
            found.append(block.times)
        return np.concatenate(found) if found else None

    def find_time_unit(self) -> None:
        """Determine the unit of the times, if it is not stated, before any row is processed."""
        if self.table.timed and self.table.time_unit is None:
            times = self.first_times()
            unit, self.time_note = guessed_time_unit(np.empty(0) if times is None else times)
            self.table, self.guessed = replace(self.table, time_unit=unit), True

    def fraction(self, place: Position) -> float | None:
        """Return the share of the file before a position; None if its length is unknown."""
        return None if self.size is None else place[self.counted] / max(1, self.size)

    def close(self) -> None:
        """Close the file."""
        return


# --- A CSV file of joint values, in blocks of whole records.
#
# pyarrow parses one block of lines at a time: its streaming reader can neither begin in the middle of a file nor tell
# the line of a row. If it refuses a block, the block is halved until the refused part is small. Only this part is read
# field by field, so that one bad row does not slow down the good ones.

BYTES_AT_ONCE = 1 << 22
_LONGEST_LINE = 1 << 24
# Blocks of this size that pyarrow refuses are read field by field.
_SMALL = 1 << 14
# pyarrow reads larger files about ten times as fast.
_MOST_WITHOUT_PYARROW = 100_000_000
# Bytes of the first rows, which show the unit of the times.
_FIRST_ROWS = 1 << 16
_CONTENT = "joint names and values"
_BOM = b"\xef\xbb\xbf"


class CsvSource(TableSource):
    """A CSV file as in `read_log`; positions in a .gz file are those of the unpacked text."""

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path, self._quick = path, has_pyarrow()
        self._file = opened(path)
        # Bytes read in advance: after the header, and after the last whole line.
        self._rest, self._behind = b"", b""
        packed = path == "-" or path.lower().endswith(".gz") or not Path(path).is_file()
        self.size = None if packed else Path(path).stat().st_size
        try:
            self._read_header(robot, options)
        except BaseException:
            self.close()
            raise

    def blocks(self, start: Position) -> Iterator[Block]:
        """Yield the blocks; a pipe is read only from its start."""
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
            used, rows, problems = self._read(block, at_end=at_end)
            part = block[:used] if used < len(block) else block
            rest = block[used:] + self._behind
            offset, before, line = offset + used, line, line + line_ends(part)
            if len(rows):
                some = True
                lines = RowLines(part, self.table.delimiter, before)
                values, times = self.table.split(rows)
                yield Block(values, (offset, line), times, problems, at_end and not rest, lines)
            if at_end and not rest:
                break
        if not some and start == self.start:
            raise BadInputFile(self.path, "a header and no configurations")

    def first_times(self) -> Floats | None:
        """As `TableSource`; a pipe is not read further."""
        rows = self._rest[:_FIRST_ROWS]
        return self.table.split(self._read(rows[: whole_lines(rows) or None], at_end=True)[1])[1]

    def close(self) -> None:
        """As `TableSource`."""
        if self.path != "-":
            self._file.close()

    def _read_header(self, robot: RobotModel, options: TableOptions) -> None:
        head = self._file.read(BYTES_AT_ONCE)
        mark = len(_BOM) if head.startswith(_BOM) else 0
        head = head[mark:]
        ends = len(head) < BYTES_AT_ONCE - mark
        beginning = csv_head(self.path, head, _CONTENT, at_end=ends)
        try:
            head[: beginning.size].decode("utf-8")
        except UnicodeDecodeError as error:
            raise BadInputFile(self.path, f"not UTF-8 text (byte {mark + error.start}); expected {_CONTENT}") from None
        self.start = mark + beginning.size, beginning.lines
        self._rest = head[beginning.size :]
        table = options.table(self.path, beginning.fields, robot, beginning)
        self.table = table.of_csv(beginning, self._rest)

    def _next_lines(self, rest: bytes, line: int) -> tuple[bytes, bool]:
        """Return whole lines, of about `BYTES_AT_ONCE`, and whether the file ends with them."""
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

    def _read(self, block: bytes, *, at_end: bool) -> tuple[int, Floats, Problems]:
        """Return the length of the whole records in a block, their rows, NaN if unreadable, and the problems."""
        if b'"' in block or not self._quick:
            return self._read_exactly(block, at_end=at_end)
        numbers = quick_numbers(block, self.table)
        if numbers is not None:
            return len(block), numbers, {}
        middle = whole_lines(block[: len(block) // 2])
        if len(block) <= _SMALL or not middle:
            return self._read_exactly(block, at_end=True)
        _, first, problems = self._read(block[:middle], at_end=True)
        _, second, behind = self._read(block[middle:], at_end=True)
        problems |= {len(first) + row: problem for row, problem in behind.items()}
        return len(block), np.concatenate([first, second]), problems

    def _read_exactly(self, block: bytes, *, at_end: bool) -> tuple[int, Floats, Problems]:
        """Do the same as `_read`, field by field."""
        records = Records(block, self.table.delimiter, at_end=at_end)
        values: list[list[float]] = []
        problems: Problems = {}
        nothing = [math.nan] * len(self.table.places)
        for _, row, column, reason in self.table.rows(self.path, records):
            if row is None:
                problems[len(values)] = column, reason
            values.append(row or nothing)
        return records.consumed, np.array(values).reshape(len(values), len(nothing)), problems


# --- Tables of joint values in binary formats: NumPy, Parquet, Arrow IPC.

ROWS_AT_ONCE = 8192
_BUFFER = 1 << 18


def _table_of_q(robot: RobotModel, degrees: bool = False) -> TableColumns:
    """Return the columns of an array of configurations, without those of a floating base."""
    return TableOptions(degrees).table("", robot.joint_names, robot)


class NpySource(TableSource):
    """A NumPy file of configurations (N, nq)."""

    whole = True
    size: int
    times: Floats | None = None

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path, self.start = path, (0,)
        self.table = _table_of_q(robot, options.degrees)
        if zipfile.is_zipfile(path):
            raise BadInputFile(path, "an archive of arrays, expected one array")
        rows = self._rows()
        if rows.ndim != 2 or rows.shape[1] != robot.nq:
            raise BadInputFile(path, f"an array of shape {rows.shape}, expected (N, {robot.nq})")
        if rows.dtype.kind not in "fiu":
            raise BadInputFile(path, f"an array of {rows.dtype}, expected real numbers")
        self.size = len(rows)

    def blocks(self, start: Position) -> Iterator[Block]:
        """Yield the blocks; the file is mapped again for each block, so that memory is released."""
        for first in range(start[0], self.size, ROWS_AT_ONCE):
            values = np.array(self._rows()[first : first + ROWS_AT_ONCE], dtype=np.float64)
            end = first + len(values)
            times = None if self.times is None else self.times[first:end]
            yield Block(values, (end,), times, last=end == self.size)

    def _rows(self) -> np.ndarray[Any, Any]:
        # Not by np.load, which leaves a file open that begins like an archive and is none.
        with numpy_errors(self.path, "not a whole NumPy array"):
            return np.lib.format.open_memmap(self.path, mode="r")


@one_line_repr
@dataclass(frozen=True, eq=False)
class Configurations:
    """Configurations in memory, for `fk` to read instead of a file.

    Attributes:
        q: shape (n, nq) [rad, m or ratio], whatever the unit of the poses.
        times: times of the rows, shape (n,) [s]; None without times.
        name: their origin, for messages.
    """

    q: Floats
    times: Floats | None = None
    name: str = "configurations"


class ArraySource(NpySource):
    """Configurations in memory, perhaps with times, read like a NumPy file."""

    def __init__(self, given: Configurations, robot: RobotModel) -> None:
        self._q = as_floats(given.q, (robot.nq,), "q")
        if self._q.ndim != 2:
            raise WrongShape("q", f"(n, {robot.nq})", self._q.shape)
        self.times = None if given.times is None else as_floats(given.times, (), "times")
        if self.times is not None and self.times.shape != (len(self._q),):
            raise WrongShape("times", f"({len(self._q)},), a time for each configuration", self.times.shape)
        self.path, self.start, self.size = given.name, (0,), len(self._q)
        self.table = replace(_table_of_q(robot), timed=self.times is not None, time_unit="s", assumed=())

    def _rows(self) -> Floats:
        return self._q


class ParquetSource(TableSource):
    """A Parquet file with one column per joint."""

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path, self.start = path, (0,)
        from pyarrow import ArrowException, parquet

        try:
            with parquet.ParquetFile(path) as file:
                self._groups = [file.metadata.row_group(index).num_rows for index in range(file.num_row_groups)]
                schema = file.schema_arrow
        except ArrowException as error:
            raise BadInputFile(path, f"not a Parquet file: {abbreviated(error)}") from None
        self.size = sum(self._groups)
        self.table, self._columns = _table_of(schema, path, robot, options)

    def blocks(self, start: Position) -> Iterator[Block]:
        """Yield the blocks; earlier row groups are not read."""
        from pyarrow import ArrowException, parquet

        skipped, left_out = 0, start[0]
        while skipped < len(self._groups) and self._groups[skipped] <= left_out:
            left_out -= self._groups[skipped]
            skipped += 1
        row = start[0]
        try:
            # Without buffers, whole columns of a group are read.
            with parquet.ParquetFile(self.path, buffer_size=_BUFFER) as file:
                for group in range(skipped, len(self._groups)):
                    for batch in file.iter_batches(ROWS_AT_ONCE, row_groups=[group], columns=self._columns):
                        rows = batch.slice(min(left_out, batch.num_rows))
                        left_out -= batch.num_rows - rows.num_rows
                        row += rows.num_rows
                        if rows.num_rows:
                            yield _block_of(rows, self.table, self._columns, (row,), last=row == self.size)
        except ArrowException as error:
            raise BadInputFile(self.path, f"cannot be read to its end: {abbreviated(error)}") from None


class ArrowSource(TableSource):
    """An Arrow IPC file, which is also a Feather file, with one column per joint.

    A position has three numbers: the rows before it, the batch with the next row, and the rows before it in that batch.
    """

    size: int
    counted = 1

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path, self.start = path, (0, 0, 0)
        import pyarrow as pa

        try:
            with pa.memory_map(path) as file, pa.ipc.open_file(file) as reader:
                batches, schema = reader.num_record_batches, reader.schema
        except pa.ArrowException as error:
            raise BadInputFile(path, f"not an Arrow IPC file: {abbreviated(error)}") from None
        self.size = int(batches)
        self.table, self._columns = _table_of(schema, path, robot, options)

    def blocks(self, start: Position) -> Iterator[Block]:
        """Yield the blocks; the file is mapped again for each batch, so that memory is released."""
        import pyarrow as pa

        row, first, offset = start
        for index in range(first, self.size):
            try:
                with pa.memory_map(self.path) as file, pa.ipc.open_file(file) as reader:
                    batch = reader.get_batch(index)
            except pa.ArrowException as error:
                raise BadInputFile(self.path, f"cannot be read to its end: {abbreviated(error)}") from None
            while offset < batch.num_rows:
                rows = batch.slice(offset, ROWS_AT_ONCE)
                row, offset = row + rows.num_rows, offset + rows.num_rows
                last = offset == batch.num_rows and index + 1 == self.size
                yield _block_of(rows, self.table, self._columns, (row, index, offset), last=last)
            offset = 0


def _table_of(schema: Any, path: str, robot: RobotModel, options: TableOptions) -> tuple[TableColumns, list[str]]:
    """Return the columns of a table, which must hold numbers or times, and their names in the file."""
    import pyarrow as pa

    table = options.table(path, schema.names, robot)
    for place in table.places:
        entry, kind = schema.field(place), schema.field(place).type
        is_time = table.timed and place == table.places[-1]
        if is_time and pa.types.is_timestamp(kind):
            table = replace(table, time_unit=kind.unit)
        elif not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)):
            raise BadInputFile(path, f"column {quoted(entry.name)} holds {abbreviated(kind)}, expected numbers")
    return table, [schema.names[place] for place in table.places]


def _block_of(rows: Any, table: TableColumns, columns: Sequence[str], end: Position, *, last: bool) -> Block:
    """Return the rows of a record batch."""
    import pyarrow as pa

    values = np.empty((rows.num_rows, len(columns)))
    problems: Problems = {}
    for column, (given, name) in enumerate(zip(columns, table.headings, strict=True)):
        numbers = rows.column(rows.schema.get_field_index(given))
        if pa.types.is_timestamp(numbers.type):
            numbers = numbers.cast(pa.int64())
        numbers = numbers.cast(pa.float64(), safe=False)
        values[:, column] = numbers.to_numpy(zero_copy_only=False)
        if numbers.null_count:
            for row in np.flatnonzero(numbers.is_null().to_numpy(zero_copy_only=False)).tolist():
                problems.setdefault(row, (0, f"{name} is null, expected a finite number"))
    numbers, times = table.split(values)
    return Block(numbers, end, times, problems, last)


# --- The format of a file, by its suffix, and several files as one source.

# Suffixes of the two formats that need pyarrow; any other suffix is CSV.
PARQUET_ENDINGS, ARROW_ENDINGS = (".parquet", ".pq"), (".arrow", ".feather", ".ipc")


def found_files(path: str) -> list[str]:
    """Return the file of a name, or the files that match a pattern with * or ? or [ ], sorted."""
    if not glob.has_magic(path) or Path(path).exists():
        return [path]
    found = sorted(name for name in glob.glob(path, recursive=True) if Path(name).is_file())
    if not found:
        raise BadInputFile(path, "no file matches this pattern")
    return found


def open_source(paths: Sequence[str] | Configurations, robot: RobotModel, options: TableOptions) -> TableSource:
    """Return the table in one file or several, or in memory."""
    if isinstance(paths, Configurations):
        return ArraySource(paths, robot)
    if len(paths) == 1:
        return _opened(paths[0], robot, options)
    return JoinedSource(paths, robot, options)


class JoinedSource(TableSource):
    """Several files in turn; a position is the index of a file and a position in it."""

    def __init__(self, paths: Sequence[str], robot: RobotModel, options: TableOptions) -> None:
        self._robot, self._options = robot, options
        self._files = []
        for path in paths:
            if path == "-":
                raise BadInputFile(path, "it cannot be joined with other files")
            with closing(_opened(path, robot, options)) as file:
                self._files.append(file)
        first = self._files[0]
        for file in self._files:
            if file.table.timed != first.table.timed:
                with_times, without = (first, file) if first.table.timed else (file, first)
                raise BadInputFile(without.path, f"no column of times, which {abbreviated(with_times.path)} has")
            _check_times_alike(file, first)
        self.path, self.table, self.start = first.path, first.table, (0, *first.start)
        self.time_note = next((file.time_note for file in self._files if file.time_note), "")

    @property
    def files(self) -> tuple[TableSource, ...]:
        """As `TableSource`."""
        return tuple(self._files)

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `TableSource`."""
        for index in range(start[0], len(self._files)):
            with closing(_opened(self._files[index].path, self._robot, self._options)) as file:
                # Times of ISO 8601 count from the first row of the first file.
                file.table = replace(file.table, iso_times=self.table.iso_times)
                for block in file.blocks(start[1:] if index == start[0] else file.start):
                    last = block.last and index + 1 == len(self._files)
                    yield replace(block, end=(index, *block.end), last=last, file=index)

    def fraction(self, place: Position) -> float:
        """As `TableSource`."""
        return (place[0] + (self._files[place[0]].fraction(place[1:]) or 0.0)) / len(self._files)


def _check_times_alike(file: TableSource, first: TableSource) -> None:
    """Refuse times that cannot be a continuation of the first file's times."""
    times, before = file.table.iso_times, first.table.iso_times
    other = abbreviated(first.path)
    unit, expected = file.table.time_unit, first.table.time_unit
    if times is None and before is None and unit != expected and (file.guessed or first.guessed):
        advice = "headings such as time [ns], or columns= (--columns), give the units"
        raise BadInputFile(
            file.path, f"its times are in {unit}, those of {other} in {expected}, one of them by a guess; {advice}"
        )
    if (times is None) != (before is None):
        forms = "numbers", "dates and times"
        given, expected = forms if times is None else forms[::-1]
        raise BadInputFile(file.path, f"its times are {given}, those of {other} are {expected}")
    if times is not None and before is not None and times.zoned != before.zoned:
        given, expected = ("a", "none") if times.zoned else ("no", "one")
        raise BadInputFile(file.path, f"its times have {given} time zone, those of {other} have {expected}")


def _opened(path: str, robot: RobotModel, options: TableOptions) -> TableSource:
    """Return the table in a file, whose suffix is its format; other suffixes are CSV."""
    if Path(path).suffix.lower() in (".json", ".jsonl", ".ndjson"):
        raise BadInputFile(path, "JSON is read whole, not as a stream; expected CSV, npy, Parquet or Arrow")
    name = Path(path)
    ending = (name.with_suffix("") if name.suffix.lower() == ".gz" else name).suffix.lower()
    binary = ending in (*PARQUET_ENDINGS, *ARROW_ENDINGS)
    large = name.is_file() and name.stat().st_size > _MOST_WITHOUT_PYARROW
    if binary or (ending != ".npy" and (large or has_pyarrow())):
        need_extra(f"reading {abbreviated(path)} as a stream", "arrow")
    kind: Callable[[str, RobotModel, TableOptions], TableSource] = CsvSource
    if binary:
        kind = ParquetSource if ending in PARQUET_ENDINGS else ArrowSource
    elif ending == ".npy":
        kind = NpySource
    try:
        source = kind(path, robot, options)
        source.find_time_unit()
        return source
    except OSError as error:
        raise BadInputFile(path, f"cannot be read: {error.strerror or error}") from None
