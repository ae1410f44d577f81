"""Completion of the command line by a shell: of commands, options, choices and names."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterable
from contextlib import redirect_stderr
from typing import TYPE_CHECKING, Any

from typer.completion import completion_init  # type: ignore[attr-defined]  # imported there from a private module

from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    import typer

    from nao_kin.robot import RobotModel

# The environment variable with which a shell asks, by typer's rule for the program's name.
VARIABLE = "_NAO_KIN_COMPLETE"

# Shell → the line that sets its completion up, once.
SETUP = {
    "bash": f"{VARIABLE}=source_bash nao-kin >> ~/.bashrc",
    "zsh": f"{VARIABLE}=source_zsh nao-kin >> ~/.zshrc",
    "fish": "mkdir -p ~/.config/fish/completions; "
    f"{VARIABLE}=source_fish nao-kin > ~/.config/fish/completions/nao-kin.fish",
}


def _versions(load: Callable[[], RobotModel]) -> Iterable[str]:
    from nao_kin.robot.nao import VERSIONS

    return VERSIONS


def _robots(load: Callable[[], RobotModel]) -> Iterable[str]:
    from nao_kin.robot import robot_names

    return ("nao", *robot_names())


def _exports(load: Callable[[], RobotModel]) -> Iterable[str]:
    from nao_kin.export import FORMATS

    return FORMATS


def _read_formats(load: Callable[[], RobotModel]) -> Iterable[str]:
    from nao_kin.motion import FORMATS

    return FORMATS


def _written_formats(load: Callable[[], RobotModel]) -> Iterable[str]:
    from nao_kin.motion import FORMATS

    return [name for name, known in FORMATS.items() if known.write is not None]


def _samples(load: Callable[[], RobotModel]) -> Iterable[str]:
    from nao_kin.cli.sample import NAMES

    return NAMES


# Parameter of commands → the names that complete its value, given a function that loads the robot of the command line.
# Each is the table that also checks the value; a parameter of a type with choices is completed by typer.
_NAMES: dict[str, Callable[[Callable[[], RobotModel]], Iterable[str]]] = {
    "posture": lambda load: load().posture_names,
    "near": lambda load: load().posture_names,
    "missing": lambda load: load().posture_names,
    "frame": lambda load: load().frame_names,
    "reference": lambda load: load().frame_names,
    "joints": lambda load: load().joint_names,
    "nao": _versions,
    "robot": _robots,
    "format_": _exports,
    "from_": _read_formats,
    "to": _written_formats,
    "sample_names": _samples,
}
# Parameters that may have several names with commas.
_WITH_COMMAS = ("frame",)
# Parameters that name a file of the robot.
_READ = ("urdf", "offsets")


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


def names_for(parameter: str, load: Callable[[dict[str, Any]], RobotModel]) -> Callable[[Any, str], list[str]] | None:
    """Return typer's function for the names that complete the value of a parameter; None if there are none.

    `load` returns the robot that the values of the other parameters name.
    """
    names = _NAMES.get(parameter)
    if names is None:
        return None

    def robot_of(parameters: dict[str, Any]) -> RobotModel:
        # A key that is pressed neither waits for a named pipe nor runs the code of a xacro file.
        given = [parameters[name] for name in _READ if parameters.get(name) is not None]
        runs = parameters.get("xacro") or any(path.endswith(".xacro") for path in given)
        if runs or not all(map(os.path.isfile, given)):
            raise BadArgument("no robot in a regular file of data")
        return load(parameters)

    def completed(ctx: Any, incomplete: str) -> list[str]:
        before = incomplete[: incomplete.rfind(",") + 1] if parameter in _WITH_COMMAS else ""
        return [before + name for name in names(lambda: robot_of(ctx.params))]

    return completed
