"""`nao-kin doctor` and `warmup`: what is installed, from where, what clashes, and kernels compiled ahead."""

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
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any

import typer

from nao_kin._core.extras import ALL, EXTRAS, Extra, with_remedy
from nao_kin._core.extras import command as install_command
from nao_kin._core.process import before_ending, kill_group, uninterrupted
from nao_kin._core.text import abbreviated
from nao_kin._kernels.cache import need_numba, warm_up
from nao_kin.cli.options import JSON, command, print_json, print_table

# --- Libraries tried in a process of their own, for mixed binary libraries do not raise, they crash.

_PROBE = """
import nao_kin
nao = nao_kin.load_nao()
print(nao.nv, *nao.position(nao.neutral(), "LArm"))
"""
_NUMBA_PROBE = """
from nao_kin._kernels.cache import numba_problem
print(numba_problem())
"""
_PROBE_SECONDS = 120


def model_problem(variables: Mapping[str, str]) -> list[str]:
    """What is wrong where the NAO does not load, if anything."""
    code, out, problem = _probed(_PROBE, variables)
    if code == 0 and out.startswith("25 "):
        return []
    return [
        f"the model could not be tried: {problem}" if code is None else f"the NAO does not load: {with_remedy(problem)}"
    ]


def numba_problem(variables: Mapping[str, str]) -> list[str]:
    """What is wrong where Numba is installed and does not load: it refuses a NumPy newer than itself."""
    code, out, problem = _probed(_NUMBA_PROBE, variables)
    return [found] if (found := out.strip() if code == 0 else f"numba does not load: {problem}") else []


def _probed(program: str, variables: Mapping[str, str]) -> tuple[int | None, str, str]:
    """Exit code and output of a program in a process of its own, and what it ended with; no code where it did not."""
    try:
        with uninterrupted():
            probe = subprocess.Popen(
                [sys.executable, "-c", program],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                env=dict(variables),
                start_new_session=True,
            )
            take_back = before_ending(partial(kill_group, probe.pid))
    except OSError as error:
        return None, "", str(error)
    try:
        with probe:
            try:
                out, errors = probe.communicate(timeout=_PROBE_SECONDS)
            except BaseException:
                probe.kill()
                raise
    except subprocess.TimeoutExpired:
        return None, "", f"it did not load within {_PROBE_SECONDS} s"
    finally:
        take_back()
    lines = errors.strip().splitlines()
    return probe.returncode, out, abbreviated(lines[-1]) if lines else f"the process ended with code {probe.returncode}"


# --- `nao-kin doctor`: what is installed, from where, and what is known to clash.
#
# It asks without importing, so that it can report a crash.

# Distribution name → module name.
_LIBRARIES = {
    "pin": "pinocchio",
    "eigenpy": "eigenpy",
    "coal": "coal",
    "numpy": "numpy",
    "yourdfpy": "yourdfpy",
    "meshcat": "meshcat",
    "typer": "typer",
    "rich": "rich",
    "trimesh": "trimesh",
}
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "firefox")


@command("doctor", "Example: nao-kin doctor --json")
def doctor(json: bool = JSON) -> None:
    """Versions, where each library comes from, extras, known clashes, and a browser; exit 1 when something is wrong."""
    state = inspect_installation()
    if json:
        print_json(state.as_dict())
    else:
        rows = [("python", state.python, state.executable), ("system", state.system, "–")]
        rows += [(library.name, library.version or "–", library.location or "–") for library in state.libraries]
        rows.append(("browser", "found" if state.browser else "none", state.browser or "–"))
        print_table(("what", "version", "where"), rows)
        print_table(
            ("extra", "version", "for"),
            [(extra.name, extra.version or "absent", extra.brings) for extra in state.extras],
        )
        if any(extra.version is None for extra in state.extras):
            one, every = install_command("NAME"), install_command(ALL)
            print(f"{one} adds an extra, {every} all of them. Nothing else needs them.\n")
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
class ExtraState:
    """An extra, as `nao_kin._core.extras` has it, and whether it is here.

    Attributes:
        name: as in `pip install 'nao-kin[name]'`.
        version: of its first package; None when one of its packages is absent.
        brings: what works with it.
        without: what works without it.
    """

    name: str
    version: str | None
    brings: str
    without: str


@dataclass(frozen=True)
class Installation:
    """The state of an installation.

    Attributes:
        python: Python's version.
        executable: where this Python is.
        system: the machine.
        libraries: what is installed and from where.
        extras: which of the optional packages are here.
        browser: a browser for the viewer, None when there is none.
        problems: what is wrong, one line each, with what to do about it.
    """

    python: str
    executable: str
    system: str
    libraries: tuple[Library, ...]
    extras: tuple[ExtraState, ...]
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
    extras = tuple(_extra_state(extra) for extra in EXTRAS.values())
    problems = [*_missing(libraries), *_clashes(libraries, variables), *model_problem(variables)]
    if any(extra.name == "batch" and extra.version is not None for extra in extras):
        problems += numba_problem(variables)
    return Installation(
        python=platform.python_version(),
        executable=sys.executable,
        system=platform.platform(),
        libraries=libraries,
        extras=extras,
        browser=next((path for name in _BROWSERS if (path := shutil.which(name))), None),
        problems=tuple(problems),
    )


def _library(name: str, module: str) -> Library:
    spec = _spec(module)
    return Library(name, _version(name), str(Path(spec.origin).parent) if spec is not None and spec.origin else None)


def _extra_state(extra: Extra) -> ExtraState:
    versions = [_version(package) for package in extra.packages]
    present = all(_spec(module) for module in extra.modules) if extra.modules else None not in versions
    return ExtraState(extra.name, (versions[0] or "present") if present else None, extra.brings, extra.without)


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _spec(module: str) -> ModuleSpec | None:
    try:
        return importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return None


def _missing(libraries: tuple[Library, ...]) -> list[str]:
    optional = ("eigenpy", "coal")
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


# --- `nao-kin warmup`: the batch kernels compiled ahead.


@command("warmup", "Example: nao-kin warmup")
def warmup(json: bool = JSON) -> None:
    """Compile the kernels for large batches, reach maps and inverse kinematics ahead, once on a machine.

    They are kept in the user's cache; NUMBA_CACHE_DIR names another folder. Without this command, the first
    large batch, map or inverse kinematics compiles what it needs.
    """
    need_numba("warmup")
    states = warm_up()
    if json:
        print_json(
            {
                "kernels": [
                    {
                        "name": state.name,
                        "compiled": state.compiled,
                        "seconds": round(state.seconds, 3),
                        "folder": None if state.folder is None else str(state.folder),
                    }
                    for state in states
                ]
            }
        )
        return
    rows = [
        (state.name, "compiled" if state.compiled else "found", f"{state.seconds:.1f}", str(state.folder or "–"))
        for state in states
    ]
    print_table(("kernel", "", "s", "kept in"), rows, numbers=("s",))
