"""`nao-kin doctor`: what is installed, from where, and what is known to clash.

It asks without importing, so that it can report a crash.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import typer

from nao_kin._common.ending import before_ending, kill_group, uninterrupted
from nao_kin._text import abbreviated
from nao_kin.cli.options import JsonOption
from nao_kin.cli.output import print_json, print_table

# Distribution name → module name.
_LIBRARIES = {
    "pin": "pinocchio",
    "eigenpy": "eigenpy",
    "coal": "coal",
    "numpy": "numpy",
    "yourdfpy": "yourdfpy",
    "meshcat": "meshcat",
    "numba": "numba",
    "pyarrow": "pyarrow",
    "dask": "dask",
    "typer": "typer",
    "rich": "rich",
    "trimesh": "trimesh",
    "example-robot-data": None,
}
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "firefox")
_PROBE = """
import nao_kin
nao = nao_kin.load_nao()
print(nao.nv, *nao.position(nao.neutral(), "LArm"))
"""
_PROBE_SECONDS = 120


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("doctor", epilog="Example: nao-kin doctor --json")(doctor)


def doctor(json: JsonOption = False) -> None:
    """Versions, where each library comes from, known clashes, and a browser if any; exit 1 when something is wrong."""
    state = inspect_installation()
    if json:
        print_json(state.as_dict())
    else:
        rows = [("python", state.python, state.executable), ("system", state.system, "–")]
        rows += [(library.name, library.version or "–", library.location or "–") for library in state.libraries]
        rows.append(("browser", "found" if state.browser else "none", state.browser or "–"))
        print_table(("what", "version", "where"), rows)
        for problem in state.problems:
            print(f"problem: {problem}")
        if not state.problems:
            print("No problems found.")
    if state.problems:
        raise typer.Exit(1)


@dataclass(frozen=True)
class Library:
    """A library the package uses.

    Attributes:
        name: distribution name.
        version: installed version, None when it is not installed.
        location: where Python would load it from, None when it would not.
    """

    name: str
    version: str | None
    location: str | None


@dataclass(frozen=True)
class Installation:
    """The state of an installation.

    Attributes:
        python: Python's version.
        executable: where this Python is.
        system: the machine.
        libraries: what is installed and from where.
        browser: a browser for the viewer, None when there is none.
        problems: what is wrong, one line each, with what to do about it.
    """

    python: str
    executable: str
    system: str
    libraries: tuple[Library, ...]
    browser: str | None
    problems: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return asdict(self)


def inspect_installation(environment: Mapping[str, str] | None = None) -> Installation:
    """Look at this Python's libraries and at the surroundings that are known to disturb them.

    Args:
        environment: environment variables; those of this process by default.
    """
    variables = os.environ if environment is None else environment
    libraries = tuple(_library(name, module) for name, module in _LIBRARIES.items())
    problems = [*_missing(libraries), *_clashes(libraries, variables), *_model_problem(variables)]
    return Installation(
        python=platform.python_version(),
        executable=sys.executable,
        system=platform.platform(),
        libraries=libraries,
        browser=next((path for name in _BROWSERS if (path := shutil.which(name))), None),
        problems=tuple(problems),
    )


def _library(name: str, module: str | None) -> Library:
    try:
        version = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        version = None
    try:
        spec = importlib.util.find_spec(module) if module else None
    except (ImportError, ValueError):
        spec = None
    return Library(name, version, str(Path(spec.origin).parent) if spec is not None and spec.origin else None)


def _missing(libraries: tuple[Library, ...]) -> list[str]:
    optional = ("example-robot-data", "eigenpy", "coal")
    return [
        f"{library.name} is not installed: pip install {library.name}"
        for library in libraries
        if library.version is None and library.location is None and library.name not in optional
    ]


def _clashes(libraries: tuple[Library, ...], variables: Mapping[str, str]) -> list[str]:
    problems = []
    pinocchio = next(library for library in libraries if library.name == "pin")
    for entry in filter(None, variables.get("PYTHONPATH", "").split(os.pathsep)):
        if entry.startswith(("/opt/ros", "/opt/openrobots")):
            problems.append(f"PYTHONPATH holds {entry}: libraries there hide those of pip; unset PYTHONPATH")
    if pinocchio.location is not None and pinocchio.version is None:
        problems.append(f"Pinocchio comes from {pinocchio.location} and not from pip's 'pin': pip install 'pin>=4.1'")
    if pinocchio.version is not None and _major_minor(pinocchio.version) < (4, 1):
        problems.append(f"pin {pinocchio.version} is too old, mimic joints need 4.1: pip install 'pin>=4.1'")
    if pinocchio.version is not None and pinocchio.location is not None:
        home = str(Path(sys.prefix).resolve())
        elsewhere = str(Path(pinocchio.location).resolve())
        if not Path(elsewhere).is_relative_to(home) and "site-packages" not in elsewhere:
            problems.append(f"Pinocchio is loaded from {elsewhere}, outside of this Python ({home})")
    conda = variables.get("CONDA_PREFIX")
    if conda and pinocchio.version is not None and any(Path(conda, "conda-meta").glob("pinocchio-*.json")):
        problems.append(f"conda ({conda}) and pip both bring Pinocchio: keep one, conda remove pinocchio")
    try:
        version = importlib.metadata.version("pinocchio")
        problems.append(f"'pinocchio' {version} from PyPI is another project; pip uninstall pinocchio, pip install pin")
    except importlib.metadata.PackageNotFoundError:
        pass
    return problems


def _major_minor(version: str) -> tuple[int, int]:
    numbers = [int(part) if part.isdigit() else 0 for part in version.split(".")[:2]]
    return numbers[0], numbers[1] if len(numbers) > 1 else 0


def _model_problem(variables: Mapping[str, str]) -> list[str]:
    """Load the model in a process of its own: mixed binary libraries do not raise, they crash."""
    try:
        with uninterrupted():
            probe = subprocess.Popen(
                [sys.executable, "-c", _PROBE],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                env=dict(variables),
                start_new_session=True,
            )
            take_back = before_ending(partial(kill_group, probe.pid))
    except OSError as error:
        return [f"the model could not be tried: {error}"]
    try:
        with probe:
            try:
                out, errors = probe.communicate(timeout=_PROBE_SECONDS)
            except BaseException:
                probe.kill()
                raise
    except subprocess.TimeoutExpired:
        return [f"the model could not be tried: it did not load within {_PROBE_SECONDS} s"]
    finally:
        take_back()
    if probe.returncode == 0 and out.startswith("25 "):
        return []
    lines = errors.strip().splitlines()
    reason = abbreviated(lines[-1]) if lines else f"the process ended with code {probe.returncode}"
    return [f"the NAO does not load: {reason}"]
