"""Printing: tables for people, JSON for programs, and what is not the result as lines on standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text


def print_note(message: str) -> None:
    """One line on standard error, whatever line breaks the message holds."""
    print(f"nao-kin: {' '.join(message.split())}", file=sys.stderr)


def print_json(document: Any) -> None:
    """One JSON document on standard output; NaN has no place in it."""
    print(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))


def print_json_list(head: dict[str, Any], name: str, items: Iterable[Any]) -> None:
    """One JSON document whose last member is a long list, written item by item."""
    opening = json.dumps(head, indent=2, ensure_ascii=False)[: -len("\n}")]
    print(f'{opening},\n  "{name}": [', end="")
    for index, item in enumerate(items):
        print(",\n    " if index else "\n    ", json.dumps(item, ensure_ascii=False, allow_nan=False), sep="", end="")
    print("\n  ]\n}")


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: Sequence[str] = ()) -> None:
    """A table on standard output; columns named in `numbers` are aligned right.

    Nothing is ever cut: where the terminal is narrower than the table, it breaks the lines itself.
    """
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for column in columns:
        # Text: names from foreign files are not markup.
        table.add_column(Text(column), justify="right" if column in numbers else "left", no_wrap=True)
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console = Console(file=sys.stdout, highlight=False)
    console.width = console.measure(table, options=console.options.update(max_width=10_000)).maximum
    console.print(table)


def without_sign_of_zero(value: float, digits: int) -> float:
    """`value` rounded for printing; adding zero takes the sign off a negative zero."""
    return round(value, digits) + 0.0
