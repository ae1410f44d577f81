"""Output files: columns of poses, lines of CSV, and parts that are joined to one file."""

from __future__ import annotations

import csv
import io
import shutil
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, get_args

import numpy as np
from numpy.typing import DTypeLike, NDArray

from nao_kin._core import files as atomic
from nao_kin._core.arrays import CROSSOVER, Floats, choice
from nao_kin._core.csv_numbers import float_texts, has_pyarrow
from nao_kin._core.text import abbreviated
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadArgument
from nao_kin.robot import PoseForm, RobotModel
from nao_kin.stream.sources import ARROW_ENDINGS, PARQUET_ENDINGS

# --- The numbers of a pose and their names, the same on the screen and in every file format.

_POSITION = ("x", "y", "z")
_MATRIX = tuple(f"t{row}{column}" for row in range(1, 5) for column in range(1, 5))
_ORIENTATION: dict[str, tuple[str, ...]] = {
    "quaternion": ("r0", "r1", "r2", "r3"),
    "rpy": ("roll", "pitch", "yaw"),
}


# Python writes this many numbers in the time that loading pyarrow takes.
_FEW = 20_000
# Up to this many rows, Pinocchio computes small pieces, without loading the batch kernels.
_FEW_ROWS = 10_000


@dataclass(frozen=True)
class PoseColumns:
    """The form of a pose as a row of numbers.

    "matrix" is the 16 entries of the homogeneous matrix, row by row, t11 … t44; "quaternion" is x, y, z and the unit
    quaternion r0, r1, r2, r3, scalar first; "rpy" is x, y, z, roll, pitch, yaw with R = Rz(yaw) Ry(pitch) Rx(roll).
    Names of angles in `degrees` end in _deg.
    """

    style: PoseForm = "matrix"
    degrees: bool = False

    def __post_init__(self) -> None:
        choice(self.style, get_args(PoseForm), "form of a pose")

    @property
    def orientation(self) -> tuple[str, ...]:
        """Names of the numbers after the position; none for a matrix."""
        suffix = "_deg" if self.degrees and self.style == "rpy" else ""
        return tuple(name + suffix for name in _ORIENTATION.get(self.style, ()))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers of a pose."""
        return _MATRIX if self.style == "matrix" else (*_POSITION, *self.orientation)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one pose in an array."""
        return (4, 4) if self.style == "matrix" else (len(self.names),)

    def poses(
        self,
        robot: RobotModel,
        q: Floats,
        frames: Sequence[str],
        reference: str | None = None,
        dtype: DTypeLike = np.float64,
        threads: int | None = None,
    ) -> NDArray[Any]:
        """Return poses (n, frames, k) as numbers; the arguments are those of `RobotModel.fk`."""
        # Pinocchio computes batches below the crossover.
        step = len(q) if threads is not None or len(q) > _FEW_ROWS else CROSSOVER - 1
        starts = range(0, len(q), max(step, 1))
        parts = [
            robot.fk(q[start : start + step], frames, reference=reference, as_=self.style, dtype=dtype, threads=threads)
            for start in starts
        ]
        numbers = parts[0] if len(parts) == 1 else np.concatenate(parts)
        if self.degrees and self.style == "rpy":
            numbers[..., 3:] = np.degrees(numbers[..., 3:])
        return numbers.reshape(*numbers.shape[:2], len(self.names))

    def csv_header(self, *, timed: bool) -> str:
        """Return the first line of CSV, with a time column if `timed`."""
        return ",".join(("row", *(("time",) if timed else ()), "frame", *self.names)) + "\n"

    @staticmethod
    def csv_lines(
        rows: NDArray[np.int64], frames: Sequence[str], numbers: NDArray[Any], times: Floats | None = None
    ) -> bytes:
        """Return lines of CSV in UTF-8: for each of `rows` (n,) and each frame, numbers (n, frames, k) and times (n,).

        The numbers have all their digits.
        """
        names = [_field(name) for name in frames]
        flat = numbers.reshape(-1, numbers.shape[-1])
        if numbers.size > _FEW and has_pyarrow():
            return _by_pyarrow(rows, times, names, flat)
        single = flat.dtype != np.float64
        written = (map(str, row) for row in flat) if single else (map(repr, row) for row in flat.tolist())
        starts = [str(row) for row in rows.tolist()]
        if times is not None:
            starts = [f"{row},{time!r}" for row, time in zip(starts, times.tolist(), strict=True)]
        heads = (f"{start},{name}," for start in starts for name in names)
        return "".join([f"{head}{','.join(text)}\n" for head, text in zip(heads, written, strict=True)]).encode()


def _by_pyarrow(rows: NDArray[np.int64], times: Floats | None, frames: list[str], numbers: NDArray[Any]) -> bytes:
    import pyarrow as pa
    from pyarrow import compute

    columns = [float_texts(np.ascontiguousarray(column)) for column in numbers.T]
    starts = [compute.cast(pa.array(rows), pa.string())]
    if times is not None:
        starts.append(float_texts(np.ascontiguousarray(times)))
    places = pa.array(np.repeat(np.arange(len(rows)), len(frames)))
    starts = [start.take(places) for start in starts]
    # The last field is empty, and its delimiter is the end of the line.
    lines = compute.binary_join_element_wise(*starts, pa.array(frames * len(rows), pa.string()), *columns, ",")
    lines = compute.binary_join_element_wise(lines, "", "\n")
    # The texts of an array are contiguous.
    offsets = np.frombuffer(lines.buffers()[1], np.int32)
    return memoryview(lines.buffers()[2])[offsets[lines.offset] : offsets[lines.offset + len(lines)]].tobytes()


def _field(name: str) -> str:
    """Return a name as a field of CSV, quoted if necessary."""
    text = io.StringIO()
    csv.writer(text, lineterminator="").writerow([name])
    return text.getvalue()


# --- Formats of output files: parts are written in turn and then joined to one file.

_COPY_BYTES = 1 << 22
# Rows of a group of a Parquet file: large for fast reading, small enough for memory.
_ROWS_OF_GROUP = 1 << 17


@dataclass(frozen=True)
class Sink(ABC):
    """A format of output files."""

    frames: tuple[str, ...]
    columns: PoseColumns
    shape: tuple[int, ...]  # of the numbers of one row
    dtype: np.dtype[Any]
    timed: bool = False  # the rows have times

    @abstractmethod
    def write(self, file: BinaryIO, rows: NDArray[np.int64], numbers: NDArray[Any], times: Floats | None) -> None:
        """Append poses (n, frames, k) of `rows` (n,), perhaps with times (n,), to a part."""

    @abstractmethod
    def join(self, parts: Iterable[Path], file: BinaryIO, rows: int) -> None:
        """Write the whole file from its parts with `rows` rows in total."""


class CsvSink(Sink):
    """CSV: one line for each row and frame."""

    def write(self, file: BinaryIO, rows: NDArray[np.int64], numbers: NDArray[Any], times: Floats | None) -> None:
        """As `Sink`."""
        file.write(self.columns.csv_lines(rows, self.frames, numbers, times))

    def join(self, parts: Iterable[Path], file: BinaryIO, rows: int) -> None:
        """As `Sink`."""
        file.write(self.columns.csv_header(timed=self.timed).encode())
        _append(parts, file)


class NpySink(Sink):
    """A NumPy array of shape (rows, *shape), which has no times."""

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
        """Append poses; a part is a sequence of streams of one batch."""
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
        numbers = [(name, number) for name in self.columns.names]
        return pa.schema([("row", pa.int64()), *time, ("frame", frame), *numbers])

    def _batch(self, rows: NDArray[np.int64], numbers: NDArray[Any], times: Floats | None) -> Any:
        import pyarrow as pa

        places = np.tile(np.arange(len(self.frames), dtype=np.int32), len(rows))
        frame = pa.DictionaryArray.from_arrays(places, pa.array(self.frames, pa.string()))
        columns = [np.ascontiguousarray(column) for column in numbers.reshape(-1, len(self.columns.names)).T]
        heads = [pa.array(np.repeat(of_rows, len(self.frames))) for of_rows in (rows, times) if of_rows is not None]
        return pa.record_batch([*heads, frame, *columns], schema=self._schema())


class ParquetSink(ArrowSink):
    """A Parquet file: one record for each row and frame."""

    def join(self, parts: Iterable[Path], file: BinaryIO, rows: int) -> None:
        """Write the file; all groups have the same length, independent of the parts."""
        import pyarrow as pa
        from pyarrow import parquet

        # The numbers do not repeat, so a dictionary is useless.
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


_SINKS: dict[str, type[Sink]] = {
    ".csv": CsvSink,
    ".npy": NpySink,
    **dict.fromkeys(ARROW_ENDINGS, ArrowSink),
    **dict.fromkeys(PARQUET_ENDINGS, ParquetSink),
}
_ENDINGS = ".parquet, .arrow, .feather, .npy or .csv"


def sink_class(path: str) -> type[Sink]:
    """Return the format for the suffix of a name; CSV for a device, a pipe or a descriptor without suffix."""
    ending = Path(path).suffix.lower()
    kind = _SINKS.get(ending)
    if kind is None:
        if ending or atomic.replaced_file(path) is not None:
            raise BadArgument(f"cannot write {abbreviated(path)}: the ending names the format; expected {_ENDINGS}")
        return CsvSink
    if issubclass(kind, ArrowSink):
        need_extra(f"writing {abbreviated(path)}", "arrow")
    return kind


def _append(parts: Iterable[Path], file: BinaryIO) -> None:
    for path in parts:
        with path.open("rb") as part:
            shutil.copyfileobj(part, file, _COPY_BYTES)


def _batches(parts: Iterable[Path]) -> Iterator[Any]:
    """Yield the record batches of the streams in the parts."""
    import pyarrow as pa

    for path in parts:
        size = path.stat().st_size
        with pa.OSFile(str(path)) as part:
            while part.tell() < size:
                with pa.ipc.open_stream(part) as stream:
                    yield from stream
