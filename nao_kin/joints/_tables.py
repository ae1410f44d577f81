"""Rows of words as a table: aligned text for a terminal, escaped HTML for a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def text_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Columns aligned to their widest cell, two spaces between them, a rule under the head."""
    lines = [list(head), *(list(row) for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(head))]
    lines.insert(1, ["─" * width for width in widths])
    return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in lines)


def html_table(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """An HTML table; every word is escaped."""
    return "".join(
        [
            f"<table><caption>{escape(caption)}</caption><thead>",
            _html_row("th", head),
            "</thead><tbody>",
            *(_html_row("td", row) for row in rows),
            "</tbody></table>",
        ]
    )


def _html_row(tag: str, cells: Iterable[str]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"
