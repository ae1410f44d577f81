"""Where poses go: parts, each written from its beginning to its end, that are joined to one file."""

from __future__ import annotations

import shutil
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from nao_kin._common import atomic
from nao_kin._common.arrays import Floats
from nao_kin._common.optional import need_extra
from nao_kin._text import abbreviated
from nao_kin.errors import BadArgument
from nao_kin.stream.csv_text import csv_header, pose_lines
from nao_kin.stream.sources import ARROW, CSV, NPY, PARQUET, kind_of

_COPIED_AT_ONCE = 1 << 22
# Rows of a group of a Parquet file: enough to be read quickly, and few enough to be held in memory.
_ROWS_OF_GROUP = 1 << 17


class Sink(ABC):
    """A kind of file that poses are written to.

    Attributes:
        frames: names of the frames.
        columns: names of the numbers of a pose.
        shape: shape of the numbers of one row.
        dtype: their kind.
        timed: the rows have times.
    """

    def __init__(
        self,
        frames: tuple[str, ...],
        columns: tuple[str, ...],
        shape: tuple[int, ...],
        dtype: np.dtype[Any],
        *,
        timed: bool = False,
    ) -> None:
        self.frames, self.columns, self.shape, self.dtype, self.timed = frames, columns, shape, dtype, timed

    @abstractmethod
    def write(self, file: BinaryIO, rows: NDArray[np.int64], numbers: NDArray[Any], times: Floats | None) -> None:
        """Append poses (n, frames, k) of `rows` (n,), with times (n,) if there are any, to a part."""

    @abstractmethod
    def join(self, parts: Iterable[Path], file: BinaryIO, rows: int) -> None:
        """Write the whole file from its parts, which hold so many rows."""


class CsvSink(Sink):
    """CSV: one line for each row and frame."""

    def write(self, file: BinaryIO, rows: NDArray[np.int64], numbers: NDArray[Any], times: Floats | None) -> None:
        """As `Sink`."""
        file.write(pose_lines(rows, self.frames, numbers, times))

    def join(self, parts: Iterable[Path], file: BinaryIO, rows: int) -> None:
        """As `Sink`."""
        file.write(csv_header(self.columns, timed=self.timed).encode())
        _append(parts, file)


class NpySink(Sink):
    """A NumPy array of shape (rows, *shape), which has no place for times."""

    def write(self, file: BinaryIO, rows: NDArray[np.int64], numbers: NDArray[Any], times: Floats | None) -> None:
        """As `Sink`."""
        file.write(np.ascontiguousarray(numbers).reshape(-1).view(np.uint8).data)

    def join(self, parts: Iterable[Path], file: BinaryIO, rows: int) -> None:
        """As `Sink`."""
        description = np.lib.format.dtype_to_descr(self.dtype)
        shape = {"descr": description, "fortran_order": False, "shape": (rows, *self.shape)}
        np.lib.format.write_array_header_1_0(file, shape)
        _append(parts, file)


class ArrowSink(Sink):
    """An Arrow IPC file: one record for each row and frame."""

    def write(self, file: BinaryIO, rows: NDArray[np.int64], numbers: NDArray[Any], times: Floats | None) -> None:
        """As `Sink`; a part is a number of streams of one batch."""
        import pyarrow as pa

        with pa.ipc.new_stream(file, self._schema()) as writer:
            writer.write_batch(self._batch(rows, numbers, times))

    def join(self, parts: Iterable[Path], file: BinaryIO, rows: int) -> None:
        """As `Sink`."""
        import pyarrow as pa

        with pa.ipc.new_file(file, self._schema()) as writer:
            for batch in _batches(parts):
                writer.write_batch(batch)

    def _schema(self) -> Any:
        import pyarrow as pa

        frame = pa.dictionary(pa.int32(), pa.string())
        number = pa.from_numpy_dtype(self.dtype)
        time = [("time", pa.float64())] if self.timed else []
        return pa.schema([("row", pa.int64()), *time, ("frame", frame), *((name, number) for name in self.columns)])

    def _batch(self, rows: NDArray[np.int64], numbers: NDArray[Any], times: Floats | None) -> Any:
        import pyarrow as pa

        places = np.tile(np.arange(len(self.frames), dtype=np.int32), len(rows))
        frame = pa.DictionaryArray.from_arrays(places, pa.array(self.frames, pa.string()))
        columns = [np.ascontiguousarray(column) for column in numbers.reshape(-1, len(self.columns)).T]
        heads = [pa.array(np.repeat(of_rows, len(self.frames))) for of_rows in (rows, times) if of_rows is not None]
        return pa.record_batch([*heads, frame, *columns], schema=self._schema())


class ParquetSink(ArrowSink):
    """A Parquet file: one record for each row and frame."""

    def join(self, parts: Iterable[Path], file: BinaryIO, rows: int) -> None:
        """As `Sink`; groups of one length, wherever a part ends."""
        import pyarrow as pa
        from pyarrow import parquet

        # The numbers do not repeat: a dictionary of them would only take time.
        options = {"compression": "zstd", "use_dictionary": ["frame"]}
        schema = self._schema()
        with parquet.ParquetWriter(file, schema, **options) as writer:
            waiting, count = [], 0
            for batch in _batches(parts):
                waiting.append(batch)
                count += batch.num_rows
                if count >= _ROWS_OF_GROUP:
                    table = pa.Table.from_batches(waiting, schema)
                    whole = count - count % _ROWS_OF_GROUP
                    writer.write_table(table.slice(0, whole), _ROWS_OF_GROUP)
                    waiting, count = table.slice(whole).to_batches(), count - whole
            if count:
                writer.write_table(pa.Table.from_batches(waiting, schema), _ROWS_OF_GROUP)


_SINKS: dict[str, type[Sink]] = {CSV: CsvSink, NPY: NpySink, ARROW: ArrowSink, PARQUET: ParquetSink}
_ENDINGS = ".parquet, .arrow, .feather, .npy or .csv"


def sink_class(path: str) -> type[Sink]:
    """The kind of file that the ending of a name promises; CSV for a device, a pipe or a descriptor without one.

    Raises:
        BadArgument: another ending, or none, or a place that cannot be written to.
        MissingExtra: pyarrow is needed and not installed.
    """
    ending = Path(path).suffix.lower()
    kind = kind_of(path) if ending not in (".tsv", ".txt", ".gz") else None
    if kind is None:
        if ending or atomic.replaced_file(path) is not None:
            raise BadArgument(f"cannot write {abbreviated(path)}: the ending names the format; expected {_ENDINGS}")
        kind = CSV
    if kind in (PARQUET, ARROW):
        need_extra(f"writing {abbreviated(path)}", "arrow")
    return _SINKS[kind]


def _append(parts: Iterable[Path], file: BinaryIO) -> None:
    for path in parts:
        with path.open("rb") as part:
            shutil.copyfileobj(part, file, _COPIED_AT_ONCE)


def _batches(parts: Iterable[Path]) -> Iterator[Any]:
    """The record batches of streams that stand one behind the other."""
    import pyarrow as pa

    for path in parts:
        size = path.stat().st_size
        with pa.OSFile(str(path)) as part:
            while part.tell() < size:
                with pa.ipc.open_stream(part) as stream:
                    yield from stream
