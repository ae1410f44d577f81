"""Motions from key frames with durations; B-Human's key frames and those of NaoDevils, in configuration streams."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.text import MAX_SHOWN, abbreviated, nearest_names, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.motion.files.source import FilePosition, Format, MotionFileWarning, MotionSource, chosen, has_line
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
    object {name = value; name = value;}. Of fields of one name, the last counts, as in Tools/Streams/SimpleMap.cpp.
    """

    def __init__(self, source: MotionSource) -> None:
        self._source = source
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
            _, name, _ = self._take("a word", end)
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


# --- B-Human's key frames, whose blocks make up motions.
#
#     motions = {
#       sit = {keyframes = [sit, sitDown]; …};
#     };
#     keyframeBlock = {
#       sit = {
#         keyframes = [
#           {
#             duration = 500;
#             interpolationType = Default;
#             angles = {
#               head = [0deg, 0deg];
#               positions = {leftArm = […]; rightArm = […]; leftLeg = […]; rightLeg = […];};
#             };
#             …
#           }
#         ];
#         interpolationType = SinusZeroToMax;
#       };
#     };
#
# Source: bhuman/BHumanCodeRelease, keyframeMotionEngine.cfg and KeyframePhaseBase. Durations are in milliseconds,
# numbers without a unit in radians; 10000 and 20000 are not angles; hands are in radians from 0 closed to 1 open.
# Interpolations to a key frame are Linear, SinusMinToMax (½ − ½ cos π s) and SinusZeroToMax (sin ½ π s); Default is
# the interpolation of the block. Up to 2021, and in getUpEngine.cfg, the file has mofs = {front = {lines = […]}}
# instead, in degrees, and a line contains head, leftArm and so on directly.

_BEGINS = re.compile(r"^\s*(?:keyframeBlock|mofs)\s*=\s*[\[{]", re.MULTILINE)
_BLOCKS, _OLD = "keyframeBlock", "mofs"
_LIMBS = ("leftArm", "leftLeg", "rightLeg", "rightArm")
# The default of a key frame is that of its block, the default of a block is linear.
_EASES: dict[str, Ease | None] = {
    "Default": None,
    "Linear": "linear",
    "SinusMinToMax": "cosine",
    "SinusZeroToMax": "sine",
}
# Actions that depend on the robot's sensors.
_BY_SENSORS = ("keyframeBranches", "waitConditions", "jointCompensation", "startAsNextPhaseMotion")


# B-Human's key frames of Booster's robots have the same form; the folder of such a file has the robot's name.
_BOOSTER = ("K1", "T1")
# Their left arm hangs down at a roll of −80°; that of a NAO does not pass −21° in any of B-Human's releases.
_LEFT_ROLL = re.compile(r"\bleftArm\s*=\s*\[[^],]*,\s*(-[\d.]+)deg")
_NO_NAO_ROLLS = -45.0


def _refuse_other_robots(source: MotionSource) -> None:
    """Refuse the key frames of a robot that is no NAO."""
    folder = Path(source.name).parent.name
    if folder in _BOOSTER:
        raise source.error(f"in the folder {folder}: key frames of Booster's {folder}, expected those of a NAO")
    for match in _LEFT_ROLL.finditer(source.text):
        roll = finite_decimal(match[1])
        if roll is not None and roll < _NO_NAO_ROLLS:
            line = source.text.count("\n", 0, match.start()) + 1
            raise source.error(
                f"the left shoulder rolls to {roll:g}°, which no NAO's does; key frames of another robot, such as "
                f"Booster's {' or '.join(_BOOSTER)}",
                FilePosition(line),
            )


def _read_bhuman(source: MotionSource) -> Motion:
    """Read the motion that `timeline` chooses: one of the motions, or a block as keyframeBlock/name."""
    _refuse_other_robots(source)
    stream = ConfigStream(source)
    old = _OLD in stream.fields
    blocks = _blocks(stream, _OLD if old else _BLOCKS)
    motions = Fields() if old else stream.fields.get("motions", Fields())
    rows = "lines" if old else "keyframes"
    choices: dict[str, list[str]] = {}
    for name in motions:
        words = stream.get(stream.get(motions, name, Fields), rows, Items)
        choices[name] = [_block_name(stream, blocks, word) for word in words]
    choices |= {name if old else f"{_BLOCKS}/{name}": [name] for name in blocks}
    full = {
        name: own
        for name, own in choices.items()
        if any(stream.get(stream.get(blocks, block, Fields), rows, Items) for block in own)
    }
    if not full:
        raise source.error("no key frames")
    name = list(full)[chosen(source, list(full), "motions")]
    frames, left_out = list[KeyFrame](), set[str]()
    for block in full[name]:
        frames += _frames(stream, blocks[block], rows, left_out, old=old)
    left_out |= _given(motions.get(name, Fields()), ("startAsNextPhaseMotion",))
    warn_of_sensors(source, left_out)
    if not frames:
        raise source.error(f"all key frames of {quoted(name, MAX_SHOWN)} wait for the robot's sensors")
    return motion_of_frames(source, frames)


def _blocks(stream: ConfigStream, name: str) -> Fields:
    """Return the blocks by name; before 2015 they were a list, each with its name in it."""
    given = stream.fields.get(name)
    if not isinstance(given, Items):
        return cast(Fields, stream.get(stream.fields, name, Fields))
    blocks = Fields()
    blocks.at = given.at
    for entry in stream.objects(given, ""):
        blocks[stream.get(entry, "name", Word).text] = entry
    return blocks


def _block_name(stream: ConfigStream, blocks: Fields, word: object) -> str:
    name = word.text if isinstance(word, Word) else ""
    if name not in blocks:
        near = ", ".join(nearest_names(name, blocks))
        at = word if isinstance(word, (Word, Fields, Items)) else blocks
        raise stream.error(f"no block {quoted(name, MAX_SHOWN)} of key frames (nearest: {near})", at)
    return name


def _given(fields: Fields, names: Iterable[str]) -> set[str]:
    """Return the names of the lists that are not empty."""
    return {name for name in names if fields.get(name)}


def _frames(stream: ConfigStream, block: Fields, rows: str, left_out: set[str], *, old: bool) -> list[KeyFrame]:
    """Return the key frames of a block, and add the names of ignored parts to `left_out`."""
    frames = []
    for row in stream.objects(stream.get(block, rows, Items), " for a key frame"):
        left_out |= _given(row, _BY_SENSORS)
        if row.get("conditions"):
            left_out |= {"lines with conditions"}
            continue
        angles = row if old else stream.get(row, "angles", Fields)
        limbs = angles if old else stream.get(angles, "positions", Fields)
        lists = [(angles, "head", 2), *((limbs, limb, 6) for limb in _LIMBS)]
        ease = ease_of(stream, "interpolationType", _EASES, row, block)
        frames.append(key_frame(stream, row, ease, lists, "deg" if old else "rad"))
    return frames


BHUMAN = Format("bhuman", (".cfg",), "B-Human's key frames", has_line(_BEGINS), _read_bhuman)


# --- NaoDevils' key frames (.kfm).
#
#     keyFrameID = nod;
#     keyFrames = [
#       {
#         headAngles = [0, 20deg];
#         armsAngles = [90deg, 11deg, 0, 90deg, -90deg, 0, 90deg, -11deg, 0, -90deg, 90deg, 0];
#         legsAngles = [0, 0, -21deg, 49deg, -27.5deg, 0, 0, 0, -21deg, 49deg, -27.5deg, 0];
#         duration = 400;
#         intType = sine;
#         …
#       }
#     ];
#
# Source: NaoDevils/CodeRelease, KeyFrameEngine: the left arm or leg comes before the right one; durations are in
# milliseconds, numbers without a unit in radians; 10000 and 20000 are not angles; a step is linear or sine
# (½ − ½ cos π s). Of two fields of one name the last counts (Tools/Streams/SimpleMap.cpp). Stiffnesses, and actions
# that depend on the robot's sensors, are left out.
#
# NaoDevils' .kmc files, like those of B-Human, hold no joint values: they move feet, elbows and the centre of mass
# through space, and the running robot's balance determines the joints.

_KFM_BEGINS = re.compile(r"^\s*(?:keyFrames|phaseParameters)\s*=\s*\[", re.MULTILINE)
_KFM_LISTS = {"headAngles": 2, "armsAngles": 12, "legsAngles": 12}
# NAOqi's order has the right arm after the legs.
_KFM_ORDER = np.array([*range(8), *range(14, 26), *range(8, 14)])
_KFM_EASES: dict[str, Ease | None] = {"linear": "linear", "sine": "cosine"}


def _read_kfm(source: MotionSource) -> Motion:
    """Read the motion in a .kfm file; a .kmc file, which contains no joint values, is refused."""
    stream = ConfigStream(source)
    if "phaseParameters" in stream.fields:
        raise source.error(
            "a kick of feet, arms and centre of mass (.kmc): its joint values depend on the running robot's balance "
            "and are not in the file; expected key frames (.kfm)"
        )
    frames = []
    for row in stream.objects(stream.get(stream.fields, "keyFrames", Items), " for a key frame"):
        lists = [(row, name, count) for name, count in _KFM_LISTS.items()]
        frame = key_frame(stream, row, ease_of(stream, "intType", _KFM_EASES, row), lists)
        frames.append(replace(frame, values=frame.values[_KFM_ORDER]))
    if not frames:
        raise source.error("no key frames")
    return motion_of_frames(source, frames)


NAODEVILS = Format("naodevils", (".kfm", ".kmc"), "NaoDevils' key frames", has_line(_KFM_BEGINS), _read_kfm)
