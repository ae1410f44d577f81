"""The input of commands: a posture and joints, a file of whole configurations, or a motion."""

from __future__ import annotations

import io
import itertools
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from nao_kin._core.arrays import Floats, choice, finite_decimal
from nao_kin._core.csv_numbers import CsvHead, TableColumns, read_csv
from nao_kin._core.files import read_bounded, read_table_text
from nao_kin._core.sides import Hips
from nao_kin._core.text import abbreviated, quoted
from nao_kin.cli import options as shared
from nao_kin.cli.options import Needs, argument, flag, option
from nao_kin.cli.output import print_note
from nao_kin.errors import (
    BadArgument,
    BadInputFile,
    CouplingViolated,
    OutsideLimits,
)

if TYPE_CHECKING:
    from nao_kin.motion import Motion, Trajectory
    from nao_kin.robot import CollisionRule, LimitPolicy, OutsideRows, RobotModel


@dataclass(frozen=True)
class JointOptions:
    """The options of one configuration, and of the joints that a motion does not name."""

    posture: str | None = option(
        "NAME", "Start from a predefined posture; for a motion, the values of joints that it does not name."
    )
    joint: list[str] | None = option("NAME=VALUE", "Set a joint; repeatable. Other joints are at zero.")
    deg: bool = shared.DEG

    def configuration(self, model: RobotModel, *, limits: LimitPolicy) -> Floats:
        """Return the configuration; without a posture only the named joints must be inside their limits."""
        deg = self.deg
        values = joint_values(self.joint, "--joint", model, deg)
        try:
            if self.posture is None:
                return model.configuration(values, limits=limits)
            return model.posture(self.posture, values, limits=limits)
        except OutsideLimits as error:
            # An angle of more than a full turn is probably in degrees.
            in_degrees = not deg and any(abs(value) > 2.0 * math.pi for value in values.values())
            advice = "are these degrees (--deg)?" if in_degrees else "--limits clamp or --limits ignore accepts it"
            raise BadArgument(f"{error.describe(degrees=deg)}; {advice}") from None
        except CouplingViolated as error:
            raise BadArgument(error.describe(degrees=deg)) from None


def settings(texts: list[str] | None, option: str, example: str) -> dict[str, str]:
    """Return the values of an option of NAME=VALUE settings, by name."""
    values: dict[str, str] = {}
    for text in texts or ():
        name, sign, value = text.rpartition("=")
        name = name.strip()
        if not sign or not name:
            raise BadArgument(f"{option} {quoted(text)}: expected {example}")
        if name in values:
            raise BadArgument(f"{option} names {abbreviated(name)} twice")
        values[name] = value.strip()
    return values


def joint_values(texts: list[str] | None, option: str, model: RobotModel, deg: bool) -> dict[str, float]:
    """Return the numbers of an option of NAME=VALUE settings, by name [rad, m or ratio]."""
    values = number_settings(texts, option, "NAME=VALUE with a number, as in HeadYaw=0.3")
    return {name: math.radians(x) if deg and model.unit(name) == "rad" else x for name, x in values.items()}


def number_settings(texts: list[str] | None, option: str, example: str) -> dict[str, float]:
    """Return the numbers of an option of NAME=VALUE settings, by name."""
    values: dict[str, float] = {}
    for name, text in settings(texts, option, example).items():
        value = finite_decimal(text)
        if value is None:
            raise BadArgument(f"{option} {quoted(f'{name}={text}')}: expected {example}")
        values[name] = value
    return values


_SEPARATORS = str.maketrans(",()[]", "     ")


def numbers_of(text: str, option: str, count: int | None = None) -> list[float]:
    """Return the finite numbers of an option, as many as `count` if it is given.

    They are separated by blanks or commas, and may be in brackets, as Python and NumPy print them.
    """
    words = text.translate(_SEPARATORS).split()
    numbers = []
    for word in words:
        number = finite_decimal(word)
        if number is None:
            unit = "; units are not written" if word.lstrip("+-.0123456789").isalpha() else ""
            raise BadArgument(f"{option} {quoted(text)}: {quoted(word)} is not a finite number{unit}")
        numbers.append(number)
    if count not in (None, len(numbers)):
        raise BadArgument(f"{option} {quoted(text)}: {len(numbers)} numbers, expected {count}")
    return numbers


def check_motion_file(path: str, to: str | None = None) -> str:
    """Return the format of a motion file to write, `to` or that of its suffix; refuse others before any work for it."""
    from nao_kin.motion import FORMATS

    written = {name: known.suffixes for name, known in FORMATS.items() if known.write is not None}
    if to is not None:
        return choice(to, written, "motion format")
    fitting = [name for name, own in written.items() if Path(path).suffix.lower() in own]
    if not fitting:
        suffixes = ", ".join(dict.fromkeys(itertools.chain(*written.values())))
        raise BadArgument(f"no motion format for {abbreviated(path)}; end it in one of: {suffixes}")
    return fitting[0]


@dataclass(frozen=True)
class OverlapOptions:
    """The overlaps of links that are accepted."""

    tolerance: float = option("M", "Overlap of links that is accepted [m].", default=0.0)
    allow: list[str] | None = option("LINK,LINK", "Two links that may overlap; repeatable.")
    exact: bool = flag("Compare the meshes wherever hulls overlap, not only by less than 3 mm.")

    @property
    def rule(self) -> CollisionRule:
        """The rule for `nao_kin.motion.check` and `nao_kin.imitation.imitate`."""
        from nao_kin.robot import CollisionRule

        pairs = []
        for text in self.allow or ():
            names = [name.strip() for name in text.split(",")]
            if len(names) != 2:
                raise BadArgument(f"--allow {quoted(text)}: expected two links, as in l_ankle,r_ankle")
            pairs.append((names[0], names[1]))
        return CollisionRule(self.tolerance, pairs, self.exact or None)


def read_columns(
    file: str, what: str, chosen: Callable[[list[str], int], Sequence[str]]
) -> tuple[tuple[str, ...], Floats]:
    """Return some headings of a CSV file with `what`, and the numbers (n, k) below them.

    `chosen` returns them, given all headings and their line.
    """
    text, is_json = read_table_text(file, what)
    if is_json:
        raise BadInputFile(file, f"is JSON, expected CSV with {what}")

    def columns(head: CsvHead) -> TableColumns:
        names = [field.strip() for field in head.fields]
        wanted = tuple(chosen(names, head.line))
        return TableColumns(wanted, (), tuple(map(names.index, wanted)), all=len(names))

    table, rows, _ = read_csv(file, text.encode(), columns, what)
    return table.names, rows


def frame_names(model: RobotModel, given: list[str] | None) -> list[str]:
    """Return the frames of --frame, which may have several with commas."""
    texts = [[text] if text in model.frame_names else text.split(",") for text in given or ()]
    return [name.strip() for parts in texts for name in parts if name.strip()]


def posture_or_number(text: str | None) -> str | float | None:
    """Return a number, or the name of a posture, of `--missing`."""
    number = None if text is None else finite_decimal(text)
    return text if number is None else number


@dataclass(frozen=True)
class MotionFile:
    """A motion file of any format, and the options of its reading."""

    file: str = argument("FILE", "A motion file of any format, - for standard input.")
    from_: str | None = option("FORMAT", "Format of FILE. Default: by its content.")
    deg: bool = shared.DEG
    file_deg: bool = shared.FILE_DEG
    timeline: str | None = shared.TIMELINE
    ignore_other: bool = shared.IGNORE_OTHER

    def read(self, model: RobotModel) -> Motion:
        """Return the motion of a robot's joints; print a note if its angles seem to be in another unit."""
        motion, note = self.read_with_note(model)
        print_note(*note)
        return motion

    def read_with_note(self, model: RobotModel) -> tuple[Motion, list[str]]:
        """Return the motion of a robot's joints, and a note if its angles seem to be in another unit."""
        from nao_kin.motion import read_motion
        from nao_kin.stream import unit_note

        motion = read_motion(
            self.file,
            format=self.from_,
            degrees=self.file_deg,
            timeline=self.timeline,
            robot=model,
            ignore_other=self.ignore_other,
        )
        ends = np.array([[keys.min() for keys in motion.keys], [keys.max() for keys in motion.keys]])
        note = unit_note(model, motion.joint_names, ends, degrees=self.file_deg)
        return motion, [f"{self.file}: {note}"] if note else []


def recorded(
    source: MotionFile, model: RobotModel, *, columns: list[str] | None, hips: Hips | None, missing: str | None
) -> Motion:
    """Return a motion; with columns or missing values from a table, as a robot records one."""
    from nao_kin import motion as motions

    if not (columns or missing):
        motion = source.read(model)
        return motion if hips is None else motions.share_motors(model, motion, hips).motion
    if source.from_ is not None or source.timeline is not None:
        raise BadArgument("--columns and --missing are for a table; leave out --from and --timeline")
    options = FileOptions(file_deg=source.file_deg, columns=columns, ignore_other=source.ignore_other, missing=missing)
    log = options.log(model, source.file, hips=hips or "average")
    if log.times is None:
        raise BadInputFile(source.file, "it has no times: a motion needs a column of them")
    return motions.Motion(log.times, model.joint_names, log.q[:, model.nq_base :])


class Input(NamedTuple):
    """Configurations (n, nq), their times (n,) [s] if they have any, whether they are a list, and sensors by name."""

    q: Floats
    times: Floats | None
    many: bool
    sensors: dict[str, Floats]

    def measured(self, model: RobotModel, sole: list[str] | None, *kinds: str) -> dict[str, Any]:
        """Return the sensors of some kinds, or all; with --sole none that are columns for each of the robot's soles."""
        found = {kind: self.sensors[kind] for kind in kinds or self.sensors if kind in self.sensors}
        count = {"contacts": None, "forces": len(model.semantics.soles)}
        apart = [kind for kind in found if sole and kind in count and count[kind] in (None, found[kind].shape[1])]
        if apart:
            print_note(f"{apart[0]} of each sole are not used with --sole")
        return {kind: found[kind] for kind in found if kind not in apart}


@dataclass(frozen=True)
class FileOptions(JointOptions):
    """The options of a file of whole configurations or of a motion, and of one configuration without a file."""

    file_deg: bool = shared.FILE_DEG
    columns: list[str] | None = shared.COLUMNS
    ignore_other: bool = shared.IGNORE_OTHER
    rate: float | None = option("N", "For a motion: configurations per second.")
    hips: Hips | None = shared.HIPS
    missing: str | None = shared.MISSING
    timeline: str | None = shared.TIMELINE
    needs: ClassVar[Needs] = dict.fromkeys(
        ("file_deg", "columns", "ignore_other", "rate", "hips", "missing", "timeline"), "file"
    )

    def configurations(
        self, model: RobotModel, file: str | None, *, limits: LimitPolicy, sampling: float | None = None
    ) -> Input:
        """Return the configurations of a file or of the options.

        With `sampling`, a table that can be read as a motion is one, and so many configurations per second are its
        --rate unless that is given.
        """
        if file is None:
            return Input(self.configuration(model, limits=limits)[None], None, False, {})
        path, hips = self.motion(model, file, limits=limits, sampling=sampling)
        if path is not None:
            return Input(path.q, path.times, True, {})
        log = self.log(model, file, limits=limits, hips=hips)
        return Input(log.q, log.times, log.many, log.sensors)

    def recording(self, model: RobotModel, file: str, soles: Sequence[str] | None, *, limits: LimitPolicy) -> Input:
        """Return the configurations of a log of the joints that move a robot's soles.

        A table with times may lack other joints; values that it does not have, in columns that it has, are NaN.
        """
        from nao_kin.robot import serial_chain

        whole = self if self.missing is not None else replace(self, missing="0")
        table = None if self.of_motion else whole._log_columns(model, file)
        if table is None or not table.timed:
            return self.configurations(model, file, limits=limits)
        chains = [serial_chain(model, model.tree.root, sole) for sole in soles or model.semantics.soles]
        needed = {joint for chain in chains for joint in chain.coordinates}
        if self.missing is None and not needed <= model.joints_by_motor(table.names).keys():
            if not (self.columns or table.sensors):
                return self.configurations(model, file, limits=limits)
            whole = self  # the error says which joints are missing
        log = whole.log(model, file, limits=limits, hips=self.hips or "average")
        return Input(np.where(log.gaps, np.nan, log.q), log.times, True, log.sensors)

    @property
    def of_motion(self) -> bool:
        """Whether an option is given that only a motion has."""
        return any(option is not None for option in (self.posture, self.rate, self.timeline))

    def motion(
        self, model: RobotModel, file: str, *, limits: LimitPolicy, sampling: float | None = None, unread: bool = False
    ) -> tuple[Trajectory | None, Hips | None]:
        """Return the configurations of a motion; for another file, and `unread` input, None, and the rule for its hips.

        A motion is every file with times except a table of whole configurations without options of motions.
        """
        moves = not unread and is_motion(file)
        if self.joint or (self.of_motion and not moves):
            reason = f"{quoted(file)} gives whole configurations"
            raise BadArgument(f"{reason}; leave out --posture, --joint, --rate and --timeline")
        as_motion = self.of_motion or (sampling is not None and not (self.columns or self.ignore_other or self.missing))
        log = None if as_motion else self._log_columns(model, file)
        if not moves or log is not None:
            return None, "average" if self.hips is None and log is not None and log.timed else self.hips
        if self.columns:
            if not as_motion and replace(self, columns=None)._log_columns(model, file) is not None:
                return None, self.hips  # what is wrong with --columns is said where the table is read
            advice = "--missing gives the values of the joints that it lacks"
            raise BadArgument(
                f"--columns is for whole configurations; {quoted(file)} is read as a motion, unless {advice}"
            )
        source = MotionFile(file, None, self.deg, self.file_deg, self.timeline, self.ignore_other)
        motion, note = source.read_with_note(model)
        rest = self.posture if self.missing is None else self.value_of_missing
        path = motion.configurations(
            model,
            rate=sampling if self.rate is None else self.rate,
            missing="hold" if rest is None else rest,
            hips="average" if self.hips is None else self.hips,
        )
        q = self._within_limits(model, file, path, limits, in_degrees=bool(note) and not self.file_deg)
        print_note(*note)
        return replace(path, q=q), None

    @property
    def renamed(self) -> dict[str, str | None] | None:
        """The columns of --columns: name in the file → heading, None to leave the column out."""
        columns = settings(self.columns, "--columns", "NAME=HEADING, as in yaw=HeadYaw")
        return {name: heading or None for name, heading in columns.items()} or None

    @property
    def value_of_missing(self) -> str | float | None:
        """The posture or the number of --missing."""
        return posture_or_number(self.missing)

    def log(self, model: RobotModel, file: str, *, limits: LimitPolicy = "ignore", hips: Hips | None = None) -> Any:
        """Return the whole configurations in a file, as `nao_kin.stream.read_log` does, and print its notes."""
        from nao_kin.stream import read_log

        log = read_log(
            model,
            file,
            limits="ignore" if limits == "clamp" else limits,
            degrees=self.file_deg,
            columns=self.renamed,
            ignore_other=self.ignore_other,
            hips=hips,
            missing=self.value_of_missing,
        )
        q = _clamped(model, log.q) if limits == "clamp" else log.q
        print_note(*log.notes)
        return replace(log, q=q)

    def _log_columns(self, model: RobotModel, file: str) -> TableColumns | None:
        """Return the columns of a file of whole configurations; None for other files, and unread standard input."""
        from nao_kin.stream import log_columns

        data = None
        if file == "-":
            buffer = getattr(sys.stdin, "buffer", None)
            if not isinstance(buffer, io.BytesIO):
                return None
            data = buffer.getvalue()
        return log_columns(model, file, columns=self.renamed, missing=self.value_of_missing, data=data)

    def _within_limits(
        self, model: RobotModel, file: str, path: Trajectory, limits: LimitPolicy, *, in_degrees: bool
    ) -> Floats:
        """Return the configurations of a motion, clamped if requested; refuse the first one outside the limits."""
        if limits == "clamp":
            return _clamped(model, path.q)
        if limits == "ignore":
            return path.q
        inside = model.within_limits(path.q, limits=limits)
        if not inside.all():
            row = inside.tolist().index(False)
            first = model.limit_violations(path.q[row])[0]
            reason = f"at {path.times[row]:.6g} s outside the joint limits: {first.describe(degrees=self.deg)}"
            advice = "nao-kin motion check lists all, --limits clamp or --limits ignore accepts them"
            advice = "are these degrees (--file-deg)?" if in_degrees else advice
            raise BadInputFile(file, f"{reason}; {advice}")
        if limits == "measured":
            _moved_inside(model, path.q)[1].warn(model.unit)
        return path.q


def _moved_inside(model: RobotModel, q: Floats) -> tuple[Floats, OutsideRows]:
    """Return configurations (n, nq) moved inside the limits, and the changes that exceed the tolerance of limits."""
    from nao_kin.robot import OutsideRows

    inside, base = model.clamp(q), model.nq_base
    return inside, OutsideRows.of(q[:, base:], inside[:, base:], model.joint_names)


def _clamped(model: RobotModel, q: Floats) -> Floats:
    """Return configurations moved inside the limits, and print a note on their number and the largest change."""
    inside, changes = _moved_inside(model, q)
    note_clamped(model, changes, len(q))
    return inside


def note_clamped(model: RobotModel, changes: OutsideRows, rows: int) -> None:
    """Print a note on the changes of --limits clamp."""
    if changes.rows:
        unit = model.unit(changes.joint)
        largest = f"{changes.largest:.3g}{'' if unit == '1' else f' {unit}'}"
        moved = f"{changes.rows} of {rows} rows to the limits, by at most {largest} ({changes.joint})"
        print_note(f"--limits clamp moved {moved}")


def is_motion(file: str) -> bool:
    """Return whether a file, "-" for standard input, contains a motion; standard input can be read again afterwards."""
    from nao_kin.motion import is_motion_file

    if file != "-":
        return is_motion_file(file)
    if sys.stdin is None:
        return False
    try:
        data = read_bounded(sys.stdin.buffer, file)
    except OSError:
        return False  # the error is reported where the file is read
    sys.stdin = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8")
    return is_motion_file("-", data)
