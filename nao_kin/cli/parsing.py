"""From the words of a command line to the call of a command: its options, their values, and completion by a shell."""

from __future__ import annotations

import inspect
import io
import itertools
import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import redirect_stderr
from dataclasses import MISSING as REQUIRED, Field, fields, is_dataclass
from functools import cache, wraps
from inspect import Parameter
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

import typer
from typer.completion import completion_init  # type: ignore[attr-defined]  # imported there from a private module
from typer.core import TyperCommand, TyperGroup

import nao_kin as nk
from nao_kin._core.arrays import finite_decimal
from nao_kin._core.text import abbreviated, nearest_names, quoted
from nao_kin.cli import sample
from nao_kin.cli.options import COMMANDS, Needs, RobotOptions
from nao_kin.cli.slips import ELSEWHERE, mended
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel

# Options of which each excludes the others.
_EXCLUDING = (
    ("nao", "urdf", "robot"),
    ("csv", "json", "latex"),
    ("symbolic", "csv"),
    ("symbolic", "latex"),
    ("latex", "deg"),
    ("csv", "output"),
    ("dh", "typed"),
    ("dh", "rule"),
    ("dh", "tolerance"),
    ("posture", "missing"),
    ("file", "target"),
    ("numeric", "analytic"),
    ("direction", "criterion"),
    ("file", "pixel", "point"),
)
# The options that name a robot stand under a heading of their own, the last one.
_ROBOT = "Robot"
_OF_ROBOTS = {option.name for option in fields(RobotOptions)}


class Option(NamedTuple):
    """An option or an argument: the name and the type of its parameter, and what is declared."""

    name: str
    kind: Any
    field: Field[Any]

    @property
    def flags(self) -> tuple[str, ...]:
        """The words that give the option; none for an argument."""
        names: tuple[str, ...] | None = self.field.metadata.get("names")
        if names is None:
            return ()
        return names or (f"--{self.name.strip('_').replace('_', '-')}", *(["-o"] if self.name == "output" else []))

    @property
    def label(self) -> str:
        """The option in a message."""
        return self.flags[0].partition("/")[0] if self.flags else self.field.metadata["metavar"].strip("[]")

    @property
    def several(self) -> bool:
        """Whether it takes a list of values."""
        return get_origin(self.kind) is list

    @property
    def choices(self) -> tuple[str, ...]:
        """The values of an option with choices."""
        return get_args(self.kind) if get_origin(self.kind) is Literal else ()

    def parameter(self) -> Parameter:
        """Return the parameter for typer, to which each value is text."""
        default, metavar, help = self.field.default, self.field.metadata["metavar"], self.field.metadata["help"]
        if default is not None and default is not REQUIRED and not isinstance(default, bool):
            help += f" Default: {default:g}." if isinstance(default, float) else f" Default: {default}."
        kind: Any = bool if self.kind is bool else list[str] if self.several or self.flags else str
        about: dict[str, Any] = {"help": help, "show_default": False}
        about |= {"rich_help_panel": _ROBOT} if self.name in _OF_ROBOTS else {}
        if self.kind is not bool:
            about |= {"metavar": metavar or f"<{'|'.join(self.choices)}>", "autocompletion": _completed(self)}
        info = typer.Option(*self.flags, **about) if self.flags else typer.Argument(**about)
        missing = Parameter.empty if default is REQUIRED else None
        kind = kind if default is REQUIRED else kind | None
        return Parameter(self.name, Parameter.KEYWORD_ONLY, default=missing, annotation=Annotated[kind, info])

    def value(self, given: Any) -> Any:
        """Return the value of what was given: a flag, a text, or texts."""
        texts = given if isinstance(given, list) else [given]
        if self.flags and self.kind is not bool and not all(map(str.strip, texts)):
            raise BadArgument(f"{self.label} is empty")
        if self.kind is bool or self.several:
            return given
        if len(texts) > 1:
            times = "twice" if len(texts) == 2 else f"{len(texts)} times"
            raise BadArgument(f"{self.label} is given {times}; give it once")
        text = texts[0]
        if self.choices and text not in self.choices:
            about = f" ({self.field.metadata['help']})" if text.lower() in self.field.metadata["help"].lower() else ""
            raise BadArgument(f"{self.label} {quoted(text)}: expected one of {', '.join(self.choices)}{about}")
        if self.kind not in (int, float):
            return text
        number = finite_decimal(text)
        if number is None or (self.kind is int and not number.is_integer()):
            raise BadArgument(f"{self.label} {quoted(text)}: expected a {'whole ' if self.kind is int else ''}number")
        return number if self.kind is float else int(text) if text.strip().lstrip("+-").isdigit() else int(number)


def _option(name: str, kind: Any, declared: Field[Any]) -> Option:
    alone = [part for part in get_args(kind) if part is not NoneType] if get_origin(kind) in (Union, UnionType) else []
    return Option(name, alone[0] if alone else kind, declared)


@cache
def options_of(name: str) -> tuple[dict[str, Option], dict[str, tuple[Any, list[str]]], Needs]:
    """Return the options of a command by name, its groups (class and names) by parameter, and what each option needs.

    The annotations of the function are evaluated now and not before, because one of them may import a library.
    """
    declared = COMMANDS[name]
    options, groups, needs = dict[str, Option](), dict[str, tuple[Any, list[str]]](), dict(declared.needs)
    for parameter in inspect.signature(declared.function, eval_str=True).parameters.values():
        kind = parameter.annotation
        if not is_dataclass(kind):
            options[parameter.name] = _option(parameter.name, kind, parameter.default)
            continue
        types = get_type_hints(kind)
        members = [member for member in fields(kind) if member.name not in declared.without]
        groups[parameter.name] = kind, [member.name for member in members]
        options |= {member.name: _option(member.name, types[member.name], member) for member in members}
        needs |= getattr(kind, "needs", {})
    return options, groups, needs


def with_options(name: str) -> Callable[..., None]:
    """Return the function of a command for typer, with an argument for each of its options."""
    options, groups, needs = options_of(name)
    function = COMMANDS[name].function

    @wraps(function)
    def run(**texts: Any) -> None:
        given = {option: text for option, text in texts.items() if text not in (None, [], ())}
        _check(options, given, needs)
        values = {
            option: about.value(given[option]) if option in given else about.field.default
            for option, about in options.items()
        }
        together = {
            parameter: kind(**{option: values.pop(option) for option in members})
            for parameter, (kind, members) in groups.items()
        }
        function(**values, **together)

    parameters = [option.parameter() for option in options.values()]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return run


def _check(options: Mapping[str, Option], given: Mapping[str, Any], needs: Needs) -> None:
    """Refuse options that exclude each other, and options without those that they need."""
    for group in _EXCLUDING:
        for one, other in itertools.combinations([name for name in group if name in given], 2):
            raise BadArgument(f"{options[one].label} and {options[other].label} exclude each other; give one")
    for name, needed in needs.items():
        for names in (needed,) if isinstance(needed, str) else needed:
            if name in given and not given.keys() & set(names.split("|")):
                needed_labels = " or ".join(options[other].label for other in names.split("|"))
                raise BadArgument(f"{options[name].label} needs {needed_labels}")


# typer carries its own copy of click; this is the base class of that copy's usage errors.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]


def usage_message(error: Any) -> str:
    """Return the message of a usage error, with the nearest options for an unknown one."""
    see = "" if error.ctx is None else f"see {error.ctx.command_path} --help"
    if not hasattr(error, "possibilities"):
        return abbreviated(error.format_message().rstrip(".")) + (f" ({see})" if see else "")
    name, given = error.option_name, error.ctx.command.get_params(error.ctx)
    known, word = [flag[2:] for option in given for flag in option.opts if flag.startswith("--")], name.lstrip("-")
    near = [f"{option.opts[0]} {word}" for option in given if word in str(option.metavar).strip("<>").split("|")]
    near = near or [f"--{flag}" for flag in nearest_names(word, known, similar=0.7)]
    advice = f"nearest: {', '.join(near)}" if near else see
    if isinstance(error.ctx.command, Group) and word in _OF_ROBOTS | {"json", "deg"}:
        advice = "the options of a command stand after it"
    if name.endswith("-completion"):  # what other programs with typer have
        shell = os.path.basename(os.environ.get("SHELL", ""))
        advice = f"to set up completion: {SETUP.get(shell, SETUP['bash'])}"
    return f"no such option: {abbreviated(name)} ({advice})"


def _write_under_headings(formatter: Any, rows: Iterable[tuple[str, Any]]) -> None:
    """Write the rows of a help under their headings, those of a robot last; None is left out."""
    sections: dict[str, list[Any]] = {}
    for heading, row in rows:
        if row is not None:
            sections.setdefault(heading, []).append(row)
    for heading in sorted(sections, key=_ROBOT.__eq__):
        with formatter.section(heading):
            formatter.write_dl(sections[heading])


class Command(TyperCommand):
    """A command whose help has the options under headings."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments, options, and the options that name a robot."""
        kinds = {"argument": "Arguments", "option": "Options"}
        given = self.get_params(ctx)
        rows = ((getattr(one, "rich_help_panel", None) or kinds[one.param_type_name], one) for one in given)
        _write_under_headings(formatter, ((heading, one.get_help_record(ctx)) for heading, one in rows))


@cache
def _made(name: str) -> Any:
    """Return a command with its options; programs that call several commands make each once."""
    alone = typer.Typer(add_completion=False, rich_markup_mode=None)
    alone.command(name.split()[-1], cls=Command, epilog=COMMANDS[name].example)(with_options(name))
    return typer.main.get_command(alone)


class Group(TyperGroup):
    """A group of commands that makes the options of a command when it is called, and names the nearest commands."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands by what they are for."""
        width = formatter.width - 6 - max(map(len, self.commands))
        commands: Any = self.commands.items()
        rows = ((one.rich_help_panel, (name, one.get_short_help_str(width))) for name, one in commands)
        _write_under_headings(formatter, rows)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that the first argument names; its options are made now, those of the others never."""
        if args[0] not in self.commands:
            near = nearest_names(args[0], self.commands, similar=0.75)
            advice = f"nearest: {', '.join(near)}" if near else f"see {ctx.command_path} --help"
            advice = f"that is {ELSEWHERE[args[0]]}" if args[0] in ELSEWHERE else advice
            advice = f"a command comes before a file; {advice}" if os.path.exists(args[0]) else advice
            raise BadArgument(f"no such command {quoted(args[0])} ({advice})")
        name = " ".join([*ctx.command_path.split()[1:], args[0]])
        if name in COMMANDS:
            return args[0], _made(name), mended(args[1:], options_of(name)[0])
        return super().resolve_command(ctx, args)


# --- Completion by a shell: of commands, options, choices and names.

# The environment variable with which a shell asks, by typer's rule for the program's name.
VARIABLE = "_NAO_KIN_COMPLETE"

# Shell → the line that sets its completion up, once.
SETUP = {
    "bash": f"{VARIABLE}=source_bash nao-kin >> ~/.bashrc",
    "zsh": f"{VARIABLE}=source_zsh nao-kin >> ~/.zshrc",
    "fish": "mkdir -p ~/.config/fish/completions; "
    f"{VARIABLE}=source_fish nao-kin > ~/.config/fish/completions/nao-kin.fish",
}


# Option → the names that complete its value, from the table that also checks the value, given a function that loads
# the robot of the command line.
_NAMES: dict[str, Callable[[Callable[[], RobotModel]], Iterable[str]]] = {
    **dict.fromkeys(("posture", "near", "missing"), lambda load: load().posture_names),
    **dict.fromkeys(("frame", "reference"), lambda load: load().frame_names),
    "joints": lambda load: load().joint_names,
    "nao": lambda load: nk.robot.nao.VERSIONS,
    "robot": lambda load: ("nao", *nk.robot.robot_names()),
    "format_": lambda load: nk.export.FORMATS,
    "from_": lambda load: nk.motion.FORMATS,
    "to": lambda load: [name for name, known in nk.motion.FORMATS.items() if known.write is not None],
    "sample_names": lambda load: sample.NAMES,
}


def _completed(option: Option) -> Callable[[Any, str], list[str]] | None:
    """Return typer's function for the names that complete the value of an option; None if there are none."""
    table = _NAMES.get(option.name)
    if table is None and not option.choices:
        return None

    def completed(ctx: Any, incomplete: str) -> list[str]:
        before = incomplete[: incomplete.rfind(",") + 1] if option.name == "frame" else ""  # several with commas
        return [before + name for name in (option.choices if table is None else table(lambda: _robot(ctx.params)))]

    return completed


def _robot(parameters: Mapping[str, Any]) -> RobotModel:
    """Return the robot that the words of a line name.

    A key that is pressed neither waits for a named pipe nor runs the code of a xacro file.
    """
    texts = {name: text for name, text in parameters.items() if text}
    given = {
        option.name: texts[option.name] if option.name in ("package_dir", "xacro") else texts[option.name][-1]
        for option in fields(RobotOptions)
        if option.name in texts
    }
    read = [given[name] for name in ("urdf", "offsets") if name in given]
    if "xacro" in given or any(path.endswith(".xacro") for path in read) or not all(map(os.path.isfile, read)):
        raise BadArgument("no robot in a regular file of data")
    return RobotOptions(**given).load()


def complete(app: typer.Typer) -> int:
    """Print what completes the words in the environment, or the script for a shell, and return the exit code.

    Nothing else is printed: a message would stand in the middle of the line that is typed.
    """
    completion_init()
    try:
        with redirect_stderr(io.StringIO()):
            app(prog_name="nao-kin", complete_var=VARIABLE)
    except SystemExit as end:
        return int(end.code or 0)
    except Exception:
        return 1  # the words before are no command
    return 0
