"""Robots by name, from the packages example-robot-data and robot_descriptions."""

from __future__ import annotations

import contextlib
import functools
import importlib
import importlib.util
import pkgutil
import re
import sys
from pathlib import Path
from types import ModuleType

from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadModel, MissingExtra, UnknownName
from nao_kin.robot.build import Base
from nao_kin.robot.model import RobotModel
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.semantics_files import NO_SEMANTICS

_PACKAGE = "example-robot-data"
_DESCRIPTIONS = "robot_descriptions"
# The suffix of all names in robot_descriptions.
_ENDING = "_description"


def robot_names(*, download: bool = False) -> tuple[str, ...]:
    """Return the names that `load_robot` takes: the URDF files of example-robot-data without their suffix.

    Args:
        download: list the names of robot_descriptions too, if it is installed; their files are downloaded when they are
            loaded for the first time.

    Raises:
        MissingExtra: example-robot-data is not installed; with `download`, neither package is installed.

    Examples:
        >>> "romeo" in nk.robot_names()
        True
    """
    described = _described_names() if download else ()
    return (*_files(None if described else MissingExtra("loading a robot by name", "robots")), *described)


def load_robot(name: str, *, base: Base = "fixed") -> RobotModel:
    """Return a robot by name, loaded as by `RobotModel.from_urdf` or `RobotModel.from_mjcf`.

    Robots of robot_descriptions ("g1_description", "panda_mj_description" …) are downloaded once, into the folder that
    ROBOT_DESCRIPTIONS_CACHE names or ~/.cache/robot_descriptions. Their xacro sources are expanded, which runs the code
    of their authors.

    Args:
        name: "romeo", "talos_full_v2", "panda" …, one of `robot_names(download=True)`.
        base: "fixed" or "floating".

    Raises:
        MissingExtra: neither example-robot-data nor robot_descriptions is installed, or the file is an MJCF and MuJoCo
            is not installed.
        BadModel: the robot's file describes no valid model, or cannot be downloaded.

    Examples:
        >>> romeo = nk.load_robot("romeo")
        >>> romeo.nv, romeo.joint_names[0]
        (33, 'LHipYaw')
    """
    described = _described_names()
    lacks_theirs = name.endswith(_ENDING) and not described
    by_this, by_name = "loading a robot by this name", "loading a robot by name"
    missing = MissingExtra(by_this, "descriptions") if lacks_theirs else MissingExtra(by_name, "robots")
    files = _files(None if described else missing)
    if name in files:
        robot = RobotModel.from_urdf(files[name], base=base)
        if robot.semantics == Semantics() and not any(note.startswith(NO_SEMANTICS) for note in robot.load_notes):
            looked = f"looked for {name}.toml and {name}.srdf beside the URDF, and in the folder srdf near it"
            robot.load_notes += (f"{NO_SEMANTICS}: {looked}",)
        return robot
    if name in described:
        return _described(name, base)
    hint = f"names of {_DESCRIPTIONS} need pip install 'nao-kin[descriptions]'" if lacks_theirs else ""
    if re.fullmatch(r"nao|v\d(\.\d)?", name.lower()):
        hint = "load_nao loads a NAO, and on the command line --nao"
    if "/" in name or Path(name).suffix:
        hint = "a file is read with RobotModel.from_file, and on the command line with --urdf"
    raise UnknownName("robot", name, (*files, *described), hint)


def _files(missing: MissingExtra | None) -> dict[str, Path]:
    """Return the URDF files of example-robot-data by name; without it raise `missing`, or return {} for None."""
    import importlib.metadata  # loading it takes as long as all other imports of this package

    try:
        # The package holds data but no module: its folder is found through its installed files.
        installed = importlib.metadata.files(_PACKAGE) or []
    except importlib.metadata.PackageNotFoundError:
        if missing is None:
            return {}
        raise missing from None
    found = {
        file.stem: Path(str(file.locate())) for file in installed if file.suffix == ".urdf" and "robots" in file.parts
    }
    return dict(sorted(found.items()))


def _described_names() -> tuple[str, ...]:
    """Return the names of robot_descriptions, if installed. Importing the module of a name downloads its robot."""
    try:
        spec = importlib.util.find_spec(_DESCRIPTIONS)
    except (ImportError, ValueError):
        spec = None
    modules = pkgutil.iter_modules((spec and spec.submodule_search_locations) or [])
    return tuple(sorted(m.name for m in modules if m.name.endswith(_ENDING) and not m.name.startswith("_")))


def _described(name: str, base: Base) -> RobotModel:
    """Return a robot of robot_descriptions."""
    try:
        with contextlib.redirect_stdout(sys.stderr):  # it prints its downloads
            module = importlib.import_module(f"{_DESCRIPTIONS}.{name}")
    except Exception as error:  # errors of git, of the network, of the disk
        reason = abbreviated(error) or type(error).__name__
        raise BadModel(f"robot {quoted(name)}: {_DESCRIPTIONS} cannot download it: {reason}") from None
    load = functools.partial(RobotModel.from_file, base=base, package_dirs=_package_dirs(module))
    if hasattr(module, "URDF_PATH"):
        srdf = getattr(module, "SRDF_PATH", None)
        return load(module.URDF_PATH, semantics=srdf if srdf and Path(srdf).is_file() else None)
    if hasattr(module, "XACRO_PATH"):
        return load(module.XACRO_PATH, xacro=True, xacro_arguments=getattr(module, "XACRO_ARGS", {}))
    if hasattr(module, "MJCF_PATH"):
        return load(module.MJCF_PATH)
    raise BadModel(f"robot {quoted(name)}: {_DESCRIPTIONS} has neither a URDF nor an MJCF of it")


def _package_dirs(module: ModuleType) -> list[Path]:
    """Return the folders of the packages that a description names."""
    own = [getattr(module, name, None) for name in ("PACKAGE_PATH", "REPOSITORY_PATH")]
    named = [*own, *getattr(module, "XACRO_PACKAGE_PATHS", {}).values()]
    paths = [Path(path) for path in named if path]
    return [path for path in dict.fromkeys((*paths, *(path.parent for path in paths))) if path.is_dir()]
