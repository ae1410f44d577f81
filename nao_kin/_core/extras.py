"""The extras: optional packages, what each is for, and what works without it.

The one place for it: `errors.MissingExtra`, `nao-kin doctor` and the table in docs/installation.md read it here, and
pyproject.toml is tested against it.
"""

from __future__ import annotations

from dataclasses import dataclass

ALL = "all"
"""The extra that is the union of all others."""


@dataclass(frozen=True)
class Extra:
    """One extra: `pip install 'nao-kin[name]'`.

    Attributes:
        name: as pip takes it.
        packages: the distributions that it asks for, as pyproject.toml has them; messages name the first.
        modules: what is imported of them; nothing of one that holds data only.
        brings: what works with it.
        without: what works without it.
    """

    name: str
    packages: tuple[str, ...]
    modules: tuple[str, ...]
    brings: str
    without: str


EXTRAS = {
    extra.name: extra
    for extra in (
        Extra(
            "batch",
            ("numba",),
            ("numba",),
            "thousands of configurations or targets at once, and reach maps, by compiled code",
            "the same answers come without it, slower where there are many",
        ),
        Extra(
            "robots",
            ("example-robot-data",),
            (),
            "Romeo, TALOS, Panda and other robots by name",
            "any URDF file loads without it",
        ),
        Extra(
            "descriptions",
            ("robot_descriptions",),
            ("robot_descriptions",),
            "hundreds of robots by name, downloaded when they are first asked for",
            "any URDF file loads without it",
        ),
        Extra(
            "mujoco",
            ("mujoco",),
            ("mujoco",),
            "MJCF files, read and written",
            "URDF files are read and written without it",
        ),
        Extra(
            "xacro",
            ("xacro",),
            ("xacro",),
            "xacro sources, expanded where that is asked for",
            "what xacro has expanded is read without it",
        ),
        Extra(
            "arrow",
            ("pyarrow",),
            ("pyarrow",),
            "Parquet, Arrow and large CSV files",
            ".npy files stream without it, and CSV and JSON are read whole",
        ),
        Extra(
            "dask",
            ("dask",),
            ("dask", "distributed"),
            "lazy arrays on many cores and machines (nao_kin.stream.distributed)",
            "arrays in memory and nao_kin.stream work without it",
        ),
        Extra(
            "notebook",
            ("anywidget",),
            ("anywidget",),
            "the viewer live in a notebook",
            "a cell shows the robot as it was when it ran without it",
        ),
        Extra(
            "naoqi",
            ("qi",),
            ("qi",),
            "NAOqi's protocol: nao-kin serve, run and live",
            "names, orders, poses and files of NAOqi work without it",
        ),
        Extra(
            "plot",
            ("matplotlib",),
            ("matplotlib",),
            "curves of motions (nao-kin motion plot)",
            "motions are checked, shown and converted without it",
        ),
        Extra(
            "pink",
            ("pin-pink", "qpsolvers"),
            ("pink", "quadprog"),
            'solver="pink" of nao_kin.ik.numeric',
            "the solver of its own, damped least squares, works without it",
        ),
    )
}


def missing(purpose: str, name: str, reason: str = "") -> str:
    """One line: what needs which package, how to get it, and what works without it.

    Args:
        purpose: what needs it.
        name: of the extra.
        reason: why the package does not load, where it is installed.
    """
    extra = EXTRAS.get(name)
    if extra is None:
        return f"{purpose} needs an optional package: {command(name)}"
    remedy = f", which does not load ({reason})" if reason else f": {command(name)}"
    return f"{purpose} needs {extra.packages[0]}{remedy}; {extra.without}"


def with_remedy(problem: str) -> str:
    """Why a library does not load; with the system's package that brings what is missing, where that is known."""
    if "libgomp.so.1" not in problem or "libgomp1" in problem:
        return problem
    return f"{problem}; install libgomp: apt-get install libgomp1 (Debian, Ubuntu), dnf install libgomp (Fedora)"


def command(name: str) -> str:
    """What a person types to get an extra."""
    return f"pip install 'nao-kin[{name}]'"
