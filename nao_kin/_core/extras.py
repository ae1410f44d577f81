"""The extras: optional packages, their purposes, and what works without them.

`errors.MissingExtra`, `nao-kin doctor` and the table in docs/installation.md use this list, and a test compares it with
pyproject.toml.
"""

from __future__ import annotations

from dataclasses import dataclass

ALL = "all"
"""The extra that is the union of all others."""


@dataclass(frozen=True)
class Extra:
    """One extra: `pip install 'nao-kin[name]'`."""

    name: str
    packages: tuple[str, ...]  # its distributions, as in pyproject.toml; messages name the first
    brings: str  # the features that it adds
    without: str  # the features that work without it
    imported: tuple[str, ...] | None = None  # modules to import; () for data alone, None for the packages' names

    @property
    def modules(self) -> tuple[str, ...]:
        """The modules imported from the distributions."""
        return self.packages if self.imported is None else self.imported


EXTRAS = {
    extra.name: extra
    for extra in (
        Extra(
            "batch",
            ("numba",),
            "thousands of configurations or targets at once, and reach maps, by compiled code",
            "same results without it; large batches are slower",
        ),
        Extra(
            "robots",
            ("example-robot-data",),
            "Romeo, TALOS, Panda and other robots by name",
            "any URDF file loads without it",
            (),
        ),
        Extra(
            "descriptions",
            ("robot_descriptions",),
            "hundreds of robots by name, downloaded on first use",
            "any URDF file loads without it",
        ),
        Extra("mujoco", ("mujoco",), "MJCF files, read and written", "URDF files are read and written without it"),
        Extra("c3d", ("c3d",), "C3D files of motion capture", "other files of skeletons are read without it"),
        Extra("xacro", ("xacro",), "xacro sources, expanded on request", "expanded files are read without it"),
        Extra(
            "arrow",
            ("pyarrow",),
            "Parquet, Arrow and large CSV files",
            ".npy files, and CSV files of up to 100 MB, are read without it",
        ),
        Extra(
            "dask",
            ("dask",),
            "lazy arrays on many cores and machines (nao_kin.stream.distributed)",
            "arrays in memory and nao_kin.stream work without it",
            ("dask", "distributed"),
        ),
        Extra(
            "notebook",
            ("anywidget",),
            "the viewer live in a notebook",
            "without it a cell shows the robot as it was when the cell ran",
        ),
        Extra(
            "naoqi",
            ("qi",),
            "NAOqi's protocol: nao-kin serve, run and live",
            "names, orders, poses and files of NAOqi work without it",
        ),
        Extra(
            "plot",
            ("matplotlib",),
            "curves of motions (nao-kin motion plot)",
            "motions are checked, shown and converted without it",
        ),
        Extra(
            "analytic",
            ("eaik",),
            "closed forms for limbs of any robot: nao_kin.ik.analytic, nao-kin ik --analytic",
            "the closed forms of a NAO's limbs and nao_kin.ik.numeric work without it",
        ),
        Extra(
            "calibration",
            ("scipy",),
            "joint offsets and camera mountings from observations (nao_kin.calibration, nao-kin calibrate); "
            "the filter of imitate",
            "offsets that you know are used, and people are imitated unfiltered, without it",
        ),
        Extra(
            "photos",
            ("opencv-python-headless",),
            "corners of chessboards in photos (nao_kin.calibration.from_photos, nao-kin calibrate --photos)",
            "corners that you have found are used without it",
            ("cv2",),
        ),
        Extra(
            "symbolic",
            ("sympy",),
            "symbolic forward kinematics (nao_kin.joints.DHTable.symbolic, nao-kin joints --dh FRAME --symbolic)",
            "Denavit–Hartenberg tables are computed without it",
        ),
    )
}


def missing(purpose: str, name: str, reason: str = "") -> str:
    """Return one line: the required package, how to get it or why it fails, and the features that work without it."""
    extra = EXTRAS.get(name)
    if extra is None:
        return f"{purpose} needs an optional package: {command(name)}"
    remedy = f", which does not load ({reason})" if reason else f": {command(name)}"
    return f"{purpose} needs {extra.packages[0]}{remedy}; {extra.without}"


def with_remedy(problem: str) -> str:
    """Return why a library does not load, and which package of the operating system adds the missing part, if known."""
    if "libgomp.so.1" not in problem or "libgomp1" in problem:
        return problem
    return f"{problem}; install libgomp: apt-get install libgomp1 (Debian, Ubuntu), dnf install libgomp (Fedora)"


def command(name: str) -> str:
    """Return the command that installs an extra."""
    return f"pip install 'nao-kin[{name}]'"
