"""Tables of points: CSV with a column for each coordinate, and rows of numbers without headings."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.csv_numbers import CsvHead, TableColumns, read_csv
from nao_kin._core.files import MAX_NUMBERS
from nao_kin._core.headings import read_heading
from nao_kin._core.text import MAX_SHOWN, abbreviated, quoted
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.imitation.layouts import LAYOUTS, Layout, by_joint
from nao_kin.imitation.reading import Options, Ordered, of_array, of_named, person_among
from nao_kin.imitation.skeleton import UNITS, Skeleton

# A column of a coordinate or a confidence: SpineBase_X, left_wrist.y, left_wrist_visibility; or z11, v_11.
_CONFIDENCE = ("trackingstate", "visibility", "confidence", "inferred", "state", "score", "conf", "v")
_NUMBERED = re.compile(rf"(?P<what>[xyz]|{'|'.join(_CONFIDENCE)})[\s_.:-]*(?P<joint>\d+)", re.IGNORECASE)
_SIGNS = " \t_.:-"
# Words around the name of a joint.
_AROUND = re.compile(r"K4ABT_JOINT_|JointType_|landmark|[\s_.:-]position", re.IGNORECASE)
# Words for numbers: states of Kinect, and whether a joint is inferred.
_STATES = {"nottracked": "0", "inferred": "1", "tracked": "2", "false": "0", "true": "1"}
_STATE_CELL = re.compile(r"(?<=[,;\t])\s*(" + "|".join(_STATES) + r")\s*(?=[,;\t\r\n]|$)", re.IGNORECASE)
# A frame of CAD-60 and CAD-120: its number; nine entries of an orientation, a confidence, x, y, z and a confidence of
# eleven joints; x, y, z and a confidence of four joints.
_CAD = (*(1 + 14 * k + 10 for k in range(11)), *(1 + 14 * 11 + 4 * k for k in range(4)))
_CAD_WIDTH = 1 + 14 * 11 + 4 * 4
# Fewer columns with numbers for headings may be anything.
_FEWEST = 45
# Numbers of frames ascend by at most this.
_FRAMES = 5.0


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


def of_table(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton in a table: with headings, or of numbers alone."""
    head = next(line for line in text.splitlines() if line.strip())
    fields = re.split(r"[,;\s]+", head.strip().strip(",;"))
    if all(finite_decimal(field) is not None for field in fields):
        return _of_numbers(name, text, options)
    first, _, rest = text.partition("\n")
    rest = _STATE_CELL.sub(lambda match: _STATES[match[1].lower()], rest)
    return _of_csv(name, f"{first}\n{rest}".encode(), options)


def _of_csv(name: str, data: bytes, options: Options) -> Skeleton:
    """Return the skeleton in a table with a column for each coordinate of each joint."""

    def units_of(_: str, heading: str, __: int) -> Sequence[str]:
        return ("", *UNITS) if _column(heading)[0] else ()

    def understood(head: CsvHead) -> TableColumns:
        def error(reason: str, place: int) -> BadInputFile:
            return BadInputFile(name, reason, head.line, place + 1)

        indices = [finite_decimal(field) is not None for field in head.fields]
        if sum(indices) >= _FEWEST:
            whole = [
                field if at or read_heading(field).is_time else None
                for field, at in zip(head.fields, indices, strict=True)
            ]
            return replace(TableColumns.of(whole, (), lambda *_: ("",), error)[0], gaps=True)
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
    advice = "a heading such as time [s], or rate= (--rate), says otherwise"
    if all(finite_decimal(heading) is not None for heading in table.names):
        return of_rows(name, values, options, times, table.time_unit)
    columns: dict[str, dict[str, Floats]] = {}
    for heading, column in zip(table.names, values.T, strict=True):
        joint, what = _column(heading)
        columns.setdefault(joint, {})[what] = column
    joints = {joint: np.stack([c["x"], c["y"], c["z"]], 1) for joint, c in columns.items() if {*"xyz"} <= c.keys()}
    stated = {unit for unit in table.units if unit}
    if len(stated) > 1:
        raise BadInputFile(name, f"columns in different units: {', '.join(sorted(stated))}")
    confidence = {joint: columns[joint]["v"] for joint in joints if "v" in columns[joint]}
    levels = options.layout(list(joints))[0].levels if any("inferred" in c for c in columns.values()) else 1.0
    for joint in joints:
        if "inferred" in columns[joint]:  # as likely as not
            confidence[joint] = np.where(columns[joint]["inferred"] > 0.0, 0.5, 1.0) * levels
    return of_named(
        name,
        joints,
        confidence,
        times,
        table.time_unit,
        options,
        units=next(iter(stated), None),
        advice=advice,
    )


# --- Numbers without headings.


def _of_numbers(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton in rows of numbers: a frame, or a point, in each.

    Rows that are shorter than a point count frames and points.
    """
    rows, counts = [], set()
    for line, content in enumerate(text.splitlines(), start=1):
        fields = re.split(r"[,;\s]+", content.strip().strip(",;"))
        if len(fields) >= 3:
            values = [finite_decimal(field) if field.lower() != "nan" else np.nan for field in fields]
            if None in values:
                at = values.index(None)
                raise BadInputFile(name, f"{quoted(fields[at], MAX_SHOWN)}, expected a number", line)
            rows.append((line, values))
        else:
            counts.add(fields[0])
    widths = [len(values) for _, values in rows]
    odd = next((k for k, width in enumerate(widths) if width != widths[0]), None)
    if odd is not None:
        raise BadInputFile(name, f"{widths[odd]} numbers, the first row has {widths[0]}", rows[odd][0])
    if sum(widths) > MAX_NUMBERS:
        raise BadInputFile(name, f"more than {MAX_NUMBERS} numbers")
    table = np.array([values for _, values in rows], dtype=np.float64)
    if not table.size:
        raise BadInputFile(name, "rows of fewer than 3 numbers; expected x, y, z of points")
    if len(table) > 1 and any((table[0] == np.arange(first, first + table.shape[1])).all() for first in (0, 1)):
        table = table[1:]  # headings, as pandas writes them
    if "40" in counts and len(table) % 40 == 0:  # of MSR Daily Activity: each point, and its place in the image
        table = table[::2]
    return of_rows(name, table, options)


def of_rows(
    name: str, table: Floats, options: Options, times: Floats | None = None, unit: str | None = None
) -> Skeleton:
    """Return the skeleton in a table of numbers, whose width and bones show what its columns are."""
    cases = {
        f"{layout.name}, {how}": (Ordered(layout, *by_joint(array, layout)), array, stamps)
        for layout in LAYOUTS.values()
        if options.source in (None, layout.name)
        for how, array, stamps in _arrangements(table, layout)
    }
    if not cases:
        if table.shape[1] == 263:
            raise BadArgument("263 numbers a row are features of HumanML3D; its folder new_joints has the points")
        counts = sorted({len(order) for layout in LAYOUTS.values() for order in layout.orders})
        what = f"{len(table)} rows of {table.shape[1]} numbers"
        raise BadArgument(
            f"{what} without headings: no source has so many; points of sources: {', '.join(map(str, counts))}"
        )
    what = f"{table.shape[1]} numbers a row"
    chosen, note = person_among(what, {how: case for how, (case, *_) in cases.items()}, "source= (--source)")
    _, array, first = next(case for case in cases.values() if case[0] is chosen)
    notes = [note]
    if times is None and first is not None:
        times, rate = first, chosen.layout.rate
        steps = np.diff(first)
        whole = (first == np.rint(first)).all() and (steps >= 0.0).all()
        if rate is not None and whole and first[-1] - first[0] <= _FRAMES * max(len(first) - 1, 1):
            later = np.diff(first, prepend=-np.inf) > 0.0
            array, times, unit = array[later], first[later] / rate, "s"
            notes.append(
                f"frames are numbered: {rate:g} per second as of {chosen.layout.name}; rate= (--rate) says otherwise"
            )
    options = replace(options, source=chosen.layout.name)
    return of_array(name, array, times, options, unit=unit, notes=notes)


def _arrangements(table: Floats, layout: Layout) -> Iterator[tuple[str, Floats, Floats | None]]:
    """Yield how rows may be the points of a layout, the points (n, k, 3 or 4), and times or frames, None for none."""
    rows, width = table.shape
    if layout.name == "cad60" and width == _CAD_WIDTH:
        yield "orientations and places", np.stack([table[:, at : at + 4] for at in _CAD], axis=1), table[:, 0]
    for order in layout.orders:
        count = len(order)
        if width in (3, 4) and rows % count == 0 and layout.rate is not None:
            yield "a row for each point", table.reshape(-1, count, width), None
        for each in (3, 4):
            before = width - each * count
            if before not in (0, 1):
                continue
            array = table[:, before:].reshape(rows, count, each)
            if each == 3 or _are_levels(array[..., 3]):
                yield f"{each} numbers each", array, table[:, 0] if before else None


def _are_levels(values: Floats) -> bool:
    """Return whether numbers may be confidences: between 0 and 1, or 0, 1, 2 and 3."""
    known = values[np.isfinite(values)]
    return bool((known >= 0.0).all() and ((known <= 1.0).all() or np.isin(known, (0.0, 1.0, 2.0, 3.0)).all()))
