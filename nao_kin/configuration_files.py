"""Configurations from CSV and JSON files.

A file names every joint once, in any order: the robot's own joints, or beside them joints that follow another one, as
NAOqi's 26 Body names do. CSV has the names in its header and one configuration a line, separated by commas, semicolons
or tabs. JSON holds one object name → value, or a list of such objects.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.csv_numbers import Records, delimiter_of, has_pyarrow, plain_floats, quick_numbers
from nao_kin._common.input_text import read_text
from nao_kin._common.scalars import decimal
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument, BadInputFile, CouplingViolated, OutsideLimits, nearest_names
from nao_kin.robot import LimitPolicy, RobotModel

# Characters of a name or a value in a message; the line holds more than it.
_MOST_SHOWN = 40
# Characters of a CSV file for which loading pyarrow pays.
_LARGE = 1 << 20

__all__ = ["check_joint_names", "finite_numbers", "read_configurations"]


def read_configurations(
    robot: RobotModel, path: Path | str, *, limits: LimitPolicy = "raise", degrees: bool = False
) -> tuple[Floats, bool]:
    """The configurations in a file.

    Args:
        robot: whose joints the file names.
        path: a CSV or JSON file, or "-" for standard input.
        limits: what to do with joints outside their limits: "raise", "clamp" or "ignore".
        degrees: turning joints are given in degrees.

    Returns:
        q, shape (n, nq), and whether the file holds a list: False for one JSON object.

    Raises:
        BadArgument: no file name.
        BadInputFile: with line and column where there is one to blame: unreadable, empty, malformed, a joint unknown,
            missing or named twice, a value that is no finite number, two joints of one motor that disagree, a joint
            outside its limits.

    Examples:
        >>> import json
        >>> from pathlib import Path
        >>> nao = nk.load_nao()
        >>> _ = Path("pose.json").write_text(json.dumps(nao.angles(nao.posture("Stand"))))
        >>> q, many = nk.configuration_files.read_configurations(nao, "pose.json")
        >>> q.shape, many
        ((1, 25), False)
    """
    name = str(path)
    if not name:
        raise BadArgument("no file name; expected a CSV or JSON file, or - for standard input")
    text = _read(name)
    if not text or text.isspace():
        raise BadInputFile(name, "empty; expected joint names and values")
    many = True
    rows: list[list[float]] | Floats
    lines: Sequence[int]
    if Path(name).suffix.lower() == ".json" or (name == "-" and text.lstrip()[0] in "[{"):
        names, rows, lines, many = _from_json(name, text, robot)
    else:
        names, rows, lines = _from_csv(name, text, robot)
    values = np.asarray(rows, dtype=np.float64).reshape(len(rows), len(names))
    if degrees:
        values = np.where([robot.unit(joint) == "rad" for joint in names], np.radians(values), values)
    try:
        return robot.configuration(dict(zip(names, values.T, strict=True)), limits=limits), many
    except CouplingViolated as error:
        column = names.index(error.mimic)
        row = int(np.argmax(values[:, column] == error.mimic_value))
        reason = error.describe(degrees=degrees and robot.unit(error.mimic) == robot.unit(error.primary) == "rad")
        raise BadInputFile(name, reason, *_place(lines[row], column)) from None
    except OutsideLimits as error:
        first = error.violations[0]
        more = f" (and {error.count - 1} more)" if error.count > 1 else ""
        reason = f"outside the joint limits: {first.describe(degrees=degrees, index=False)}{more}"
        row = first.index[0]
        if not lines[row] and many:
            reason = f"configuration {row}: {reason}"
        # A joint that the file names only through one that follows it has no column of its own.
        column = names.index(first.joint) if first.joint in names else -1
        raise BadInputFile(name, reason, *_place(lines[row], column)) from None


def check_joint_names(name: str, names: Sequence[str], robot: RobotModel, line: int = 0, where: str = "") -> None:
    """Refuse names that do not name every joint of a robot once.

    Args:
        name: the file, for the message.
        names: what it names.
        robot: whose joints they should be; one that follows another may stand for it or beside it.
        line: where they stand in a CSV file, 0 elsewhere.
        where: what the message begins with.

    Raises:
        BadInputFile: an unknown joint, one named twice, or joints missing.

    Examples:
        >>> nk.configuration_files.check_joint_names("walk.csv", ["HeadYaw"], nk.load_nao(), line=1)
        Traceback (most recent call last):
            ...
        nao_kin.errors.BadInputFile: walk.csv, line 1: missing joints: HeadPitch, ...
    """
    known = {*robot.joint_names, *robot.mimics}
    for column, joint in enumerate(names, start=1):
        if joint not in known:
            near = ", ".join(nearest_names(joint, [*robot.joint_names, *robot.mimics]))
            advice = f"nearest: {near}" if near else f"expected the robot's {len(robot.joint_names)} joints"
            what = f"unknown joint {quoted(joint, _MOST_SHOWN)} ({advice})" if joint else "a column without a name"
            raise BadInputFile(name, where + what, line, column if line else 0)
        if joint in names[: column - 1]:
            raise BadInputFile(name, f"{where}joint {quoted(joint)} is given twice", line, column if line else 0)
    missing = [joint for joint in robot.joint_names if joint not in _determined(robot, names)]
    if missing:
        shown = ", ".join(missing[:5]) + (f" and {len(missing) - 5} more" if len(missing) > 5 else "")
        raise BadInputFile(name, f"{where}missing joints: {shown}", line)


def finite_numbers(name: str, fields: Sequence[str], names: Sequence[str], line: int) -> list[float]:
    """The numbers that the fields of one CSV record write in decimal digits.

    Raises:
        BadInputFile: with line and column of the first that is no finite number.

    Examples:
        >>> nk.configuration_files.finite_numbers("walk.csv", ["0.1", "-2e-3"], ["HeadYaw", "HeadPitch"], line=2)
        [0.1, -0.002]
    """
    values = []
    for column, (joint, field) in enumerate(zip(names, fields, strict=True), start=1):
        try:
            value = decimal(field)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise BadInputFile(
                name, f"{joint} is {quoted(field.strip(), _MOST_SHOWN)}, expected a finite number", line, column
            )
        values.append(value)
    return values


def _place(line: int, column: int) -> tuple[int, int]:
    """1-based line and column of a CSV field; JSON values have neither (line 0)."""
    return line, column + 1 if line else 0


def _read(name: str) -> str:
    large = Path(name).suffix.lower() in (".npy", ".parquet", ".arrow", ".feather")
    advice = "; such a file is read with an output, as in -o poses.npy, or by nao_kin.stream" if large else ""
    return read_text(name, advice)


def _from_csv(name: str, text: str, robot: RobotModel) -> tuple[list[str], list[list[float]] | Floats, Sequence[int]]:
    header_line = text.lstrip("\r\n").split("\n", 1)[0]
    delimiter = delimiter_of(header_line)
    file = io.StringIO(text, newline="")
    reader = csv.reader(file, delimiter=delimiter, strict=True)
    # Then `float` reads only decimal digits.
    plain = text.isascii() and "_" not in text
    rows, lines, names = [], [], list[str]()
    try:
        for fields in reader:
            if not any(fields) or not any(field.strip() for field in fields):
                continue
            if not names:
                names = [field.strip() for field in fields]
                check_joint_names(name, names, robot, reader.line_num)
                if len(text) > _LARGE and has_pyarrow():
                    numbers = quick_numbers(text[file.tell() :].encode(), len(names), delimiter)
                    if numbers is not None and len(numbers):
                        return names, numbers, _Lines(text, delimiter)
                continue
            if len(fields) != len(names):
                reason = f"{len(fields)} values, the header names {len(names)} joints"
                raise BadInputFile(name, reason, line=reader.line_num)
            row = plain_floats(fields) if plain else None
            rows.append(row or finite_numbers(name, fields, names, reader.line_num))
            lines.append(reader.line_num)
    except csv.Error as error:
        raise BadInputFile(name, f"malformed CSV: {error}", line=reader.line_num) from None
    if not rows:
        raise BadInputFile(name, "a header and no configurations")
    return names, rows, lines


class _Lines(Sequence[int]):
    """The line of every row of a CSV text, found when one is asked for."""

    def __init__(self, text: str, delimiter: str) -> None:
        self._text, self._delimiter = text, delimiter

    def __getitem__(self, row: Any) -> Any:
        return self._found[row]

    def __len__(self) -> int:
        return len(self._found)

    @cached_property
    def _found(self) -> list[int]:
        return [line for line, _, _ in Records(self._text.encode(), self._delimiter)][1:]


def _from_json(name: str, text: str, robot: RobotModel) -> tuple[list[str], list[list[float]], list[int], bool]:
    try:
        document = json.loads(text, object_pairs_hook=lambda pairs: _object(name, pairs), parse_constant=_Constant)
    except json.JSONDecodeError as error:
        raise BadInputFile(name, f"malformed JSON: {error.msg}", error.lineno, error.colno) from None
    except (ValueError, RecursionError) as error:  # a number of thousands of digits, lists in lists in lists
        raise BadInputFile(name, f"JSON of too long numbers or too deep lists: {error}") from None
    objects = document if isinstance(document, list) else [document]
    if not objects:
        raise BadInputFile(name, "a list of no configurations")
    names: list[str] = []
    rows = []
    for index, entry in enumerate(objects):
        where = f"configuration {index}: " if isinstance(document, list) else ""
        if not isinstance(entry, dict):
            raise BadInputFile(name, f"{where}expected an object of joint values, got {_kind(entry)}")
        if not names:
            names = list(entry)
            check_joint_names(name, names, robot, 0, where)
        elif entry.keys() != set(names):
            odd = sorted(entry.keys() ^ set(names))
            raise BadInputFile(
                name, f"{where}names other joints than configuration 0: {abbreviated(', '.join(odd[:3]))}"
            )
        for joint, value in entry.items():
            if not _is_finite_number(value):
                raise BadInputFile(name, f"{where}{joint} is {_kind(value)}, expected a finite number")
        rows.append([float(entry[joint]) for joint in names])
    return names, rows, [0] * len(rows), isinstance(document, list)


def _is_finite_number(value: Any) -> bool:
    try:
        return not isinstance(value, bool) and isinstance(value, (int, float)) and math.isfinite(value)
    except OverflowError:
        return False


def _object(name: str, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    seen = dict[str, Any]()
    for key, value in pairs:
        if key in seen:
            raise BadInputFile(name, f"joint {quoted(key)} is given twice in one object")
        seen[key] = value
    return seen


class _Constant(str):
    """NaN, Infinity or -Infinity, which JSON does not know and Python's reader takes; kept to be refused by name."""


def _kind(value: Any) -> str:
    """What stands in a JSON file where a number was expected."""
    if isinstance(value, (dict, list)):
        return "an object" if isinstance(value, dict) else "a list"
    if isinstance(value, _Constant):
        return str(value)
    if isinstance(value, float) and math.isinf(value):
        return "a number too large for floating point"
    return abbreviated(json.dumps(value, ensure_ascii=False), _MOST_SHOWN)


def _determined(robot: RobotModel, names: Iterable[str]) -> set[str]:
    return {robot.mimics[joint].joint if joint in robot.mimics else joint for joint in names}
