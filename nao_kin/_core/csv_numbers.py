"""Read tables of numbers from CSV: large blocks with pyarrow if it is installed, all others with the csv module.

Both read the same numbers, correctly rounded. If pyarrow rejects a block (a word, a row of another length, an empty
field, NaN), the csv module reads it again, and reports the error.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
import re
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.files import MAX_NUMBERS
from nao_kin._core.headings import (
    LONGEST_HEADING,
    TIME_UNITS,
    IsoTimes,
    in_si_units,
    is_decimal,
    is_index,
    is_iso_time,
    joint_state_columns,
    read_heading,
)
from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin.errors import BadInputFile

DELIMITERS = ",;\t"
# Size of a table, in bytes, from which loading pyarrow pays.
_LARGE = 1 << 20
# Number of bytes that one thread of pyarrow parses at a time.
_PARSED_AT_ONCE = 1 << 20
# Beginnings of comment lines above the header.
_COMMENTS = ("#", "%", "//")
# Number of bytes of the first rows, which show the decimal mark and the form of times.
_SHOWN_ROWS = 1 << 16
_COMMA_FRACTION, _POINT_FRACTION = re.compile(rb"\d,\d"), re.compile(rb"\d\.\d")
# The decimal mark of times may differ from that of numbers.
_SECONDS_FRACTION = re.compile(rb":\d\d[.,]\d+")


def delimiter_of(header: str) -> str:
    """Return the delimiter that occurs most often in a header line; a comma if there is none."""
    return max(DELIMITERS, key=header.count)


@dataclass(frozen=True)
class CsvHead:
    """The beginning of a CSV file."""

    fields: tuple[str, ...]
    line: int  # where the headings end
    delimiter: str
    mark: str  # the decimal mark
    lines: int  # before the first row
    size: int  # bytes before the first row
    first: tuple[str, ...]  # fields of the first row; none if there is no row

    @cached_property
    def read_as(self) -> dict[str, str | None]:
        """Heading → joint, or None to skip it, in a table whose columns do not name the joints but its rows do."""
        return joint_state_columns(self.fields, self.first)


def csv_head(name: str, block: bytes, expected: str, *, at_end: bool = True) -> CsvHead:
    """Return the head of a table: headings follow comment lines, or are the last comment line before numbers.

    A row of numbers and names, as `rostopic echo -p` prints it, follows a comment line with as many headings.
    """
    lines = block.splitlines(keepends=True)
    above, comment, comment_line = 0, "", 0
    for number, content in enumerate(lines, start=1):
        text = content.decode("utf-8", "replace").strip()
        if text and not text.startswith(_COMMENTS):
            break
        above = number
        if text.lstrip("#%/ "):
            comment, comment_line = text.lstrip("#%/ "), number
    size = sum(map(len, lines[:above]))
    delimiter = delimiter_of(lines[above].decode("utf-8", "replace")) if above < len(lines) else ","
    records = iter(Records(block[size:], delimiter, at_end=at_end))
    last, fields, problem = next(records, (0, [], ""))
    line = above + last if last else 0
    if problem:
        raise BadInputFile(name, problem, line)
    if not fields:
        raise BadInputFile(name, f"empty; expected {expected}")
    headings = next(csv.reader([comment], delimiter=delimiter), [])
    numbers = [is_decimal(field) or is_iso_time(field) for field in fields]
    if comment and (all(numbers) or (any(numbers) and len(headings) == len(fields))):
        first, fields, line = fields, headings, comment_line
    else:
        first = next(records, (0, [], ""))[1]
        above += last
        size += sum(map(len, lines[above - last : above]))
    longest = max(map(len, fields))
    if longest > LONGEST_HEADING:
        raise BadInputFile(name, f"a heading of {longest} characters, expected at most {LONGEST_HEADING}", line)
    rows = _SECONDS_FRACTION.sub(b"", block[size : size + _SHOWN_ROWS]) if delimiter != "," else b""
    commas = delimiter != "," and bool(_COMMA_FRACTION.search(rows)) and not _POINT_FRACTION.search(rows)
    return CsvHead(tuple(fields), line, delimiter, "," if commas else ".", above, size, tuple(first))


def quick_numbers(block: bytes, table: TableColumns) -> Floats | None:
    """Return the numbers of whole lines (n, places) by pyarrow; None if the csv module must read them (quotes)."""
    if b'"' in block or not table.places:  # of which pyarrow would return all columns
        return None
    import pyarrow as pa
    from pyarrow import csv as pyarrow_csv

    read = [str(place) for place in table.places]
    types = dict.fromkeys(read, pa.float64())
    if table.iso_times is not None:
        types[read[-1]] = pa.string()
    try:
        columns = pyarrow_csv.read_csv(
            pa.BufferReader(block),
            pyarrow_csv.ReadOptions(column_names=list(map(str, range(table.all))), block_size=_PARSED_AT_ONCE),
            pyarrow_csv.ParseOptions(delimiter=table.delimiter, quote_char=False),
            pyarrow_csv.ConvertOptions(
                column_types=types, include_columns=read, null_values=[], decimal_point=table.mark
            ),
        )
    except pa.ArrowInvalid:
        return None
    if table.fixed and block.count(table.delimiter.join(table.fixed).encode()) != columns.num_rows:
        return None
    numbers = np.empty((columns.num_rows, len(read)))
    for column, values in enumerate(columns.itercolumns()):
        if table.iso_times is not None and column == len(read) - 1:
            numbers[:, column] = table.iso_times.all_seconds(values.to_pylist())
        else:
            numbers[:, column] = values.to_numpy()
    return numbers if np.isfinite(numbers).all() else None


class Records:
    """The records in a block of whole lines, without blank lines, as the csv module reads them in strict mode.

    Yields the number of a record's last line, from 1, its fields, and the error in its quoting, or "". A malformed
    record counts as one line, so that an open quote does not swallow the rest of the file. `consumed` is the number of
    bytes up to the end of the last complete record.
    """

    def __init__(self, block: bytes, delimiter: str, *, at_end: bool = True) -> None:
        """Prepare to read; unless `at_end`, a quote that is still open at the end continues in the next block."""
        self.consumed = len(block)
        self.block, self._delimiter, self._at_end = block, delimiter, at_end

    def __iter__(self) -> Iterator[tuple[int, list[str], str]]:
        lines = list(io.StringIO(self.block.decode("utf-8", "replace"), newline=""))
        done = 0
        while done < len(lines):
            reader = csv.reader(itertools.islice(lines, done, None), delimiter=self._delimiter, strict=True)
            start = done
            try:
                for fields in reader:
                    done = start + reader.line_num
                    if any(fields) and any(field.strip() for field in fields):
                        yield done, fields, ""
            except csv.Error as error:
                if not self._at_end and done > 0 and start + reader.line_num == len(lines):
                    self.consumed = sum(map(len, self.block.splitlines(keepends=True)[:done]))
                    return
                done += 1
                yield done, [], f"malformed CSV: {error}"


def plain_floats(fields: Sequence[str]) -> list[float] | None:
    """Return the numbers of a record of ASCII text without underscores, or None if any of them is not finite."""
    try:
        numbers = list(map(float, fields))
    except ValueError:
        return None
    return numbers if all(map(math.isfinite, numbers)) else None


class SensorColumns(NamedTuple):
    """The columns of one kind of sensors: their headings, indices in the file, and units, "" for any unit."""

    kind: str
    headings: tuple[str, ...]
    places: tuple[int, ...]
    units: tuple[str, ...]


@dataclass(frozen=True)
class TableColumns:
    """The columns to read from a table of joint values, and their meaning."""

    names: tuple[str, ...]
    units: tuple[str, ...]  # "rad", "deg", "m", "1" or "%"
    places: tuple[int, ...]  # index of each column in the file; that of the times, if any, is the last
    timed: bool = False  # whether the last place is the column of times
    time_unit: str | None = None  # None if the file does not state it
    all: int = 0  # number of columns in the file
    iso_times: IsoTimes | None = None  # None if the times are numbers
    assumed: tuple[bool, ...] = ()  # whether the heading of each name gives no unit
    notes: tuple[str, ...] = ()  # on columns that are left out
    sensors: tuple[SensorColumns, ...] = ()  # read if `places` has them, between joints and times
    blanks: bool = False  # whether empty cells are NaN rather than errors
    gaps: bool = False  # whether empty cells of joints and the text NaN are NaN rather than errors
    delimiter: str = ","
    mark: str = "."  # the decimal mark
    fixed: tuple[str, ...] = ()  # fields that are the same in every row
    fixed_from: int = 0  # the column of the first of them

    @classmethod
    def of(
        cls,
        headings: Sequence[str | None],
        joints: Container[str],
        units_of: Callable[[str, str, int], Sequence[str]],
        error: Callable[[str, int], Exception],
        *,
        degrees: bool = False,
        given: Sequence[str] | None = None,
    ) -> tuple[TableColumns, list[int]]:
        """Return the columns to read from a table, and the indices of all columns of times.

        `headings` has None for a column to skip, and `given` are the headings in the file if they differ. `joints` take
        precedence over names of times. `units_of(heading, name, index)` returns the units that a column may have, the
        default first, or nothing to skip it.
        """
        found: dict[str, tuple[str, int, bool]] = {}
        times: dict[int, str | None] = {}
        for place, text in enumerate(headings):
            if text is None or (place == 0 and is_index(text)):
                continue
            heading = read_heading(text)
            name, unit = heading.name, heading.unit
            is_time = heading.is_time and name not in joints
            unit = heading.time_unit if is_time else unit
            units = tuple(TIME_UNITS) if is_time else units_of(text, name, place)
            if name in found:
                both = [(given or headings)[at] for at in (found[name][1], place)]
                names = "" if both[0] == both[1] else f", as {quoted(both[0])} and as {quoted(both[1])}"
                raise error(f"joint {quoted(name)} is given twice{names}", place)
            if units and unit is not None and unit not in units:
                reason = f"unit {quoted(unit, MAX_SHOWN)} of {name}, expected one of {', '.join(units)}"
                raise error(reason, place)
            if is_time:
                times[place] = unit
            elif units:
                usual = "deg" if degrees and "deg" in units else units[0]
                found[name] = usual if unit is None else "deg" if unit == "°" else unit, place, unit is None
        units, own, assumed = zip(*found.values(), strict=True) if found else ((), (), ())
        places = (*own, *list(times)[:1])
        time_unit = next(iter(times.values()), None)
        table = cls(tuple(found), units, places, bool(times), time_unit, len(headings), assumed=assumed)
        return table, list(times)

    @property
    def headings(self) -> tuple[str, ...]:
        """The name of each column to read, for messages."""
        read = self.sensors if len(self.places) > len(self.names) + self.timed else ()
        return (*self.names, *(name for one in read for name in one.headings), *["time"] * self.timed)

    def with_sensors(self) -> TableColumns:
        """Return the columns to read with those of the sensors."""
        count, more = len(self.names), [place for one in self.sensors for place in one.places]
        return replace(self, places=(*self.places[:count], *more, *self.places[count:]))

    def measured(self, rows: Floats) -> dict[str, Floats]:
        """Return the values of each kind of sensors (n, k) in rows (n, places) [rad, rad/s or any unit]."""
        found, at = dict[str, Floats](), len(self.names)
        for one in self.sensors:
            found[one.kind] = in_si_units(rows[:, at : at + len(one.places)], one.units)
            at += len(one.places)
        return found

    @property
    def in_degrees(self) -> bool:
        """Whether any joint is in degrees."""
        return "deg" in self.units

    def split(self, rows: Floats) -> tuple[Floats, Floats | None]:
        """Split rows (n, places) into the values of joints (n, names) and the times (n,), None without times."""
        joints = len(self.names)
        return rows[:, :joints], rows[:, joints] if self.timed else None

    def place(self, line: int, column: int) -> tuple[int, int]:
        """Return line and column, from 1, of a field of a CSV file; both are 0 for JSON values, whose line is 0."""
        return line, self.places[column] + 1 if line and column >= 0 else 0

    def of_csv(self, head: CsvHead, rows: bytes) -> TableColumns:
        """Return the columns with the delimiter, decimal mark and form of times that head and first rows show."""
        table = replace(self, delimiter=head.delimiter, mark=head.mark)
        names = [place for place, field in enumerate(head.fields) if field.startswith("field.name")]
        if head.read_as and names:
            table = replace(table, fixed_from=names[0], fixed=head.first[names[0] : names[-1] + 1])
        if not self.timed:
            return table
        # The first rows show whether times are numbers or ISO 8601 times.
        records = Records(rows[:_SHOWN_ROWS], head.delimiter, at_end=False)
        return table.with_times(fields[self.places[-1]] for _, fields, _ in records if len(fields) > self.places[-1])

    def with_times(self, texts: Iterable[str]) -> TableColumns:
        """Return the columns with times read in the form of the first time in `texts`: a number, or ISO 8601."""
        times = IsoTimes.of(texts)
        return self if times is None else replace(self, time_unit="s", iso_times=times)

    def may_lack(self, at: int) -> bool:
        """Return whether a column, by its index in `places`, may have no value: of a sensor, or with `gaps` a joint."""
        return self.gaps if at < len(self.names) else at < len(self.headings) - self.timed

    def numbers(self, name: str, fields: Sequence[str], line: int) -> list[float]:
        """Return the decimal numbers of one record; raise `BadInputFile` with line and column of the first error."""
        values: list[float] = []
        for at, (place, heading) in enumerate(zip(self.places, self.headings, strict=True)):
            cell = fields[place]
            try:
                is_time = self.timed and place == self.places[-1]
                text = cell.strip()
                if (self.blanks and not text) or (self.may_lack(at) and text.lower() in ("", "nan")):
                    values.append(math.nan)
                elif self.iso_times is not None and is_time:
                    values.append(self.iso_times.seconds(cell))
                else:
                    values.append(_finite(cell, self.mark))
            except ValueError as error:
                raise BadInputFile(name, f"{heading} {error}", line, place + 1) from None
        return values

    def rows(self, name: str, records: Records) -> Iterator[tuple[int, list[float] | None, int, str]]:
        """Yield the line of each record and its numbers, or None with the column and the reason of an error."""
        # In a block like this `float` accepts only decimal digits.
        plain = self.mark == "." and records.block.isascii() and b"_" not in records.block and self.iso_times is None
        for line, fields, reason in records:
            if not reason and len(fields) != self.all:
                what = "joints" if self.all == len(self.units) else "columns"
                reason = f"{len(fields)} values, the header names {self.all} {what}"
            elif not reason and tuple(fields[self.fixed_from :][: len(self.fixed)]) != self.fixed:
                reason = "its joints are not those of the first row, or in another order"
            if reason:
                yield line, None, 0, reason
                continue
            row = plain_floats([fields[place] for place in self.places]) if plain else None
            try:
                yield line, row or self.numbers(name, fields, line), 0, ""
            except BadInputFile as error:
                yield line, None, error.column, error.reason


def _finite(field: str, mark: str) -> float:
    """Return the finite number of a field; raise ValueError with a message that follows the column's name."""
    value = finite_decimal(field if mark == "." else field.replace(mark, ".", "." not in field))
    if value is None:
        raise ValueError(f"is {quoted(field.strip(), MAX_SHOWN)}, expected a finite number")
    return value


def read_csv(
    name: str, data: bytes, understood: Callable[[CsvHead], TableColumns], expected: str
) -> tuple[TableColumns, Floats, Sequence[int]]:
    """Return the columns, the numbers (n, places), and the line of each row of a table; `understood` reads its head."""
    head = csv_head(name, data, expected)
    body = data[head.size :]
    table = understood(head).of_csv(head, body)
    if (line_ends(body) + 1) * len(table.places) > MAX_NUMBERS:
        raise BadInputFile(name, f"more than {MAX_NUMBERS} numbers")
    if len(data) > _LARGE and has_pyarrow():
        numbers = quick_numbers(body, table)
        if numbers is not None and len(numbers):
            return table, numbers, RowLines(body, head.delimiter, head.lines)
    rows, lines = [], []
    for line, row, column, reason in table.rows(name, Records(body, head.delimiter)):
        if row is None:
            raise BadInputFile(name, reason, head.lines + line, column)
        rows.append(row)
        lines.append(head.lines + line)
    return table, np.array(rows, dtype=np.float64).reshape(len(rows), len(table.places)), lines


class RowLines(Sequence[int]):
    """The line of every row of a CSV text that begins after `before` lines, computed on first use."""

    def __init__(self, body: bytes, delimiter: str, before: int) -> None:
        self._body, self._delimiter, self._before = body, delimiter, before

    def __getitem__(self, row: Any) -> Any:
        return self._found[row]

    def __len__(self) -> int:
        return len(self._found)

    @cached_property
    def _found(self) -> list[int]:
        return [self._before + line for line, _, _ in Records(self._body, self._delimiter)]


def whole_lines(block: bytes) -> int:
    """Return the number of bytes of the whole lines at the beginning of a block."""
    end = block.rfind(b"\n") + 1
    # If a block ends with a carriage return, its line feed may be in the next block.
    return end or block.rfind(b"\r", 0, -1) + 1


def line_ends(block: bytes) -> int:
    """Return the number of line ends in a block: line feeds, carriage returns, or both together."""
    return block.count(b"\n") + block.count(b"\r") - block.count(b"\r\n")


def has_pyarrow() -> bool:
    """Return whether pyarrow is installed."""
    from importlib.util import find_spec

    return find_spec("pyarrow") is not None


def float_texts(values: NDArray[Any]) -> Any:
    """Return `str` of numbers (n,), float64 or float32, as a pyarrow array; needs pyarrow.

    pyarrow also writes the fewest digits, but formats whole, large and small numbers differently; Python writes those.
    """
    import pyarrow as pa
    from pyarrow import compute

    texts = compute.cast(pa.array(values), pa.string())
    size = np.abs(values)
    other = ~((size > 1e-4) & (size < 1e2)) | (values == np.rint(values))
    if other.any():
        few = values[other]
        written = map(repr, few.tolist()) if few.dtype == np.float64 else map(str, few)
        texts = compute.replace_with_mask(texts, pa.array(other), pa.array(list(written), pa.string()))
    return texts
