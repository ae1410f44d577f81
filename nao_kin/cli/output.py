"""The output of commands: tables for people, JSON for programs, and notes as lines on standard error."""

from __future__ import annotations

import csv
import io
import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from nao_kin._core.files import leads_to_standard_output, replaced_file, write_bytes
from nao_kin._core.text import abbreviated
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadArgument

_COLUMN_FILES = (".csv", ".npz", ".parquet", ".arrow", ".feather")


def print_note(*messages: str) -> None:
    """Print each message as one line on standard error, by a single write, because another thread may print too."""
    for message in messages:
        print(f"nao-kin: {' '.join(message.split())}\n", end="", file=sys.stderr)


def print_json(document: Any) -> None:
    """Print one JSON document on standard output; NaN is not allowed."""
    print(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))


def print_json_list(head: dict[str, Any], name: str, items: Iterable[Any]) -> None:
    """Print one JSON document whose last member is a long list, item by item."""
    opening = json.dumps(head, indent=2, ensure_ascii=False)[: -len("\n}")]
    print(f'{opening},\n  "{name}": [', end="")
    for index, item in enumerate(items):
        print(",\n    " if index else "\n    ", json.dumps(item, ensure_ascii=False, allow_nan=False), sep="", end="")
    print("\n  ]\n}")


def csv_text(names: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return CSV of rows under a header: numbers with all their digits, true and false, and nothing for None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([str(cell).lower() if isinstance(cell, bool) else cell for cell in row] for row in rows)
    return text.getvalue()


def column_writer(path: str) -> Callable[[Mapping[str, Any]], None]:
    """Return what writes named columns of equal length, of numbers, texts or booleans, to a file by its suffix.

    CSV has an empty cell for NaN. Other suffixes are refused before anything is computed.
    """
    ending = Path(path).suffix.lower()
    if ending not in _COLUMN_FILES and (ending or replaced_file(path) is not None):
        endings = ", ".join(_COLUMN_FILES)
        raise BadArgument(f"cannot write {abbreviated(path)}: the ending names the format; expected one of {endings}")
    if ending in (".parquet", ".arrow", ".feather"):
        need_extra(f"writing {abbreviated(path)}", "arrow")

    def write(columns: Mapping[str, Any]) -> None:
        content = io.BytesIO()
        if ending == ".npz":
            np.savez_compressed(content, **columns)  # none of them is pickled: they hold numbers and text
        elif ending in _COLUMN_FILES[2:]:
            import pyarrow as pa
            from pyarrow import feather, parquet

            table = pa.table({name: pa.array(values) for name, values in columns.items()})
            (parquet.write_table if ending == ".parquet" else feather.write_feather)(table, content)
        else:
            rows = zip(*(values.tolist() for values in columns.values()), strict=True)
            filled = ([None if cell != cell else cell for cell in row] for row in rows)
            content.write(csv_text(tuple(columns), filled).encode())
        write_bytes(path, content.getvalue())

    return write


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: Sequence[str] = ()) -> None:
    """Print a table without truncation; columns named in `numbers` are aligned right."""
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for column in columns:
        # Text objects, so that names from foreign files are not read as markup.
        table.add_column(Text(column), justify="right" if column in numbers else "left", no_wrap=True)
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console = Console(file=sys.stdout, highlight=False)
    console.width = console.measure(table, options=console.options.update(max_width=10_000)).maximum
    console.print(table)


def print_written(*paths: str | Path) -> None:
    """Print the names of written files; not of standard output, because nothing may follow the file there."""
    for path in paths:
        if not leads_to_standard_output(path):
            print(path)


def fixed(value: float) -> str:
    """Return a number with five decimals; adding zero removes the sign of a negative zero."""
    return f"{round(value, 5) + 0.0:.5f}"


def units(deg: bool) -> dict[str, str]:
    """Return the units of lengths and angles in a JSON document."""
    return {"length": "m", "angle": "deg" if deg else "rad"}


def degrees_per(unit: str, deg: bool) -> float:
    """Return the factor of values of this unit in the output: with --deg, radians become degrees."""
    return math.degrees(1.0) if deg and unit == "rad" else 1.0


@contextmanager
def progress(what: str, *, shown: bool = True) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar on standard error if that is a terminal; yield a function of the numbers done and in all."""
    from rich.progress import Progress

    errors = Console(file=sys.stderr)
    with Progress(console=errors, disable=not (shown and errors.is_terminal), transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
