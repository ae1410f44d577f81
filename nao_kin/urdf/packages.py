"""Where the files are that a robot's file names: beside it, or in the packages of ROS and the models of Gazebo.

A package is searched in this order: in the folders given, in the folders above the file, by its `package.xml` at any
depth of the folders given, in what ROS_PACKAGE_PATH and AMENT_PREFIX_PATH name, in what CMAKE_PREFIX_PATH and the paths
of Gazebo name. The first place that has the file wins.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from urllib.parse import unquote

from nao_kin._text import quoted
from nao_kin.errors import BadArgument

# Variables of lists of folders, and where below each folder the packages are.
_PREFIXES = (("AMENT_PREFIX_PATH", "share"), ("CMAKE_PREFIX_PATH", "share"))
_MODEL_PATHS = ("GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH")
# ROS_PACKAGE_PATH names folders that hold packages at any depth; ROS itself looks this far.
_DEEPEST = 6
_URI = re.compile(r"(package|model)://+([^/]+)/*(.*)", re.DOTALL)
_NAME = re.compile(rb"<name(?:\s[^>]*)?>\s*([^<\s]+)\s*</name>")
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)


class Packages:
    """The search for files and packages on behalf of one robot's file.

    Args:
        file: the robot's file.
        folders: folders to search first; each holds packages, or is one.

    Examples:
        >>> from pathlib import Path
        >>> nao = nk.load_nao()
        >>> packages = nk.urdf.Packages(nao.urdf_path)
        >>> packages.file(nao.tree.visuals[0].geometry.filename).is_file()
        True
        >>> packages.folder("a_package_that_nobody_has")
    """

    def __init__(self, file: Path, folders: Iterable[Path] = ()) -> None:
        try:
            self._folder, self._given = Path(file).resolve().parent, tuple(map(Path, folders))
        except (TypeError, ValueError):
            given = quoted((file, folders))
            raise BadArgument(f"expected the path of a robot's file, and folders, got {given}") from None
        self._places: dict[str, tuple[Path, ...]] = {}

    def file(self, name: str) -> Path | None:
        """The file that `name` means, None when it is not there.

        Args:
            name: a path relative to the robot's file or from the root, `file://…`, `package://package/…` or
                `model://model/…`.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.tree.packages.file(nao.tree.visuals[0].geometry.filename).is_file()
            True
        """
        try:
            match = _URI.fullmatch(name)
            if match is not None:
                places, inside = self._searched(match[2]), match[3]
            else:
                places, inside = (self._folder,), name.removeprefix("file://")
            candidates = (place / text for place in places for text in dict.fromkeys((inside, unquote(inside))))
            return next((path for path in candidates if path.is_file()), None)
        except (OSError, ValueError, TypeError):  # a name that no system takes
            return None

    def folder(self, package: str) -> Path | None:
        """The folder of a package, None when it is not there.

        Examples:
            >>> nk.load_nao().tree.packages.folder("a_package_that_nobody_has") is None
            True
        """
        try:
            return next((place for place in self._searched(package) if place.is_dir()), None)
        except (OSError, ValueError, TypeError):
            return None

    def contain(self, file: Path) -> bool:
        """Return whether a file lies in the robot's folder, in the package of that folder, or in a folder given.

        Symbolic links are followed first, so that a link in the package to a file elsewhere is not in the package.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.tree.packages.contain(nao.urdf_path), nao.tree.packages.contain("/etc/hostname")
            (True, False)
        """
        above = (self._folder, *self._folder.parents)
        package = next((folder for folder in above if (folder / "package.xml").is_file()), self._folder)
        try:
            real = Path(os.path.realpath(file))
        except (OSError, ValueError, TypeError):
            return False
        return any(real.is_relative_to(os.path.realpath(folder)) for folder in (package, *self._given))

    def _searched(self, package: str) -> tuple[Path, ...]:
        if package not in self._places:
            self._places[package] = tuple(dict.fromkeys(self._candidates(package)))
        return self._places[package]

    def _candidates(self, package: str) -> Iterator[Path]:
        for folder in (*self._given, *self._folder.parents, self._folder):
            yield folder / package
            if _is_package(folder, package):
                yield folder
        for folder in self._given:
            if not (folder / package).is_dir():
                yield from _below(folder, package, _DEEPEST)
        for folder in _listed("ROS_PACKAGE_PATH"):
            yield from _below(folder, package, _DEEPEST)
        for variable, share in _PREFIXES:
            yield from (folder / share / package for folder in _listed(variable))
        for variable in _MODEL_PATHS:
            yield from (folder / package for folder in _listed(variable))


def mesh_in(folder: Path, filename: str) -> Path | None:
    """The file that a URDF in a folder means by `filename`, None when it is not there; see `Packages.file`.

    Raises:
        BadArgument: the folder is no path.

    Examples:
        >>> nk.urdf.mesh_in(nk.load_nao().urdf_path.parent, "no_such.stl") is None
        True
    """
    try:
        file = Path(folder, "robot.urdf")
    except TypeError:
        raise BadArgument(f"folder must be a path, got {quoted(folder)}") from None
    return Packages(file).file(filename)


def checked_folders(folders: object) -> tuple[Path, ...]:
    """Folders to search for packages, as absolute paths.

    Raises:
        BadArgument: no folders, or one that is not there.
    """
    if isinstance(folders, (str, bytes, os.PathLike)) or not isinstance(folders, Iterable):
        raise BadArgument(f"package_dirs must be several folders, as in a list, got {quoted(folders)}")
    found = []
    for folder in folders:
        try:
            path = Path(folder).absolute()
            there = path.is_dir()
        except (TypeError, ValueError, OSError):
            there = False
        if not there:
            raise BadArgument(f"package_dirs: there is no folder {quoted(str(folder))}")
        found.append(path)
    return tuple(found)


def _listed(variable: str) -> list[Path]:
    """The folders that an environment variable lists, wherever the process goes later."""
    return [Path(entry).absolute() for entry in os.environ.get(variable, "").split(os.pathsep) if entry]


def _below(folder: Path, package: str, depth: int) -> Iterator[Path]:
    """The folders of a package at or below a folder; packages hold no packages."""
    if folder.name == package or _is_package(folder, package):
        yield folder
    elif depth and not (folder / "package.xml").is_file():
        try:
            inside = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
        except OSError:  # not there, or closed to us
            return
        for below in inside:
            yield from _below(below, package, depth - 1)


def _is_package(folder: Path, package: str) -> bool:
    """Whether a folder says that it is this package; it may have been downloaded under another name."""
    try:
        text = (folder / "package.xml").read_bytes()
    except OSError:
        return False
    match = _NAME.search(_COMMENT.sub(b"", text))
    return match is not None and match[1] == os.fsencode(package)
