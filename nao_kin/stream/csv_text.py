"""Poses as lines of CSV: row, frame, and the numbers with as many digits as give them back."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.csv_numbers import float_texts, has_pyarrow

# Loading pyarrow takes as long as Python takes to write this many numbers.
_FEW = 20_000


def csv_header(columns: Sequence[str]) -> str:
    """The first line.

    Examples:
        >>> nk.stream.csv_header(["x", "y", "z"]).strip()
        'row,frame,x,y,z'
    """
    return ",".join(("row", "frame", *columns)) + "\n"


def pose_lines(rows: NDArray[np.int64], frames: Sequence[str], numbers: NDArray[Any]) -> bytes:
    """One line for each of `rows` (n,) and each frame, of numbers (n, frames, k), in UTF-8.

    The lines are the same whether pyarrow writes them, or Python, which takes longer.

    Examples:
        >>> nk.stream.pose_lines(np.array([0]), ["LArm"], np.array([[[0.5, 0.25]]])).decode().strip()
        '0,LArm,0.5,0.25'
    """
    names = [_field(name) for name in frames]
    flat = numbers.reshape(-1, numbers.shape[-1])
    if numbers.size > _FEW and has_pyarrow():
        return _by_pyarrow(np.repeat(rows, len(names)), names * len(rows), flat)
    texts = (map(repr, row) for row in flat.tolist()) if flat.dtype == np.float64 else (map(str, row) for row in flat)
    heads = (f"{row},{name}," for row in rows.tolist() for name in names)
    return "".join([f"{head}{','.join(text)}\n" for head, text in zip(heads, texts, strict=True)]).encode()


def _by_pyarrow(rows: NDArray[np.int64], frames: list[str], numbers: NDArray[Any]) -> bytes:
    import pyarrow as pa
    from pyarrow import compute

    columns = [float_texts(np.ascontiguousarray(column)) for column in numbers.T]
    row_texts = compute.cast(pa.array(rows), pa.string())
    # The last field is empty and its delimiter the end of the line.
    lines = compute.binary_join_element_wise(row_texts, pa.array(frames, pa.string()), *columns, ",")
    lines = compute.binary_join_element_wise(lines, "", "\n")
    # The texts of an array stand one behind the other.
    offsets = np.frombuffer(lines.buffers()[1], np.int32)
    return memoryview(lines.buffers()[2])[offsets[lines.offset] : offsets[lines.offset + len(lines)]].tobytes()


def _field(name: str) -> str:
    """A name as a field of CSV, quoted where it must be."""
    text = io.StringIO()
    csv.writer(text, lineterminator="").writerow([name])
    return text.getvalue()
