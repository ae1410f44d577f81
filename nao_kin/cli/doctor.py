"""`nao-kin doctor` and `warmup`: the installed packages, their origins, conflicts, and kernels compiled in advance."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import re
import subprocess
import sys
from collections.abc import Mapping
from functools import partial
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any

import typer

from nao_kin import warm_up
from nao_kin._core.extras import ALL, EXTRAS, Extra, command as install_command, with_remedy
from nao_kin._core.process import BROWSER_VARIABLE, before_ending, find_browsers, kill_group, uninterrupted
from nao_kin._core.text import abbreviated
from nao_kin._core.warn import need_extra
from nao_kin.cli.options import JSON, command
from nao_kin.cli.output import print_json, print_table
from nao_kin.errors import NoBrowser

# --- Libraries tried in a separate process, because incompatible binary libraries crash instead of raising.

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


def _probed(program: str, variables: Mapping[str, str]) -> tuple[int | None, str, str]:
    """Run a program in a separate process; return its exit code (None without one), its output, and its last error."""
    given: Any = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    try:
        with uninterrupted():  # a signal ends the probe, too
            command = [sys.executable, "-c", program]
            probe = subprocess.Popen(command, env=dict(variables), start_new_session=True, **given)
            registered = before_ending(partial(kill_group, probe))
        with registered, probe:
            try:
                out, errors = probe.communicate(timeout=_PROBE_SECONDS)
            finally:
                if probe.poll() is None:
                    probe.kill()
    except (OSError, subprocess.TimeoutExpired) as error:
        return None, "", str(error)
    lines = errors.strip().splitlines()
    said = lines[-1] if lines else f"the process ended with code {probe.returncode}"
    return probe.returncode, out, abbreviated(said)


# --- `nao-kin doctor`, which does not import the libraries, so that it can report a crash.

# Distribution name → module name.
_LIBRARIES = {"pin": "pinocchio"} | {
    name: name for name in "eigenpy coal numpy yourdfpy meshcat typer rich trimesh".split()
}
# These may be absent: Pinocchio includes them, or works without them.
_OPTIONAL = ("eigenpy", "coal")


@command("doctor", "Example: nao-kin doctor --json")
def doctor(json: bool = JSON) -> None:
    """Print versions, the location of each library, extras, known conflicts and a browser; exit code 1 for problems."""
    state = inspect_installation()
    if json:
        print_json(state)
    else:
        rows = [("python", state["python"], state["executable"]), ("system", state["system"], "–")]
        rows += [(lib["name"], lib["version"] or "–", lib["location"] or "–") for lib in state["libraries"]]
        rows.append(("browser", "found" if state["browser"] else "none", state["browser"] or "–"))
        print_table(("what", "version", "where"), rows)
        extras = [(extra["name"], extra["version"] or "absent", extra["brings"]) for extra in state["extras"]]
        print_table(("extra", "version", "for"), extras)
        if any(extra["version"] is None for extra in state["extras"]):
            one, every = install_command("NAME"), install_command(ALL)
            print(f"{one} adds an extra, {every} adds all of them. The extras are optional.\n")
        for problem in state["problems"]:
            print(f"problem: {problem}")
        if not state["problems"]:
            print("No problems found.")
    if state["problems"]:
        raise typer.Exit(1)


def inspect_installation(environment: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Return the document of `nao-kin doctor --json`, for these environment variables, by default this process's."""
    variables = os.environ if environment is None else environment
    libraries = [
        {"name": name, "version": _version(name), "location": _location(module)} for name, module in _LIBRARIES.items()
    ]
    extras = [
        {"name": extra.name, "version": _extra_version(extra), "brings": extra.brings, "without": extra.without}
        for extra in EXTRAS.values()
    ]
    problems = [
        f"{library['name']} is not installed: pip install {library['name']}"
        for library in libraries
        if library["version"] is None and library["location"] is None and library["name"] not in _OPTIONAL
    ]
    problems += _clashes(_version("pin"), _location("pinocchio"), variables)
    code, out, said = _probed(_PROBE, variables)
    if code != 0 or not out.startswith("25 "):
        problems.append(f"the NAO does not load: {with_remedy(said)}")
    if _extra_version(EXTRAS["batch"]) is not None:
        code, out, said = _probed(_NUMBA_PROBE, variables)
        problems += filter(None, [out.strip() if code == 0 else f"numba does not load: {said}"])
    browser = None
    try:
        browser = str(find_browsers(variables)[0])
    except NoBrowser as error:
        if variables.get(BROWSER_VARIABLE):
            problems.append(str(error))
    return {
        "python": platform.python_version(),
        "executable": sys.executable,
        "system": platform.platform(),
        "libraries": libraries,
        "extras": extras,
        "browser": browser,
        "problems": problems,
    }


def _extra_version(extra: Extra) -> str | None:
    """Return the version of the first package of an extra; None if one of its packages is absent."""
    versions = [_version(package) for package in extra.packages]
    present = all(_spec(module) for module in extra.modules) if extra.modules else None not in versions
    return (versions[0] or "present") if present else None


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


def _location(module: str) -> str | None:
    """Return the folder from which Python would load a module, without loading it."""
    spec = _spec(module)
    return str(Path(spec.origin).parent) if spec is not None and spec.origin else None


def _clashes(pin: str | None, place: str | None, variables: Mapping[str, str]) -> list[str]:
    """Return the packages that hide or duplicate Pinocchio, given pip's version of pin and its folder (or None)."""
    problems = []
    for entry in filter(None, variables.get("PYTHONPATH", "").split(os.pathsep)):
        if entry.startswith(("/opt/ros", "/opt/openrobots")):
            problems.append(f"PYTHONPATH contains {entry}: libraries there hide those of pip; unset PYTHONPATH")
    if place is not None and pin is None:
        problems.append(f"Pinocchio comes from {place} and not from pip's 'pin': pip install 'pin>=4.1'")
    if pin is not None and tuple(map(int, re.findall(r"\d+", pin)[:2])) < (4, 1):
        problems.append(f"pin {pin} is too old, mimic joints need 4.1: pip install 'pin>=4.1'")
    if pin is not None and place is not None:
        home, elsewhere = Path(sys.prefix).resolve(), Path(place).resolve()
        if not elsewhere.is_relative_to(home) and "site-packages" not in str(elsewhere):
            problems.append(f"Pinocchio is loaded from {elsewhere}, outside of this Python ({home})")
    conda = variables.get("CONDA_PREFIX")
    if conda and pin is not None and any(Path(conda, "conda-meta").glob("pinocchio-*.json")):
        problems.append(f"conda ({conda}) and pip both bring Pinocchio: keep one, conda remove pinocchio")
    other = _version("pinocchio")
    if other is not None:
        problems.append(f"'pinocchio' {other} from PyPI is another project; pip uninstall pinocchio, pip install pin")
    return problems


# --- `nao-kin warmup`.


@command("warmup", "Example: nao-kin warmup")
def warmup(json: bool = JSON) -> None:
    """Compile the kernels for large batches, reach maps and inverse kinematics in advance, once per machine.

    The kernels are kept in the user's cache; NUMBA_CACHE_DIR names another folder. Without this command, the first
    large batch, reach map or solution of inverse kinematics compiles the kernels that it needs.
    """
    need_extra("warmup", "batch")
    states = warm_up()
    if json:
        kernels = [vars(state) | {"folder": None if state.folder is None else str(state.folder)} for state in states]
        print_json({"kernels": [kernel | {"seconds": round(kernel["seconds"], 3)} for kernel in kernels]})
        return
    rows = [
        (state.name, "compiled" if state.compiled else "found", f"{state.seconds:.1f}", str(state.folder or "–"))
        for state in states
    ]
    print_table(("kernel", "", "s", "kept in"), rows, numbers=("s",))
