"""The `nao-kin` program: its commands, and one line for each error and warning."""

from __future__ import annotations

import io
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cache
from typing import Annotated, Any

import typer

import nao_kin
from nao_kin._core.extras import with_remedy
from nao_kin._core.process import before_ending
from nao_kin._core.text import abbreviated
from nao_kin.cli import (  # noqa: F401
    balance,
    camera,
    doctor,
    export,
    fk,
    ik,
    motion,
    naoqi,
    reach,
    robots,
    sample,
    state,
    view,
)
from nao_kin.cli.options import COMMANDS
from nao_kin.cli.output import print_note
from nao_kin.cli.parsing import VARIABLE, Group, UsageError, complete, usage_message
from nao_kin.errors import DegreesWarning, NaoKinError, NaoKinWarning

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
_motion = typer.Typer(
    name="motion",
    cls=Group,
    epilog=COMMANDS["motion convert"].example,
    invoke_without_command=True,
    rich_markup_mode=None,
)
# What commands are for → their names, in the order of the help; `motion` is a group of commands.
_JOBS = {
    "A robot": "info joints fk ik reach collisions",
    "A robot on the floor, its cameras and logs": "balance state camera calibrate",
    "Motions": "motion imitate",
    "Pictures, and files for other programs": "view export",
    "NAOqi": "serve run live",
    "This installation": "sample check doctor warmup",
}
_OF_MOTIONS = {"Commands": "convert check info plot"}
for _group, _jobs in ((app, _JOBS), (_motion, _OF_MOTIONS)):
    for _job, _names in _jobs.items():
        for _name in _names.split():
            if _name == "motion":
                app.add_typer(_motion, rich_help_panel=_job)
                continue
            # Listed in the help without its options, which `Group` makes when the command is called.
            _about = COMMANDS[_name if _group is app else f"motion {_name}"].function.__doc__
            _group.command(_name, help=_about, rich_help_panel=_job)(lambda: None)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the program with `arguments` (default: those of this process), and return its exit code."""
    if sys.stderr is None:
        # Otherwise Python prints text for standard error on standard output.
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    if sys.stdout is None:
        return _fail("standard output is closed")
    if VARIABLE in os.environ:
        return complete(app)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without ° or … shows ? instead
    try:
        with _terminal_restored(), _warnings_as_lines():
            code = _command()(None if arguments is None else list(arguments), "nao-kin", standalone_mode=False)
            sys.stdout.flush()
            return int(code or 0)
    except NaoKinError as error:
        return _fail(str(error))
    except UsageError as error:
        return _fail(usage_message(error))
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


@cache
def _command() -> Any:
    """Return the program as a command with all others; a process that calls it several times makes it once."""
    return typer.main.get_command(app)


def _fail(message: str) -> int:
    print_note(message)
    return 2


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


@_motion.callback()
def _motion_program(context: typer.Context) -> None:
    """Convert, check, describe and draw motion files.

    Formats are recognised by content and suffix: csv, json, npz, webots, runswift, hulks, motion2, python (Choregraphe
    export), xar and naoqi (arguments of angleInterpolation); naodevils, bhuman and xap can only be read.
    """
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
