"""Text for people: values in messages, tables, and names that are not taken."""

from __future__ import annotations

import itertools
import re
import reprlib
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from html import escape
from typing import Any, TypeVar

import numpy as np

_Class = TypeVar("_Class", bound=type)

# Longest text of a value that is a part of a message.
MAX_SHOWN = 40
# No message shows more characters of a value.
MAX_ECHOED = 200

# A word of a message, such as the path of a file, and a whole message are not longer.
_MAX_WORD, _MAX_LINE = 2 * MAX_ECHOED, 2000
_LONG_WORD = re.compile(rf"\S{{{_MAX_WORD + 1},}}")


def nearest_names(name: str, valid: Iterable[str], count: int = 3, similar: float = 0.5) -> tuple[str, ...]:
    """Return the valid names that begin with `name`, then the most similar ones, best first, in any letter case.

    `similar` is the least ratio of equal letters, from 0 to 1. Three letters are a beginning.

    Examples:
        >>> nearest_names("lhnd", ["LHand", "RHand", "LLeg"])
        ('LHand', 'RHand')
    """
    import difflib  # imported late, as other modules that few calls need: together they take 25 ms

    name = name[:MAX_ECHOED]
    by_lower: dict[str, list[str]] = {}
    for candidate in valid:
        by_lower.setdefault(candidate.lower(), []).append(candidate)
    begun = sorted((lower for lower in by_lower if name[2:] and lower.startswith(name.lower())), key=len)
    close = difflib.get_close_matches(name.lower(), list(by_lower), n=count, cutoff=similar)
    return tuple(candidate for lower in dict.fromkeys([*begun, *close]) for candidate in by_lower[lower])[:count]


def abbreviated(value: object, max_length: int = MAX_ECHOED) -> str:
    """Return `str(value)` on one line of at most `max_length` characters, shortened with … at the end."""
    text = str(value)
    text = " ".join(text[: 4 * max_length].split()) + ("…" if len(text) > 4 * max_length else "")
    return text if len(text) <= max_length else f"{text[: max_length - 1]}…"


def one_line(message: str) -> str:
    """Return a message on one line without control characters, with long words and a long middle replaced by …."""
    line = _LONG_WORD.sub(lambda word: f"{word.group()[: _MAX_WORD - 1]}…", " ".join(message.split()))
    if len(line) > _MAX_LINE:
        line = f"{line[: 3 * _MAX_LINE // 4]} … {line[-_MAX_LINE // 4 :]}"
    return line if line.isprintable() else "".join(c if c.isprintable() else repr(c)[1:-1] for c in line)


def quoted(value: object, max_length: int = MAX_ECHOED) -> str:
    """Return `repr(value)`, abbreviated; only the beginning of a long text is used."""
    return abbreviated(repr(value[: 4 * max_length] if isinstance(value, (str, bytes)) else value), max_length)


class _Short(reprlib.Repr):
    """`repr` of values, shortened: arrays of more than six numbers are represented by their shapes."""

    def __init__(self) -> None:
        super().__init__()
        self.maxother = self.maxstring = MAX_SHOWN

    def repr_ndarray(self, array: Any, level: int) -> str:
        """Return a vector of at most six numbers, or the shape."""
        if array.ndim < 2 and array.size <= 6:
            return np.array2string(array, separator=", ", precision=6, suppress_small=True, max_line_width=MAX_ECHOED)
        return f"<array of shape {array.shape}>"

    def repr_mappingproxy(self, mapping: Any, level: int) -> str:
        """Return the first items, as of a dictionary."""
        return self.repr_dict(dict(mapping), level)

    def repr_instance(self, value: Any, level: int) -> str:
        """Return the name of a part that has fields of its own."""
        return f"{type(value).__name__}(…)" if is_dataclass(value) else super().repr_instance(value, level)


_SHORT = _Short()


def one_line_repr(kind: _Class) -> _Class:
    """Give a data class a `repr` of one line, with its public fields shortened; a class decorator."""

    def text(self: Any) -> str:
        names = [field.name for field in fields(self) if field.repr and not field.name.startswith("_")]
        values = (f"{name}={_SHORT.repr(getattr(self, name))}" for name in names)
        return abbreviated(f"{type(self).__name__}({', '.join(values)})", 2 * MAX_ECHOED)

    kind.__repr__ = text  # type: ignore[assignment,method-assign]
    return kind


def listed(names: Sequence[str], most: int = 8) -> str:
    """Return the first of some names, and how many follow.

    Examples:
        >>> listed(["HeadYaw", "HeadPitch", "LHand"], most=2)
        'HeadYaw, HeadPitch and 1 more'
    """
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def text_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table with columns aligned to their widest cell, two spaces between them, a rule under the head."""
    lines = [list(head), *(list(row) for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(head))]
    lines.insert(1, ["─" * width for width in widths])
    return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in lines)


def html_table(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return an HTML table; every text is escaped."""
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


# --- Names that are not taken.


def fresh_name(name: str, taken: Container[str], *endings: str) -> str:
    """Return the name with the first ending that makes it free, else with the last one numbered from 2 on."""
    return next(name + ending for ending in _endless(endings or ("",)) if name + ending not in taken)


def with_underscores(name: str, taken: Container[str]) -> str:
    """Return the name with enough underscores at its end to differ from the names taken."""
    while name in taken:
        name += "_"
    return name


def _endless(endings: tuple[str, ...]) -> Iterator[str]:
    return itertools.chain(endings, (f"{endings[-1]}_{n}" for n in itertools.count(2)))


def two_numbers(text: str) -> tuple[int, int] | None:
    """Return two whole numbers such as 640x480; None for another text."""
    found = re.fullmatch(r"(\d{1,7})\s*[xX×*,]\s*(\d{1,7})", text)
    return None if found is None else (int(found[1]), int(found[2]))
