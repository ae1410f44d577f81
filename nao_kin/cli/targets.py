"""Targets of inverse kinematics: numbers on the command line, or files of them.

The count of numbers determines the kind: 3 a position, 4 a quaternion and 9 a rotation matrix, 6 a position with roll,
pitch and yaw, 7 a position with a quaternion, 16 a homogeneous matrix; for both legs twice as many. Quaternions must
have unit length, so that a position with a stray number is not one. In a CSV file the header determines the kind, with
the headings of `nao-kin fk --csv`.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from nao_kin._core.arrays import Floats, finite_decimal, join_poses
from nao_kin._core.csv_numbers import Records, TableColumns, delimiter_of
from nao_kin._core.files import described, is_finite_number, numpy_errors, read_json, read_table_text
from nao_kin._core.text import abbreviated, quoted
from nao_kin.cli.output import print_note
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError
from nao_kin.rotations import matrix_from_quat, matrix_from_rpy

Kind = Literal["place", "rotation", "pose"]

_SEPARATORS = str.maketrans(",()[]", "     ")

_TURN = 2.0 * math.pi
# Count of numbers → kind of target, and conversion of rows.
_READ: dict[int, tuple[Kind, Callable[[Floats], Floats]]] = {
    3: ("place", lambda rows: rows),
    4: ("rotation", matrix_from_quat),
    9: ("rotation", lambda rows: rows.reshape(-1, 3, 3)),
    6: ("pose", lambda rows: join_poses(matrix_from_rpy(rows[:, 3:]), rows[:, :3])),
    7: ("pose", lambda rows: join_poses(matrix_from_quat(rows[:, 3:]), rows[:, :3])),
    16: ("pose", lambda rows: rows.reshape(-1, 4, 4)),
}
# The kinds with a quaternion, which is last.
_WITH_QUATERNION = {4: "an orientation as a quaternion", 7: "a position with a quaternion"}
# Largest difference of a quaternion's length from 1, as of numbers with three decimals.
_UNIT = 1e-3
# Part of a message that is redundant for a single target.
_ONLY = " at index [0]"
_EXPECTED = "3 numbers for a position, 4 or 9 for an orientation, 6, 7 or 16 for a pose"


class _BadTarget(BadArgument):
    """A target, by its row in the numbers, that cannot be used."""

    def __init__(self, message: str, row: int) -> None:
        self.index = (row,)
        super().__init__(message)


@dataclass(frozen=True, eq=False)
class Targets:
    """Targets of one kind."""

    kind: Kind
    values: Floats  # positions (n, 3), rotations (n, 3, 3) or poses (n, 4, 4); for both legs (n, 2, 4, 4)
    many: bool  # whether they come from a list


def target_of(text: str, *, feet: bool, degrees: bool) -> Targets:
    """Return the target of --target; for `feet` two poses, the left one first; roll, pitch and yaw in `degrees`."""
    numbers = numbers_of(text, "--target")
    try:
        kind, values = _values(np.array([numbers]), feet, degrees)
    except NaoKinError as error:
        raise BadArgument(f"--target {quoted(text)}: {str(error).replace(_ONLY, '')}") from None
    return Targets(kind, values, False)


def numbers_of(text: str, option: str, count: int | None = None) -> list[float]:
    """Return the finite numbers of an option, as many as `count` if it is given.

    They are separated by blanks or commas, and may be in brackets, as Python and NumPy print them.
    """
    words = text.translate(_SEPARATORS).split()
    numbers = []
    for word in words:
        number = finite_decimal(word)
        if number is None:
            raise BadArgument(f"{option} {quoted(text)}: {quoted(word)} is not a finite number")
        numbers.append(number)
    if count not in (None, len(numbers)):
        raise BadArgument(f"{option} {quoted(text)}: {len(numbers)} numbers, expected {count}")
    return numbers


def csv_records(name: str, text: str) -> tuple[int, list[str], Iterator[tuple[int, list[str]]]]:
    """Return a CSV header's line number and headings, and line number and fields of each record; all are as long."""
    records = iter(Records(text.encode(), delimiter_of(text.lstrip("\r\n").split("\n", 1)[0])))
    line, header, wrong = next(records, (1, list[str](), ""))
    if wrong:
        raise BadInputFile(name, wrong, line)

    def rows() -> Iterator[tuple[int, list[str]]]:
        for line, fields, wrong in records:
            if wrong or len(fields) != len(header):
                raise BadInputFile(name, wrong or f"{len(fields)} values, the header names {len(header)}", line)
            yield line, fields

    return line, [field.strip() for field in header], rows()


def read_targets(path: str, frames: Sequence[str], *, degrees: bool, roots: Sequence[str] = ()) -> Targets:
    """Return the targets in a CSV, JSON or .npy file, "-" for standard input, for one frame or both feet.

    Rows of other frames are skipped. Headings that end in _deg also mean degrees. A JSON reference must be one of
    `roots`.
    """
    if not path:
        raise BadArgument("no file name; expected a CSV, JSON or .npy file, or - for standard input")
    if Path(path).suffix.lower() == ".npy":
        return _from_npy(path, len(frames) == 2, degrees)
    text, is_json = read_table_text(path, "targets")
    if is_json:
        return _from_json(path, text, frames, degrees, roots)
    return _from_csv(path, text, frames, degrees)


def _values(rows: Floats, feet: bool, degrees: bool) -> tuple[Kind, Floats]:
    """Return the kind of rows of numbers (n, k), and their values."""
    n, count = rows.shape
    if feet:
        if count not in (12, 14, 32):
            raise BadArgument(f"{count} numbers; expected 12, 14 or 32 for the poses of both feet, the left one first")
        _, poses = _values(rows.reshape(2 * n, count // 2), False, degrees)
        return "pose", poses.reshape(n, 2, 4, 4)
    if count not in _READ:
        raise BadArgument(f"{count} numbers; expected {_EXPECTED}")
    if count == 6:
        worst = float(np.abs(rows[:, 3:]).max(initial=0.0))
        if not degrees and worst > _TURN:
            print_note(f"an angle of {worst:.6g} rad is more than a full turn; --deg takes degrees")
        rows = np.hstack([rows[:, :3], np.radians(rows[:, 3:]) if degrees else rows[:, 3:]])
    if count in _WITH_QUATERNION:
        lengths = np.linalg.norm(rows[:, -4:], axis=1)
        off = np.flatnonzero(~(np.abs(lengths - 1.0) <= _UNIT))
        if off.size:
            what = f"{count} numbers are {_WITH_QUATERNION[count]}, whose length must be 1, not {lengths[off[0]]:.6g}"
            raise _BadTarget(f"{what}; expected {_EXPECTED}", int(off[0]))
    kind, read = _READ[count]
    return kind, read(rows)


def _named(name: str, rows: Floats, feet: bool, degrees: bool, lines: Sequence[int]) -> Targets:
    """Return the targets of a file; an error names the line if there is one."""
    try:
        kind, values = _values(rows, feet, degrees)
    except NaoKinError as error:
        at = getattr(error, "index", ())
        row = at[0] // (2 if feet else 1) if at else 0
        raise BadInputFile(name, str(error), lines[row] if row < len(lines) else 0) from None
    return Targets(kind, values, True)


def _from_npy(name: str, feet: bool, degrees: bool) -> Targets:
    try:
        with numpy_errors(name, "not a .npy file"):
            array = np.load(name, allow_pickle=False)
    except OSError as error:
        raise BadInputFile(name, f"cannot be read: {error.strerror or error}") from None
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu" or array.ndim == 0:
        raise BadInputFile(name, "expected an array of numbers, one target in each row")
    if not len(array):
        raise BadInputFile(name, "the array has no targets")
    rows = np.asarray(array, dtype=np.float64).reshape(len(array), math.prod(array.shape[1:]))
    bad = np.argwhere(~np.isfinite(rows))
    if len(bad):
        raise BadInputFile(name, f"row {bad[0][0]} has a number that is not finite")
    return _named(name, rows, feet, degrees, ())


def _from_csv(name: str, text: str, frames: Sequence[str], degrees: bool) -> Targets:
    from nao_kin.stream import PoseColumns, PoseStyle

    line, names, records = csv_records(name, text)
    places = {column: index for index, column in enumerate(names)}
    poses = [PoseColumns(style, unit).names for style in get_args(PoseStyle) for unit in (False, True)]
    headers = {*poses, ("x", "y", "z"), ("r0", "r1", "r2", "r3")}
    wanted = next((columns for columns in headers if set(columns) == {*places} - {"row", "time", "frame"}), None)
    if wanted is None or len(places) < len(names):
        known = "x,y,z; r0,r1,r2,r3; x,y,z,roll,pitch,yaw; x,y,z,r0,r1,r2,r3; t11,…,t44"
        raise BadInputFile(name, f"the header names {abbreviated(', '.join(names))}; expected one of {known}", line)
    frame_column = places.get("frame")
    table = TableColumns(wanted, (), tuple(places[column] for column in wanted))
    if len(frames) == 2 and frame_column is None:
        raise BadInputFile(name, f"no column frame; for both feet, it must name {' and '.join(frames)}", line)
    found: dict[str, list[list[float]]] = {frame: [] for frame in frames}
    lines: list[int] = []
    for line, fields in records:
        frame = frames[0] if frame_column is None else fields[frame_column].strip()
        if frame in found:
            found[frame].append(table.numbers(name, fields, line))
            if frame == frames[0]:
                lines.append(line)
    for frame, rows in found.items():
        if len(rows) != len(lines) or not rows:
            seen = f"{len(rows)} targets for {frame}" + (f", {len(lines)} for {frames[0]}" if rows else "")
            raise BadInputFile(name, seen if rows else f"no targets for {quoted(frame)}")
    together = np.concatenate([np.array(rows) for rows in found.values()], axis=1)
    return _named(name, together, len(frames) == 2, degrees or wanted[-1].endswith("_deg"), lines)


def _from_json(name: str, text: str, frames: Sequence[str], degrees: bool, roots: Sequence[str]) -> Targets:
    document = read_json(name, text)
    many = True
    if isinstance(document, dict):  # as `nao-kin fk --json` writes it
        units = document.get("units")
        degrees = degrees or (isinstance(units, dict) and units.get("angle") == "deg")
        if document.get("reference", "root") not in ("root", *roots):
            asked = abbreviated(json.dumps(document["reference"], ensure_ascii=False))
            raise BadInputFile(name, f"poses in {asked}; expected them in the torso, as without --reference")
        many = "configurations" in document
        entries = document.get("configurations", [document.get("poses")])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise BadInputFile(name, "expected a list of targets, or what nao-kin fk --json prints")
        for index, entry in enumerate(entries):
            for frame in frames:
                if frame not in entry:
                    raise BadInputFile(name, f"target {index}: no pose of {quoted(frame)}")
        document = [[_flat(name, index, entry[frame]) for frame in frames] for index, entry in enumerate(entries)]
    if not isinstance(document, list) or not document:
        raise BadInputFile(name, "expected a list of targets, each a list of numbers")
    if not any(isinstance(entry, (list, dict)) for entry in document):
        document, many = [document], False
    rows = [_flat(name, index, entry) for index, entry in enumerate(document)]
    if len({len(row) for row in rows}) > 1:
        odd = next(index for index, row in enumerate(rows) if len(row) != len(rows[0]))
        raise BadInputFile(name, f"target {odd} has {len(rows[odd])} numbers, the first {len(rows[0])}")
    targets = _named(name, np.array(rows), len(frames) == 2, degrees, ())
    return Targets(targets.kind, targets.values, many)


def _flat(name: str, index: int, entry: Any) -> list[float]:
    """Return the numbers of nested lists or of an object's values, in order."""
    if isinstance(entry, (list, dict)):
        parts = entry.values() if isinstance(entry, dict) else entry
        return [number for part in parts for number in _flat(name, index, part)]
    if not is_finite_number(entry):
        raise BadInputFile(name, f"target {index}: {described(entry)} is not a finite number")
    return [float(entry)]


def targets_as_csv(names: Sequence[str], rows: Floats) -> str:
    """Return rows of numbers under a header, with all their digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([[repr(float(value)) for value in row] for row in rows])
    return text.getvalue()
