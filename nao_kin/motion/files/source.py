"""A motion file that is being read: its bytes, its text, what the caller says of it, and what is wrong with it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.csv_numbers import plain_floats
from nao_kin._core.files import described, is_finite_number, read_json
from nao_kin._core.text import MOST_SHOWN, abbreviated, quoted
from nao_kin.errors import BadArgument, BadInputFile, NaoKinWarning, nearest_names
from nao_kin.motion.motion import Motion

_PLAIN = re.compile(r"[A-Za-z_]\w{0,39}", re.ASCII)
# Joints of Aldebaran's Pepper that no NAO has.
_PEPPER = ("HipRoll", "HipPitch", "KneePitch", "WheelFL", "WheelFR", "WheelB")


class MotionFileWarning(NaoKinWarning):
    """Something that a motion file holds and a motion does not, or the other way round, is left out or changed.

    Examples:
        >>> issubclass(nk.motion.MotionFileWarning, nk.errors.NaoKinWarning)
        True
    """


@dataclass(frozen=True)
class Place:
    """Where in a file something stands.

    Attributes:
        line: 1-based, 0 for none.
        column: 1-based, 0 for none.
        where: words in front of a message, such as "keys[3][2]".
    """

    line: int = 0
    column: int = 0
    where: str = ""

    def entry(self, index: int) -> Place:
        """The place of an entry of the list that stands here."""
        return Place(self.line, self.column, f"{self.where}[{index}]")

    def field(self, index: int) -> Place:
        """The place of a field of the row whose first one stands here."""
        return Place(self.line, self.column + index)


def in_json(*path: str | int) -> Place:
    """The place in JSON of the value that names and indices lead to, as keys[3][2] or motion[0].keyframes."""
    words = ""
    for step in path:
        if isinstance(step, int):
            words += f"[{step}]"
        elif _PLAIN.fullmatch(step):
            words += f".{step}" if words else step
        else:
            words += f"[{quoted(step, MOST_SHOWN)}]"
    return Place(where=words)


# The names and indices that lead to a value in JSON.
Path = list[str | int]
# Where the entry with a number stands.
PlaceOf = Callable[[int], Place]
NOWHERE = Place()


@dataclass(frozen=True)
class Source:
    """A motion file that is being read.

    Attributes:
        name: the file, "-" for standard input.
        data: all of it.
        joints: the joint names that may occur.
        degrees: turning joints are in degrees where the file does not say so.
        timeline: which of several motions in the file is wanted; None for the only one.
        ignore_other: joints that may not occur are left out.
    """

    name: str
    data: bytes = field(repr=False)
    joints: tuple[str, ...]
    degrees: bool = False
    timeline: str | None = None
    ignore_other: bool = False

    @cached_property
    def text(self) -> str:
        """The text, without a byte order mark.

        Raises:
            BadInputFile: no UTF-8 text.
        """
        try:
            return self.data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            place = Place(self.data.count(b"\n", 0, error.start) + 1)
            raise self.error(f"not UTF-8 text (byte {error.start})", place) from None

    @cached_property
    def lines(self) -> list[str]:
        """The text, line by line."""
        return self.text.replace("\r\n", "\n").replace("\r", "\n").split("\n")

    @cached_property
    def json(self) -> Any:
        """The value of the text as JSON.

        Raises:
            BadInputFile: it is none.
        """
        return read_json(self.name, self.text)

    def at(self, *path: str | int) -> Any:
        """The value in the JSON text that a path of names and indices leads to.

        Raises:
            BadInputFile: an object on the way does not have the name.
        """
        value = self.json
        for index, step in enumerate(path):
            if isinstance(value, dict) and step not in value:
                raise self.error(f"no {step!r}", in_json(*path[:index]))
            value = value[step]
        return value

    def list_at(self, *path: str | int) -> list[Any]:
        """The same, which must be a list."""
        value = self.at(*path)
        if not isinstance(value, list):
            raise self.error(f"expected a list, got {described(value)}", in_json(*path))
        return value

    def objects_at(self, *path: str | int) -> Iterator[tuple[Path, dict[str, Any]]]:
        """The objects of a list, each with its path."""
        for index, value in enumerate(self.list_at(*path)):
            if not isinstance(value, dict):
                raise self.error(f"expected an object, got {described(value)}", in_json(*path, index))
            yield [*path, index], value

    def fields(self, value: Any, names: Sequence[str], what: str, *path: str | int) -> dict[str, Any]:
        """A value in the JSON text, which must be an object without other fields than those of these names."""
        if not isinstance(value, dict):
            raise self.error(f"expected an object, got {described(value)}", in_json(*path))
        for name in value:
            if name not in names:
                near = ", ".join(nearest_names(name, names)) or ", ".join(names)
                raise self.error(f"unknown {what} (nearest: {near})", in_json(*path, name))
        return value

    def error(self, reason: str, place: Place = NOWHERE) -> BadInputFile:
        """What to raise for something that is wrong with the file."""
        return BadInputFile(self.name, f"{place.where}: {reason}" if place.where else reason, place.line, place.column)

    def floats(self, values: Sequence[Any], what: str, place: PlaceOf) -> Floats:
        """Numbers out of JSON or Python, shape (n,).

        Args:
            values: what stands in the file.
            what: what one of them is.
            place: where each stands.

        Raises:
            BadInputFile: one is no finite number.
        """
        if set(map(type, values)) <= {int, float}:
            with suppress(OverflowError):
                numbers = np.array(values, dtype=np.float64)
                if np.isfinite(numbers).all():
                    return numbers
        first = next(index for index, value in enumerate(values) if not is_finite_number(value))
        raise self.error(f"{what} is {described(values[first])}, expected a finite number", place(first))

    def decimals(
        self, fields: Sequence[str], names: Sequence[str], place: PlaceOf, hold: str | None = None
    ) -> list[float]:
        """Numbers out of text.

        Args:
            fields: what stands in the file.
            names: what each of them is.
            place: where each stands.
            hold: stands for no number, NaN.

        Raises:
            BadInputFile: one is no finite number.
        """
        numbers = plain_floats(fields) if self._has_plain_digits else None
        if numbers:
            return numbers
        numbers = []
        for index, (name, text) in enumerate(zip(names, map(str.strip, fields), strict=True)):
            number = math.nan if text == hold else finite_decimal(text)
            if number is None:
                reason = f"{name} is {quoted(text, MOST_SHOWN)}, expected a finite number"
                raise self.error(reason if hold is None else f"{reason} or {hold}", place(index))
            numbers.append(number)
        return numbers

    @cached_property
    def _has_plain_digits(self) -> bool:
        """Whether Python's `float` reads decimal digits only: it takes those of any script, and underscores."""
        return self.text.isascii() and "_" not in self.text

    def floats_at(self, what: str, *path: str | int) -> Floats:
        """The numbers of a list in the JSON text, each of which is `what`."""
        return self.floats(self.list_at(*path), what, in_json(*path).entry)

    def check_joint(self, joint: Any, place: Place = NOWHERE) -> str:
        """A joint name that may occur, or that is left out later.

        Args:
            joint: what stands in the file.
            place: where.

        Raises:
            BadInputFile: none, with the nearest ones.
        """
        if isinstance(joint, str) and (joint in self.joints or (joint and self.ignore_other)):
            return joint
        if not isinstance(joint, str):
            raise self.error(f"expected a joint name, got {described(joint)}", place)
        if not joint:
            raise self.error("a joint without a name", place)
        near = ", ".join(nearest_names(joint, self.joints))
        advice = f"nearest: {near}" if near else f"expected one of {len(self.joints)}, such as {self.joints[0]}"
        advice = "this is a Pepper's" if joint in _PEPPER else advice
        raise self.error(
            f"unknown joint {quoted(joint, MOST_SHOWN)} ({advice}); ignore_other=True, or --ignore-other of nao-kin "
            "motion, fk and view, leaves it out",
            place,
        )


def file_name(path: object) -> str:
    """A file's name as text.

    Raises:
        BadArgument: it is none, or empty.
    """
    if not isinstance(path, (str, FilePath)):
        raise BadArgument(f"path must be the name of a file, got {type(path).__name__}")
    if not str(path):
        raise BadArgument("no file name; expected a motion file, or - for standard input")
    return str(path)


# --- What a motion file format is made of.


@dataclass(frozen=True)
class Format:
    """A motion file format.

    Attributes:
        name: by which `read_motion` and `write_motion` know it.
        suffixes: of its files, the first one by custom.
        title: what it is, in a few words.
    """

    name: str
    suffixes: tuple[str, ...]
    title: str
    # Whether the content looks like it; never raises.
    recognises: Callable[[Source], bool] = field(repr=False)
    read: Callable[[Source], Motion] = field(repr=False)
    # The bytes of a file of a motion, or of its samples at a rate; None for a format that is only read.
    write: Callable[[Motion, float | None], bytes] | None = field(repr=False, default=None)


# --- Which one of several motions in a file.

_MOST_LISTED = 12


def chosen(source: Source, names: Sequence[str], what: str) -> int:
    """The index of the motion that the caller wants.

    Args:
        source: the file; its `timeline` is a name, the end of one after a slash, or a number from 1.
        names: of the motions in the file.
        what: what they are, in messages.

    Raises:
        BadInputFile: none or several fit; lists them.
    """
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
    listed = ", ".join(f"{index + 1}: {abbreviated(names[index], 60)}" for index in shown[:_MOST_LISTED])
    more = f" and {len(shown) - _MOST_LISTED} more" if len(shown) > _MOST_LISTED else ""
    if wanted is None:
        raise source.error(
            f"{len(names)} {what}; choose one with timeline= or --timeline, by name or number: {listed}{more}"
        )
    if fitting:
        raise source.error(
            f"timeline {quoted(wanted)} stands for {len(fitting)} of the {what}; choose by number: {listed}{more}"
        )
    near = ", ".join(nearest_names(wanted, names))
    listed = f"nearest: {near}" if near else listed + more
    raise source.error(f"no timeline {quoted(wanted)} among {len(names)} {what} ({listed})")
