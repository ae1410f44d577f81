"""Options: their declaration, those that several commands share, and the loading of the robot."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING as REQUIRED, dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar

from nao_kin._core import files as atomic
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel

_Function = TypeVar("_Function", bound=Callable[..., None])
# Option → the options without which it means nothing: one of "html|output", each of a tuple.
Needs = Mapping[str, str | tuple[str, ...]]


def option(metavar: str | None, help: str, *names: str, default: Any = None) -> Any:
    """Return an option, as the default value of a command's parameter or of a field of a dataclass of options.

    `metavar` is the placeholder in the help, None for a choice, whose values are listed.
    """
    return field(default=default, metadata={"metavar": metavar, "help": help, "names": names})


def flag(help: str, *names: str, default: bool | None = False) -> Any:
    """Return an option without a value, as in `option`."""
    return option(None, help, *names, default=default)


def argument(metavar: str, help: str, default: Any = REQUIRED) -> Any:
    """Return a positional argument, as in `option`."""
    return field(default=default, metadata={"metavar": metavar, "help": help})


class Declared(NamedTuple):
    """A command: its function, its example, the options of its groups that it does not have, and `Needs`."""

    function: Callable[..., None]
    example: str
    without: Sequence[str]
    needs: Needs


# Name of a command → the command.
COMMANDS: dict[str, Declared] = {}


def command(
    name: str, example: str, without: Sequence[str] = (), needs: Needs | None = None
) -> Callable[[_Function], _Function]:
    """Make a function a command of the program; `name` is "motion check" for a command in a group.

    Each parameter has an `option`, a `flag` or an `argument` as its default value. A parameter whose type is a
    dataclass adds the fields of the class as options, except those in `without`, and the class's own `needs`. `example`
    is the last line of the help.
    """

    def entered(function: _Function) -> _Function:
        COMMANDS[name] = Declared(function, example, without, needs or {})
        return function

    return entered


@dataclass(frozen=True)
class OutOptions:
    """The file or folder to write, as an argument or an option."""

    out: str | None = argument("OUT", "The file or folder to write, - for standard output.", None)
    output: str | None = option("FILE", "The same as OUT.")

    @property
    def path(self) -> str:
        """The path to write; "-" is standard output."""
        path = self.output if self.out is None else self.out
        if path is None or None not in (self.out, self.output):
            raise BadArgument("give one file or folder to write, as OUT or with --output")
        return "/dev/stdout" if path == "-" else path


@dataclass(frozen=True)
class OutputOptions:
    """The options of a command that writes files."""

    force: bool = flag("Replace the output file if it exists.")
    json: bool = flag("Print JSON.")

    def check(
        self, outputs: Mapping[str, str | None], *, csv: bool = False, continued: bool = False, kind: str = ""
    ) -> None:
        """Refuse files that may not or cannot be written, before anything is loaded or drawn.

        `outputs` maps each option ("" for an argument) to its file (None if not given); with `csv` the option --csv
        uses standard output. An existing file of --output that the command continues is not refused. `kind` is the
        format of --output, if there is only one.
        """
        given = {option: path for option, path in outputs.items() if path is not None}
        for option, path in given.items():
            atomic.check_writable(path, kind=kind if option == "--output" else option.removeprefix("--"))
            atomic.check_replaceable(path, overwrite=self.force or (continued and option == "--output"))
        for option, path in given.items():
            if (self.json or csv) and atomic.leads_to_standard_output(path):
                printed = "--json" if self.json else "--csv"
                raise BadArgument(f"{option} {path} and {printed} both write to standard output; give one".lstrip())
        for (first, path), (second, other) in itertools.combinations(given.items(), 2):
            if os.path.realpath(path) == os.path.realpath(other):
                raise BadArgument(f"{first} and {second} name one file, {path}; give two")


@dataclass(frozen=True)
class RobotOptions:
    """The options that name a robot."""

    nao: str | None = option("V", "NAO version: v3.2, v3.3, v4, v5 or v6. Default: that of --offsets, or v6.")
    urdf: str | None = option("FILE", "Another robot, from a URDF, xacro or MJCF file.")
    robot: str | None = option("NAME", "Another robot, from example-robot-data or robot_descriptions.")
    package_dir: list[str] | None = option("DIR", "Search this folder for packages of --urdf; repeatable.")
    xacro: bool = flag(
        "Expand the file of --urdf as xacro, which runs code in it; files named .xacro are always expanded."
    )
    offsets: str | None = option("FILE", "What was measured of the robot: TOML, or files of B-Human and HULKs.")
    needs: ClassVar[Needs] = {"package_dir": "urdf", "xacro": "urdf"}

    def load(self) -> RobotModel:
        """Return the robot that the options name, with the offsets of a file."""
        from nao_kin.robot import RobotModel, load_nao, load_robot, read_offsets

        # The offsets are read before the robot, which may have to be downloaded.
        offsets = None if self.offsets is None else read_offsets(self.offsets)
        if self.urdf is not None:
            if self.urdf == "-":
                raise BadArgument("--urdf does not read standard input as -; give /dev/stdin, or the path of the file")
            robot = RobotModel.from_file(self.urdf, package_dirs=self.package_dir or (), xacro=self.xacro or None)
        else:
            is_nao = self.robot is None or self.robot.lower() == "nao"
            version = self.nao or (offsets or {}).get("version")
            robot = load_nao(version) if is_nao else load_robot(str(self.robot))
        if offsets is None:
            return robot
        try:
            return robot.with_offsets(**offsets)
        except NaoKinError as error:
            raise BadInputFile(str(self.offsets), str(error)) from None


# Options that are missing in commands for the NAO only.
OTHER_ROBOTS = ("urdf", "robot", "package_dir", "xacro")

# --- Options and arguments of several commands, each with the same word, placeholder and help everywhere.

JSON = flag("Print JSON.")
CSV = flag("Print CSV.")
DEG = flag("Angles that are typed or printed are in degrees; hands stay 0 to 1.")
FILE_DEG = flag("Angles in a file that names no unit are in degrees.")
OUTSIDE = "Treatment of joints outside their limits."
LIMITS = option(None, OUTSIDE, default="enforce")
FRAME = option("FRAME", "A frame; repeatable, or several with commas.")
REFERENCE = option("FRAME", "Give poses in this frame. Default: the root link.")
SEED = option("N", "Seed of random numbers.", default=0)
TIMELINE = option("NAME", "One of several motions in the file, by name or number.")
COLUMNS = option(
    "NAME=HEADING",
    "Read column NAME as HEADING: yaw=HeadYaw, 'ms=time [ms]'; NAME= skips the column; repeatable.",
)
IGNORE_OTHER = flag("Skip columns of unknown names.")
HIPS = option(None, "For two HipYawPitch joints that differ. Default of a motion: average.")
MISSING = option("VALUE", "Values of joints without a column, empty cells and NaN: a posture, or a number.")
CONFIGURATIONS = argument("FILE", "CSV or JSON file of configurations, or a motion; - for standard input.", None)
