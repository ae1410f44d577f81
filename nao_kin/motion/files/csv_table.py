"""CSV: a header with units, a column of times, a column for each joint; an empty cell is no key.

The delimiter is a comma, a semicolon or a tab; straight lines lie between the keys. Headings, comment lines above them,
decimal commas, and dates and times of ISO 8601 are read as those of logs are.

    time [s], HeadYaw [deg], LHand [%]
    0.0, 0, 40
    0.5, 30,
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.csv_numbers import CsvHead, csv_head, iso_times, plain_floats
from nao_kin._common.headings import (
    JOINT_UNITS,
    TIME_UNITS,
    IsoTimes,
    in_si_units,
    is_index,
    read_heading,
    seconds,
    time_unit_of,
)
from nao_kin._common.scalars import decimal
from nao_kin._text import quoted
from nao_kin.errors import BadArgument
from nao_kin.motion.files.format import Format
from nao_kin.motion.files.source import MOST_SHOWN, Place, Source
from nao_kin.motion.files.tables import is_hand, sampled, warn_of_curves
from nao_kin.motion.files.tracks import Track, check_times, motion_of
from nao_kin.motion.motion import Motion


class _Column(NamedTuple):
    """A column that is read: the joint or the times, their unit ("" where that of times is not said), and where."""

    name: str
    unit: str
    place: int
    is_time: bool
    heading: str


def recognises(source: Source) -> bool:
    """Whether the header names a time column."""
    return any(read_heading(field).is_time for field in _head(source).fields)


def _head(source: Source) -> CsvHead:
    return csv_head(source.text.encode("utf-8", "replace"))


def read(source: Source) -> Motion:
    """The motion in a CSV file.

    Raises:
        BadInputFile: with line and column.
    """
    head = _head(source)
    if head.problem:
        raise source.error(f"malformed CSV: {head.problem}", Place(head.line))
    if not head.fields:
        raise source.error("empty; expected a header with a time column")
    columns, other = _columns(source, head)
    rows, lines = [], []
    body = source.text.encode("utf-8", "replace")[head.size :]
    rest = body.decode()
    time = next(index for index, column in enumerate(columns) if column.is_time)
    times = iso_times(body, head.delimiter, columns[time].place)
    if times is not None:
        columns[time] = columns[time]._replace(unit="s")
    reader = csv.reader(io.StringIO(rest, newline=""), delimiter=head.delimiter, strict=True)
    # Then `float` reads only decimal digits.
    plain = rest.isascii() and "_" not in rest and times is None
    try:
        for fields in reader:
            if not any(fields) or not any(field.strip() for field in fields):
                continue
            line = head.lines + reader.line_num
            if len(fields) != len(head.fields):
                raise source.error(f"{len(fields)} values, the header names {len(head.fields)} columns", Place(line))
            fields = [fields[column.place] for column in columns]
            if head.mark != ".":
                fields = [field.replace(head.mark, ".") for field in fields]
            row = plain_floats(fields) if plain else None
            rows.append(row or _cells(source, fields, columns, line, times))
            lines.append(line)
    except csv.Error as error:
        raise source.error(f"malformed CSV: {error}", Place(head.lines + reader.line_num)) from None
    if not rows:
        raise source.error("a header and no keys", Place(head.line))
    tracks = [
        Track(column.name, np.zeros(0), np.zeros(0), place=Place(head.line, column.place + 1)) for column in other
    ]
    tracks += _tracks(source, columns, np.array(rows), lines, head.line)
    return motion_of(source, tracks, negative=True)


def _tracks(source: Source, columns: list[_Column], table: Floats, lines: list[int], header_at: int) -> list[Track]:
    time = next(index for index, column in enumerate(columns) if column.is_time)
    times, at = table[:, time], columns[time].place + 1
    if np.isnan(times).any():
        raise source.error("a row without a time", Place(lines[int(np.argmax(np.isnan(times)))], at))
    times = seconds(times, columns[time].unit or time_unit_of(times))
    check_times(source, times, lambda row: Place(lines[row], at), negative=True)
    tracks = []
    for column, values in zip(columns, in_si_units(table, [column.unit for column in columns]).T, strict=True):
        if not column.is_time:
            rows = np.flatnonzero(~np.isnan(values))
            # All joints that have a key in every row share one array.
            own = times if len(rows) == len(times) else times[rows]
            tracks.append(Track(column.name, own, values[rows], place=Place(header_at, column.place + 1)))
    return tracks


def _cells(source: Source, fields: list[str], columns: list[_Column], line: int, times: IsoTimes | None) -> list[float]:
    """The numbers of a row, NaN where a cell is empty."""
    values = []
    for column, field in zip(columns, fields, strict=True):
        if times is not None and column.is_time and field.strip():
            try:
                values.append(times.seconds(field))
            except ValueError as error:
                at = Place(line, column.place + 1)
                raise source.error(f"{column.heading[:MOST_SHOWN]} {error}", at) from None
            continue
        try:
            value = decimal(field) if field.strip() else math.nan
        except ValueError:
            value = math.inf
        if math.isinf(value):
            shown = quoted(field.strip(), MOST_SHOWN)
            raise source.error(
                f"{column.heading[:MOST_SHOWN]} is {shown}, expected a finite number", Place(line, column.place + 1)
            )
        values.append(value)
    return values


def _columns(source: Source, head: CsvHead) -> tuple[list[_Column], list[_Column]]:
    """The columns that are read, times and joints each once, and those that are left out."""
    found, other = list[_Column](), list[_Column]()
    for place, field in enumerate(head.fields):
        if place == 0 and is_index(field):
            continue
        heading, at = read_heading(field), Place(head.line, place + 1)
        name, unit = heading.name, heading.unit
        if heading.is_time:
            units: Iterable[str] = TIME_UNITS
        else:
            source.check_joint(name, at)
            if name not in source.joints:
                other.append(_Column(name, "", place, False, ""))
                continue
            if name in (column.name for column in found):
                raise source.error(f"joint {name} is given twice", at)
            units = JOINT_UNITS["1"] if is_hand(name) else (*JOINT_UNITS["rad"], *JOINT_UNITS["m"])
            usual = "1" if is_hand(name) else "deg" if source.degrees else "rad"
            unit = usual if unit is None else unit
        if unit is not None and unit not in units:
            raise source.error(f"unit {quoted(unit, MOST_SHOWN)} of {name}, expected one of {', '.join(units)}", at)
        found.append(_Column(name, unit or "", place, heading.is_time, field.strip()))
    times = sum(column.is_time for column in found)
    if times != 1:
        raise source.error(f"{times} columns of times, expected one, headed time [s] or time [ms]", Place(head.line))
    return found, other


def write(motion: Motion, rate: float | None) -> bytes:
    """A CSV file: seconds and radians, hands as ratios; a cell is empty where a joint has no key.

    Raises:
        BadArgument: a name that a header cannot hold.
    """
    if rate is None:
        warn_of_curves(motion, "CSV")
        times = motion.key_times
        table = np.full((len(times), len(motion.keys)), math.nan)
        for column, (own, keys) in enumerate(zip(motion.times, motion.keys, strict=True)):
            table[np.searchsorted(times, own), column] = keys
    else:
        times, table = sampled(motion, rate, "CSV")
    for joint in motion.joint_names:
        if not re.fullmatch(r"[^\[\](),;\t\r\n\"]*", joint) or joint != joint.strip() or read_heading(joint).is_time:
            raise BadArgument(f"a CSV header cannot hold the joint {quoted(joint)}")
    header = ["time [s]", *(f"{joint} [{'1' if is_hand(joint) else 'rad'}]" for joint in motion.joint_names)]
    lines = [",".join(header)]
    for time, row in zip(times.tolist(), table.tolist(), strict=True):
        lines.append(",".join([repr(time), *("" if value != value else repr(value) for value in row)]))
    return ("\n".join(lines) + "\n").encode()


CSV = Format("csv", (".csv", ".tsv", ".txt"), "a table with units in its header", recognises, read, write)
