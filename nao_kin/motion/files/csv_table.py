"""CSV: a header with units, a column of times, a column for each joint; an empty cell is no key.

The delimiter is a comma, a semicolon or a tab; straight lines lie between the keys.

    time [s], HeadYaw [deg], LHand [%]
    0.0, 0, 40
    0.5, 30,
"""

from __future__ import annotations

import csv
import io
import math
import re

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.csv_numbers import delimiter_of, plain_floats
from nao_kin._common.scalars import decimal
from nao_kin._text import quoted
from nao_kin.errors import BadArgument
from nao_kin.motion.files.format import Format
from nao_kin.motion.files.source import MOST_SHOWN, Place, Source
from nao_kin.motion.files.tables import is_hand, sampled, warn_of_curves
from nao_kin.motion.files.tracks import Track, check_times, motion_of
from nao_kin.motion.motion import Motion

_HEADING = re.compile(r"(?P<name>[^\[\]()]*?)\s*(?:[\[(]\s*(?P<unit>[^\[\]()]*?)\s*[\])])?")
_TIME_NAMES = ("time", "t")
_TIME_UNITS = {"s": 1.0, "ms": 1e-3}
_HAND_UNITS = {"1": 1.0, "%": 0.01}
_DEGREES = math.pi / 180.0
_UNITS = {"rad": 1.0, "deg": _DEGREES, "°": _DEGREES, "m": 1.0}


def recognises(source: Source) -> bool:
    """Whether the first line that is not blank names a time column."""
    header = next((line for line in source.lines if line.strip()), "")
    headings = map(_HEADING.fullmatch, map(str.strip, header.split(delimiter_of(header))))
    return any(match is not None and match["name"].lower() in _TIME_NAMES for match in headings)


def read(source: Source) -> Motion:
    """The motion in a CSV file.

    Raises:
        BadInputFile: with line and column.
    """
    text = source.text
    header_line = text.lstrip("\r\n").split("\n", 1)[0]
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter_of(header_line), strict=True)
    # Then `float` reads only decimal digits.
    plain = text.isascii() and "_" not in text
    header: list[str] = []
    rows, lines, header_at = [], [], 0
    try:
        for fields in reader:
            if not any(fields) or not any(field.strip() for field in fields):
                continue
            if not header:
                header, header_at = fields, reader.line_num
                names, scales, time = _headings(source, header, header_at)
                other = {column for column, name in enumerate(names) if column != time and name not in source.joints}
                continue
            if len(fields) != len(header):
                raise source.error(
                    f"{len(fields)} values, the header names {len(header)} columns", Place(reader.line_num)
                )
            if other:
                fields = ["" if column in other else field for column, field in enumerate(fields)]
            row = plain_floats(fields) if plain else None
            rows.append(row or _cells(source, fields, header, reader.line_num))
            lines.append(reader.line_num)
    except csv.Error as error:
        raise source.error(f"malformed CSV: {error}", Place(reader.line_num)) from None
    if not header:
        raise source.error("empty; expected a header with a time column")
    if not rows:
        raise source.error("a header and no keys", Place(header_at))
    return _motion(source, names, np.array(rows) * scales, time, lines, header_at)


def _motion(source: Source, names: list[str], table: Floats, time: int, lines: list[int], header_at: int) -> Motion:
    times = table[:, time]
    if np.isnan(times).any():
        raise source.error("a row without a time", Place(lines[int(np.argmax(np.isnan(times)))], time + 1))
    check_times(source, times, lambda row: Place(lines[row], time + 1), negative=True)
    tracks = []
    for column, joint in enumerate(names):
        if column != time:
            rows = np.flatnonzero(~np.isnan(table[:, column]))
            # All joints that have a key in every row share one array.
            own = times if len(rows) == len(times) else times[rows]
            tracks.append(Track(joint, own, table[rows, column], place=Place(header_at, column + 1)))
    return motion_of(source, tracks, negative=True)


def _cells(source: Source, fields: list[str], header: list[str], line: int) -> list[float]:
    """The numbers of a row, NaN where a cell is empty."""
    values = []
    for column, (heading, field) in enumerate(zip(header, fields, strict=True), start=1):
        try:
            value = decimal(field) if field.strip() else math.nan
        except ValueError:
            value = math.inf
        if math.isinf(value):
            shown = quoted(field.strip(), MOST_SHOWN)
            raise source.error(
                f"{heading.strip()[:MOST_SHOWN]} is {shown}, expected a finite number", Place(line, column)
            )
        values.append(value)
    return values


def _headings(source: Source, header: list[str], line: int) -> tuple[list[str], Floats, int]:
    """Names and scales of the columns, and which one is time."""
    names, scales, times = [], [], []
    for column, heading in enumerate(header):
        place = Place(line, column + 1)
        match = _HEADING.fullmatch(heading.strip())
        if match is None:
            raise source.error(f"heading {quoted(heading.strip(), MOST_SHOWN)}, expected a name and [unit]", place)
        name, unit = match["name"], match["unit"]
        if name.lower() in _TIME_NAMES:
            units, usual = _TIME_UNITS, "s"
            times.append(column)
        else:
            source.check_joint(name, place)
            if name in names:
                raise source.error(f"joint {name} is given twice", place)
            units, usual = (_HAND_UNITS, "1") if is_hand(name) else (_UNITS, "deg" if source.degrees else "rad")
            unit = unit if name in source.joints else None
        if unit is not None and unit not in units:
            raise source.error(f"unit {quoted(unit, MOST_SHOWN)} of {name}, expected one of {', '.join(units)}", place)
        names.append(name)
        scales.append(units[usual if unit is None else unit])
    if len(times) != 1:
        raise source.error(f"{len(times)} columns of times, expected one, headed time [s] or time [ms]", Place(line))
    return names, np.array(scales), times[0]


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
        if not re.fullmatch(r"[^\[\](),;\t\r\n\"]*", joint) or joint != joint.strip() or joint.lower() in _TIME_NAMES:
            raise BadArgument(f"a CSV header cannot hold the joint {quoted(joint)}")
    header = ["time [s]", *(f"{joint} [{'1' if is_hand(joint) else 'rad'}]" for joint in motion.joint_names)]
    lines = [",".join(header)]
    for time, row in zip(times.tolist(), table.tolist(), strict=True):
        lines.append(",".join([repr(time), *("" if value != value else repr(value) for value in row)]))
    return ("\n".join(lines) + "\n").encode()


FORMAT = Format("csv", (".csv", ".tsv", ".txt"), "a table with units in its header", recognises, read, write)
