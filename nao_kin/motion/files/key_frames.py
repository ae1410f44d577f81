"""Key frames that take a duration each, some joints of which are not commanded, made into a motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin._core.text import MOST_SHOWN, quoted
from nao_kin.motion.files.config_stream import ConfigStream, Fields, Items, Word
from nao_kin.motion.files.source import Place, Source
from nao_kin.motion.files.tracks import Track, check_times, motion_of
from nao_kin.motion.motion import Motion
from nao_kin.robot.nao import BODY_ORDER

# Time of the handles, as a share of the step, with which a cubic is nearest to half a wave of the cosine.
_COSINE = 0.36434
# What such a cubic differs from the cosine by, as a share of the step.
COSINE_ERROR = 0.0002
# Values from here on are no angles: 10000 switches a joint off, 20000 leaves it as it is.
_NO_ANGLE = 10000.0

Ease = Literal["linear", "cosine", "sine"]


@dataclass(frozen=True)
class KeyFrame:
    """Joint values and the way there.

    Attributes:
        duration: how long it takes [ms].
        ease: how far of the way at the share s of the duration: "linear" s, "cosine" ½ − ½ cos π s, "sine" sin ½ π s.
        values: of all joints, NaN for those that are not commanded [rad, for hands 1 for open], shape (26,).
        place: where the duration stands.
    """

    duration: float
    ease: Ease
    values: Floats
    place: Place


def key_frame(
    stream: ConfigStream,
    row: Fields,
    ease: Ease,
    lists: Sequence[tuple[Fields, str, int]],
    plain: Literal["rad", "deg"] = "rad",
) -> KeyFrame:
    """The key frame that an object describes.

    Args:
        stream: the file.
        row: holds the duration.
        ease: the way there.
        lists: of values, in NAOqi's order: the object that holds each, its name there, and how many it must have.
        plain: unit of numbers without one.
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
    """The way to a key frame: what a word says in the first object that has it, straight where none does.

    Args:
        stream: the file.
        name: of the word.
        eases: what words stand for; None for what the next object says.
        objects: a key frame, and what it is part of.
    """
    for fields in objects:
        if name in fields:
            word = stream.get(fields, name, Word)
            if word.text not in eases:
                shown = quoted(word.text, MOST_SHOWN)
                raise stream.error(f"{name} is {shown}, expected one of {', '.join(eases)}", word)
            ease = eases[word.text]
            if ease is not None:
                return ease
    return "linear"


def motion_of_frames(source: Source, frames: Sequence[KeyFrame]) -> Motion:
    """The motion through key frames, the first of which is reached from wherever the robot is.

    A joint that is not commanded has no key; between two values it holds the first one up to the last frame that does
    not command it.

    Raises:
        BadInputFile: with the place of a duration that is none, or where no joint is commanded.
    """
    times = np.cumsum([frame.duration for frame in frames]) / 1e3
    check_times(source, times, lambda row: frames[row].place)
    table = np.array([frame.values for frame in frames])
    if np.isnan(table).all():
        raise source.error("no key frame commands a joint")
    eases = np.array([frame.ease for frame in frames])
    straight = bool((eases == "linear").all())
    tracks = []
    for joint, column in zip(BODY_ORDER, table.T, strict=True):
        rows, keys = held(column)
        if len(rows):
            handles = None if straight else eased(times[rows], keys, eases[rows])
            tracks.append(Track(joint, times[rows], keys, handles))
    return motion_of(source, tracks, "linear" if straight else "bezier")


def held(column: Floats) -> tuple[NDArray[np.intp], Floats]:
    """The rows in which a joint has a key, and its values there, from values that are NaN where it is not commanded.

    Between two values it holds the first one up to the last NaN.
    """
    given = np.flatnonzero(~np.isnan(column))
    gaps = np.flatnonzero(np.diff(given) > 1)
    ends = given[gaps + 1] - 1
    filled = np.array(column)
    filled[ends] = column[given[gaps]]
    rows = np.sort(np.concatenate([given, ends]))
    return rows, filled[rows]


def eased(times: Floats, keys: Floats, eases: NDArray[np.str_]) -> Floats:
    """Bezier handles, shape (k, 2, 2), with which the segment before each key is of a kind of `KeyFrame.ease`.

    The cosine rests at both ends. The sine is its second half: of half of a cubic cut in the middle.
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
