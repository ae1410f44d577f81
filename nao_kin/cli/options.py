"""Options shared by several commands, the rules between them, and the loading of the robot."""

from __future__ import annotations

import inspect
import itertools
import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING as REQUIRED, Field, dataclass, field, fields, is_dataclass
from functools import wraps
from inspect import Parameter
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_type_hints

import typer
from typer.core import TyperCommand, TyperGroup

from nao_kin._core import files as atomic
from nao_kin._core.text import abbreviated, nearest_names, quoted
from nao_kin.cli.completion import SETUP, names_for
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel

_Function = TypeVar("_Function", bound=Callable[..., None])

# Pairs of contradicting options, by the names of their parameters, and the error.
_CONTRADICTIONS = (
    ("urdf", "robot", "--urdf and --robot name two robots; give one"),
    ("nao", "urdf", "--nao is a version of the NAO, and --urdf another robot; give one"),
    ("nao", "robot", "--nao is a version of the NAO, and --robot another robot; give one"),
    ("csv", "json", "--csv and --json are two formats; give one"),
    ("csv", "output", "--csv is for printed output, and the suffix of --output sets its format; leave out --csv"),
    ("file", "joint", "a file gives whole configurations; leave out --posture and --joint"),
)


def option(metavar: str | None, help: str, *names: str, default: Any = None) -> Any:
    """Return an option, as the default value of a command's parameter or of a field of a dataclass of options.

    `metavar` is the placeholder in the help, None for a choice, whose values are listed; REQUIRED makes it required.
    """

    def info(name: str) -> Any:
        flags = names or [f"--{name.strip('_').replace('_', '-')}"]
        return typer.Option(*flags, metavar=metavar, help=help, autocompletion=names_for(name, _robot))

    return field(default=default, metadata={"info": info})


def flag(help: str, *names: str, default: bool | None = False) -> Any:
    """Return an option without a value, as in `option`."""
    return option(None, help, *names, default=default)


def argument(metavar: str, help: str, default: Any = REQUIRED) -> Any:
    """Return a positional argument, as in `option`."""

    def info(name: str) -> Any:
        return typer.Argument(metavar=metavar, help=help, autocompletion=names_for(name, _robot))

    return field(default=default, metadata={"info": info})


# The names of the option for the file to write.
OUTPUT = "--output", "-o"

# Name of a command → its function, its example, and the options of its groups that it does not have.
COMMANDS: dict[str, tuple[Callable[..., None], str, Sequence[str]]] = {}


def command(name: str, example: str, without: Sequence[str] = ()) -> Callable[[_Function], _Function]:
    """Make a function a command of the program; `name` is "motion check" for a command in a group.

    Each parameter has an `option`, a `flag` or an `argument` as its default value. A parameter whose type is a
    dataclass adds the fields of the class as options, except those in `without`. `example` is the last line of the
    help.
    """

    def entered(function: _Function) -> _Function:
        COMMANDS[name] = function, example, without
        return function

    return entered


def with_options(name: str) -> Callable[..., None]:
    """Return the function of a command for typer, with an argument for each of its options.

    The annotations of the function are evaluated now and not before, because one of them may import a library.
    """
    function, _, without = COMMANDS[name]
    parameters, groups = [], dict[str, tuple[Any, list[str]]]()
    for parameter in inspect.signature(function, eval_str=True).parameters.values():
        kind = parameter.annotation
        if not is_dataclass(kind):
            parameters.append(_parameter(parameter.name, kind, parameter.default))
            continue
        types = get_type_hints(kind)
        options = [option for option in fields(kind) if option.name not in without]
        groups[parameter.name] = kind, [option.name for option in options]
        parameters += [_parameter(option.name, types[option.name], option) for option in options]

    @wraps(function)
    def run(**given: Any) -> None:
        together = {
            parameter: kind(**{option: given.pop(option) for option in options})
            for parameter, (kind, options) in groups.items()
        }
        function(**given, **together)

    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return run


def _parameter(name: str, kind: Any, given: Field[Any]) -> Parameter:
    """Return the parameter for typer, made from an `option`, a `flag` or an `argument`."""
    default = Parameter.empty if given.default is REQUIRED else given.default
    annotation = Annotated[kind, given.metadata["info"](name)]
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


# typer may carry its own copy of click; this is the base class of that copy's usage errors.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]

# Words that are often tried as a command → what was meant.
_MEANT = {
    "help": "nao-kin --help",
    "version": "nao-kin --version",
    "forward": "nao-kin fk",
    "inverse": "nao-kin ik",
    "convert": "nao-kin motion convert",
    "show": "nao-kin view",
}
# The same for options of a command.
_MEANT_OPTIONS = {
    ("ik", "--frame"): "FRAME is an argument, as in nao-kin ik LArm",
    ("ik", "--posture"): "--near prefers solutions near a posture",
    ("reach", "--frame"): "FRAME is an argument, as in nao-kin reach LArm",
}


class Group(TyperGroup):
    """A group of commands that makes the options of a command when it is called, and names the nearest commands."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the options before the command; the error for an unknown one says what was meant."""
        try:
            return list(super().parse_args(ctx, args))
        except UsageError as error:
            if not hasattr(error, "possibilities"):
                raise
            known = [name for parameter in self.get_params(ctx) for name in parameter.opts]
            raise _no_such_option(ctx, getattr(error, "option_name", ""), known) from None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that the first argument names; its options are made now, those of the others never."""
        if args[0] not in self.commands:
            near = (_MEANT[args[0].lower()],) if args[0].lower() in _MEANT else nearest_names(args[0], self.commands)
            advice = f"nearest: {', '.join(near)}" if near else f"see {ctx.command_path} --help"
            raise BadArgument(f"no such command {quoted(args[0])} ({advice})")
        name = " ".join([*ctx.command_path.split()[1:], args[0]])
        if name in COMMANDS:
            alone = typer.Typer(add_completion=False, rich_markup_mode=None)
            alone.command(args[0], cls=Command, epilog=COMMANDS[name][1])(with_options(name))
            self.commands[args[0]] = typer.main.get_command(alone)
        return super().resolve_command(ctx, args)


class Command(TyperCommand):
    """A command that refuses repeated and contradicting options, which click accepts."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Check which options are given, and how often, before their values."""
        if ctx.resilient_parsing:  # a shell completes words that are not all there yet
            return list(super().parse_args(ctx, args))
        known = [name for parameter in self.get_params(ctx) for name in (*parameter.opts, *parameter.secondary_opts)]
        try:
            values, _, order = self.make_parser(ctx).parse_args(list(args))
        except UsageError as error:
            if hasattr(error, "possibilities"):  # an unknown option
                raise _no_such_option(ctx, getattr(error, "option_name", ""), known) from None
            error.ctx = ctx  # type: ignore[attr-defined]  # absent if the argument of an option is missing
            raise
        if not any(parameter.is_eager for parameter in order):  # --help works with any other options
            for parameter, times in Counter(order).items():
                if times > 1 and not getattr(parameter, "multiple", False):
                    option = " or ".join([*parameter.opts, *parameter.secondary_opts])
                    raise BadArgument(f"{option} is given {'twice' if times == 2 else f'{times} times'}; give it once")
            # An argument is listed even if it is not given; one that takes several values is then empty or not a tuple.
            names = {str(parameter.name) for parameter in order}
            file = values.get("file")
            if not isinstance(file, str) and not (isinstance(file, tuple) and file):
                names.discard("file")
            for one, other, reason in _CONTRADICTIONS:
                if one in names and other in names:
                    raise BadArgument(reason)
        return list(super().parse_args(ctx, args))


def _no_such_option(ctx: Any, name: str, known: Sequence[str]) -> BadArgument:
    """Return the error for an unknown option, with what was meant, or the nearest options of the command."""
    names = [option.lstrip("-") for option in known if option.startswith("--")]
    near = nearest_names(name.lstrip("-"), names, similar=0.6)
    advice = f"nearest: {', '.join(f'--{option}' for option in near)}" if near else f"see {ctx.command_path} --help"
    if name.endswith("-completion"):  # what other programs with typer have
        shell = os.path.basename(os.environ.get("SHELL", ""))
        advice = f"to set up completion: {SETUP.get(shell, SETUP['bash'])}"
    return BadArgument(f"no such option: {abbreviated(name)} ({_MEANT_OPTIONS.get((ctx.info_name, name), advice)})")


@dataclass(frozen=True)
class OutOptions:
    """The file or folder to write, as an argument or an option."""

    out: str | None = argument("OUT", "The file or folder to write, - for standard output.", None)
    output: str | None = option("FILE", "The same as OUT.", *OUTPUT)

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

    nao: str = option("V", "NAO version: v3.2, v3.3, v4, v5 or v6.", default="v6")
    urdf: str | None = option("FILE", "Another robot, from a URDF, xacro or MJCF file.")
    robot: str | None = option("NAME", "Another robot, from example-robot-data or robot_descriptions.")
    package_dir: list[str] | None = option("DIR", "Search this folder for packages of --urdf; repeatable.")
    xacro: bool = flag(
        "Expand the file of --urdf as xacro, which runs code in it; files named .xacro are always expanded."
    )
    offsets: str | None = option("FILE", "Calibrated joints and frames of the robot, from a TOML file.")

    def load(self) -> RobotModel:
        """Return the robot that the options name, with the offsets of a file."""
        from nao_kin.robot import RobotModel, load_nao, load_robot, read_offsets

        # The offsets are read before the robot, which may have to be downloaded.
        offsets = None if self.offsets is None else read_offsets(self.offsets)
        if self.urdf is not None:
            if not self.urdf:
                raise BadArgument("--urdf is empty; expected a URDF, xacro or MJCF file")
            if self.urdf == "-":
                raise BadArgument("--urdf does not read standard input as -; give /dev/stdin, or the path of the file")
            robot = RobotModel.from_file(self.urdf, package_dirs=self.package_dir or (), xacro=self.xacro or None)
        elif self.package_dir:
            raise BadArgument("--package-dir is for the packages that a file names; give --urdf")
        elif self.xacro:
            raise BadArgument("--xacro is for the file that --urdf names; give --urdf")
        else:
            is_nao = self.robot is None or self.robot.lower() == "nao"
            robot = load_nao(self.nao) if is_nao else load_robot(str(self.robot))
        if offsets is None:
            return robot
        try:
            return robot.with_offsets(**offsets)
        except NaoKinError as error:
            raise BadInputFile(str(self.offsets), str(error)) from None


def _robot(parameters: dict[str, Any]) -> RobotModel:
    """Return the robot that the values of a command's parameters name."""
    given = {name: value for name, value in parameters.items() if name in RobotOptions.__dataclass_fields__}
    return RobotOptions(**given).load()


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
IGNORE_OTHER = flag("Skip columns that are neither a joint nor a time.")
HIPS = option(None, "For two HipYawPitch joints that differ. Default of a motion: average.")
MISSING = option("VALUE", "Values of joints without a column, empty cells and NaN: a posture, or a number.")
CONFIGURATIONS = argument("FILE", "CSV or JSON file of configurations, or a motion; - for standard input.", None)
TOLERANCE = option("M", "Overlap of links that is accepted [m].", default=0.0)
ALLOW = option("LINK,LINK", "Two links that may overlap; repeatable.")
EXACT = flag("Where hulls overlap, compare the meshes.")
CONTACTS = option("HEADINGS", "Columns of FILE, with commas: whether each sole touches the floor.")
GYRO = option("HEADINGS", "Columns of FILE, with commas: angular velocity about x, y and z [rad/s].")
FORCES = option("HEADINGS", "Columns of FILE, with commas: the force on each sole, or on each sensor.")
