"""Tables of points: CSV with a column for each coordinate, rows of numbers alone, CSV of Motive, and TRC.

Sources: docs.optitrack.com, Data Export: CSV; opensimconfluence.atlassian.net, Marker (.trc) Files.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.csv_numbers import CsvHead, TableColumns, read_csv
from nao_kin._core.files import MAX_NUMBERS
from nao_kin._core.text import MAX_SHOWN, abbreviated, quoted
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.imitation.layouts import Layout, by_joint, check_names, key_of, side_and_word
from nao_kin.imitation.reading import BY_SOURCE, Options, person_among, skeleton_of
from nao_kin.imitation.skeleton import UNITS, Points, Skeleton

# A column of a coordinate or a confidence: SpineBase_X, left_wrist.y, left_wrist_visibility; or z11, v_11.
_CONFIDENCE = ("trackingstate", "visibility", "confidence", "inferred", "state", "score", "conf", "v")
_NUMBERED = re.compile(rf"(?P<what>[xyz]|{'|'.join(_CONFIDENCE)})[\s_.:-]*(?P<joint>\d+)", re.IGNORECASE)
_SIGNS = " \t_.:-"
# Words around the name of a joint.
_AROUND = re.compile(r"K4ABT_JOINT_|JointType_|landmark|[\s_.:-]position", re.IGNORECASE)
# Words for numbers: states of Kinect, and whether a joint is inferred.
_STATES = {"nottracked": "0", "inferred": "1", "tracked": "2", "false": "0", "true": "1"}
_STATE_CELL = re.compile(rf"(?<=[,;\t])\s*({'|'.join(_STATES)})\s*(?=[,;\t\r\n]|$)", re.IGNORECASE)
# A frame of CAD-60 and CAD-120: its number; nine entries of an orientation, a confidence, x, y, z and a confidence of
# eleven joints; x, y, z and a confidence of four joints.
_CAD = (*(1 + 14 * k + 10 for k in range(11)), *(1 + 14 * 11 + 4 * k for k in range(4)))
_CAD_WIDTH = 1 + 14 * 11 + 4 * 4
# Fewer columns with numbers for headings may be anything.
_FEWEST = 45
# Numbers of frames ascend by at most this.
_FRAMES = 10.0
# Words of the names of markers, and of units.
_MARKERS = {"sho", "elb", "wra", "asi", "kne"}
_UNIT_WORDS = {"meters": "m", "centimeters": "cm", "millimeters": "mm", "inches": "inch", **{u: u for u in UNITS}}


def of_table(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton in a table: with headings, or of numbers alone."""
    above = len(text) - len(text.lstrip())
    head, _, rest = text[above:].partition("\n")
    head = _with_coordinates(head)
    if all(finite_decimal(field) is not None for field in re.split(r"[,;\s]+", head.strip(" ,;"))):
        return _of_numbers(name, text, options)
    rest = _STATE_CELL.sub(lambda match: _STATES[match[1].lower()], rest)
    return _of_csv(name, f"{text[:above]}{head}\n{rest}".encode(), options)


def _with_coordinates(head: str) -> str:
    """Return headings with x0, y0, z0, v0, x1 … in place of the numbers 0, 1, 2 … of a table that pandas wrote."""
    fields = [field.strip() for field in head.split(",")]
    numbers = [int(field) for field in fields if field.isdecimal()]
    if len(numbers) < _FEWEST or numbers != [*range(numbers[0], numbers[0] + len(numbers))]:
        return head
    each = 3 + (len(numbers) % 4 == 0)
    places = ((field, int(field) - numbers[0]) if field.isdecimal() else (field, None) for field in fields)
    return ",".join(field if k is None else f"{'xyzv'[k % each]}{k // each}" for field, k in places)


# --- A column for each coordinate.


def _column(heading: str) -> tuple[str, str]:
    """Return joint and "x", "y", "z", "v" or "inferred" of a heading, or two empty texts."""
    match = _NUMBERED.fullmatch(heading)
    if match is not None:
        joint, what = match["joint"], match["what"].lower()
    else:
        what = next((end for end in (*_CONFIDENCE, *"xyz") if heading.lower().endswith(end)), "")
        joint = heading[: len(heading) - len(what)].rstrip(_SIGNS)
        if not what or not joint:
            return "", ""
    return _AROUND.sub("", joint), what if what in (*"xyz", "inferred") else "v"


def _of_csv(name: str, data: bytes, options: Options) -> Skeleton:
    """Return the skeleton in a table with a column for each coordinate of each joint."""

    def units_of(_: str, heading: str, __: int) -> Sequence[str]:
        return ("", *UNITS) if _column(heading)[0] else ()

    def understood(head: CsvHead) -> TableColumns:
        def error(reason: str, place: int) -> BadInputFile:
            return BadInputFile(name, reason, head.line, place + 1)

        table, _ = TableColumns.of(head.fields, (), units_of, error)
        known = {_column(heading) for heading in table.names}
        if not any({(joint, "y"), (joint, "z")} <= known for joint, what in known if what == "x"):
            flat = any((joint, "y") in known for joint, what in known if what == "x")
            reason = "only x and y: two coordinates give no directions" if flat else "no columns such as left_wrist_x"
            shown = abbreviated(", ".join(field for field in head.fields if field), MAX_SHOWN)
            raise BadInputFile(name, f"{reason}; expected columns x, y and z of each point, got {shown}")
        return replace(table, gaps=True)

    table, rows, _ = read_csv(name, data, understood, "a table of points")
    values, times = table.split(rows)
    if not len(rows):
        raise BadInputFile(name, "a header and no rows")
    columns: dict[str, dict[str, Floats]] = {}
    for heading, column in zip(table.names, values.T, strict=True):
        joint, what = _column(heading)
        columns.setdefault(joint, {})[what] = column
    joints = {joint: np.stack([c["x"], c["y"], c["z"]], 1) for joint, c in columns.items() if {*"xyz"} <= c.keys()}
    units = {unit: None for unit in table.units if unit}
    if len(units) > 1:
        raise BadInputFile(name, f"columns in different units: {', '.join(sorted(units))}")
    confidence = {joint: columns[joint]["v"] for joint in joints if "v" in columns[joint]}
    points = Points(joints, confidence, times=times, time_unit=table.time_unit, units=next(iter(units), None))
    points = _numbered(points, options) or options.named(points)
    inferred = {joint: columns[joint]["inferred"] > 0.0 for joint in joints if "inferred" in columns[joint]}
    sure = {joint: np.where(less, 0.5, 1.0) * points.layout.levels for joint, less in inferred.items()}
    points = replace(points, confidence={**points.confidence, **sure})
    return skeleton_of(name, points, options, advice="a heading such as time [s], or rate= (--rate), says otherwise")


def _numbered(points: Points, options: Options) -> Points | None:
    """Return points with numbers in the order of a source, with a note; None unless there are some.

    The order is that of a source with as many points, or of MediaPipe, counted from 0 or from 1. If the numbers allow
    several, the lengths of bones decide.
    """
    at = {int(key_of(joint)): joint for joint in points.joints if re.fullmatch("[0-9]{1,3}", key_of(joint))}
    if not at or any(key_of(part).isdecimal() for text in (options.names or {}).values() for part in text.split("+")):
        return None
    cases = {}
    numbers = sorted(at)
    orders = ((layout, order) for layout in options.layouts for order in layout.orders)
    for (layout, order), first in product(orders, (0, 1)):
        known = range(first, first + len(order))
        part = layout.name == (options.source or "mediapipe") and {*numbers} <= {*known}
        if part or numbers == [*known]:
            named, sure = (
                {order[k - first]: arrays[joint] for k, joint in at.items() if joint in arrays}
                for arrays in (points.joints, points.confidence)
            )
            check_names(options.names or {}, [*named])
            case = replace(points, joints=named, confidence=sure, layout=replace(layout, stated=options.names))
            cases[f"{layout.name}, counted from {first}"] = case
    advice = f"{BY_SOURCE}, or names= (--names) such as left_shoulder=11"
    return person_among(f"{len(at)} numbered points", cases, options, advice) if cases else None


# --- Numbers without headings.


def _of_numbers(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton in rows of numbers: a frame, or a point, in each.

    Rows that are shorter than a point count frames and points.
    """
    rows, counts = [], set()
    for line, content in enumerate(text.splitlines(), start=1):
        fields = re.split(r"[,;\s]+", content.strip(" \t\r,;"))
        if len(fields) < 3:
            counts.add(fields[0])
            continue
        rows.append(_floats(name, line, fields))
        if len(fields) != len(rows[0]):
            raise BadInputFile(name, f"{len(fields)} numbers, the first row has {len(rows[0])}", line)
    if not rows:
        raise BadInputFile(name, "rows of fewer than 3 numbers; expected x, y, z of points")
    if len(rows) * len(rows[0]) > MAX_NUMBERS:
        raise BadInputFile(name, f"more than {MAX_NUMBERS} numbers")
    if "40" in counts and len(rows) % 40 == 0:  # of MSR Daily Activity: each point, and its place in the image
        rows = rows[::2]
    return of_rows(name, np.array(rows), options)


def _floats(name: str, line: int, cells: Sequence[str]) -> list[float]:
    """Return the numbers of a row, NaN for empty cells."""
    values = [finite_decimal(cell) if cell.strip().lower() not in ("", "nan") else np.nan for cell in cells]
    for at, value in enumerate(values):
        if value is None:
            raise BadInputFile(name, f"{quoted(cells[at], MAX_SHOWN)}, expected a number", line, at + 1)
    return [value for value in values if value is not None]


def of_rows(name: str, table: Floats, options: Options) -> Skeleton:
    """Return the skeleton in a table of numbers, whose width and bones show what its columns are."""
    cases = {
        f"{layout.name}, {how}": points for layout in options.layouts for how, points in _arrangements(table, layout)
    }
    if not cases:
        what = f"{len(table)} rows of {table.shape[1]} numbers without headings: no source has so many points"
        features = "; 263 are features of HumanML3D, whose folder new_joints has the points" * (table.shape[1] == 263)
        raise BadArgument(f"{what}{features}; state {BY_SOURCE}")
    return skeleton_of(name, person_among(f"{table.shape[1]} numbers a row", cases, options), options)


def _arrangements(table: Floats, layout: Layout) -> Iterator[tuple[str, Points]]:
    """Yield how rows may be the points of a layout, and the points, with times or numbers of frames before them."""
    rows, width = table.shape
    if layout.name == "cad60" and width == _CAD_WIDTH:
        yield "orientations and places", _timed(table, np.stack([table[:, at : at + 4] for at in _CAD], axis=1), layout)
    for order in layout.orders:
        count = len(order)
        if width in (3, 4) and rows % count == 0 and layout.rate is not None:
            yield "a row for each point", Points(*by_joint(table.reshape(-1, count, width), layout), layout)
        for each in (3, 4):
            before = width - each * count
            if before in (0, 1):
                array = table[:, before:].reshape(rows, count, each)
                if each == 3 or _are_levels(array[..., 3]):
                    points = _timed(table, array, layout) if before else Points(*by_joint(array, layout), layout)
                    yield f"{each} numbers each", points


def _timed(table: Floats, array: Floats, layout: Layout) -> Points:
    """Return points whose first column is a time or, of whole numbers, counts frames, of which some may be twice."""
    first, steps = table[:, 0], np.diff(table[:, 0], prepend=-np.inf)
    whole = (first == np.rint(first)).all() and (steps >= 0.0).all()
    if layout.rate is None or not whole or first[-1] - first[0] > _FRAMES * len(first):
        return Points(*by_joint(array, layout), layout, first)
    note = f"frames are numbered: {layout.rate:g} per second as of {layout.name}; rate= (--rate) says otherwise"
    kept = steps > 0.0
    return Points(*by_joint(array[kept], layout), layout, first[kept] / layout.rate, "s", notes=(note,))


def _are_levels(values: Floats) -> bool:
    """Return whether numbers may be confidences: between 0 and 1, or 0, 1, 2 and 3."""
    known = values[np.isfinite(values)]
    return bool((known >= 0.0).all() and ((known <= 1.0).all() or np.isin(known, (0.0, 1.0, 2.0, 3.0)).all()))


# --- Wide tables: the names of points above three columns of each.


def of_motive(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton in the CSV of OptiTrack's Motive: the positions of bones, else of markers."""
    rows = _rows(text, ",")
    start = next((k for k, (_, cells) in enumerate(rows) if cells[0].strip().lower() == "frame"), 0)
    if start < 4:
        raise BadInputFile(name, "no row Frame, Time (Seconds) below those of types, names and positions")
    (_, types), (_, names), (_, kinds), (_, axes) = (rows[k] for k in (1, 2, start - 1, start))
    at: dict[str, dict[str, int]] = {}
    for k, (kind, label, what, axis) in enumerate(zip(types, names, kinds, axes, strict=False)):
        if axis.strip().upper() == "X" and what.strip() == "Position":
            at.setdefault(kind.strip(), {})[label.split(":")[-1]] = k
    places = at.get("Bone") or at.get("Marker")
    if not places:
        raise BadInputFile(name, f"no positions of bones or markers of a person; types: {', '.join(at) or 'none'}")
    return _of_wide(name, rows[start + 1 :], places, _after(rows[0][1], "length units"), options)


def of_trc(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton in a TRC file, tab-separated or, as spreadsheets write it, with commas."""
    rows = _rows(text, "\t" if "\t" in text[:200] else ",")
    if len(rows) < 6 or rows[3][1][0].strip().lower() != "frame#":
        raise BadInputFile(name, "no row Frame#, Time and names above the numbers of TRC")
    places = {label.split(":")[-1]: k for k, label in enumerate(rows[3][1]) if k >= 2 and label.strip()}
    stated = [cell for pair in zip(rows[1][1], rows[2][1], strict=False) for cell in pair]
    return _of_wide(name, rows[5:], places, _after(stated, "units"), options)


def _after(cells: Sequence[str], label: str) -> str:
    """Return the cell after a label, in lower case."""
    words = [cell.strip().lower() for cell in (*cells, label, "")]
    return words[words.index(label) + 1]


def _rows(text: str, delimiter: str) -> list[tuple[int, list[str]]]:
    reader = csv.reader(io.StringIO(text), delimiter=delimiter)
    return [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]


def _of_wide(
    name: str, rows: Sequence[tuple[int, list[str]]], places: Mapping[str, int], unit: str, options: Options
) -> Skeleton:
    """Return the skeleton of joint → the first of its three columns, below which times are in the second column."""
    width = max(places.values()) + 3
    table = np.array([_floats(name, line, (cells + [""] * width)[:width]) for line, cells in rows]).reshape(-1, width)
    joints = {joint: table[:, k : k + 3] for joint, k in places.items()}
    return of_recorded(name, joints, table[:, 1], unit, options)


def of_recorded(name: str, joints: Mapping[str, Floats], times: Floats, unit: str, options: Options) -> Skeleton:
    """Return the skeleton of joints or markers of motion capture, at times in seconds."""
    skin = _MARKERS & {side_and_word(joint)[1] for joint in joints}
    notes = ("markers on the skin stand for joints: directions are some degrees off",) if skin else ()
    points = Points(joints, times=times, time_unit="s", units=_UNIT_WORDS.get(unit), notes=notes)
    return skeleton_of(name, options.named(points), options)
