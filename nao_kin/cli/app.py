"""The `nao-kin` program: its commands, and errors as one line."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence
from typing import Annotated, NoReturn

import typer

import nao_kin
from nao_kin.cli import check, doctor, fk, info, joints, view
from nao_kin.errors import NaoKinError

app = typer.Typer(
    name="nao-kin",
    help="Kinematics of the NAO humanoid.",
    epilog="Example: nao-kin fk --posture StandInit --frame LArm",
    invoke_without_command=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for _command in (info, joints, fk, check, view, doctor):
    _command.register(app)

# typer carries its own copy of click; this is the class of its "you called it wrongly" errors, whichever copy it is.
_UsageError: type[Exception] = typer.BadParameter.__mro__[1]


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the program and exit: 0 when all is well, 1 when a check failed, 2 for bad input, 130 when interrupted."""
    sys.exit(run(arguments))


def run(arguments: Sequence[str] | None = None) -> int:
    """The exit code of the program called with `arguments` (default: those of this process)."""
    if sys.stdout is None:
        return _fail("standard output is closed")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without ° or … shows ? and goes on
    try:
        code = app(args=None if arguments is None else list(arguments), prog_name="nao-kin", standalone_mode=False)
        sys.stdout.flush()
        return int(code or 0)
    except NaoKinError as error:
        return _fail(str(error))
    except _UsageError as error:
        context = getattr(error, "ctx", None)
        path = getattr(context, "command_path", "nao-kin")
        message = error.format_message() if hasattr(error, "format_message") else str(error)
        return _fail(f"{message.rstrip('.')} (see {path} --help)")
    except ImportError as error:
        return _fail(f"{error} (see nao-kin doctor)")
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except BrokenPipeError:
        # Whoever read the output has seen enough; keep the interpreter from complaining when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _fail(f"cannot write the output: {error.strerror or error}")


def _fail(message: str) -> int:
    print(f"nao-kin: {' '.join(message.split())}", file=sys.stderr)
    return 2


def _print_version(wanted: bool) -> None:
    if wanted:
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
