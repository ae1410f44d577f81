"""Make a motion from the checked keys of each joint in a file, and a table from a motion, for writers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.headings import COLUMN_ADVICE, TIME_UNITS, guessed_time_unit, refuse_long
from nao_kin._core.text import MAX_SHOWN, abbreviated, listed
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, NaoKinError
from nao_kin.motion.files.source import NOWHERE, FilePosition, FilePositionOf, MotionFileWarning, MotionSource
from nao_kin.motion.interpolation import Interpolation
from nao_kin.motion.motion import Motion, out_of_order
from nao_kin.robot.nao import BODY_ORDER

# Largest distance of a handle outside its segment in a file, which has six digits, and in a motion [s, and share].
_FILE_TOLERANCE = 1e-5
_MOTION_TOLERANCE = 1e-6
# Larger values, or shorter steps [s], in a file would overflow.
_LARGEST, _SHORTEST = 1e100, 1e-100
_MAX_LISTED = 5


def nowhere(key: int) -> FilePosition:
    """Return no place, for any key."""
    return NOWHERE


def units_per_second(source: MotionSource, times: Floats, unit: str | None, advice: str = COLUMN_ADVICE) -> float:
    """Return how many of the stated unit of times are in a second; without one it is guessed, with a warning."""
    if unit is None:
        unit, note = guessed_time_unit(times, advice=advice)
        if note:
            warn_caller(f"{abbreviated(source.name)}: {note}", MotionFileWarning)
    return TIME_UNITS[unit]


@dataclass(frozen=True)
class Track:
    """The k keys of one joint."""

    joint: str
    times: Floats  # [s]
    keys: Floats  # [rad, m or ratio]
    handles: Floats | None = None  # of a Bezier curve, shape (k, 2, 2), as in `Motion`
    place: FilePosition = NOWHERE  # of the name
    time_of: FilePositionOf = nowhere  # place of the time of each key
    key_of: FilePositionOf = nowhere  # place of each key


def motion_of(
    source: MotionSource, tracks: Sequence[Track], interpolation: Interpolation = "linear", *, negative: bool = False
) -> Motion:
    """Return the motion of all tracks, at most a day; times before 0 s are an error unless they may be `negative`."""
    other = [abbreviated(track.joint, MAX_SHOWN) for track in tracks if track.joint not in source.joints]
    if other and source.ignore_other:
        tracks = [track for track in tracks if track.joint in source.joints]
        warn_caller(
            f"{abbreviated(source.name)}: left out names that are not joints: {listed(other, _MAX_LISTED)}",
            MotionFileWarning,
        )
    if not tracks:
        raise source.error("no joint with keys")
    seen = dict[str, FilePosition]()
    checked: Floats | None = None
    for track in tracks:
        source.check_joint(track.joint, track.place)
        if track.joint in seen:
            raise source.error(f"joint {track.joint} is given twice", track.place)
        seen[track.joint] = track.place
        if len(track.times) != len(track.keys):
            raise source.error(f"{track.joint} has {len(track.times)} times and {len(track.keys)} keys", track.place)
        if not len(track.keys):
            raise source.error(f"{track.joint} has no keys", track.place)
        if track.times is not checked:
            checked = check_times(source, track.times, track.time_of, negative=negative)
        numbers = track.keys if track.handles is None else np.append(track.keys, track.handles)
        if (np.abs(numbers) > _LARGEST).any() or (np.diff(track.times) < _SHORTEST).any():
            raise source.error(f"{track.joint} has numbers too large or too near to compute with", track.place)
        if track.handles is not None:
            _check_handles(source, track, track.handles)
    handles = [track.handles for track in tracks if track.handles is not None]
    try:
        motion = Motion(
            [track.times for track in tracks],
            [track.joint for track in tracks],
            [track.keys for track in tracks],
            interpolation,
            handles if interpolation == "bezier" and len(handles) == len(tracks) else None,
        )
    except NaoKinError as error:
        raise source.error(str(error)) from None
    refuse_long(source.name, motion.key_times)
    return motion


def check_times(source: MotionSource, times: Floats, place: FilePositionOf, *, negative: bool = False) -> Floats:
    """Return times that ascend, and are not negative unless that is allowed."""
    if len(times) and times[0] < 0.0 and not negative:
        raise source.error(f"time {times[0]:.9g} s is negative", place(0))
    wrong = out_of_order(times)
    if wrong is not None:
        key, word = wrong
        raise source.error(
            f"time {times[key]:.9g} s is {word} the one of the key before, {times[key - 1]:.9g} s", place(key)
        )
    return times


def _check_handles(source: MotionSource, track: Track, handles: Floats) -> None:
    """Refuse handles that leave their segment in time; correct those that do so by rounding."""
    widths = np.diff(track.times)
    for side, sign, word in ((0, -1.0, "before"), (1, 1.0, "after")):
        inner = slice(1, None) if side == 0 else slice(None, -1)
        length = sign * handles[inner, side, 0]
        wrong = (length < -_FILE_TOLERANCE) | (length > widths * (1.0 + _FILE_TOLERANCE) + _FILE_TOLERANCE)
        if wrong.any():
            segment = int(np.argmax(wrong))
            key = segment + (side == 0)
            raise source.error(
                f"the handle {word} key {key} of {track.joint} is {sign * length[segment]:.9g} s from it, outside of "
                f"its segment of {widths[segment]:.9g} s",
                track.key_of(key),
            )
        off = (length < -_MOTION_TOLERANCE * widths) | (length > widths * (1.0 + _MOTION_TOLERANCE))
        handles[inner, side, 0][off] = sign * np.clip(length, 0.0, widths)[off]


# --- A motion as a table: one list of times for all joints, with straight lines between.

# Smallest change of a time [s] with a warning.
_NOTICED = 1e-6


def is_hand(joint: str) -> bool:
    """Return whether a joint is a hand, given as a ratio from 0 to 1 and not in radians."""
    return joint in ("LHand", "RHand")


def straight_rows(motion: Motion, what: str) -> tuple[Floats, Floats]:
    """Return times (n,) [s] and values (n, joints) at all key times, for a linear format."""
    warn_of_curves(motion, what)
    return motion.key_times, motion.sample(motion.key_times)


def warn_of_curves(motion: Motion, what: str) -> None:
    """Warn if a motion has curves, which a linear format loses."""
    if motion.interpolation != "linear" and any(len(keys) > 1 for keys in motion.keys):
        warn_caller(
            f"{what} files hold straight lines only: the {motion.interpolation} curves between the keys are lost; "
            "rate= or --rate samples them",
            MotionFileWarning,
        )


def milliseconds(times: Floats, what: str) -> list[int]:
    """Return times in whole milliseconds, which must be distinct and not negative."""
    if times[0] < 0.0:
        raise BadArgument(f"{what} files begin at 0 s, the motion at {times[0]:g} s")
    whole = np.rint(times * 1e3)
    if (np.diff(whole) < 1.0).any():
        row = int(np.argmin(np.diff(whole))) + 1
        raise BadArgument(
            f"{what} files count milliseconds: {times[row - 1]:.9g} s and {times[row]:.9g} s become the same; "
            "rate= or --rate spaces them evenly"
        )
    if whole[-1] >= 2**31:
        raise BadArgument(f"{what} files count milliseconds in 31 bits, the motion ends at {times[-1]:g} s")
    off = float(np.abs(whole * 1e-3 - times).max())
    if off > _NOTICED:
        warn_caller(
            f"{what} files count milliseconds: times are rounded, by up to {off * 1e3:.3g} ms",
            MotionFileWarning,
            f"{what} files round times",
        )
    return [int(time) for time in whole]


def nao_rows(motion: Motion, wanted: Sequence[str], what: str, *, one_hip: bool = False) -> tuple[Floats, Floats]:
    """Return the times (n,) [s] and the rows (n, wanted) of a linear format with fixed joints of the NAO.

    With `one_hip` the format has one column, LHipYawPitch, for both HipYawPitch; else a missing one equals the other.
    """
    times, values = straight_rows(motion, what)
    given = dict(zip(motion.joint_names, values.T, strict=True))
    left, right = "LHipYawPitch", "RHipYawPitch"
    if one_hip and left in given and right in given and not np.array_equal(given[left], given[right]):
        off = float(np.abs(given[left] - given[right]).max())
        warn_caller(
            f"{what} files have one HipYawPitch: {left} is written, {right} differs from it by up to {off:.3g} rad",
            MotionFileWarning,
            f"{what} files have one HipYawPitch",
        )
    if left in given or right in given:
        given.setdefault(left, given.get(right, values[:, 0]))
        given.setdefault(right, given[left])
    unknown = [joint for joint in motion.joint_names if joint not in BODY_ORDER]
    if unknown:
        raise BadArgument(f"{what} files have no place for {', '.join(unknown[:3])}; they hold the NAO's joints only")
    missing = [joint for joint in wanted if joint not in given]
    if missing:
        raise BadArgument(
            f"{what} files hold all {len(wanted)} joints, the motion lacks {listed(missing, _MAX_LISTED)}; "
            "nao_kin.motion.complete or --posture fills them in"
        )
    return times, np.stack([given[joint] for joint in wanted], axis=-1)
