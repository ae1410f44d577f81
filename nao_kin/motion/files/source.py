"""A motion file that is being read: its bytes, text and JSON, the options of the caller, and its errors."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.files import described, is_finite_number, read_json
from nao_kin._core.headings import is_joint_state
from nao_kin._core.text import MAX_SHOWN, abbreviated, listed, nearest_names, quoted
from nao_kin.errors import BadArgument, BadInputFile, NaoKinWarning
from nao_kin.motion.motion import Motion

_PLAIN = re.compile(r"[A-Za-z_]\w{0,39}", re.ASCII)
# The encoding of a Python file, in a comment of its first or second line (PEP 263).
_CODING = re.compile(rb"(?:[^\n]*\n)?[ \t\f]*#[^\n]*?coding[:=][ \t]*([-\w.]+)", re.ASCII)
# Joints of Aldebaran's Pepper that no NAO has.
_PEPPER = ("HipRoll", "HipPitch", "KneePitch", "WheelFL", "WheelFR", "WheelB")


class MotionFileWarning(NaoKinWarning):
    """Part of a motion file is left out or changed in the motion that is read, or part of a motion in its file.

    Examples:
        >>> issubclass(nk.motion.MotionFileWarning, nk.errors.NaoKinWarning)
        True
    """


@dataclass(frozen=True)
class FilePosition:
    """A position in a file."""

    line: int = 0  # from 1; 0 for none
    column: int = 0  # from 1; 0 for none
    where: str = ""  # a prefix of messages, such as "keys[3][2]"

    def entry(self, index: int) -> FilePosition:
        """Return the place of an entry of the list at this place."""
        return FilePosition(self.line, self.column, f"{self.where}[{index}]")

    def field(self, index: int) -> FilePosition:
        """Return the place of a field of the row that begins here."""
        return FilePosition(self.line, self.column + index)


def in_json(*path: str | int) -> FilePosition:
    """Return the place in JSON at the end of a path of names and indices, such as keys[3][2] or motion[0].keyframes."""
    words = ""
    for step in path:
        if isinstance(step, int):
            words += f"[{step}]"
        elif _PLAIN.fullmatch(step):
            words += f".{step}" if words else step
        else:
            words += f"[{quoted(step, MAX_SHOWN)}]"
    return FilePosition(where=words)


# Names and indices that lead to a value in JSON.
JsonPath = list[str | int]
# The place of the entry with an index.
FilePositionOf = Callable[[int], FilePosition]
NOWHERE = FilePosition()


@dataclass(frozen=True)
class MotionSource:
    """A motion file that is being read."""

    name: str  # "-" for standard input
    data: bytes = field(repr=False)
    joints: tuple[str, ...]  # the known joint names
    degrees: bool = False  # turning joints are in degrees if the file does not say so
    timeline: str | None = None  # name or number of one of several motions; None for the only one
    ignore_other: bool = False  # unknown joints are left out

    @cached_property
    def text(self) -> str:
        """The text, without a byte order mark: UTF-8, or in the encoding that a comment declares, as in Python."""
        try:
            return self.data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            declared = _CODING.match(self.data)
            if declared:
                with suppress(UnicodeError, LookupError):
                    return self.data.decode(declared[1].decode("ascii"))
            place = FilePosition(self.data.count(b"\n", 0, error.start) + 1)
            raise self.error(f"not UTF-8 text (byte {error.start})", place) from None

    @cached_property
    def lines(self) -> list[str]:
        """The lines of the text."""
        return self.text.replace("\r\n", "\n").replace("\r", "\n").split("\n")

    @cached_property
    def json(self) -> Any:
        """The text parsed as JSON, which is no motion if it is a ROS message."""
        value = read_json(self.name, self.text)
        if is_joint_state(value):
            raise self.error("a ROS JointState, which is one configuration: nao_kin.stream.read_log reads it")
        return value

    def at(self, *path: str | int) -> Any:
        """Return the value at the end of a path in the JSON text."""
        value = self.json
        for index, step in enumerate(path):
            if isinstance(value, dict) and step not in value:
                raise self.error(f"no {step!r}", in_json(*path[:index]))
            value = value[step]
        return value

    def list_at(self, *path: str | int) -> list[Any]:
        """Return the list at the end of a path in the JSON text."""
        value = self.at(*path)
        if not isinstance(value, list):
            raise self.error(f"expected a list, got {described(value)}", in_json(*path))
        return value

    def objects_at(self, *path: str | int) -> Iterator[tuple[JsonPath, dict[str, Any]]]:
        """Yield the objects of a list in the JSON text, each with its path."""
        for index, value in enumerate(self.list_at(*path)):
            if not isinstance(value, dict):
                raise self.error(f"expected an object, got {described(value)}", in_json(*path, index))
            yield [*path, index], value

    def fields(self, value: Any, names: Sequence[str], what: str, *path: str | int) -> dict[str, Any]:
        """Return a value at a path in the JSON text, which must be an object with only these fields."""
        if not isinstance(value, dict):
            raise self.error(f"expected an object, got {described(value)}", in_json(*path))
        for name in value:
            if name not in names:
                near = ", ".join(nearest_names(name, names)) or ", ".join(names)
                raise self.error(f"unknown {what} (nearest: {near})", in_json(*path, name))
        return value

    def error(self, reason: str, place: FilePosition = NOWHERE) -> BadInputFile:
        """Return the error for a reason and a place."""
        return BadInputFile(self.name, f"{place.where}: {reason}" if place.where else reason, place.line, place.column)

    def floats(self, values: Sequence[Any], what: str, place: FilePositionOf) -> Floats:
        """Return the finite numbers (n,) in values of JSON or Python, which messages call `what`."""
        if set(map(type, values)) <= {int, float}:
            with suppress(OverflowError):
                numbers = np.array(values, dtype=np.float64)
                if np.isfinite(numbers).all():
                    return numbers
        first = next(index for index, value in enumerate(values) if not is_finite_number(value))
        raise self.error(f"{what} is {described(values[first])}, expected a finite number", place(first))

    def decimals(
        self, fields: Sequence[str], names: Sequence[str], place: FilePositionOf, hold: str | None = None
    ) -> list[float]:
        """Return the finite numbers in texts; the text `hold` gives NaN."""
        numbers = []
        for index, (name, text) in enumerate(zip(names, map(str.strip, fields), strict=True)):
            number = math.nan if text == hold else finite_decimal(text)
            if number is None:
                reason = f"{name} is {quoted(text, MAX_SHOWN)}, expected a finite number"
                raise self.error(reason if hold is None else f"{reason} or {hold}", place(index))
            numbers.append(number)
        return numbers

    def floats_at(self, what: str, *path: str | int) -> Floats:
        """Return the numbers of a list in the JSON text, which messages call `what`."""
        return self.floats(self.list_at(*path), what, in_json(*path).entry)

    def check_joint(self, joint: Any, place: FilePosition = NOWHERE) -> str:
        """Return a known joint name, or one to leave out later; refuse other names, with the nearest ones."""
        if isinstance(joint, str) and (joint in self.joints or (joint and self.ignore_other)):
            return joint
        if not isinstance(joint, str):
            raise self.error(f"expected a joint name, got {described(joint)}", place)
        if not joint:
            raise self.error("a joint without a name", place)
        near = ", ".join(nearest_names(joint, self.joints))
        advice = f"nearest: {near}" if near else f"expected one of {len(self.joints)}, such as {self.joints[0]}"
        advice = "a joint of Pepper" if joint in _PEPPER else advice
        raise self.error(
            f"unknown joint {quoted(joint, MAX_SHOWN)} ({advice}); ignore_other=True, or --ignore-other of nao-kin "
            "motion, fk and view, leaves it out",
            place,
        )


def file_name(path: Path | str) -> str:
    """Return a file's name as text."""
    if not str(path):
        raise BadArgument("no file name; expected a motion file, or - for standard input")
    return str(path)


# --- Motion file formats.


@dataclass(frozen=True)
class Format:
    """A motion file format."""

    name: str  # in `read_motion` and `write_motion`
    suffixes: tuple[str, ...]  # of its files, the usual one first
    title: str  # a short description
    # Whether the content looks like this format.
    recognises: Callable[[MotionSource], bool] = field(repr=False)
    read: Callable[[MotionSource], Motion] = field(repr=False)
    # Writes a motion; the second argument is the motion before sampling. None for a format that is only read.
    write: Callable[[Motion, Motion], bytes] | None = field(repr=False, default=None)


def has_line(pattern: re.Pattern[str]) -> Callable[[MotionSource], bool]:
    """Return a test of whether a pattern matches somewhere in the text."""
    return lambda source: pattern.search(source.text) is not None


def has_field(*names: str) -> Callable[[MotionSource], bool]:
    """Return a test of whether the text is a JSON object with one of these fields."""
    return lambda source: isinstance(source.json, dict) and any(name in source.json for name in names)


# --- One of several motions in a file.

_MAX_LISTED = 12


def chosen(source: MotionSource, names: Sequence[str], what: str) -> int:
    """Return the index of the motion that `timeline` chooses, by name, end of a name after a slash, or number."""
    wanted = source.timeline
    if wanted is None:
        fitting = list(range(len(names)))
    else:
        fitting = [index for index, name in enumerate(names) if name == wanted]
        fitting = fitting or [index for index, name in enumerate(names) if name.endswith(f"/{wanted}")]
        if not fitting and wanted.isdecimal() and wanted.isascii() and 1 <= int(wanted[:9]) <= len(names):
            fitting = [int(wanted) - 1]
    if len(fitting) == 1:
        return fitting[0]
    shown = fitting or range(len(names))
    known = listed([f"{index + 1}: {abbreviated(names[index], 60)}" for index in shown], _MAX_LISTED)
    if wanted is None:
        raise source.error(f"{len(names)} {what}; choose one with timeline= or --timeline, by name or number: {known}")
    if fitting:
        raise source.error(f"timeline {quoted(wanted)} fits {len(fitting)} of the {what}; choose by number: {known}")
    near = ", ".join(nearest_names(wanted, names))
    known = f"nearest: {near}" if near else known
    raise source.error(f"no timeline {quoted(wanted)} among {len(names)} {what} ({known})")
