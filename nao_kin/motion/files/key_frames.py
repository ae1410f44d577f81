"""Motions from key frames with durations, and B-Human's configuration streams, which contain them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.text import MAX_SHOWN, abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.motion.files.source import FilePosition, MotionFileWarning, MotionSource
from nao_kin.motion.files.tracks import Track, check_times, motion_of
from nao_kin.motion.motion import Motion
from nao_kin.robot.nao import BODY_ORDER

# Length of the handles in time, as a share of the step, for the cubic nearest to half a wave of the cosine.
_COSINE = 0.36434
# Difference between such a cubic and the cosine, as a share of the step.
COSINE_ERROR = 0.0002
# Values this large are not angles: 10000 switches a joint off, 20000 leaves it unchanged.
_NO_ANGLE = 10000.0

Ease = Literal["linear", "cosine", "sine"]


@dataclass(frozen=True)
class KeyFrame:
    """Joint values, and the interpolation to them."""

    duration: float  # of the step [ms]
    ease: Ease  # progress at the fraction s of the duration: "linear" s, "cosine" ½ − ½ cos π s, "sine" sin ½ π s
    values: Floats  # of the 26 joints, NaN for those that are not commanded [rad, for hands 1 for open]
    place: FilePosition  # of the duration


def key_frame(
    stream: ConfigStream,
    row: Fields,
    ease: Ease,
    lists: Sequence[tuple[Fields, str, int]],
    plain: Literal["rad", "deg"] = "rad",
) -> KeyFrame:
    """Return the key frame that an object describes, with numbers without a unit in the unit `plain`.

    `lists` describes the lists of values, in NAOqi's order: the object that contains each, its name there, and its
    length.
    """
    values = []
    for items, count in [(stream.get(fields, name, Items), count) for fields, name, count in lists]:
        if len(items) != count:
            raise stream.error(f"{len(items)} angles, expected {count}", items)
        for word in items:
            number = stream.number(word, "an angle", plain)
            raw = number / (math.pi / 180.0) if plain == "deg" else number
            values.append(math.nan if raw >= _NO_ANGLE else number)
    duration = stream.get(row, "duration", Word)
    return KeyFrame(stream.number(duration, "duration", ""), ease, np.array(values), stream.place(duration))


def ease_of(stream: ConfigStream, name: str, eases: Mapping[str, Ease | None], *objects: Fields) -> Ease:
    """Return the ease of the first object that has the word `name`; a word with None in `eases` is skipped."""
    for fields in objects:
        if name in fields:
            word = stream.get(fields, name, Word)
            if word.text not in eases:
                shown = quoted(word.text, MAX_SHOWN)
                raise stream.error(f"{name} is {shown}, expected one of {', '.join(eases)}", word)
            ease = eases[word.text]
            if ease is not None:
                return ease
    return "linear"


def motion_of_frames(source: MotionSource, frames: Sequence[KeyFrame]) -> Motion:
    """Return the motion through key frames, the first of which is reached from the robot's current pose.

    Of several frames at 0 s, which the robot commands at once, the last that commands a joint counts for it.
    """
    while len(frames) > 1 and frames[0].duration == 0.0 == frames[1].duration:
        first, second, *rest = frames
        values = np.where(np.isnan(second.values), first.values, second.values)
        frames = [replace(second, values=values), *rest]
    times = np.cumsum([frame.duration for frame in frames]) / 1e3
    check_times(source, times, lambda row: frames[row].place)
    table = np.array([frame.values for frame in frames])
    if np.isnan(table).all():
        raise source.error("no key frame commands a joint")
    eases = np.array([frame.ease for frame in frames])
    straight = bool((eases == "linear").all())
    tracks = []
    for joint, column in zip(BODY_ORDER, table.T, strict=True):
        rows, keys = held_keys(column)
        if len(rows):
            handles = None if straight else eased(times[rows], keys, eases[rows])
            tracks.append(Track(joint, times[rows], keys, handles))
    return motion_of(source, tracks, "linear" if straight else "bezier")


def warn_of_sensors(source: MotionSource, names: set[str]) -> None:
    """Warn about parts of a file, if there are any, that wait for the robot's sensors and are left out."""
    if names:
        listed = ", ".join(sorted(names))
        warn_caller(
            f"{abbreviated(source.name)}: parts that wait for the robot's sensors are left out: {listed}",
            MotionFileWarning,
        )


def held_keys(column: Floats) -> tuple[NDArray[np.intp], Floats]:
    """Return the rows in which a joint has a key, and its values there, from values with NaN if it is not commanded.

    Between two values it keeps the first one up to the last NaN.
    """
    given = np.flatnonzero(~np.isnan(column))
    gaps = np.flatnonzero(np.diff(given) > 1)
    ends = given[gaps + 1] - 1
    filled = np.array(column)
    filled[ends] = column[given[gaps]]
    rows = np.sort(np.concatenate([given, ends]))
    return rows, filled[rows]


def eased(times: Floats, keys: Floats, eases: NDArray[np.str_]) -> Floats:
    """Return Bezier handles, shape (k, 2, 2), with which the segment before each key has an ease of `KeyFrame`.

    The cosine is at rest at both ends. The sine is its second half, from a cubic cut in the middle.
    """
    handles = np.zeros((len(keys), 2, 2))
    width, rise, kinds = np.diff(times), np.diff(keys), eases[1:]
    first = {"linear": (1.0 / 3.0, 1.0 / 3.0), "cosine": (_COSINE, 0.0), "sine": (0.5 - 0.5 * _COSINE, 0.5)}
    second = {"linear": (1.0 / 3.0, 1.0 / 3.0), "cosine": (_COSINE, 0.0), "sine": (_COSINE, 0.0)}
    for kind in first:
        at = np.flatnonzero(kinds == kind)
        step = np.stack([width[at], rise[at]], axis=-1)
        handles[at, 1], handles[at + 1, 0] = step * first[kind], -step * second[kind]
    return handles


# --- Configuration streams: the text format of B-Human and of teams that use its code.

_TOKEN = re.compile(
    r'\s+|//[^\n]*|/\*.*?\*/|(?P<mark>[{}\[\]=;,])|(?P<word>"(?:[^"\\]|\\.)*"|(?:(?!//|/\*)[^\s{}\[\]=;,"])+)',
    re.DOTALL,
)
_NUMBER = re.compile(r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)([A-Za-z]*)", re.ASCII)
_ANGLES = {"rad": 1.0, "deg": math.pi / 180.0}
_DEEPEST = 200


@dataclass(frozen=True)
class Word:
    """A number or a word, and its index in the text."""

    text: str
    at: int


class Fields(dict[str, Any]):
    """The values of an object by name, and its index in the text."""

    at = 0


class Items(list[Any]):
    """The values of a list, and its index in the text."""

    at = 0


class ConfigStream:
    """A file of `name = value;  // comment` that is read as a configuration stream, with all its values in `fields`.

    A value is a number, with or without a unit after it (30deg), a word, a quoted text, a list [value, value] or an
    object {name = value; name = value;}.
    """

    def __init__(self, source: MotionSource, *, last_counts: bool = False) -> None:
        """Parse the file; of fields of one name, the last counts, or the second is an error."""
        self._source = source
        self._last_counts = last_counts
        self._tokens = self._split(source.text)
        self._next = 0
        self.fields = self._fields("", 0)

    def place(self, value: Word | Fields | Items) -> FilePosition:
        """Return the place of a value."""
        return self._place(value.at)

    def error(self, reason: str, value: Word | Fields | Items) -> Exception:
        """Return the error for a value."""
        return self._source.error(reason, self.place(value))

    def get(self, fields: Fields, name: str, kind: type[Any]) -> Any:
        """Return a value of an object, which must be a Word, Fields or Items."""
        value = fields.get(name)
        if not isinstance(value, kind):
            wanted = {Fields: "an object {…}", Items: "a list […]", Word: "a number or a word"}[kind]
            got = "nothing" if value is None else _kind(value)
            raise self.error(f"{name} is {got}, expected {wanted}", fields if value is None else value)
        return value

    def objects(self, rows: Items, what: str) -> Iterator[Fields]:
        """Yield the values of a list, which must all be objects."""
        for row in rows:
            if not isinstance(row, Fields):
                raise self.error(f"expected an object {{…}}{what}", row)
            yield row

    def number(self, value: Any, what: str, plain: str = "rad") -> float:
        """Return a finite number, angles in radians. A number without a unit is in `plain`, "" for a pure number."""
        match = _NUMBER.fullmatch(value.text) if isinstance(value, Word) else None
        units: dict[str, float] = _ANGLES if plain else {"": 1.0}
        known = match is not None and (not match[2] or match[2] in units)
        number = finite_decimal(match[1]) if match is not None and known else None
        if match is None or number is None:
            got = quoted(value.text, MAX_SHOWN) if isinstance(value, Word) else _kind(value)
            unit = f" in {' or '.join(_ANGLES)}" if plain else ""
            raise self.error(f"{what} is {got}, expected a number{unit}", value)
        return number * units[match[2] or plain]

    def _place(self, at: int) -> FilePosition:
        before = self._source.text[:at]
        return FilePosition(before.count("\n") + 1, at - before.rfind("\n"))

    def _split(self, text: str) -> list[tuple[str, str, int]]:
        """Return marks and words, each with its index, and an empty mark at the end."""
        tokens, at = [], 0
        while at < len(text):
            match = _TOKEN.match(text, at)
            if match is None:
                raise self._source.error(f"unexpected {quoted(text[at : at + 10])}", self._place(at))
            if match.lastgroup:
                tokens.append((match.lastgroup, match[0], at))
            at = match.end()
        return [*tokens, ("mark", "", len(text))]

    def _take(self, *wanted: str) -> tuple[str, str, int]:
        """Return the next token, which must be one of the `wanted` marks, or a word if "a word" is among them."""
        kind, text, at = self._tokens[self._next]
        if not (text in wanted if kind == "mark" else "a word" in wanted):
            got = quoted(text, MAX_SHOWN) if text else "the end of the file"
            shown = " or ".join(mark or "the end of the file" for mark in wanted)
            raise self._source.error(f"{got}, expected {shown}", self._place(at))
        self._next += 1
        return kind, text, at

    def _value(self, depth: int) -> Word | Fields | Items:
        kind, text, at = self._take("a word", "{", "[")
        if kind == "word":
            return Word(text.strip('"'), at)
        if depth > _DEEPEST:
            raise self._source.error(f"values more than {_DEEPEST} deep", self._place(at))
        value = self._fields("}", depth) if text == "{" else self._items(depth)
        value.at = at
        return value

    def _fields(self, end: str, depth: int) -> Fields:
        fields = Fields()
        while self._tokens[self._next][:2] != ("mark", end):
            _, name, at = self._take("a word", end)
            if name in fields and not self._last_counts:
                raise self._source.error(f"{quoted(name, MAX_SHOWN)} is given twice", self._place(at))
            self._take("=")
            fields[name] = self._value(depth + 1)
            self._take(";")
        self._take(end)
        return fields

    def _items(self, depth: int) -> Items:
        items = Items()
        while self._tokens[self._next][:2] != ("mark", "]"):
            items.append(self._value(depth + 1))
            if self._tokens[self._next][:2] != ("mark", "]"):
                self._take(",", "]")
        self._take("]")
        return items


def _kind(value: Any) -> str:
    return "an object" if isinstance(value, Fields) else "a list" if isinstance(value, Items) else "a word"
