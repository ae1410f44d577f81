"""Poses as lines of CSV: row, time, frame, and the numbers with as many digits as give them back."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.choices import flag, texts
from nao_kin._common.csv_numbers import float_texts, has_pyarrow
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, WrongShape

# Loading pyarrow takes as long as Python takes to write this many numbers.
_FEW = 20_000


def csv_header(columns: Sequence[str], *, timed: bool = False) -> str:
    """The first line; `timed` where the rows have times.

    Raises:
        BadArgument: no list of texts, or neither True nor False.

    Examples:
        >>> nk.stream.csv_header(["x", "y", "z"]).strip()
        'row,frame,x,y,z'
    """
    return ",".join(("row", *(("time",) if flag(timed, "timed") else ()), "frame", *texts(columns, "columns"))) + "\n"


def pose_lines(
    rows: NDArray[np.int64], frames: Sequence[str], numbers: NDArray[Any], times: Floats | None = None
) -> bytes:
    """One line for each of `rows` (n,) and each frame, of numbers (n, frames, k) and maybe times (n,), in UTF-8.

    The lines are the same whether pyarrow writes them, or Python, which takes longer.

    Raises:
        BadArgument: no arrays of numbers, or no list of texts.
        WrongShape: rows, frames, numbers and times do not fit together.

    Examples:
        >>> nk.stream.pose_lines(np.array([0]), ["LArm"], np.array([[[0.5, 0.25]]])).decode().strip()
        '0,LArm,0.5,0.25'
    """
    names = [_field(name) for name in texts(frames, "frames")]
    for what, array, kinds in (("rows", rows, "iu"), ("numbers", numbers, "f"), ("times", times, "f")):
        if not (isinstance(array, np.ndarray) and array.dtype.kind in kinds) and (what != "times" or times is not None):
            raise BadArgument(f"{what} must be an array of {'whole ' * (kinds == 'iu')}numbers, got {quoted(array)}")
    if rows.ndim != 1 or numbers.ndim != 3 or numbers.shape[:2] != (len(rows), len(names)):
        raise WrongShape("numbers", f"(n, {len(names)}, k) for rows (n,)", numbers.shape)
    if times is not None and times.shape != rows.shape:
        raise WrongShape("times", str(rows.shape), times.shape)
    flat = numbers.reshape(-1, numbers.shape[-1])
    if numbers.size > _FEW and has_pyarrow():
        return _by_pyarrow(rows, times, names, flat)
    written = (map(repr, row) for row in flat.tolist()) if flat.dtype == np.float64 else (map(str, row) for row in flat)
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
    # The last field is empty and its delimiter the end of the line.
    lines = compute.binary_join_element_wise(*starts, pa.array(frames * len(rows), pa.string()), *columns, ",")
    lines = compute.binary_join_element_wise(lines, "", "\n")
    # The texts of an array stand one behind the other.
    offsets = np.frombuffer(lines.buffers()[1], np.int32)
    return memoryview(lines.buffers()[2])[offsets[lines.offset] : offsets[lines.offset + len(lines)]].tobytes()


def _field(name: str) -> str:
    """A name as a field of CSV, quoted where it must be."""
    text = io.StringIO()
    csv.writer(text, lineterminator="").writerow([name])
    return text.getvalue()
