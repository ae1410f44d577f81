"""Tables of joint values in the binary formats: NumPy's, Parquet, Arrow IPC."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._text import abbreviated, quoted
from nao_kin.configuration_files import TableColumns
from nao_kin.errors import BadInputFile, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.stream.blocks import Block, Position, Source, TableOptions

ROWS_AT_ONCE = 8192
_BUFFER = 1 << 18


class NpySource(Source):
    """A NumPy file of configurations (N, nq)."""

    whole = True

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path, self.table, self.start = path, options.of_q(robot), (0,)
        rows = self._rows()
        if rows.ndim != 2 or rows.shape[1] != robot.nq:
            raise BadInputFile(path, f"an array of shape {rows.shape}, expected (N, {robot.nq})")
        if rows.dtype.kind not in "fiu":
            raise BadInputFile(path, f"an array of {rows.dtype}, expected real numbers")
        self._count = len(rows)

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `Source`; mapped anew for each block, so that what has been read leaves the memory."""
        for first in range(start[0], self._count, ROWS_AT_ONCE):
            values = np.array(self._rows()[first : first + ROWS_AT_ONCE], dtype=np.float64)
            end = first + len(values)
            yield Block(values, (end,), last=end == self._count)

    def fraction(self, place: Position) -> float:
        """As `Source`."""
        return place[0] / max(1, self._count)

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


class ArraySource(Source):
    """Configurations in memory."""

    whole = True

    def __init__(self, rows: Configurations, robot: RobotModel) -> None:
        self.path, self.start = rows.name, (0,)
        self._rows = as_floats(rows.q, (robot.nq,), "q")
        if self._rows.ndim != 2:
            raise WrongShape("q", f"(n, {robot.nq})", self._rows.shape)
        self._times = None if rows.times is None else as_floats(rows.times, (), "times")
        if self._times is not None and self._times.shape != (len(self._rows),):
            raise WrongShape("times", f"({len(self._rows)},), a time for each configuration", self._times.shape)
        self.table = replace(TableOptions().of_q(robot), timed=self._times is not None, time_unit="s")

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `Source`."""
        count = len(self._rows)
        for first in range(start[0], count, ROWS_AT_ONCE):
            end = min(first + ROWS_AT_ONCE, count)
            times = None if self._times is None else self._times[first:end]
            yield Block(self._rows[first:end], (end,), times, last=end == count)

    def fraction(self, place: Position) -> float:
        """As `Source`."""
        return place[0] / max(1, len(self._rows))


class ParquetSource(Source):
    """A Parquet file with one column per joint."""

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path, self.start = path, (0,)
        from pyarrow import ArrowException, parquet

        try:
            with parquet.ParquetFile(path) as file:
                groups = [file.metadata.row_group(index).num_rows for index in range(file.num_row_groups)]
                schema = file.schema_arrow
        except ArrowException as error:
            raise BadInputFile(path, f"not a Parquet file: {abbreviated(error)}") from None
        self._groups: list[int] = groups
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
                            yield _block_of(rows, self.table, self._columns, (row,), last=row == sum(self._groups))
        except ArrowException as error:
            raise BadInputFile(self.path, f"cannot be read to its end: {abbreviated(error)}") from None

    def fraction(self, place: Position) -> float:
        """As `Source`."""
        return place[0] / max(1, sum(self._groups))


class ArrowSource(Source):
    """An Arrow IPC file, which is also a Feather file, with one column per joint.

    A place in it is a number of rows, the batch they end in, and the rows of that batch.
    """

    def __init__(self, path: str, robot: RobotModel, options: TableOptions) -> None:
        self.path, self.start = path, (0, 0, 0)
        import pyarrow as pa

        try:
            with pa.memory_map(path) as file, pa.ipc.open_file(file) as reader:
                batches, schema = reader.num_record_batches, reader.schema
        except pa.ArrowException as error:
            raise BadInputFile(path, f"not an Arrow IPC file: {abbreviated(error)}") from None
        self._batches = int(batches)
        self.table = _table_of(schema, path, robot, options)
        self._columns = [schema.names[place] for place in self.table.places]

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `Source`; mapped anew for each batch, so that what has been read leaves the memory."""
        import pyarrow as pa

        row, first, offset = start
        for index in range(first, self._batches):
            try:
                with pa.memory_map(self.path) as file, pa.ipc.open_file(file) as reader:
                    batch = reader.get_batch(index)
            except pa.ArrowException as error:
                raise BadInputFile(self.path, f"cannot be read to its end: {abbreviated(error)}") from None
            while offset < batch.num_rows:
                rows = batch.slice(offset, ROWS_AT_ONCE)
                row, offset = row + rows.num_rows, offset + rows.num_rows
                last = offset == batch.num_rows and index + 1 == self._batches
                yield _block_of(rows, self.table, self._columns, (row, index, offset), last=last)
            offset = 0

    def fraction(self, place: Position) -> float:
        """As `Source`."""
        return place[1] / max(1, self._batches)


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
    problems: dict[int, tuple[int, str]] = {}
    for column, (given, name) in enumerate(zip(columns, table.headings, strict=True)):
        numbers = rows.column(rows.schema.get_field_index(given))
        if pa.types.is_timestamp(numbers.type):
            numbers = numbers.cast(pa.int64())
        numbers = numbers.cast(pa.float64(), safe=False)
        values[:, column] = numbers.to_numpy(zero_copy_only=False)
        if numbers.null_count:
            for row in np.flatnonzero(numbers.is_null().to_numpy(zero_copy_only=False)).tolist():
                problems.setdefault(row, (0, f"{name} is null, expected a finite number"))
    joints = len(table.names)
    times = values[:, joints] if table.timed else None
    return Block(values[:, :joints], end, times, problems, last)
