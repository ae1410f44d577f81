"""Motion files as commands take them beside plain configuration files."""

from __future__ import annotations

import io
import sys
from typing import TYPE_CHECKING

from nao_kin._common.arrays import Floats
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, BadInputFile

if TYPE_CHECKING:
    from nao_kin.motion import Motion, Trajectory
    from nao_kin.robot import LimitPolicy, RobotModel


def is_motion(file: str) -> bool:
    """Whether a file, "-" for standard input, holds a motion; standard input can be read again afterwards."""
    from nao_kin.motion import is_motion_file

    if file != "-":
        return is_motion_file(file)
    if sys.stdin is None:
        return False
    try:
        data = sys.stdin.buffer.read()
    except OSError:
        return False  # which is said where it is read
    sys.stdin = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8")
    return is_motion_file("-", data)


def refuse_motion_options(file: str | None, **given: object) -> None:
    """Refuse options that only a motion file takes, where there is another file or none.

    Raises:
        BadArgument: with the first of them that is not None.
    """
    for option, value in given.items():
        if value is None:
            continue
        if file is None:
            raise BadArgument(f"--{option} is for a motion; name its FILE")
        if option == "posture":
            raise BadArgument("a file gives whole configurations; leave out --posture and --joint")
        raise BadArgument(f"--{option} is for a motion, and {quoted(file)} has no times: it gives whole configurations")


def read(
    model: RobotModel,
    file: str,
    *,
    deg: bool,
    timeline: str | None = None,
    format_: str | None = None,
    ignore_other: bool = False,
) -> Motion:
    """The motion in a file, of joints of a robot."""
    from nao_kin.motion import read_motion

    return read_motion(file, format=format_, degrees=deg, timeline=timeline, robot=model, ignore_other=ignore_other)


def trajectory(
    model: RobotModel, motion: Motion, *, posture: str | None, hips: str | None, rate: float | None
) -> Trajectory:
    """The configurations that a motion goes through."""
    from nao_kin.motion import HOLD

    check_posture(model, posture)
    return motion.configurations(
        model,
        rate=rate,
        fill=HOLD if posture is None else posture,
        hips="average" if hips is None else hips,  # type: ignore[arg-type]
    )


def check_posture(model: RobotModel, posture: str | None) -> None:
    """Refuse a posture of a robot that has none."""
    if posture is not None and not model.posture_names:
        raise BadArgument(f"--posture {quoted(posture)}: {model.name} has no predefined postures")


def within_limits(model: RobotModel, file: str, path: Trajectory, limits: LimitPolicy, *, deg: bool) -> Floats:
    """The configurations of a motion, none outside the limits.

    Raises:
        BadInputFile: one is; says when.
    """
    if limits == "ignore":
        return path.q
    if limits == "clamp":
        return model.clamp(path.q)
    violations = model.limit_violations(path.q, most=1)
    if violations:
        first = violations[0]
        when = f"{path.times[first.index[0]]:.6g} s"
        reason = f"at {when} outside the joint limits: {first.describe(degrees=deg, index=False)}"
        raise BadInputFile(file, f"{reason}; nao-kin motion check lists all, --clamp and --ignore-limits take it")
    return path.q
