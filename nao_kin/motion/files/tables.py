"""A motion as a table: one list of times for all joints, straight lines between."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.warn import warn_caller
from nao_kin.errors import BadArgument
from nao_kin.motion.configurations import sampling_times
from nao_kin.motion.files.source import MotionFileWarning
from nao_kin.motion.motion import Motion
from nao_kin.parameters import BODY_ORDER

# A time that moves by more than this [s] is worth a word.
_NOTICED = 1e-6


def is_hand(joint: str) -> bool:
    """Whether a joint is a hand, given as a ratio from 0 to 1 and not in radians."""
    return joint in ("LHand", "RHand")


def sampled(motion: Motion, rate: float | None, what: str) -> tuple[Floats, Floats]:
    """The rows of a format that knows straight lines only.

    Args:
        motion: what is written.
        rate: samples a second, from the first key to the last; None for the times of all keys.
        what: the format, for the warning.

    Returns:
        times (n,) [s] and values (n, joints).

    Raises:
        BadArgument: a rate that is no positive number, or makes more than 4 million rows.
    """
    if rate is None:
        warn_of_curves(motion, what)
        times = motion.key_times
        return times, motion.sample(times)
    times = sampling_times(motion, rate, None)
    return times, motion.sample(times)


def warn_of_curves(motion: Motion, what: str) -> None:
    """Warn that a format knows no curves, if the motion has some."""
    if motion.interpolation != "linear" and any(len(keys) > 1 for keys in motion.keys):
        warn_caller(
            f"{what} files know straight lines only: the {motion.interpolation} curves between the keys are lost; "
            "rate= or --rate samples them",
            MotionFileWarning,
        )


def milliseconds(times: Floats, what: str) -> list[int]:
    """Times in whole milliseconds.

    Raises:
        BadArgument: a negative one, or two that become the same.
    """
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


def columns(motion: Motion, values: Floats, wanted: Sequence[str], what: str, *, one_hip: bool) -> Floats:
    """The columns of a format that holds the same joints of the NAO in every file.

    Args:
        motion: what is written.
        values: its rows, shape (n, joints).
        wanted: the joints of the format.
        what: the format, for messages.
        one_hip: the format has one column for the two HipYawPitch, LHipYawPitch; else what is missing of the two is
            what the other one is.

    Returns:
        Shape (n, wanted).

    Raises:
        BadArgument: joints that the format has no place for, or that the motion does not name.
    """
    given = {joint: values[:, column] for column, joint in enumerate(motion.joint_names)}
    left, right = "LHipYawPitch", "RHipYawPitch"
    if one_hip and left in given and right in given and not np.array_equal(given[left], given[right]):
        off = float(np.abs(given[left] - given[right]).max())
        warn_caller(
            f"{what} files have one HipYawPitch: {left} is written, from which {right} differs by up to {off:.3g} rad",
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
        shown = ", ".join(missing[:5]) + (f" and {len(missing) - 5} more" if len(missing) > 5 else "")
        raise BadArgument(
            f"{what} files hold all {len(wanted)} joints, the motion lacks {shown}; "
            "nao_kin.motion.complete or --posture fills them in"
        )
    return np.stack([given[joint] for joint in wanted], axis=-1)
