"""Completion of the command line by a shell: of commands, options, choices, and the robot's names."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from contextlib import redirect_stderr
from typing import TYPE_CHECKING, Any

from typer.completion import completion_init  # type: ignore[attr-defined]  # imported there from a private module

if TYPE_CHECKING:
    import typer

    from nao_kin.robot import RobotModel

# The environment variable with which a shell asks, by typer's rule for the program's name.
VARIABLE = "_NAO_KIN_COMPLETE"

# Parameter of commands → the names that complete its value, of the robot that the other options name.
_NAMES: dict[str, Callable[[RobotModel], Iterable[str]]] = {
    "posture": lambda robot: robot.posture_names,
    "near": lambda robot: robot.posture_names,
    "frame": lambda robot: robot.frame_names,
    "reference": lambda robot: robot.frame_names,
}


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


def names_for(parameter: str) -> Callable[[Any, str], list[str]] | None:
    """Return typer's function for the names that complete the value of a parameter; None if there are none."""
    names = _NAMES.get(parameter)
    if names is None:
        return None

    def completed(ctx: Any, incomplete: str) -> list[str]:
        from nao_kin.cli.options import RobotOptions

        given = {name: value for name, value in ctx.params.items() if name in RobotOptions.__dataclass_fields__}
        return list(names(RobotOptions(**given).load()))

    return completed
