"""The `nao-kin` program: its commands, and one line for each error and warning."""

from __future__ import annotations

import io
import os
import re
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Annotated, Any

import typer

import nao_kin
from nao_kin._core.extras import with_remedy
from nao_kin._core.process import before_ending
from nao_kin._core.text import MAX_ECHOED, abbreviated, quoted
from nao_kin.cli import (  # noqa: F401
    balance,
    calibrate,
    camera,
    collisions,
    completion,
    doctor,
    export,
    fk,
    ik,
    imitate,
    motion,
    naoqi,
    odometry,
    reach,
    robots,
    sample,
    view,
)
from nao_kin.cli.options import COMMANDS, Group, UsageError
from nao_kin.cli.output import print_note
from nao_kin.errors import DegreesWarning, NaoKinError, NaoKinWarning

# A quoted text, or a word, that is too long for a message.
_LONG = re.compile(rf"'[^']{{{MAX_ECHOED},}}'|\S{{{MAX_ECHOED + 1},}}")

# Kinds of errors of typer's validator → what was expected.
_EXPECTED = {"float_parsing": "a number", "int_parsing": "a whole number", "int_from_float": "a whole number"}
# What typer says without this validator, as version 0.26 does.
_EXPECTED |= {"float": "a number", "integer": "a whole number"}
_INVALID = re.compile(r"Invalid value for '([^']+)': (?:'(.*)' is not a valid (float|integer)|(.*))", re.DOTALL)

app = typer.Typer(
    name="nao-kin",
    cls=Group,
    context_settings={"help_option_names": ["--help", "-h"]},
    help="Kinematics of the NAO humanoid.",
    epilog="Example: nao-kin fk --posture StandInit --frame LArm",
    invoke_without_command=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
_ORDER = ("info", "joints", "dh", "fk", "ik", "check", "reach", "view", "export", "sample")
_WORLD = ("balance", "odometry", "state", "collisions", "camera", "calibrate")
_SERVICES = ("serve", "run", "live", "warmup", "doctor")
_OF_MOTIONS = ("motion convert", "motion check", "motion info", "motion plot")
for _name in (*_ORDER, *_WORLD, "imitate", *_SERVICES, *_OF_MOTIONS):
    # Listed in the help without its options, which `Group` makes when the command is called.
    _group = motion.app if _name in _OF_MOTIONS else app
    _group.command(_name.removeprefix("motion "), help=COMMANDS[_name][0].__doc__)(lambda: None)
app.add_typer(motion.app)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the program with `arguments` (default: those of this process), and return its exit code."""
    if sys.stderr is None:
        # Otherwise Python prints text for standard error on standard output.
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    if sys.stdout is None:
        return _fail("standard output is closed")
    if completion.VARIABLE in os.environ:
        return completion.complete(app)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without ° or … shows ? instead
    try:
        with _terminal_restored(), _warnings_as_lines():
            code = app(args=None if arguments is None else list(arguments), prog_name="nao-kin", standalone_mode=False)
            sys.stdout.flush()
            return int(code or 0)
    except NaoKinError as error:
        return _fail(str(error))
    except UsageError as error:
        path = getattr(getattr(error, "ctx", None), "command_path", "nao-kin")
        return _fail(f"{_usage(error)} (see {path} --help)")
    except ImportError as error:
        return _fail(f"{with_remedy(str(error))} (see nao-kin doctor)")
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except (BrokenPipeError, SystemExit):
        # The reader of the output has closed it, and typer or rich exits. Let Python flush the output without an error.
        _discard_output()
        return 0
    except MemoryError as error:
        return _fail(f"not enough memory{f': {error}' if str(error) else ''}")
    except OSError as error:
        _discard_output()
        what = "write the output" if error.filename is None else f"use {abbreviated(error.filename)}"
        return _fail(f"cannot {what}: {error.strerror or error}")


def _usage(error: Any) -> str:
    """Return the message of a usage error; of a value that typer's validator refused, with the option and the value."""
    refused = getattr(error.__cause__, "errors", None)
    if refused is None or error.param is None:
        message = str(error.format_message()).rstrip(".")
        invalid = _INVALID.fullmatch(message)
        if invalid is None:
            return _LONG.sub(_shortened, message)
        name, value, kind, reason = invalid.groups()
    else:
        first, flags = refused()[0], error.param.opts
        name = next((flag for flag in flags if flag.startswith("--")), error.param.metavar or error.param.name)
        value, kind, reason = first["input"], first["type"], first.get("ctx", {}).get("error", first["msg"])
    if kind in _EXPECTED:
        return f"{name} {quoted(value)}: expected {_EXPECTED[kind]}"
    return _LONG.sub(_shortened, f"{name}: {reason}".rstrip("."))


def _fail(message: str) -> int:
    print_note(message)
    return 2


def _shortened(match: re.Match[str]) -> str:
    text = match.group()
    return f"'{abbreviated(text[1:-1])}'" if text.startswith("'") and text.endswith("'") else abbreviated(text)


def _discard_output() -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Print each of the library's own warnings once, as one line; other warnings as Python does."""
    printed = set[str]()
    with warnings.catch_warnings():
        others = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if not issubclass(category, NaoKinWarning):
                others(message, category, *place, **more)
                return
            text = str(message)
            if issubclass(category, DegreesWarning) and "deg2rad" in text:  # with the option in place of the function
                text = f"{text.partition(';')[0]}; are these degrees (--deg, of a file --file-deg)?"
            if text not in printed:
                printed.add(text)
                print_note(text)

        warnings.showwarning = show
        warnings.simplefilter("always", NaoKinWarning)
        yield


def _terminal_restored() -> AbstractContextManager[object]:
    """On a signal, restore the terminal's cursor and remove the progress bar."""

    def restore() -> None:
        os.write(2, b"\r\x1b[K\x1b[?25h")

    terminal = os.name == "posix" and os.isatty(2) and os.environ.get("TERM", "dumb") != "dumb"
    return before_ending(restore) if terminal else nullcontext()


def _print_version(context: typer.Context, wanted: bool) -> None:
    if wanted and not context.resilient_parsing:
        typer.echo(nao_kin.__version__)
        raise typer.Exit


@app.callback()
def _program(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """Kinematics of the NAO humanoid."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
