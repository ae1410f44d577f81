"""A motion file that is being read: its bytes, its text, what the caller says of it, and what is wrong with it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.input_text import read_bounded
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument, BadInputFile, NaoKinWarning, nearest_names
from nao_kin.motion.files.json_document import Constant, JsonDocument

# Characters of a foreign value in a message.
MOST_SHOWN = 40
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
    def json(self) -> JsonDocument:
        """The text as JSON.

        Raises:
            BadInputFile: it is none.
        """
        return JsonDocument(self.name, self.text)

    def place(self, path: Sequence[str | int]) -> Place:
        """Where in the JSON text the value that a path of names and indices leads to stands."""
        return Place(*self.json.position(path), self.json.words(path))

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
            try:
                numbers = np.array(values, dtype=np.float64)
            except OverflowError:
                numbers = np.array([_as_float(value) for value in values])
            if np.isfinite(numbers).all():
                return numbers
            first = int(np.argmin(np.isfinite(numbers)))
        else:
            first = next(index for index, value in enumerate(values) if type(value) not in (int, float))
        raise self.error(f"{what} is {described(values[first])}, expected a finite number", place(first))

    def check_joint(self, joint: Any, place: Place | Callable[[], Place] = NOWHERE) -> str:
        """A joint name that may occur, or that is left out later.

        Args:
            joint: what stands in the file.
            place: where, or a function that looks it up.

        Raises:
            BadInputFile: none, with the nearest ones.
        """
        if isinstance(joint, str) and (joint in self.joints or (joint and self.ignore_other)):
            return joint
        place = place() if callable(place) else place
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
    if not isinstance(path, (str, Path)):
        raise BadArgument(f"path must be the name of a file, got {type(path).__name__}")
    if not str(path):
        raise BadArgument("no file name; expected a motion file, or - for standard input")
    return str(path)


def read_bytes(name: str) -> bytes:
    """All of a file, or of standard input for "-".

    Raises:
        BadInputFile: it cannot be read.
    """
    try:
        if name != "-":
            with Path(name).open("rb") as file:
                return read_bounded(file, name)
        if sys.stdin is None:
            raise BadInputFile(name, "closed; there is nothing to read")
        return read_bounded(sys.stdin.buffer, name)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else None
        raise BadInputFile(name, f"cannot be read: {reason or error}") from None


def described(value: Any) -> str:
    """What stands in a file where something else was expected."""
    if isinstance(value, Constant):
        return str(value)
    if value is None or isinstance(value, bool):
        return "null" if value is None else str(value).lower()
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    if isinstance(value, float) and value in (float("inf"), float("-inf")):
        return "a number too large for floating point"
    if isinstance(value, int) and value.bit_length() > 1023:
        return "a number too large for floating point"
    return abbreviated(quoted(value, MOST_SHOWN), MOST_SHOWN)


def _as_float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return float("inf")
