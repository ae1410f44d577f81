"""Printing: tables for people, JSON for programs."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text


def print_json(document: Any) -> None:
    """One JSON document on standard output; NaN has no place in it."""
    print(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: Sequence[str] = ()) -> None:
    """A table on standard output; columns named in `numbers` are aligned right."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        table.add_column(Text(column), justify="right" if column in numbers else "left", no_wrap=column in numbers)
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))  # Text: names from foreign files are not markup
    console().print(table)


def console() -> Console:
    """Standard output; as wide as it needs when it is no terminal, so that nothing is cut in a pipe."""
    return Console(file=sys.stdout, width=None if sys.stdout.isatty() else 400, soft_wrap=False, highlight=False)
