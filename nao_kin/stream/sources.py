"""Where configurations come from: CSV, NumPy, Parquet and Arrow files, read block by block."""

from __future__ import annotations

import glob
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats
from nao_kin._core.csv_numbers import Records, RowLines, TableColumns, csv_head, line_ends, quick_numbers, whole_lines
from nao_kin._core.files import opened
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadInputFile, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.stream.tables import TableOptions

# --- Tables of joint values, read block by block from any place that a block begins at.

# Where a block begins: bytes, lines and rows before it, as far as the kind of file needs them.
Position = tuple[int, ...]
# Column, from 1 and 0 for none, and reason of rows that could not be read, by their place in a block.
Problems = dict[int, tuple[int, str]]


@dataclass(frozen=True)
class Block:
    """Some rows of a table.

    Attributes:
        values: shape (n, columns); NaN in rows that could not be read.
        end: where the next block begins.
        times: shape (n,), in the unit of the file; None where it has none.
        problems: rows that could not be read.
        last: no block follows.
        lines: of every row of the block, found when one is asked for; None where there are no lines.
        file: which of several files it is from.
    """

    values: Floats
    end: Position
    times: Floats | None = None
    problems: Problems = field(default_factory=dict)
    last: bool = False
    lines: Sequence[int] | None = None
    file: int = 0


class Source(ABC):
    """A table of joint values in a file.

    Attributes:
        path: the file.
        table: which columns are joints and times, and their units.
        whole: the columns are those of q itself, a floating base included.
        start: where the first block begins.
        size: how long it is, None where that is not known; in what the number `counted` of a place counts.
    """

    path: str
    table: TableColumns
    whole: bool = False
    start: Position
    size: int | None = None
    counted: int = 0

    @property
    def files(self) -> tuple[Source, ...]:
        """The source itself, or the sources that it joins."""
        return (self,)

    @abstractmethod
    def blocks(self, start: Position) -> Iterator[Block]:
        """The blocks from a place on; the same ones whatever came before."""

    def fraction(self, place: Position) -> float | None:
        """How much of the file lies before a place; None where its length is not known."""
        return None if self.size is None else place[self.counted] / max(1, self.size)

    def close(self) -> None:
        """Nothing more is read."""
        return


# --- A CSV file of joint values, in blocks of whole records.
#
# The file is cut by us and the numbers are read by pyarrow, one block at a time: its own streaming reader can neither
# begin in the middle of a file nor say on which line a row stood. A block that it refuses is halved until what is
# left is small, and that is read exactly: good rows beside a bad one cost nothing more.

BYTES_AT_ONCE = 1 << 22
_LONGEST_LINE = 1 << 24
# Read exactly where the quick way refuses it.
_SMALL = 1 << 14
_BOM = b"\xef\xbb\xbf"


class CsvSource(Source):
    """Joint names in the header, in any order, and one configuration a line, as `read_log` reads them.

    A file whose name ends in .gz is unpacked; a place in it is one of what is unpacked.
    """

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path = path
        self._file = opened(path)
        # What has been read and not yet been given out: at the start, and behind the last whole line.
        self._rest, self._behind = b"", b""
        packed = path == "-" or path.lower().endswith(".gz") or not Path(path).is_file()
        self.size = None if packed else Path(path).stat().st_size
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

    def close(self) -> None:
        """As `Source`."""
        if self.path != "-":
            self._file.close()

    def _read_header(self, robot: RobotModel, options: TableOptions) -> None:
        head = self._file.read(BYTES_AT_ONCE)
        mark = len(_BOM) if head.startswith(_BOM) else 0
        head = head[mark:]
        ends = len(head) < BYTES_AT_ONCE - mark
        beginning = csv_head(self.path, head, "joint names and values", at_end=ends)
        try:
            head[: beginning.size].decode("utf-8")
        except UnicodeDecodeError as error:
            raise BadInputFile(self.path, f"not UTF-8 text (byte {mark + error.start})") from None
        self.start = mark + beginning.size, beginning.lines
        self._rest = head[beginning.size :]
        table = options.table(self.path, beginning.fields, robot, beginning.line)
        self.table = table.of_csv(beginning, self._rest)

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

    def _read(self, block: bytes, *, at_end: bool) -> tuple[int, Floats, Problems]:
        """How much of a block whole records are, their rows, NaN where they could not be read, and why not."""
        if b'"' in block:
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
        """The same, field by field."""
        records = Records(block, self.table.delimiter, at_end=at_end)
        values: list[list[float]] = []
        problems: Problems = {}
        nothing = [math.nan] * len(self.table.places)
        for _, row, column, reason in self.table.rows(self.path, records):
            if row is None:
                problems[len(values)] = column, reason
            values.append(row or nothing)
        return records.consumed, np.array(values).reshape(len(values), len(nothing)), problems


# --- Tables of joint values in the binary formats: NumPy's, Parquet, Arrow IPC.

ROWS_AT_ONCE = 8192
_BUFFER = 1 << 18


def _table_of_q(robot: RobotModel, degrees: bool = False) -> TableColumns:
    """What the columns of an array of configurations are, behind those of a floating base."""
    return TableOptions(degrees).table("", robot.joint_names, robot)


class NpySource(Source):
    """A NumPy file of configurations (N, nq)."""

    whole = True
    size: int
    times: Floats | None = None

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path, self.start = path, (0,)
        self.table = _table_of_q(robot, options.degrees)
        rows = self._rows()
        if rows.ndim != 2 or rows.shape[1] != robot.nq:
            raise BadInputFile(path, f"an array of shape {rows.shape}, expected (N, {robot.nq})")
        if rows.dtype.kind not in "fiu":
            raise BadInputFile(path, f"an array of {rows.dtype}, expected real numbers")
        self.size = len(rows)

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `Source`; mapped anew for each block, so that what has been read leaves the memory."""
        for first in range(start[0], self.size, ROWS_AT_ONCE):
            values = np.array(self._rows()[first : first + ROWS_AT_ONCE], dtype=np.float64)
            end = first + len(values)
            times = None if self.times is None else self.times[first:end]
            yield Block(values, (end,), times, last=end == self.size)

    def _rows(self) -> np.ndarray[Any, Any]:
        try:
            rows = np.load(self.path, mmap_mode="r", allow_pickle=False)
        except (ValueError, EOFError) as error:
            raise BadInputFile(self.path, f"not a whole NumPy array: {abbreviated(error)}") from None
        if not isinstance(rows, np.ndarray):
            raise BadInputFile(self.path, "an archive of arrays, expected one array")
        return rows


@dataclass(frozen=True, eq=False)
class Configurations:
    """Configurations in memory, for `fk` to take in place of a file.

    Attributes:
        q: shape (n, nq) [rad, m or ratio], whatever the unit of the poses.
        times: of the rows, shape (n,) [s]; None for none.
        name: where they are from, for messages.

    Examples:
        >>> nao = nk.load_nao()
        >>> rows = nk.stream.Configurations(nao.random(rng=0, n=3), name="three random ones")
        >>> nk.stream.fk(nao, rows, "LArm", "poses.npy").rows_read
        3
    """

    q: Floats
    times: Floats | None = None
    name: str = "configurations"


class ArraySource(NpySource):
    """Configurations in memory, as if they were in a NumPy file, and maybe with times."""

    def __init__(self, given: Configurations, robot: RobotModel) -> None:
        self._q = as_floats(given.q, (robot.nq,), "q")
        if self._q.ndim != 2:
            raise WrongShape("q", f"(n, {robot.nq})", self._q.shape)
        self.times = None if given.times is None else as_floats(given.times, (), "times")
        if self.times is not None and self.times.shape != (len(self._q),):
            raise WrongShape("times", f"({len(self._q)},), a time for each configuration", self.times.shape)
        self.path, self.start, self.size = given.name, (0,), len(self._q)
        self.table = replace(_table_of_q(robot), timed=self.times is not None, time_unit="s")

    def _rows(self) -> Floats:
        return self._q


class ParquetSource(Source):
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
        self.table = _table_of(schema, path, robot, options)
        self._columns = [schema.names[place] for place in self.table.places]

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `Source`; groups of rows that lie before it are not read."""
        from pyarrow import ArrowException, parquet

        skipped, left_out = 0, start[0]
        while skipped < len(self._groups) and self._groups[skipped] <= left_out:
            left_out -= self._groups[skipped]
            skipped += 1
        row = start[0]
        try:
            # A buffer of its own for each column: without one, whole columns of a group are read.
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


class ArrowSource(Source):
    """An Arrow IPC file, which is also a Feather file, with one column per joint.

    A place in it is a number of rows, the batch they end in, and the rows of that batch.
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
        self.table = _table_of(schema, path, robot, options)
        self._columns = [schema.names[place] for place in self.table.places]

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `Source`; mapped anew for each batch, so that what has been read leaves the memory."""
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


def _table_of(schema: Any, path: str, robot: RobotModel, options: TableOptions) -> TableColumns:
    """What the columns of a table are, when they hold numbers; times may be those of Arrow."""
    import pyarrow as pa

    table = options.table(path, schema.names, robot)
    for place in table.places:
        entry, kind = schema.field(place), schema.field(place).type
        is_time = table.timed and place == table.places[-1]
        if is_time and pa.types.is_timestamp(kind):
            table = replace(table, time_unit=kind.unit)
        elif not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)):
            raise BadInputFile(path, f"column {quoted(entry.name)} holds {abbreviated(kind)}, expected numbers")
    return table


def _block_of(rows: Any, table: TableColumns, columns: Sequence[str], end: Position, *, last: bool) -> Block:
    """The rows of a record batch."""
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


# --- Where configurations come from: the kind of a file, by the ending of its name, and several files as one.

CSV, NPY, PARQUET, ARROW = "csv", "npy", "parquet", "arrow"
KINDS = {
    ".csv": CSV,
    ".tsv": CSV,
    ".txt": CSV,
    ".npy": NPY,
    ".parquet": PARQUET,
    ".pq": PARQUET,
    ".arrow": ARROW,
    ".feather": ARROW,
    ".ipc": ARROW,
}


_SOURCES: dict[str | None, Callable[[str, RobotModel, TableOptions], Source]] = {
    NPY: NpySource,
    PARQUET: ParquetSource,
    ARROW: ArrowSource,
}


def kind_of(path: str) -> str | None:
    """The kind of file that the ending of a name promises."""
    name = Path(path)
    unpacked = name.with_suffix("") if name.suffix.lower() == ".gz" else name
    return KINDS.get(unpacked.suffix.lower())


def found_files(path: str) -> list[str]:
    """The file of a name, or the files that a pattern with * or ? or [ ] stands for, sorted.

    Raises:
        BadInputFile: a pattern stands for no file.
    """
    if not glob.has_magic(path) or Path(path).exists():
        return [path]
    found = sorted(name for name in glob.glob(path, recursive=True) if Path(name).is_file())
    if not found:
        raise BadInputFile(path, "no file has such a name")
    return found


def open_source(paths: Sequence[str] | Configurations, robot: RobotModel, options: TableOptions) -> Source:
    """The table in one file or several.

    Raises:
        BadInputFile, MissingExtra: as `_opened`; some files have times and others none.
    """
    if isinstance(paths, Configurations):
        return ArraySource(paths, robot)
    if len(paths) == 1:
        return _opened(paths[0], robot, options)
    return JoinedSource(paths, robot, options)


class JoinedSource(Source):
    """Several files, one behind the other. A place is the number of a file and a place in it."""

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

    @property
    def files(self) -> tuple[Source, ...]:
        """As `Source`."""
        return tuple(self._files)

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `Source`."""
        for index in range(start[0], len(self._files)):
            with closing(_opened(self._files[index].path, self._robot, self._options)) as file:
                # Times of ISO 8601 count from the first row of all.
                file.table = replace(file.table, iso_times=self.table.iso_times)
                for block in file.blocks(start[1:] if index == start[0] else file.start):
                    last = block.last and index + 1 == len(self._files)
                    yield replace(block, end=(index, *block.end), last=last, file=index)

    def fraction(self, place: Position) -> float:
        """As `Source`."""
        return (place[0] + (self._files[place[0]].fraction(place[1:]) or 0.0)) / len(self._files)


def _check_times_alike(file: Source, first: Source) -> None:
    """Refuse times that cannot be counted on from those of the first file."""
    times, before = file.table.iso_times, first.table.iso_times
    other = abbreviated(first.path)
    if (times is None) != (before is None):
        forms = "numbers", "dates and times"
        given, expected = forms if times is None else forms[::-1]
        raise BadInputFile(file.path, f"its times are {given}, those of {other} are {expected}")
    if times is not None and before is not None and times.zoned != before.zoned:
        given, expected = ("a", "none") if times.zoned else ("no", "one")
        raise BadInputFile(file.path, f"its times have {given} time zone, those of {other} have {expected}")


def _opened(path: str, robot: RobotModel, options: TableOptions) -> Source:
    """The table in a file, whose kind its ending names; without an ending of ours, it is CSV.

    Raises:
        BadInputFile: it cannot be read, or its columns are not the joints of the robot.
        MissingExtra: pyarrow is needed and not installed.
    """
    if Path(path).suffix.lower() == ".json":
        raise BadInputFile(path, "JSON is read whole, not as a stream; expected CSV, npy, Parquet or Arrow")
    kind = kind_of(path)
    if kind != NPY:
        need_extra(f"reading {abbreviated(path)} as a stream", "arrow")
    try:
        return _SOURCES.get(kind, CsvSource)(path, robot, options)
    except OSError as error:
        raise BadInputFile(path, f"cannot be read: {error.strerror or error}") from None
