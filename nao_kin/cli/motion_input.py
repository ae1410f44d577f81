"""Motion files as commands take them beside plain configuration files."""

from __future__ import annotations

import io
import sys
from typing import TYPE_CHECKING

from nao_kin._common.arrays import Floats
from nao_kin._common.input_text import read_bounded
from nao_kin._text import quoted
from nao_kin.cli.output import print_note
from nao_kin.errors import BadArgument, BadInputFile

if TYPE_CHECKING:
    from nao_kin.configuration_files import TableColumns
    from nao_kin.motion import Motion, Trajectory
    from nao_kin.robot import LimitPolicy, RobotModel
    from nao_kin.stream import Clamped


def is_motion(file: str) -> bool:
    """Whether a file, "-" for standard input, holds a motion; standard input can be read again afterwards.

    Raises:
        BadInputFile: standard input is a pipe or device of more than 2³⁰ bytes, which may have no end.
    """
    from nao_kin.motion import is_motion_file

    if file != "-":
        return is_motion_file(file)
    if sys.stdin is None:
        return False
    try:
        data = read_bounded(sys.stdin.buffer, file)
    except OSError:
        return False  # which is said where it is read
    sys.stdin = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8")
    return is_motion_file("-", data)


def log_columns(model: RobotModel, file: str, columns: dict[str, str | None] | None) -> TableColumns | None:
    """The columns of a file whose rows are whole configurations; None for other files, and input not read yet."""
    from nao_kin.configuration_files import log_columns

    data = None
    if file == "-":
        buffer = getattr(sys.stdin, "buffer", None)
        if not isinstance(buffer, io.BytesIO):
            return None
        data = buffer.getvalue()
    return log_columns(model, file, columns=columns, data=data)


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


def clamped(model: RobotModel, q: Floats) -> Floats:
    """Configurations moved inside the limits, and a note that says how many, and how far."""
    from nao_kin import stream

    inside, changes = stream.clamp(model, q)
    note_clamped(model, changes, len(q))
    return inside


def note_clamped(model: RobotModel, changes: Clamped, rows: int) -> None:
    """Say what --clamp has changed."""
    if changes.rows:
        unit = model.unit(changes.joint)
        most = f"{changes.most:.3g}{'' if unit == '1' else f' {unit}'}"
        print_note(f"--clamp moved {changes.rows} of {rows} rows to the limits, by at most {most} ({changes.joint})")


def within_limits(model: RobotModel, file: str, path: Trajectory, limits: LimitPolicy, *, deg: bool) -> Floats:
    """The configurations of a motion, none outside the limits.

    Raises:
        BadInputFile: one is; says when.
    """
    if limits == "ignore":
        return path.q
    if limits == "clamp":
        return clamped(model, path.q)
    violations = model.limit_violations(path.q, most=1)
    if violations:
        first = violations[0]
        when = f"{path.times[first.index[0]]:.6g} s"
        reason = f"at {when} outside the joint limits: {first.describe(degrees=deg, index=False)}"
        raise BadInputFile(file, f"{reason}; nao-kin motion check lists all, --clamp and --ignore-limits take it")
    return path.q
