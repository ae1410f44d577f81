"""The input of commands: a posture and joints, a file of whole configurations, or a motion."""

from __future__ import annotations

import io
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.csv_numbers import CsvHead, TableColumns, read_csv
from nao_kin._core.files import read_bounded, read_table_text
from nao_kin._core.text import abbreviated, quoted
from nao_kin.cli.options import argument, flag, option
from nao_kin.cli.output import print_note
from nao_kin.cli.shared import COLUMNS, HIPS, IGNORE_OTHER, TIMELINE
from nao_kin.errors import BadArgument, BadInputFile, CouplingViolated, OutsideLimits, UnknownName

if TYPE_CHECKING:
    from nao_kin.motion import Motion, Trajectory
    from nao_kin.robot import LimitPolicy, RobotModel


@dataclass(frozen=True)
class JointOptions:
    """The options of one configuration, and of the joints that a motion does not name."""

    posture: str | None = option(
        "NAME", "Start from a predefined posture; for a motion, the values of joints that it does not name."
    )
    joint: list[str] | None = option("NAME=VALUE", "Set a joint; repeatable. Other joints are at zero.")

    def configuration(self, model: RobotModel, *, deg: bool, limits: LimitPolicy) -> Floats:
        """Return the configuration; without a posture only the named joints must be inside their limits."""
        values = joint_values(self.joint, "--joint", model, deg)
        check_posture(model, self.posture)
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


def joint_values(settings: list[str] | None, option: str, model: RobotModel, deg: bool) -> dict[str, float]:
    """Return the values of an option of NAME=VALUE settings, by name [rad, m or ratio]."""
    values: dict[str, float] = {}
    for setting in settings or ():
        name, _, text = setting.partition("=")
        name = name.strip()
        value = finite_decimal(text)
        if value is None:
            raise BadArgument(f"{option} {quoted(setting)}: expected NAME=VALUE with a number, as in HeadYaw=0.3")
        if name in values:
            raise BadArgument(f"{option} names {abbreviated(name)} twice")
        values[name] = math.radians(value) if deg and model.unit(name) == "rad" else value
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
            raise BadArgument(f"{option} {quoted(text)}: {quoted(word)} is not a finite number")
        numbers.append(number)
    if count not in (None, len(numbers)):
        raise BadArgument(f"{option} {quoted(text)}: {len(numbers)} numbers, expected {count}")
    return numbers


def pairs_of(allow: list[str] | None) -> list[tuple[str, str]]:
    """Return the pairs of links of --allow."""
    pairs = []
    for text in allow or ():
        names = [name.strip() for name in text.split(",")]
        if len(names) != 2:
            raise BadArgument(f"--allow {quoted(text)}: expected two links, as in l_ankle,r_ankle")
        pairs.append((names[0], names[1]))
    return pairs


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


def _numbers_in(file: str, columns: list[str]) -> Floats:
    """Return the numbers in columns of a CSV file, shape (n, columns)."""

    def chosen(names: list[str], line: int) -> list[str]:
        for name in columns:
            if name not in names:
                raise UnknownName("column", name, names)
        return columns

    return read_columns(file, f"the column {quoted(columns[0])}", chosen)[1]


def frame_names(model: RobotModel, given: list[str] | None) -> list[str]:
    """Return the frames of --frame, which may have several with commas."""
    texts = [[text] if text in model.frame_names else text.split(",") for text in given or ()]
    return [name.strip() for parts in texts for name in parts if name.strip()]


def check_posture(model: RobotModel, posture: str | None) -> None:
    """Refuse a posture if the robot has none."""
    if posture is not None and not model.posture_names:
        raise BadArgument(f"--posture {quoted(posture)}: {model.name} has no predefined postures")


@dataclass(frozen=True)
class MotionFile:
    """A motion file of any format, and the options of its reading."""

    file: str = argument("FILE", "A motion file of any format, - for standard input.")
    from_: str | None = option("FORMAT", "Format of FILE. Default: by its content.")
    deg: bool = flag("Use degrees for a FILE without units, and in messages.")
    timeline: str | None = TIMELINE
    ignore_other: bool = IGNORE_OTHER

    def read(self, model: RobotModel) -> Motion:
        """Return the motion of a robot's joints."""
        from nao_kin.motion import read_motion

        return read_motion(
            self.file,
            format=self.from_,
            degrees=self.deg,
            timeline=self.timeline,
            robot=model,
            ignore_other=self.ignore_other,
        )


@dataclass(frozen=True)
class FileOptions:
    """The options of a file of whole configurations or of a motion."""

    columns: list[str] | None = COLUMNS
    ignore_other: bool = IGNORE_OTHER
    rate: float | None = option("N", "For a motion: configurations per second.")
    hips: str | None = HIPS
    timeline: str | None = TIMELINE

    def check(self, file: str | None, posture: str | None, *, moves: bool) -> None:
        """Refuse the options of a motion if there is no motion, and those of a file if there is no file."""
        if not moves:
            posture = None if file is None else posture
            refuse_for_motions(file, posture=posture, rate=self.rate, timeline=self.timeline)
        if file is None and (self.columns or self.ignore_other or self.hips):
            raise BadArgument("--columns, --ignore-other and --hips are for a file; name it")

    @property
    def renamed(self) -> dict[str, str | None] | None:
        """The columns of --columns: name in the file → heading, None to leave the column out."""
        columns: dict[str, str | None] = {}
        for setting in self.columns or ():
            name, sign, heading = setting.rpartition("=")
            if not sign or name in columns:
                wrong = "names a column twice" if name in columns else "expected NAME=HEADING, as in yaw=HeadYaw"
                raise BadArgument(f"--columns {quoted(setting)}: {wrong}")
            columns[name.strip()] = heading.strip() or None
        return columns or None

    def measured(self, file: str | None, **named: str | None) -> tuple[FileOptions, dict[str, Any]]:
        """Return the options to read the joints, and numbers in other columns, whose headings are given with commas.

        Each array has the shape (n, columns); `named` are options without their hyphens.
        """
        headings = {
            what: [name.strip() for name in text.split(",")] for what, text in named.items() if text is not None
        }
        if not headings:
            return self, {}
        option = f"--{next(iter(headings))}"
        if file is None or file == "-":
            why = "names columns of FILE; name it" if file is None else "reads FILE twice; name a file instead of -"
            raise BadArgument(f"{option} {why}")
        skipped = dict.fromkeys(f"{name}=" for columns in headings.values() for name in columns)
        arrays = {what: _numbers_in(file, columns) for what, columns in headings.items()}
        return replace(self, columns=[*(self.columns or ()), *skipped]), arrays

    def log(
        self, model: RobotModel, file: str, *, deg: bool, limits: LimitPolicy = "ignore", hips: str | None = None
    ) -> Any:
        """Return the whole configurations in a file, as `nao_kin.stream.read_log` does."""
        from nao_kin.stream import read_log

        rule: Any = hips
        return read_log(
            model, file, limits=limits, degrees=deg, columns=self.renamed, ignore_other=self.ignore_other, hips=rule
        )

    def configurations(
        self, model: RobotModel, file: str | None, joints: JointOptions, *, deg: bool, limits: LimitPolicy
    ) -> tuple[Floats, Floats | None, bool]:
        """Return configurations (n, nq) of a file or of the options, their times, and whether they are a list."""
        moves = file is not None and is_motion(file)
        self.check(file, joints.posture, moves=moves)
        if file is None:
            return joints.configuration(model, deg=deg, limits=limits)[None], None, False
        as_motion = joints.posture is not None or self.rate is not None or self.timeline is not None
        log = None if as_motion else self.log_columns(model, file)
        if moves and log is None:
            path = self.trajectory(model, file, deg=deg, posture=joints.posture, rate=self.rate)
            return model.clamp(path.q) if limits == "clamp" else path.q, path.times, True
        found = self.log(model, file, deg=deg, limits=limits, hips=self.hips)
        print_note(*found.notes)
        return found.q, found.times, found.many

    def log_columns(self, model: RobotModel, file: str) -> TableColumns | None:
        """Return the columns of a file of whole configurations; None for other files, and unread standard input."""
        from nao_kin.stream import log_columns

        data = None
        if file == "-":
            buffer = getattr(sys.stdin, "buffer", None)
            if not isinstance(buffer, io.BytesIO):
                return None
            data = buffer.getvalue()
        return log_columns(model, file, columns=self.renamed, data=data)

    def trajectory(
        self, model: RobotModel, file: str, *, deg: bool, posture: str | None, rate: float | None
    ) -> Trajectory:
        """Return the configurations of a motion."""
        from nao_kin.motion import HOLD

        motion = MotionFile(file, None, deg, self.timeline, self.ignore_other).read(model)
        check_posture(model, posture)
        rule: Any = "average" if self.hips is None else self.hips
        return motion.configurations(model, rate=rate, fill=HOLD if posture is None else posture, hips=rule)


def refuse_for_motions(file: str | None, **given: object) -> None:
    """Refuse options of motions for another file, or without a file (None)."""
    for name, value in given.items():
        if value is None:
            continue
        if file is None:
            raise BadArgument(f"--{name} is for a motion; name its FILE")
        if name == "posture":
            raise BadArgument("a file gives whole configurations; leave out --posture and --joint")
        raise BadArgument(f"--{name} is for a motion, and {quoted(file)} has no times: it gives whole configurations")


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
